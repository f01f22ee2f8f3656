"""Keys of a symmetric head, alike on both sides: what a fit has made a little of one, it has of the other."""

import itertools
from typing import NamedTuple

import numpy as np

from . import sides, topology

SAME = 1e-4  # of the head's diagonal: a vertex is so near to the mirror image of its twin
TOGETHER = 4  # vertices at one place
UNUSUAL = 0.1  # of the vertices may have none: where quads are cut otherwise, or in a scar
ROUNDS = 5  # in which these take on what is beside them


class Plane(NamedTuple):
    """Where a head is its own mirror image: ``x . normal = offset``."""

    normal: np.ndarray
    offset: float

    @classmethod
    def between(cls, points, images):
        """The nearest to taking points (n, 3) to images (n, 3), least squares."""
        a, b = points - points.mean(axis=0), images - images.mean(axis=0)
        _, vectors = np.linalg.eigh(a.T @ b + b.T @ a)
        normal = vectors[:, 0]
        return cls(normal, float((points + images).mean(axis=0) @ normal / 2))

    @classmethod
    def of_rims(cls, one, other):
        """Between two loops, (n, 3) each in order and none twice, that are each other's mirror image as one
        sees them along y, or one that is its own; None where they differ in number.
        """
        if len(one) != len(other):
            return None
        one, other = (loop if _is_counterclockwise(loop) else loop[::-1] for loop in (one, other))
        images = [np.roll(other[::-1], shift, axis=0) for shift in range(len(one))]
        planes = [cls.between(one, image) for image in images]
        off = [np.abs(plane.image(one) - image).max() for plane, image in zip(planes, images, strict=True)]
        return planes[int(np.argmin(off))]

    def image(self, points):
        """(n, 3) the mirror images of points."""
        return points - 2 * np.outer(points @ self.normal - self.offset, self.normal)

    def mirrored(self, offsets):
        """(..., 3) the mirror images of displacements."""
        return offsets - 2 * (offsets @ self.normal)[..., None] * self.normal


def _is_counterclockwise(loop):
    x, z = (loop - loop.mean(axis=0))[:, [0, 2]].T
    return (x * np.roll(z, -1) - z * np.roll(x, -1)).sum() > 0


def twins(vertices, triangles, plane):
    """(n,) the vertex at the mirror image of each of (n, 3) in a Plane, -1 where none is there; None for a
    head that is not symmetric. What belongs to none of ``triangles`` (m, 3) is left out.

    Lips that touch have vertices at one place: the normals tell which is whose.
    """
    used, size = np.unique(triangles), np.linalg.norm(np.ptp(vertices, axis=0))
    normals = _normals(vertices, triangles)
    images = plane.image(vertices), plane.mirrored(normals)
    found = _nearest((vertices[used], normals[used]), [rows[used] for rows in images], SAME * size)
    if (found < 0).sum() > UNUSUAL * len(used):
        return None
    number = np.full(len(vertices), -1)
    number[used] = np.where(found < 0, -1, used[found])
    return number


def _normals(vertices, triangles):
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    sums = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], np.cross(b - a, c - a))
    return sums / np.maximum(np.linalg.norm(sums, axis=1), 1e-300)[:, None]


def _nearest(those, images, within):
    """(n,) which of those, points (n, 3) and normals (n, 3), is within a distance of each of the images, by
    its normal where several are; -1 where none is.
    """
    found, least = np.full(len(those[0]), -1), np.full(len(those[0]), np.inf)
    # Cells on which either or its neighbour lies: places that are nearly the same share one of eight grids.
    for shift in itertools.product((0, 0.5), repeat=3):
        cells = [np.floor(points[0] / (4 * within) + shift).astype(np.int64) for points in (those, images)]
        own, theirs = (cell @ [73856093, 19349663, 83492791] for cell in cells)
        order = np.argsort(own, kind="stable")
        first = np.searchsorted(own[order], theirs)
        for further in range(TOGETHER):
            place = order[np.minimum(first + further, len(order) - 1)]
            away, otherwise = (
                np.linalg.norm(some[place] - image, axis=1) for some, image in zip(those, images, strict=True)
            )
            off = np.where(away < within, away / within + otherwise, np.inf)
            better = off < least
            found[better], least[better] = place[better], off[better]
    return found


def alike(names, offsets, twins, plane, triangles):
    """``offsets`` (k, n, 3) of keys by name, each the mean of it and the mirror image of its counterpart.

    What has no twin goes with what is beside it, by ``triangles`` (m, 3).
    """
    place = {name: number for number, name in enumerate(names)}
    other = [place.get(sides.swapped(name), number) for number, name in enumerate(names)]
    own, lost = np.flatnonzero(twins >= 0), twins < 0
    changes = np.zeros_like(offsets)
    changes[:, own] = (plane.mirrored(offsets[other][:, twins[own]]) - offsets[:, own]) / 2
    edges = topology.edges(triangles)[0]
    edges = np.concatenate([edges, edges[:, ::-1]])
    to, beside = edges[lost[edges[:, 0]]].T
    alone, place = np.unique(to, return_inverse=True)
    for _ in range(ROUNDS if len(alone) else 0):
        sums = np.zeros((len(alone), len(offsets), 3))
        np.add.at(sums, place, changes[:, beside].swapaxes(0, 1))
        changes[:, alone] = (sums / np.bincount(place)[:, None, None]).swapaxes(0, 1)
    return offsets + changes
