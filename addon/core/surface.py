"""Points on a surface of triangles: they go with it when it deforms."""

from typing import NamedTuple

import lissom
import numpy as np

DIGITS = 6  # of a weight: those that single precision keeps, so that scene and file have the same
SNAP = 1e-4  # weight of the other corners below which a point is at a vertex


class Point(NamedTuple):
    """Three vertices of one face and what each counts, at least 0, 1 together.

    There is one Point of one place: at a vertex all three are that one, and the first counts; on an edge the
    last is again the first.
    """

    corners: tuple[int, int, int]
    weights: tuple[float, float, float]

    @classmethod
    def at(cls, vertex):
        """The point at a vertex."""
        return cls((vertex,) * 3, (1.0, 0.0, 0.0))

    @classmethod
    def of(cls, corners, weights):
        """The point of three corners by any weights, at least 0, not all 0."""
        shares = np.asarray(weights, dtype=np.float64)
        shares = shares / shares.sum()
        heaviest = int(shares.argmax())
        if shares[heaviest] > 1 - SNAP:
            return cls.at(int(corners[heaviest]))
        kept = sorted(
            (int(corner), round(float(share), DIGITS)) for corner, share in zip(corners, shares, strict=True)
        )
        kept = [(corner, share) for corner, share in kept if share > SNAP / 3]
        kept += [(kept[0][0], 0.0)] * (3 - len(kept))
        corners, weights = zip(*kept, strict=True)
        rest = 1 - sum(weights)  # what rounding took
        return cls(corners, (round(weights[0] + rest, DIGITS), *weights[1:]))

    @property
    def is_vertex(self):
        """Whether it is at a vertex."""
        return self.weights[0] == 1.0

    @property
    def vertex(self):
        """The corner that counts most."""
        return self.corners[int(np.argmax(self.weights))]

    def position(self, vertices):
        """(3,): where it is with the surface's vertices at (n, 3)."""
        if self.is_vertex:
            return vertices[self.corners[0]].copy()
        return np.array(self.weights) @ vertices[list(self.corners)]


def closest(vertices, triangles, places):
    """The points of a surface nearest to (k, 3) places: a list of Point, and (k,) distances.

    ``vertices`` (n, 3), ``triangles`` (m, 3), at least one.
    """
    found, weights, away = lissom.closest_points(vertices, triangles, places)
    return [Point.of(*point) for point in zip(triangles[found].tolist(), weights, strict=True)], away
