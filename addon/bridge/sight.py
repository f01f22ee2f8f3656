"""What a 3D view shows along a ray: every visible object hides what is behind it."""

from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Vector

BESIDE = 1e-3  # of an object's size: this far before a place nothing hides it
THROUGH = 64  # surfaces along a ray that are not shown


class Seen(NamedTuple):
    """The first thing along a ray: whether it is the front of a face, and the object itself, no instance."""

    obj: bpy.types.Object
    place: Vector
    face: int
    front: bool
    itself: bool


class Sight:
    """The scene as one 3D view, ``space``, shows it; by None as the view layer does."""

    def __init__(self, scene, depsgraph, space):
        self._scene, self._depsgraph, self._space = scene, depsgraph, space
        self._culls = space is not None and space.shading.show_backface_culling

    def shows(self, obj):
        """Whether an object is there to be seen."""
        return obj.visible_get(viewport=self._space) if self._space else obj.visible_get()

    def along(self, origin, direction, limit=1e30):
        """The first Seen from ``origin`` along a unit ``direction``, not beyond ``limit``, or None."""
        start, way, gone = Vector(origin), Vector(direction), 0.0
        for _ in range(THROUGH):
            if gone >= limit:
                return None
            hit, place, normal, face, obj, matrix = self._scene.ray_cast(
                self._depsgraph, start, way, distance=limit - gone
            )
            if not hit:
                return None
            front, itself = normal.dot(way) < 0, matrix == obj.matrix_world
            if self._draws(obj.original, front, itself):
                return Seen(obj.original, place, face, front, itself)
            start = place + 1e-5 * max(1.0, place.length) * way
            gone = (start - Vector(origin)).dot(way)
        return None

    def _draws(self, obj, front, itself):
        solid = obj.display_type in {"SOLID", "TEXTURED"}
        return solid and (front or not self._culls) and (not itself or self.shows(obj))

    def hides(self, view, place, size):
        """Whether something is before a place of the world (3,), on an object of this size."""
        spots, _ = view.project(np.array([place]))
        if not np.isfinite(spots).all():
            return True
        (origin,), (direction,) = view.rays(spots)
        limit = (np.array(place) - origin) @ direction - BESIDE * size
        return self.along(origin, direction, limit) is not None
