"""A region of a mesh, and where it is in an artist's words."""

import lissom
import numpy as np

NEAR = 0.1  # of the diagonal: so near to a marker a region is called by its name
_SIDES = (
    ("right", "left"),
    ("front", "back"),
    ("bottom", "top"),
)  # along x, y and z, as the character has them


def largest_piece(triangles, count):
    """The vertices (k,), of ``count``, of the largest piece that some triangles (m, 3) form; None of none."""
    if not len(triangles):
        return None
    component = lissom.components(count, triangles)
    used = np.unique(triangles)
    return used[component[used] == np.bincount(component[used]).argmax()]


def words(place, vertices, marked, names):
    """Where ``place`` (3,) is among ``vertices`` (n, 3): by the nearest of ``marked`` (k,), or by sides."""
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    if len(marked):
        away = np.linalg.norm(vertices[marked] - place, axis=1)
        if away.min() < NEAR * np.linalg.norm(size):
            return f"near '{names[away.argmin()]}'"
    share = np.divide(place - low, size, out=np.full(3, 0.5), where=size > 0)
    sides = [
        pair[int(part > 0.5)] for pair, part in zip(_SIDES, share, strict=True) if abs(part - 0.5) > 1 / 6
    ]
    return " ".join(["at the", *sides[::-1]]) if sides else "in the middle"
