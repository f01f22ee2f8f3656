"""The ghost of an arc as lines: outlines of shapes seen from an eye, and trails of what moves.

The outline of a smooth surface are its points whose normal n is at right angles to the way to the eye e:
n . (e - x) = 0. With n . (e - x) taken at the vertices and linear in between, that is one straight piece in
every triangle where it changes sign (Hertzmann & Zorin 2000, Illustrating smooth surfaces, section 4.1), and
no lines jump from edge to edge as the eye moves. Open borders belong to it from everywhere.
"""

import numpy as np

from . import topology

MOVES = 0.02  # of the longest way: what moves less has no outline
TRAILS = 12
LIGHT = np.array([0.35, -0.70, 0.62])


def normals(shape, triangles):
    """(n, 3): unit normals of the vertices of (n, 3) positions, faces by their area; 0 in no face."""
    a, b, c = (shape[column] for column in triangles.T)
    faces = np.cross(b - a, c - a)
    summed = np.stack(
        [sum(np.bincount(column, faces[:, i], len(shape)) for column in triangles.T) for i in range(3)],
        axis=1,
    )
    lengths = np.linalg.norm(summed, axis=1, keepdims=True)
    return summed / np.where(lengths > 0, lengths, 1.0)


def light(unit):
    """(n,) in [0.35, 1]: how much light vertices of these normals get, from one side."""
    return 0.675 + 0.325 * (unit @ LIGHT)


def borders(triangles):
    """(b, 2): the edges that have one triangle."""
    edges, times = topology.edges(triangles)
    return edges[times == 1]


def outline(shape, unit, triangles, eye):
    """(k, 2, 3): pieces of the outline; ``eye`` is (4,), homogeneous: a direction where eye[3] is 0."""
    facing = np.einsum("ij,ij->i", unit, np.asarray(eye[:3]) - eye[3] * shape)
    front = facing >= 0
    changes = front[triangles]
    changing = triangles[changes.any(axis=1) & ~changes.all(axis=1)]
    if not len(changing):
        return np.empty((0, 2, 3))
    # Each has one corner that differs from the other two: the piece joins the two edges at it.
    others = front[changing]
    alone = np.argmax(others != (others.sum(axis=1) > 1)[:, None], axis=1)
    row = np.arange(len(changing))
    corner = changing[row, alone]
    ends = [_crossing(shape, facing, corner, changing[row, (alone + step) % 3]) for step in (1, 2)]
    return np.stack(ends, axis=1)


def _crossing(shape, facing, one, other):
    share = facing[one] / (facing[one] - facing[other])
    return shape[one] + share[:, None] * (shape[other] - shape[one])


def ways(shapes):
    """(n,): how far each vertex of (k, n, 3) shapes gets from where it starts."""
    return np.linalg.norm(shapes - shapes[0], axis=2).max(axis=0)


def moving(shapes, triangles):
    """(m, 3): the triangles that move, as far as one sees."""
    far = ways(shapes)
    return triangles[(far[triangles] > MOVES * far.max(initial=0.0)).any(axis=1)]


def trailed(shapes, count=TRAILS):
    """Vertices that show what moves, at most ``count``: the farthest first, then what is far from them all.

    Each next one has the largest product of its way and its distance to those that were chosen, as seen at
    the start: the longest ways, and not all of them side by side.
    """
    far = ways(shapes)
    if not far.any():
        return np.empty(0, dtype=np.int64)
    chosen = [int(far.argmax())]
    nearest = np.full(len(far), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, np.linalg.norm(shapes[0] - shapes[0][chosen[-1]], axis=1))
        worth = far * nearest
        best = int(worth.argmax())
        if worth[best] <= 0 or far[best] < MOVES * far[chosen[0]]:
            break
        chosen.append(best)
    return np.array(chosen)


def between(times, shapes, time):
    """(n, 3): the shape at a time, straight between the shapes at rising ``times``."""
    after = int(np.clip(np.searchsorted(times, time), 1, len(times) - 1))
    share = np.float32((time - times[after - 1]) / (times[after] - times[after - 1]))
    return (1 - share) * shapes[after - 1] + share * shapes[after]
