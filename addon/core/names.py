"""Names of keys: Blender's length limit, its numbering, and what to do with a name that is taken."""

MAX_BYTES = 63  # a shape key's name is a char[64] with its terminator, counted in bytes of UTF-8

EXISTS_ITEMS = [
    ("UPDATE", "Update", "Write over what has the same name"),
    ("SKIP", "Skip", "Leave what has the same name as it is"),
    ("RENAME", "Rename", "Keep what has the same name and number the new one"),
]
EDITED_ITEMS = [
    ("KEEP", "Keep", "They stay as they are"),
    ("CARRY", "Carry Over", "The new result, with what was changed by hand on top of it"),
    ("OVERWRITE", "Overwrite", "The new result: what was changed by hand is lost"),
]


def shorten(name, suffix=""):
    """``name + suffix`` within Blender's limit; only the name is cut, and never inside a character."""
    room = MAX_BYTES - len(suffix.encode())
    return name.encode()[:room].decode(errors="ignore") + suffix


def unused(name, taken):
    """``name``, or the first of ``name.001``, ``name.002``, ... that is not in ``taken``."""
    candidate, number = shorten(name), 0
    while candidate in taken:
        number += 1
        candidate = shorten(name, f".{number:03d}")
    return candidate


def resolve(name, taken, exists):
    """The name to write a key under, or None to leave it out.

    ``exists`` says what a taken name gets: "UPDATE" writes over that key, "SKIP" leaves it as it is,
    "RENAME" numbers the new one.
    """
    name = shorten(name)
    if name not in taken or exists == "UPDATE":
        return name
    return None if exists == "SKIP" else unused(name, taken)
