"""What mirrors a mesh object: its Mirror modifiers, which make the other half, and the artist's wish."""

import numpy as np

from ..core import space
from ..core.mirrors import AXES, Mirrors
from ..core.refused import Refused
from .meshes import rest_positions

HALF = 0.1  # of its extent beyond the plane, and less: a neck's rim need not lie on it


def of(obj, linear, symmetry="OFF"):
    """core.mirrors.Mirrors of an object in solve space; ``symmetry`` is "OFF" or an axis."""
    modifiers = taken(obj)
    axes = sorted({axis for modifier in modifiers for axis in range(3) if modifier.use_axis[axis]})
    merging = [modifier.merge_threshold for modifier in modifiers if modifier.use_mirror_merge]
    asked = [AXES.index(symmetry)] if symmetry != "OFF" else []
    planes = {axis: space.mirror_normal(linear, axis, obj.name) for axis in {*axes, *asked}}
    reach = max((float(np.linalg.norm(linear[:, axis])) for axis in axes), default=1.0)
    return Mirrors(
        mirror=tuple(planes[axis] for axis in axes),
        symmetry=tuple(planes[axis] for axis in asked if axis not in axes),
        distance=max(merging) * reach if merging else None,
    )


def taken(obj):
    """The Mirror modifiers of an object that make the half of it that is posed along."""
    return [modifier for modifier in _shown(obj) if not _reason(modifier)]


def left_out(obj):
    """Warnings about Mirror modifiers whose seams are not kept together."""
    return [
        f"Mirror modifier '{m.name}' {_reason(m)}, or its seam may open" for m in _shown(obj) if _reason(m)
    ]


def refuse_half(obj):
    """Refused where a Mirror modifier makes the other half of an object: each key would be of both."""
    points = rest_positions(obj.data)
    for modifier in taken(obj):
        for axis in np.flatnonzero(modifier.use_axis):
            low, high = points[:, axis].min(), points[:, axis].max()
            if max(low, -high) > -HALF * (high - low):
                raise Refused(
                    f"'{obj.name}' is one half, and its modifier '{modifier.name}' makes the other: "
                    "apply that first, or each key moves both sides"
                )


def _shown(obj):
    return [m for m in obj.modifiers if m.type == "MIRROR" and m.show_viewport and any(m.use_axis)]


def _reason(modifier):
    """What to do about a modifier that is not taken, or ""."""
    if modifier.mirror_object is not None:
        return f"mirrors about '{modifier.mirror_object.name}': clear its Mirror Object"
    if any(map(np.logical_and, modifier.use_axis, modifier.use_bisect_axis)):
        return "bisects the mesh: turn off Bisect"
    return ""
