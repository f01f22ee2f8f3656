"""The Empties that stand for handles."""

import bpy
import numpy as np
from mathutils import Matrix

from ..core import space


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
    space.linear_part(obj.matrix_world, obj.name)
    return np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64)) @ np.array(empty.matrix_world)


def place(obj, empty, matrix):
    """Moves the Empty to a matrix (4, 4) given in the coordinates of the object."""
    empty.matrix_world = obj.matrix_world @ Matrix(matrix)


def is_alive(empty):
    """True where the Empty is in some scene: Blender keeps deleted objects that are still referred to."""
    return empty is not None and len(empty.users_scene) > 0
