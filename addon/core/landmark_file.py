"""The file of landmarks that an outside detector has found on a head.

JSON: ``{"tip of the nose": [0.0, -1.2, 0.3], ...}`` by the names of the 68 landmarks, or the 68 themselves
in the order of Multi-PIE, ``[[x, y, z], ...]``, also under ``"landmarks"`` or ``"points"``. Coordinates are
the head object's own.
"""

import json
import os

from .landmarks import FACE
from .refused import Refused, first

MOST_BYTES = 1024 * 1024
LEAST = 3


def load(path, known):
    """{name: (x, y, z)} of the landmarks in a file that are ``known`` by name; Refused where it is none."""
    if not os.path.isfile(path):  # a pipe or a device would block
        raise Refused(f"Landmark file '{path}' does not exist")
    try:
        with open(path, "rb") as file:
            text = file.read(MOST_BYTES + 1)
        if len(text) > MOST_BYTES:
            raise Refused(f"larger than {MOST_BYTES // 2**20} MiB")
        return read(text.decode("utf-8-sig"), known)
    except OSError as error:
        raise Refused(f"Landmark file '{path}' cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, Refused) as error:
        raise Refused(f"Landmark file '{path}': {error}") from error


def read(text, known):
    """The same of the text of a file."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Refused(f"not valid JSON: {error}") from error
    if isinstance(found, dict):
        found = next((found[key] for key in ("landmarks", "points") if key in found), found)
    if isinstance(found, list):
        if len(found) != len(FACE):
            raise Refused(f"a list of {len(found)} points: expected {len(FACE)}, in the order of Multi-PIE")
        found = {mark.name: place for mark, place in zip(FACE, found, strict=True)}
    if not isinstance(found, dict):
        raise Refused("expected landmarks by name, or a list of them")
    other = [name for name in found if name not in known]
    if other:
        raise Refused(f"these are no landmarks of a face: {first(map(repr, other))}")
    wrong = [name for name, place in found.items() if not _is_place(place)]
    if wrong:
        raise Refused(f"expected three finite numbers for {first(map(repr, wrong))}")
    if len(found) < LEAST:
        raise Refused(f"{len(found)} landmarks: {LEAST} are needed at least")
    return {name: tuple(map(float, place)) for name, place in found.items()}


def _is_place(place):
    return (
        isinstance(place, list)
        and len(place) == 3
        and all(isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e30 for x in place)
    )
