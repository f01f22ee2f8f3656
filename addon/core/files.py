"""Files that appear whole or not at all."""

import contextlib
import os
import tempfile


@contextlib.contextmanager
def replacing(path, mode, **options):
    """An open file beside ``path``, which takes its place at the end; what was there stays until then."""
    partial = new_beside(path)
    try:
        with open(partial, mode, **options) as file:
            yield file
        os.replace(partial, path)
    except BaseException:
        os.remove(partial)
        raise


def new_beside(path):
    """The path of a new, empty file in the same folder, with the rights that a new file gets there."""
    folder, name = os.path.split(path)
    handle, partial = tempfile.mkstemp(".part", f"{name[:100]}.", folder or ".")
    os.close(handle)
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(partial, 0o666 & ~mask)
    return partial
