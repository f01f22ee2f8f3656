"""Where the landmark that is asked for is to be expected on source or target, as they are shown."""

from typing import NamedTuple

import numpy as np
from mathutils import Vector

from ..core import expected
from ..core.landmarks import SETS
from . import landmarks
from .markers import SIDES, of_scene
from .picking import mean_of, of_normals, shown_mesh


class Spot(NamedTuple):
    """A place of a surface in the world, the way out of it (3,), and how far around it one wants to see."""

    place: np.ndarray
    outward: np.ndarray
    reach: float

    @property
    def corners(self):
        """(8, 3): of the box to look at."""
        signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
        return self.place + self.reach * signs


def spots(scene, depsgraph, wanted):
    """{side: Spot} of a landmark, on the sides where what they bear already tells."""
    settings = scene.lissom_transfer
    ends = {side: getattr(settings, side) for side in SIDES}
    marks = {side: _borne(scene, depsgraph, side, obj) for side, obj in ends.items()}
    picture = {
        one.name: np.array([(*one.spot, 0.0), (0.0, 0.0, 1.0)]) for one in SETS.get(settings.landmarks, ())
    }
    found = {}
    for (side, other), obj in zip((SIDES, SIDES[::-1]), ends.values(), strict=True):
        place = expected.expected(wanted, marks[side], [marks[other], picture])
        if place is not None:
            places = np.array([mark[0] for mark in marks[side].values()])
            found[side] = _on(obj.evaluated_get(depsgraph), place, places)
    return {side: spot for side, spot in found.items() if spot is not None}


def _borne(scene, depsgraph, side, obj):
    """{name: (2, 3)}: places and normals in the world of the named landmarks of a side."""
    points = landmarks.of(obj)
    for marker in of_scene(scene):
        if marker.name and not marker.guessed:
            points[marker.name] = marker.point(side)
    mesh, outward = shown_mesh(obj, depsgraph), of_normals(obj)
    place = obj.matrix_world
    return {
        name: np.array([place @ mean_of(mesh, point, "co"), outward @ mean_of(mesh, point, "normal")])
        for name, point in points.items()
        if max(point.corners) < len(mesh.vertices)
    }


def _on(shown, place, marks):
    """The Spot of the surface of an evaluated object nearest to a place in the world."""
    found, near, normal, _ = shown.closest_point_on_mesh(shown.matrix_world.inverted_safe() @ Vector(place))
    if not found:  # no faces
        return None
    outward = of_normals(shown) @ normal
    reach = expected.reach(marks, shown.dimensions.length)
    return Spot(np.array(shown.matrix_world @ near), np.array(outward.normalized()), reach)
