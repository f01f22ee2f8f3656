"""Mirror planes of a mesh in solve space, as options of lissom."""

from typing import NamedTuple

import numpy as np

AXES = ("X", "Y", "Z")

SYMMETRIES = (
    ("OFF", "Off", "Every handle moves its own side only"),
    *(
        (axis, axis, f"Handles on the side of +{axis} lead, the other side of the mesh mirrors them")
        for axis in AXES
    ),
)


class Mirrors(NamedTuple):
    """Planes through the object's origin, by their normals (3,) as tuples."""

    mirror: tuple = ()  # the mesh is a half, and these make the whole
    symmetry: tuple = ()  # the mesh is whole, and moves alike on both sides
    distance: float | None = None  # vertices so near to their mirror image are joined with it

    def half(self, vertices):
        """Options of lissom.Inbetween, which completes halves; ``vertices`` (n, 3)."""
        options = {"mirror": [((0.0, 0.0, 0.0), normal) for normal in self.mirror]}
        if self.mirror and self.distance is not None:
            extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
            options["mirror_tolerance"] = self.distance / extent if extent else 0.0
        return options

    def pose(self, vertices):
        """Options of lissom.Pose."""
        return self.half(vertices) | {"symmetry": [((0.0, 0.0, 0.0), normal) for normal in self.symmetry]}


NONE = Mirrors()
