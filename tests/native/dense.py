"""Small dense references that methods are compared with, on a window of a larger mesh."""

import numpy as np


def neighbours(faces: np.ndarray, n: int) -> list[np.ndarray]:
    rings = [set() for _ in range(n)]
    for triangle in faces:
        for a in triangle:
            rings[a].update(triangle)
    return [np.array(sorted(ring - {i}), int) for i, ring in enumerate(rings)]


def window(faces: np.ndarray, kept: np.ndarray, rings: int):
    """The part of a mesh up to `rings` rings from the vertices `kept`: their indices, its triangles."""
    near = np.zeros(faces.max() + 1, bool)
    near[kept] = True
    for _ in range(rings):
        touched = faces[near[faces].any(1)]
        near[touched] = True
    inner = faces[near[faces].all(1)]
    ids, local = np.unique(inner, return_inverse=True)
    return ids, local.reshape(-1, 3)


def gradient_and_areas(v: np.ndarray, f: np.ndarray):
    """G (3 m, n) takes vertex values to the gradients of the triangles, x, y, z of each together."""
    a, b, c = (v[f[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    double = np.linalg.norm(normal, axis=1)
    normal /= double[:, None]
    matrix = np.zeros((len(f), 3, len(v)))
    for k, edge in enumerate((c - b, a - c, b - a)):
        matrix[np.arange(len(f)), :, f[:, k]] += np.cross(normal, edge) / double[:, None]
    return matrix.reshape(-1, len(v)), double / 2


def surface_diagonal(v: np.ndarray, f: np.ndarray) -> float:
    """The square root of 12 times the radius of gyration: by the midpoints of edges, exact for squares."""
    corners = v[f]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    middles = 0.5 * (corners + np.roll(corners, 1, axis=1))
    centre = np.average(middles.mean(1), axis=0, weights=area)
    return np.sqrt(12 * np.average(((middles - centre) ** 2).sum(2).mean(1), weights=area))


def laplacian_and_mass(v: np.ndarray, f: np.ndarray):
    """L = G^T A G, positive semidefinite, and a third of the area at each vertex."""
    g, areas = gradient_and_areas(v, f)
    mass = np.zeros(len(v))
    np.add.at(mass, f.ravel(), np.repeat(areas / 3, 3))
    return g.T @ (np.repeat(areas, 3)[:, None] * g), mass


def minimise(rows: np.ndarray, delta: np.ndarray, fixed: np.ndarray, values: np.ndarray, soft=None):
    """min |rows x - delta|^2 with x[fixed] = values; soft = (indices, weight, targets) adds
    weight^2 |x[indices] - targets|^2."""
    if soft is not None:
        indices, weight, targets = soft
        pull = np.zeros((len(indices), rows.shape[1]))
        pull[np.arange(len(indices)), indices] = weight
        rows, delta = np.concatenate([rows, pull]), np.concatenate([delta, weight * targets])
    free = np.setdiff1d(np.arange(rows.shape[1]), fixed)
    x = np.zeros((rows.shape[1], *delta.shape[1:]))
    x[fixed] = values
    x[free] = np.linalg.lstsq(rows[:, free], delta - rows[:, fixed] @ values, rcond=None)[0]
    return x
