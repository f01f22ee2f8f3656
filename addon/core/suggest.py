"""Where the next marker helps most."""

import numpy as np


def suggest(fit, source, target, marked):
    """(source vertex, target vertex) of the marker to add next, or None where every vertex is marked.

    ``source`` (vertices (n, 3), triangles (m, 3)) and ``target`` vertices (n_target, 3) are what ``fit``
    was made of; ``marked`` (k,) are the marked source vertices. Where a fit has slid along the surface, it
    has stretched some triangles and squeezed others; and it can slide the further, the further away the
    markers are. So it is the vertex with the largest mean logarithm of the stretch around it times its
    distance to the nearest marker, among the pieces that bear markers. Its target vertex is the nearest to
    where it has been fitted: to be corrected by eye.
    """
    vertices, triangles = source
    around = np.zeros(len(vertices))
    count = np.zeros(len(vertices))
    for corner in triangles.T:
        around += np.bincount(corner, np.log(fit.stretch), len(vertices))
        count += np.bincount(corner, minlength=len(vertices))
    piece = pieces(len(vertices), triangles)
    allowed = np.isin(piece, piece[marked]) & np.isfinite(fit.distances) & (count > 0)
    allowed[marked] = False
    if not allowed.any():
        return None
    away = np.full(len(vertices), np.inf)
    for vertex in marked:
        np.minimum(away, np.linalg.norm(vertices - vertices[vertex], axis=1), out=away)
    score = np.where(allowed, away * around / np.maximum(count, 1), -1.0)
    best = int(score.argmax())
    return best, int(np.linalg.norm(target - fit.fitted_vertices[best], axis=1).argmin())


def pieces(count, triangles):
    """(count,) a number that the vertices of one connected piece share."""
    label = np.arange(count)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    while True:
        before = label.copy()
        lower = np.minimum(label[edges[:, 0]], label[edges[:, 1]])
        np.minimum.at(label, label[edges[:, 0]], lower)
        np.minimum.at(label, label[edges[:, 1]], lower)
        label = label[label]
        if np.array_equal(label, before):
            return label
