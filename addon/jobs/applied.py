"""A bound object keeps its pose where its transforms are applied or its origin is set.

Blender then moves the vertices one way in the object's coordinates and the object the other way, so that
nothing moves in the scene. What Bind wrote down in these coordinates has to go along with the vertices.
"""

import numpy as np
from mathutils import Euler, Matrix

from .. import session
from ..bridge import shape_keys
from ..core import space
from ..core.pose import PROBES


def note(obj):
    """Remembers where the vertices of a bound object are in its coordinates, and where it is itself."""
    probes = np.float32(shape_keys.probes(obj.data, PROBES)).ravel()
    if not np.array_equal(probes, obj.lissom_pose.probes):  # to write it is to have the object evaluated
        obj.lissom_pose.probes = probes
    session.worlds[obj.session_uid] = np.array(obj.matrix_world)


def follow(obj):
    """Takes what Bind wrote down along with the vertices, where these and the object moved since ``note``."""
    before = session.worlds.get(obj.session_uid)
    known = np.array(obj.lissom_pose.probes).reshape(-1, 3)
    change = None
    if before is not None:
        change = space.applied(before, np.array(obj.matrix_world), known, shape_keys.probes(obj.data, PROBES))
    if change is not None:
        _carry(obj, change)
    note(obj)


def _carry(obj, change):
    settings, world = obj.lissom_pose, np.array(obj.matrix_world)
    bound = session.poses.pop(obj.session_uid, None)
    beyond = bound.beyond_half_a_turn() if bound else np.zeros(len(settings.handles), dtype=bool)
    settings.linear = world[:3, :3].ravel()
    for handle, keep in zip(settings.handles, beyond, strict=True):
        rest = change @ np.array(handle.rest).reshape(4, 4)
        handle.rest = rest.ravel()
        empty = handle.empty
        if empty is None or empty.parent != obj:
            continue
        # Blender keeps a child in its place by other channels: those that it would have at rest.
        placed = obj.matrix_world @ empty.matrix_parent_inverse
        basis = placed.inverted_safe() @ Matrix(world @ rest)
        if handle.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
            handle.rotation_mode = ""  # whole turns can no longer be told from the channels
        elif handle.rotation_mode:
            mode = handle.rotation_mode
            near = Euler(handle.rotation[1:], mode) if keep else empty.rotation_euler
            handle.rotation = (0.0, *basis.to_euler(mode, near))


def bound_mesh(obj):
    """True for a mesh object that is bound."""
    return obj.type == "MESH" and obj.lissom_pose.bound and len(obj.data.vertices) > 0
