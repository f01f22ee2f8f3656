"""A range of frames that is baked, and the names of the shape keys that hold them."""

from .names import shorten
from .refused import Refused

MOST_KEYS = 10_000
MOST_FRAMES = 1_000_000


def frames(start, end, step, keys):
    """The frames in rising order; Refused where there is no such range. ``keys``: a shape key for each."""
    if end < start:
        raise Refused(f"The last frame, {end}, is before the first, {start}")
    count = (end - start) // step + 1
    if count > MOST_FRAMES:
        raise Refused(f"{count} frames are too many: raise the step, or bake in parts")
    if keys and count > MOST_KEYS:
        raise Refused(f"{count} shape keys are too many for Blender: raise the step, or bake a cache")
    return list(range(start, end + 1, step))


def key_names(name, frames):
    """The name of the shape key of each frame."""
    return [shorten(name, f" {frame:04d}") for frame in frames]
