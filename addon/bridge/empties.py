"""The Empties that stand for handles."""

import math

import bpy
import numpy as np
from lissom import nearest_rotations
from mathutils import Euler, Matrix

from ..core import space, turns
from . import views

STEP = 0.2  # radians between looks along the way of a channel
MOST_STEPS = 4096


def add(obj, name, centre, size):
    """An Empty at ``centre`` (object coordinates), child of the object but for the object's scale.

    Under a scaled parent a turned child is sheared; the parent inverse takes the scale out again, so that a
    turned handle stays a rotation.
    """
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = size
    empty.show_in_front = True
    for collection in obj.users_collection:
        collection.objects.link(empty)
    views.show_along(obj, empty)
    empty.lissom_handle_of = obj
    empty.parent = obj
    world = obj.matrix_world
    location, rotation, _ = world.decompose()
    rigid = Matrix.LocRotScale(location, rotation, None)
    empty.matrix_parent_inverse = world.inverted() @ rigid
    empty.matrix_basis = Matrix.Translation(rigid.inverted() @ (world @ centre))
    return empty


def matrix_in(obj, empty):
    """The Empty's matrix in the coordinates of the object, (4, 4); Refused where that has none (row 36)."""
    return matrices_in(obj, [empty])[0]


def matrices_in(obj, empties):
    """The same of several Empties, (h, 4, 4)."""
    space.linear_part(obj.matrix_world, obj.name)
    placed = np.array([empty.matrix_world for empty in empties], dtype=np.float64).reshape(-1, 4, 4)
    return np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64)) @ placed


def channels(empty):
    """Rotation mode, and four numbers: what the mode keeps, as far as it can hold whole turns."""
    mode = empty.rotation_mode
    if mode == "AXIS_ANGLE":
        return mode, tuple(empty.rotation_axis_angle)
    return mode, (0.0, 0.0, 0.0, 0.0) if mode == "QUATERNION" else (0.0, *empty.rotation_euler)


def told_turn(obj, empty, mode, values, linear, transform):
    """(3,) in solve space: how far the Empty turned since its channels had ``mode`` and ``values``.

    ``linear`` (3, 3) leads from object coordinates to solve space. None where the channels do not tell, or
    are not what led to ``transform``, (4, 4) in solve space.
    """
    now_mode, now = channels(empty)
    if now_mode != mode or mode == "QUATERNION":
        return None
    rest, now = np.array(values), np.array(now)
    if mode == "AXIS_ANGLE":
        axis = now[1:]
        if abs(now[0] - rest[0]) <= math.pi or (rest[0] and not np.allclose(axis, rest[1:], atol=1e-4)):
            return None
        at = [Matrix.Rotation(angle, 3, axis) for angle in _ramp(rest[0], now[0])]
    else:
        if not turns.is_told_by_angles(now[1:] - rest[1:]):
            return None
        at = [Euler(angles, mode).to_matrix() for angles in _ramp(rest[1:], now[1:])]
    placed = matrix_in(obj, empty) @ np.array(empty.matrix_basis.inverted_safe())
    rotation = nearest_rotations(transform[:3, :3])
    return turns.explained(np.array(at), linear @ placed[:3, :3], rotation)


def _ramp(start, end):
    steps = math.ceil(float(np.abs(end - start).max()) / STEP)
    return np.linspace(start, end, min(steps, MOST_STEPS) + 1)


def place(obj, empty, matrix):
    """Moves the Empty to a matrix (4, 4) given in the coordinates of the object."""
    empty.matrix_world = obj.matrix_world @ Matrix(matrix)


def is_alive(empty):
    """True where the Empty is in some scene: Blender keeps deleted objects that are still referred to."""
    return empty is not None and len(empty.users_scene) > 0
