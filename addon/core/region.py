"""Which region of a mesh a fit is off at, in an artist's words."""

import numpy as np

from .suggest import pieces

NEAR = 0.1  # of the diagonal: so near to a marker a region is called by its name
LEAST = 0.002  # of the vertices: a smaller region is not worth a word
_SIDES = (
    ("right", "left"),
    ("front", "back"),
    ("bottom", "top"),
)  # along x, y and z, as the character has them


def weakest(fit, triangles, limit):
    """The vertices (k,) of the source's largest region in one piece that is off by more than ``limit``.

    ``triangles`` (m, 3) are the source's, ``limit`` is in the target's units. None if none is worth it.
    """
    off = np.nan_to_num(fit.distances) > limit
    inside = triangles[off[triangles].all(axis=1)]
    if not len(inside):
        return None
    piece = pieces(len(off), inside)
    counts = np.bincount(piece[np.unique(inside)], minlength=len(off))
    largest = counts.argmax()
    return np.flatnonzero(off & (piece == largest)) if counts[largest] > LEAST * len(off) else None


def words(place, vertices, marked, names):
    """Where ``place`` (3,) is among ``vertices`` (n, 3): by the nearest of ``marked`` (k,), or by sides."""
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    if len(marked):
        away = np.linalg.norm(vertices[marked] - place, axis=1)
        if away.min() < NEAR * np.linalg.norm(size):
            return f"near '{names[away.argmin()]}'"
    share = (place - low) / np.where(size > 0, size, 1)
    sides = [
        pair[int(part > 0.5)] for pair, part in zip(_SIDES, share, strict=True) if abs(part - 0.5) > 1 / 6
    ]
    return " ".join(["at the", *sides[::-1]]) if sides else "in the middle"
