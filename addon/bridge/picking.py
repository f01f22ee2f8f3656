"""Surfaces and marks under the mouse."""

from dataclasses import dataclass

import bmesh
import bpy
from bpy_extras import view3d_utils
from mathutils.bvhtree import BVHTree

REACH = 12  # pixels: so near to a mark the mouse is on it


@dataclass
class Picking:
    """The half of a pair that is picked so far: a side and a vertex, or None and -1."""

    side: str | None = None
    vertex: int = -1


class Surface:
    """A mesh object as it is shown now; of modifiers that change its vertices nothing is seen."""

    def __init__(self, obj, depsgraph):
        self._obj, self._tree = obj.evaluated_get(depsgraph), None
        self._mesh = shown_mesh(obj, depsgraph)
        if self._mesh == obj.data:
            edit = bmesh.new()
            edit.from_mesh(obj.data)
            self._tree = BVHTree.FromBMesh(edit)
            edit.free()

    def hit(self, origin, direction):
        """(distance, vertex) where a ray of the world first meets the surface, or None."""
        matrix = self._obj.matrix_world
        back = matrix.inverted_safe()
        start, way = back @ origin, back.to_3x3() @ direction
        if self._tree is None:
            place, face = self._obj.ray_cast(start, way)[1::2]
        else:
            place, _, face, _ = self._tree.ray_cast(start, way)
        if place is None or face in (None, -1):
            return None
        vertices = self._mesh.vertices
        nearest = min(
            self._mesh.polygons[face].vertices,
            key=lambda vertex: (vertices[vertex].co - place).length_squared,
        )
        return (matrix @ place - origin).length, nearest


def shown_mesh(obj, depsgraph):
    """The evaluated mesh of an object, or its own where modifiers change its vertices, or in edit mode."""
    found = obj.evaluated_get(depsgraph).data
    same = obj.mode == "OBJECT" and len(found.vertices) == len(obj.data.vertices)
    return found if same else obj.data


def view_under(window, x, y):
    """(region, its 3D view's data, x and y in it) under the mouse, or None."""
    for area in window.screen.areas:
        inside = [
            region
            for region in area.regions
            if region.width > 1 and 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
        ]
        if area.type == "VIEW_3D" and inside and all(region.type == "WINDOW" for region in inside):
            region = inside[0]
            return region, region.data, (x - region.x, y - region.y)
    return None


def ray(region, view, spot):
    """(origin, direction) in the world."""
    return (
        view3d_utils.region_2d_to_origin_3d(region, view, spot),
        view3d_utils.region_2d_to_vector_3d(region, view, spot),
    )


def on_screen(obj, vertex, mesh, region, view):
    """(x, y) of a vertex in a view, or None where it is outside of it or turned away."""
    if vertex >= len(mesh.vertices):
        return None
    point = mesh.vertices[vertex]
    place = obj.matrix_world @ point.co
    normal = obj.matrix_world.inverted_safe().to_3x3().transposed() @ point.normal
    eye = view.view_matrix.inverted_safe().translation
    toward = eye - place if view.is_perspective else view.view_matrix.to_3x3()[2]
    if normal.dot(toward) < 0:
        return None
    return view3d_utils.location_3d_to_region_2d(region, view, place)


def ui_scale():
    """Pixels a unit of the interface has."""
    return bpy.context.preferences.system.ui_scale
