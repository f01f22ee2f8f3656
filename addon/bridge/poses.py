"""Between a bound mesh object, with its handles' Empties, and the native pose that is kept in the session."""

import numpy as np

from .. import session
from ..core import space
from ..core.pose import BoundPose, check_groups
from ..core.refused import Refused, first
from . import empties, groups, meshes, shape_keys


def build(obj, linear, method):
    """A BoundPose of the object's rest shape; handles and region are read from its vertex groups."""
    settings = obj.lissom_pose
    names = [handle.name for handle in settings.handles]
    found = groups.members(obj, [*names, settings.roi])
    check_groups(found, names, settings.roi)
    return BoundPose(
        space.into(linear, meshes.rest_positions(obj.data)),
        space.outward(linear, meshes.triangles(obj.data)),
        meshes.corners(obj.data),
        [found[name] for name in names],
        found[settings.roi] if settings.roi else None,
        method,
    )


def current(obj):
    """The bound pose of the object: the one in memory while it holds, else made anew.

    That happens after loading a file, or where rest shape or method were changed. New faces need a new
    Bind (row 26).
    """
    settings = obj.lissom_pose
    if not settings.bound:
        raise Refused(f"'{obj.name}' is not bound: press Bind first")
    linear = linear_part(obj)
    known = session.poses.get(obj.session_uid)
    if known is not None:
        rest = space.into(linear, meshes.rest_positions(obj.data))
        if known.fits(rest, meshes.corners(obj.data), settings.method):
            return known
    if meshes.signature(obj.data) != settings.topology:
        raise Refused(f"The mesh of '{obj.name}' was remodelled since Bind: press Unbind, then Bind")
    made = session.poses[obj.session_uid] = build(obj, linear, settings.method)
    made.forget()
    return made


def linear_part(obj):
    """The (3, 3) part of the object's matrix that was applied at Bind."""
    return np.array(obj.lissom_pose.linear, dtype=np.float64).reshape(3, 3)


def preview(obj):
    """The shape key that shows the live pose."""
    keys = obj.data.shape_keys
    key = keys.key_blocks.get(obj.lissom_pose.preview) if keys else None
    if key is None:
        raise Refused(
            f"Shape key '{obj.lissom_pose.preview}', which shows the pose, was removed or renamed: "
            "press Unbind, then Bind"
        )
    return key


def alive_handles(obj):
    """The handles of the object; Refused where an Empty was deleted."""
    handles = obj.lissom_pose.handles
    lost = [handle.name for handle in handles if not empties.is_alive(handle.empty)]
    if lost:
        raise Refused(
            f"The Empty of handle {first(repr(name) for name in lost)} was deleted: "
            "undo that, or unbind, remove the handle and add it again"
        )
    return handles


def transforms(obj):
    """(h, 4, 4): rest -> posed of every handle, in solve space."""
    handles = alive_handles(obj)
    rest = np.array([handle.rest for handle in handles], dtype=np.float64).reshape(-1, 4, 4)
    posed = np.array([empties.matrix_in(obj, handle.empty) for handle in handles])
    return space.handle_transforms(linear_part(obj), rest, posed)


def show(obj, vertices):
    """Writes (n, 3) solved positions to the preview key."""
    shape_keys.write_points(preview(obj), space.back(linear_part(obj), vertices))


def place_at_rest(obj):
    """Puts every handle's Empty back where it was at Bind."""
    for handle in obj.lissom_pose.handles:
        if empties.is_alive(handle.empty):
            empties.place(obj, handle.empty, np.array(handle.rest).reshape(4, 4))


def reset(obj):
    """Handles and preview at rest."""
    place_at_rest(obj)
    shape_keys.write_points(preview(obj), meshes.rest_positions(obj.data))
    if obj.session_uid in session.poses:
        session.poses[obj.session_uid].put_to_rest()
