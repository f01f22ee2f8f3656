"""Points on a surface of triangles: they go with it when it deforms."""

from typing import NamedTuple

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
    centres = vertices[triangles].mean(axis=1)
    radii = np.linalg.norm(vertices[triangles] - centres[:, None], axis=2).max(axis=1)
    points, away = [], []
    for place in places:
        far = np.linalg.norm(centres - place, axis=1)
        near = np.flatnonzero(far - radii <= (far + radii).min())
        corners = vertices[triangles[near]]
        weights = closest_weights(corners, np.asarray(place, dtype=np.float64))
        distances = np.linalg.norm(np.einsum("tc,tcx->tx", weights, corners) - place, axis=1)
        best = int(distances.argmin())
        points.append(Point.of(triangles[near[best]].tolist(), weights[best]))
        away.append(distances[best])
    return points, np.array(away)


def closest_weights(corners, place):
    """(m, 3): barycentric coordinates of the point of each triangle, (m, 3, 3), nearest to a place (3,)."""
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.einsum("tcx,tcx->tc", sides, sides)
    along = np.einsum("tcx,tcx->tc", place - corners, sides) / np.where(lengths > 0, lengths, 1)
    along = np.clip(along, 0, 1)
    off = corners + along[..., None] * sides - place
    side = np.einsum("tcx,tcx->tc", off, off).argmin(axis=1)  # the nearest of the three
    rows = np.arange(len(corners))
    weights = np.zeros((len(corners), 3))
    weights[rows, side] = 1 - along[rows, side]
    weights[rows, (side + 1) % 3] = along[rows, side]
    normals = np.cross(sides[:, 0], -sides[:, 2])
    areas = np.einsum("tx,tx->t", normals, normals)
    opposite = np.cross(np.roll(sides, -1, axis=1), place - np.roll(corners, -1, axis=1))
    inner = np.einsum("tcx,tx->tc", opposite, normals) / np.where(areas > 0, areas, 1)[:, None]
    inside = (areas > 0) & (inner > 0).all(axis=1)
    weights[inside] = inner[inside]
    return weights
