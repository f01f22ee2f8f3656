"""Handles made on a mesh by a click: where the click is, the new handle, and its Empty."""

from typing import NamedTuple

import numpy as np
from bpy_extras import view3d_utils
from mathutils import Matrix, Vector

from ..core import brush, names
from ..core.refused import Refused
from . import empties, groups, meshes

REACH = 16  # pixels: so near to its Empty a click is on a handle


class Hit(NamedTuple):
    """A click on a mesh: a vertex, the place in the world, and how large a pixel is there."""

    vertex: int
    place: Vector
    pixel: float


def hit(context, obj, spot):
    """The Hit of a spot of the view, (x, y) in pixels, on what is shown of a mesh object; None beside it."""
    region, data = context.region, context.region_data
    origin = view3d_utils.region_2d_to_origin_3d(region, data, spot)
    way = view3d_utils.region_2d_to_vector_3d(region, data, spot)
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    inverse = obj.matrix_world.inverted_safe()
    start = inverse @ origin
    found, place, _, face = shown.ray_cast(start, (inverse @ (origin + way) - start).normalized())
    if not found:
        return None
    if len(shown.data.vertices) != len(obj.data.vertices):
        raise Refused(
            f"A modifier of '{obj.name}' makes other vertices: hide it in the viewport to click on the mesh"
        )
    corners = shown.data.polygons[face].vertices
    vertex = min(corners, key=lambda corner: (shown.data.vertices[corner].co - place).length_squared)
    place = obj.matrix_world @ place
    beside = view3d_utils.region_2d_to_location_3d(region, data, (spot[0] + 100, spot[1]), place)
    return Hit(int(vertex), place, (beside - place).length / 100)


def handle_at(context, obj, spot):
    """The name of the handle of an object whose Empty is at a spot of the view, or None."""
    away = {}
    for handle in obj.lissom_pose.handles:
        if empties.is_alive(handle.empty):
            place = handle.empty.matrix_world.translation
            seen = view3d_utils.location_3d_to_region_2d(context.region, context.region_data, place)
            if seen is not None:
                away[handle.name] = (seen - Vector(spot)).length
    return next((name for name in sorted(away, key=away.get) if away[name] <= REACH), None)


def handle_of(obj, vertex):
    """The name of the handle that has a vertex, or None."""
    for handle in obj.lissom_pose.handles:
        group = obj.vertex_groups.get(handle.name)
        if group and any(own.group == group.index and own.weight for own in obj.data.vertices[vertex].groups):
            return handle.name
    return None


def add(context, obj, found, radius, shapes, pin=False):
    """Makes a handle of what a brush of ``radius`` pixels touches, or a pin; returns its row in the list.

    ``shapes`` are the mesh at rest and as it is posed now, (n, 3) each in the object's own coordinates: posed
    vertices stay where they are, and the Empty begins there.
    """
    settings, (rest, posed) = obj.lissom_pose, shapes
    edges = meshes.edges(obj.data)
    scale = np.array(obj.matrix_world)[:3, :3].T
    indices, weights = brush.touched(posed @ scale, edges, found.vertex, radius * found.pixel)
    taken = groups.members(obj, [handle.name for handle in settings.handles])
    free = ~np.isin(indices, np.concatenate([*taken.values(), np.zeros(0, dtype=np.int64)]))
    indices, weights = indices[free], weights[free]
    name = names.unused("Pin" if pin else "Touch", obj.vertex_groups.keys())
    values = np.zeros(len(rest))
    values[indices] = weights
    groups.make(obj, name, values)
    size = 0.5 * radius * found.pixel or 1.0
    centre = np.average(rest[indices], axis=0, weights=weights)
    row = settings.handles.add()
    row.name, row.dragged = name, not pin
    row.empty = empties.add(obj, f"{obj.name} {name}", Vector(centre), size)
    settings.active_handle = len(settings.handles) - 1
    settings.property_unset("reach")
    if settings.bound:  # all before Blender evaluates the Empty, and the mesh follows
        row.rest = np.array(row.empty.matrix_parent_inverse @ row.empty.matrix_basis).ravel()
        row.rotation_mode, row.rotation = empties.channels(row.empty)
        moved = brush.rigid(rest[indices], posed[indices]) if len(indices) > 2 else np.eye(4)
        if not np.allclose(moved, np.eye(4), atol=1e-6):
            empties.place(obj, row.empty, moved @ np.array(row.rest).reshape(4, 4))
    context.view_layer.update()
    return row


def drag(context, empty, start, before, spot):
    """Moves an Empty in the plane of the view: by where a spot is, from the world's place ``start``."""
    now = view3d_utils.region_2d_to_location_3d(context.region, context.region_data, spot, start)
    empty.matrix_world = Matrix.Translation(now - start) @ before
