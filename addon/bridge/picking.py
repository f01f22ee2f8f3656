"""What is under the mouse: marks, rims and surfaces of the source and the target."""

from typing import NamedTuple

import bmesh
import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ..core.picking import BESIDE_RIM, MARK_REACH, RIM_REACH, View, grabbed, near_edges
from ..core.refused import Refused
from ..core.surface import Point, closest
from .markers import SIDES, marks_of
from .meshes import positions, rims
from .sight import Sight

CURLED = -0.35  # cosine: faces that curl in at a rim may look so far away from the eye
OTHER_SHAPE = 0.1  # of an object's size: modifiers that make other vertices move the surface by less


class Pane(NamedTuple):
    """A region of a 3D view under the mouse, and where in it."""

    area: bpy.types.Area
    region: bpy.types.Region
    space: bpy.types.SpaceView3D
    spot: tuple[int, int]

    @property
    def view(self):
        """As core.picking.View."""
        return view_of(self.region, self.region.data)


def view_of(region, data):
    """A region and its 3D view's data as core.picking.View."""
    return View(np.array(data.perspective_matrix, dtype=np.float64), (region.width, region.height))


def pane_under(window, x, y):
    """The Pane under the mouse, or None."""
    for area in window.screen.areas:
        inside = [
            region
            for region in area.regions
            if region.width > 1 and 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
        ]
        if area.type == "VIEW_3D" and inside and all(region.type == "WINDOW" for region in inside):
            region = inside[0]
            return Pane(area, region, area.spaces.active, (x - region.x, y - region.y))
    return None


def shown_mesh(obj, depsgraph):
    """The evaluated mesh of an object, or its own where modifiers change its vertices, or in edit mode."""
    found = obj.evaluated_get(depsgraph).data
    same = obj.mode == "OBJECT" and len(found.vertices) == len(obj.data.vertices)
    return found if same else obj.data


class Stage:
    """Source and target as one view shows them now; made anew for every look.

    ``begun``: the core.picking.Picking whose half of a pair is shown with the marks of the scene, or None.
    """

    def __init__(self, scene, depsgraph, view, space, begun=None):
        settings = scene.lissom_transfer
        self._scene, self._view, self._begun = scene, view, begun
        self._sight = Sight(scene, depsgraph, space)
        self._ends = {side: getattr(settings, side) for side in SIDES}
        self._ends = {side: obj for side, obj in self._ends.items() if obj and self._sight.shows(obj)}
        self._meshes = {side: shown_mesh(obj, depsgraph) for side, obj in self._ends.items()}

    def marks(self, behind=True):
        """[(Mark, (x, y), hidden)] of all marks that lie in the view.

        Without ``behind`` those that are turned away alone are hidden: a look at what is in front searches
        each surface anew that has moved.
        """
        return [(mark, spot, self._hidden(mark, behind)) for mark, spot in self._placed()]

    def mark_at(self, mouse, scale):
        """(Mark, (x, y)) of the mark under the mouse, with so many pixels a unit, or None."""
        reach = MARK_REACH * scale
        near = [entry for entry in self._placed() if np.hypot(*np.subtract(entry[1], mouse)) <= reach]
        hidden = [self._hidden(mark) for mark, _ in near]
        number = grabbed([spot for _, spot in near], hidden, mouse)
        return None if number is None else near[number]

    def point_at(self, mouse, scale, exact=False, only=None):
        """(side, Point, (x, y)) of the place under the mouse, drawn to a rim that is near, or None.

        ``exact`` draws it only where nothing else is under the mouse; ``only`` looks at one side. Refused on
        the inside of a mesh.
        """
        seen, side = self._under(mouse)
        rim = self._rim_at(mouse, scale, exact, side, only)
        if rim is not None:
            return rim
        if side is not None and only in (None, side):
            point = self._point(side, seen)
            return None if point is None else (side, point, mouse)
        if only is None and seen and seen.itself and seen.obj in self._ends.values():
            raise Refused(
                f"That is the inside of '{seen.obj.name}', seen through an opening: click its outside. "
                "If it is the outside, its normals point inwards: Mesh > Normals > Recalculate Outside"
            )
        return None

    def rim_at(self, mouse, scale, exact=False):
        """As ``point_at``, of rims alone."""
        return self._rim_at(mouse, scale, exact, self._under(mouse)[1], None)

    def ring_at(self, mouse, scale, exact=False):
        """(x, y) of the mark or the rim that a click would take, or None; ``exact`` takes no mark."""
        found = (None if exact else self.mark_at(mouse, scale)) or self.rim_at(mouse, scale, exact)
        return found and found[-1]

    def _under(self, mouse):
        """What is Seen under the mouse, and the side whose outside it is, or None."""
        (origin,), (direction,) = self._view.rays([mouse])
        seen = self._sight.along(origin, direction)
        sides = [side for side, obj in self._ends.items() if seen and seen.obj == obj]
        return seen, sides[0] if sides and seen.front and seen.itself else None

    def _placed(self):
        places = [(mark, self._place(mark)) for mark in marks_of(self._scene, self._begun)]
        places = [(mark, place) for mark, place in places if place is not None]
        if not places:
            return []
        spots, _ = self._view.project(np.array([place for _, place in places]))
        within = ((spots >= 0) & (spots < self._view.size)).all(axis=1)  # not a number is not
        return [
            (mark, tuple(spot))
            for (mark, _), spot, shown in zip(places, spots.tolist(), within, strict=True)
            if shown
        ]

    def _place(self, mark):
        """(3,) in the world, or None where the side is not seen or has no such vertices."""
        mesh = self._meshes.get(mark.side)
        if mesh is None or max(mark.point.corners) >= len(mesh.vertices):
            return None
        return self._ends[mark.side].matrix_world @ self._mean(mark, "co")

    def _mean(self, mark, what):
        return mean_of(self._meshes[mark.side], mark.point, what)

    def _hidden(self, mark, behind=True):
        obj, place = self._ends[mark.side], self._place(mark)
        normal = of_normals(obj) @ self._mean(mark, "normal")
        if self._facing(place, normal) < 0:
            return True
        return behind and self._sight.hides(self._view, place, obj.dimensions.length)

    def _facing(self, place, normal):
        """The cosine between a normal and the way to the eye."""
        (origin,), _ = self._view.rays(self._view.project(np.array([place]))[0])
        return normal.normalized().dot((Vector(origin) - place).normalized())

    def _rim_at(self, mouse, scale, exact, under, only):
        if under is not None and exact:
            return None
        reach = RIM_REACH * scale * (BESIDE_RIM if under else 1.0)
        for side in [under] if under else self._ends:
            if only not in (None, side):
                continue
            obj, mesh = self._ends[side], self._meshes[side]
            edges, faces = rims(mesh)
            if not len(edges):
                continue
            matrix = np.array(obj.matrix_world, dtype=np.float64)
            ends = positions(mesh.vertices)[edges] @ matrix[:3, :3].T + matrix[:3, 3]
            outward = of_normals(obj)
            for edge, share in near_edges(self._view, ends, mouse, reach):
                place = Vector((1 - share) * ends[edge, 0] + share * ends[edge, 1])
                facing = self._facing(place, outward @ mesh.polygons[int(faces[edge])].normal)
                if facing < CURLED or self._sight.hides(self._view, place, obj.dimensions.length):
                    continue
                a, b = edges[edge].tolist()
                spot = tuple(self._view.project(np.array([place]))[0][0].tolist())
                return side, Point.of((a, b, a), (1 - share, share, 0)), spot
        return None

    def _point(self, side, seen):
        obj, mesh = self._ends[side], self._meshes[side]
        place, face = obj.matrix_world.inverted_safe() @ seen.place, seen.face
        if mesh == obj.data:  # as other vertices are shown
            place, face = _nearest(obj.data, place)
            if face is None:
                return None
        mesh.calc_loop_triangles()
        polygon = mesh.polygons[face]
        first = polygon.loop_start - 2 * face  # a face of k corners has k - 2 triangles
        corners = [mesh.loop_triangles[first + i].vertices for i in range(polygon.loop_total - 2)]
        names, rows = np.unique(np.array(corners), return_inverse=True)
        vertices = np.array([mesh.vertices[name].co for name in names.tolist()])
        (point,), _ = closest(vertices, rows.reshape(-1, 3), [np.array(place)])
        return Point.of([names[corner] for corner in point.corners], point.weights)


def _nearest(mesh, place):
    """(place, face) of a mesh nearest to a place that modifiers show, or (None, None) where that is far."""
    edit = bmesh.new()
    edit.from_mesh(mesh)
    tree = BVHTree.FromBMesh(edit)
    edit.free()
    size = np.linalg.norm(np.ptp(positions(mesh.vertices), axis=0))
    found, _, face, _ = tree.find_nearest(place, OTHER_SHAPE * size)
    return found, face


def ui_scale():
    """Pixels a unit of the interface has."""
    return bpy.context.preferences.system.ui_scale


def mean_of(mesh, point, what):
    """The mean of what a mesh's vertices have, "co" or "normal", at a core.surface.Point."""
    parts = zip(point.corners, point.weights, strict=True)
    return sum((weight * getattr(mesh.vertices[corner], what) for corner, weight in parts), Vector((0, 0, 0)))


def of_normals(obj):
    """The matrix that takes an object's normals to the world."""
    return obj.matrix_world.inverted_safe().to_3x3().transposed()
