"""The landmarks that a mesh object bears by name, whatever it is paired with."""

import numpy as np

from ..core import marker_places
from ..core.landmarks import SETS, is_own_name
from ..core.surface import Point
from .meshes import surface

SAME = 1e-5  # of the diagonal: a point this near to where it was is where it was


def keep(obj, pairs, side):
    """Has a mesh object remember those of the pairs that have names, as they lie on its side."""
    if obj.library is not None or not obj.is_editable:
        return
    for marker in pairs:
        if marker.guessed or marker.place(side) is None or not is_own_name(marker.name):
            continue
        row = obj.lissom_landmarks.get(marker.name)
        if row is None:
            row = obj.lissom_landmarks.add()
            row.name = marker.name
        point = marker.point(side)
        row.corners, row.weights, row.place = point.corners, point.weights, marker.place(side)


def of(obj):
    """{name: Point} of a mesh object, found again by their places where it was remodelled since."""
    rows = list(obj.lissom_landmarks)
    if not rows or not len(obj.data.polygons):
        return {}
    vertices, triangles = surface(obj)
    points = [Point.of(row.corners, row.weights) for row in rows]
    places = np.array([tuple(row.place) for row in rows])
    kept = [
        max(point.corners) < len(vertices)
        and np.linalg.norm(point.position(vertices) - place) <= SAME * marker_places.diagonal(vertices)
        for point, place in zip(points, places, strict=True)
    ]
    if not all(kept):
        again = marker_places.found_again(vertices, triangles, places)
        points = [point if same else new for point, same, new in zip(points, kept, again, strict=True)]
    return {row.name: point for row, point in zip(rows, points, strict=True) if point is not None}


def names(settings):
    """The names of the set that is to be marked, in their order; those of "OWN" are what the source bears."""
    if settings.landmarks == "OWN":
        return [row.name for row in settings.source.lissom_landmarks] if settings.source else []
    return [landmark.name for landmark in SETS.get(settings.landmarks, ())]
