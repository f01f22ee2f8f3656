"""Keys of a symmetric head, alike on both sides: what a fit has made a little of one, it has of the other."""

import itertools

import numpy as np

from . import sides

SAME = 1e-4  # of the head's diagonal: a vertex is so near to the mirror image of its twin
UNUSUAL = 0.001  # of the vertices may have none, and stay as they are


def twins(vertices):
    """(n,) the vertex at the mirror image of each of (n, 3), across the middle of their extent along x, or
    itself where none is there; None for a head that is not symmetric.
    """
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    middle = (vertices[:, 0].min() + vertices[:, 0].max()) / 2
    local = vertices - [middle, 0, 0]
    image = local * [-1, 1, 1]
    found, nearest = np.full(len(vertices), -1), np.full(len(vertices), SAME * size)
    # Cells on which either or its neighbour lies: places that are nearly the same share one of eight grids.
    for shift in itertools.product((0, 0.5), repeat=3):
        cells = [np.floor(points / (4 * SAME * size) + shift).astype(np.int64) for points in (local, image)]
        own, theirs = (cell @ [73856093, 19349663, 83492791] for cell in cells)
        order = np.argsort(own, kind="stable")
        place = order[np.minimum(np.searchsorted(own[order], theirs), len(order) - 1)]
        away = np.linalg.norm(local[place] - image, axis=1)
        better = away < nearest
        found[better], nearest[better] = place[better], away[better]
    lost = found < 0
    if lost.sum() > UNUSUAL * len(vertices):
        return None
    found[lost] = np.flatnonzero(lost)
    return found


def alike(names, offsets, twins):
    """``offsets`` (k, n, 3) of keys by name, each the mean of it and the mirror image of its counterpart."""
    place = {name: number for number, name in enumerate(names)}
    other = [place.get(sides.swapped(name), number) for number, name in enumerate(names)]
    return (offsets + offsets[other][:, twins] * [-1, 1, 1]) / 2
