"""What one sees that is wrong with a fit: where it is folded, torn, uncovered, or off."""

from typing import NamedTuple

import numpy as np

from .place_in_words import largest_piece, words

# A triangle so much longer or narrower than the usual one is torn. Of a cat on a lion by 8 markers or by 55,
# the largest piece of such is 0.04 % of the area at most; with two markers swapped it is 1.5 %.
TORN = 5.0
TORN_PART = 0.001
UNCOVERED_PART = 0.05  # of the target's area, in one piece: less is as the shapes differ
LEAST = 0.002  # of the vertices: a smaller region that is off is not worth a word


class Fault(NamedTuple):
    """A region (k,) of vertices of "source" or "target"; a ``grave`` one has to be mended."""

    kind: str
    grave: bool
    side: str
    vertices: np.ndarray
    line: str


class Side(NamedTuple):
    """The mesh of one side, (n, 3) and (m, 3), and its ``marked`` vertices with their ``names``."""

    vertices: np.ndarray
    triangles: np.ndarray
    marked: list
    names: list

    def piece(self, triangles):
        """The largest piece of some of its triangles, or None."""
        return largest_piece(triangles, len(self.vertices))

    def where(self, places):
        """Where some of its vertices, or one, are, in words."""
        at = np.atleast_2d(self.vertices[places]).mean(axis=0)
        return words(at, self.vertices, self.marked, self.names)

    def part(self, region):
        """The part of its area that lies within a region."""
        a, b, c = (self.vertices[corner] for corner in self.triangles.T)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        inside = np.zeros(len(self.vertices), dtype=bool)
        inside[region] = True
        return areas[inside[self.triangles].all(axis=1)].sum() / max(areas.sum(), np.finfo(float).tiny)


def of_fit(fit, source, target, limit, diagonal, masked=()):
    """The Faults of a fit of two Sides, the worst first.

    What is off by more than ``limit``, in the target's units as its ``diagonal``, is worth a word; ``masked``
    vertices of the target need not be covered.
    """
    found = (
        _folded(fit, source),
        _torn(fit, source),
        _uncovered(fit, target, masked),
        _off(fit, source, limit, diagonal),
    )
    return [fault for fault in found if fault is not None]


def _folded(fit, side):
    if not len(fit.flipped):
        return None
    region, count = side.piece(side.triangles[fit.flipped]), len(fit.flipped)
    told = f"{count} faces are folded" if count > 1 else "1 face is folded"
    line = f"{told}, most {side.where(region)}: look for a marker that is swapped or missing"
    return Fault("folded", True, "source", region, line)


def _torn(fit, side):
    region = side.piece(side.triangles[fit.distortion > TORN])
    if region is None or side.part(region) < TORN_PART:
        return None
    line = f"The source is torn {side.where(region)}: mark places on either side of it"
    return Fault("torn", True, "source", region, line)


def _uncovered(fit, side, masked):
    bare = np.isnan(fit.image_distances)
    bare[np.asarray(masked, dtype=int)] = False
    region = side.piece(side.triangles[bare[side.triangles].all(axis=1)])
    part = 0.0 if region is None else side.part(region)
    if part < UNCOVERED_PART:
        return None
    bare = f"{100 * part:.0f} % of the target, {side.where(region)}, is covered by nothing"
    line = f"{bare}: mark places there, or mask it"
    return Fault("uncovered", True, "target", region, line)


def _off(fit, side, limit, diagonal):
    off = np.nan_to_num(fit.distances) > limit
    region = side.piece(side.triangles[off[side.triangles].all(axis=1)])
    if region is None or len(region) <= LEAST * len(off):
        return None
    worst = region[fit.distances[region].argmax()]
    percent = 100 * fit.distances[worst] / diagonal
    line = f"Least sure {side.where(worst)} of the source, up to {percent:.1f} % off: look there"
    return Fault("off", False, "source", region, line)
