"""Files that appear whole or not at all, and what kind of picture one is."""

import contextlib
import errno
import json
import math
import os
import pathlib
import stat
import tempfile
from collections.abc import Mapping

from .refused import Refused

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}


@contextlib.contextmanager
def replacing(path, mode, **options):
    """An open file beside ``path``, which takes its place at the end; what was there stays until then.

    A link stays, and the file that it leads to is replaced; what is no file, as a pipe, is written to.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        with open(path, mode, **options) as file:
            yield file
        return
    partial = new_beside(path)
    try:
        with open(partial, mode, **options) as file:
            yield file
        take_place(partial, path)
    except BaseException:
        os.remove(partial)
        raise


def new_beside(path):
    """The path of a new, empty file in the same folder, with the rights of the file there, or of a new one.

    OSError where there is something at ``path`` that is no file, as a device.
    """
    path = os.path.realpath(path)
    if os.path.exists(path):
        if not os.path.isfile(path):
            raise OSError(errno.EINVAL, "it is no file that could be replaced", path)
        rights = stat.S_IMODE(os.stat(path).st_mode)
    else:
        mask = os.umask(0)
        os.umask(mask)
        rights = 0o666 & ~mask
    folder, name = os.path.split(path)
    handle, partial = tempfile.mkstemp(".part", f"{name[:100]}.", folder)
    os.close(handle)
    os.chmod(partial, rights)
    return partial


def take_place(partial, path):
    """Puts a file of ``new_beside`` where ``path`` leads to."""
    os.replace(partial, os.path.realpath(path))


def write_json(path, value):
    """Writes ``value`` as JSON, which knows no NaN and no infinity: they become null."""
    text = json.dumps(_known_to_json(value), indent=2, allow_nan=False) + "\n"
    with replacing(path, "w", encoding="utf-8") as file:
        file.write(text)


def _known_to_json(value):
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _known_to_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_known_to_json(item) for item in value]
    return value


def image_format(path):
    """Blender's name of the format that the suffix asks for; Refused for others."""
    suffix = pathlib.Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise Refused(f"'{path}' is no name for a picture: end it in .png or .jpg")
    return FORMATS[suffix]
