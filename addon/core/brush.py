"""The part of a mesh under a brush: what becomes a handle by a click."""

import numpy as np
from lissom import nearest_rotations


def touched(points, edges, vertex, radius):
    """(k,) indices, sorted, and (k,) weights of the vertices that are joined to one within a radius of it.

    ``points`` (n, 3), ``edges`` (m, 2). Weights are 1 up to half the radius and fall smoothly to the
    rim, where they stay above 0; the vertex itself is always there.
    """
    away = np.linalg.norm(points - points[vertex], axis=1)
    near = away < radius
    inner = edges[near[edges].all(axis=1)]
    reached = np.zeros(len(points), dtype=bool)
    reached[vertex] = True
    while True:
        before = reached.sum()
        for one, other in (inner.T, inner.T[::-1]):
            reached[other[reached[one]]] = True
        if reached.sum() == before:
            break
    found = np.flatnonzero(reached)
    fall = np.clip(2 * away[found] / max(radius, 1e-300) - 1, 0, 1)
    return found, np.maximum(1 - fall * fall * (3 - 2 * fall), 0.01)


def rigid(rest, posed):
    """(4, 4): the rotation and translation that take (k, 3) points nearest to their new places.

    Horn 1987, by the singular value decomposition of Arun, Huang & Blostein 1987.
    """
    centre, new = rest.mean(axis=0), posed.mean(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = nearest_rotations((posed - new).T @ (rest - centre))
    matrix[:3, 3] = new - matrix[:3, :3] @ centre
    return matrix
