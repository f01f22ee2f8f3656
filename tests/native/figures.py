"""Figures of merit of a pose."""

import numpy as np


def edges(faces: np.ndarray) -> np.ndarray:
    pairs = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0)


def edge_error(rest: np.ndarray, posed: np.ndarray, faces: np.ndarray) -> float:
    """Root mean square of the relative change of edge lengths."""
    i, j = edges(faces).T
    old, new = (np.linalg.norm(p[j] - p[i], axis=1) for p in (rest, posed))
    return float(np.sqrt(np.mean((new / old - 1) ** 2)))


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def dihedral_change(rest: np.ndarray, posed: np.ndarray, faces: np.ndarray) -> float:
    """Root mean square change of dihedral angles, in degrees."""
    sides = {}
    for t, (a, b, c) in enumerate(faces.tolist()):
        for i, j in ((a, b), (b, c), (c, a)):
            sides.setdefault((min(i, j), max(i, j)), []).append((t, i < j))
    inner = [(e, *sorted(s, key=lambda side: -side[1])) for e, s in sides.items() if len(s) == 2]
    e, first, second = (
        np.array([x[0] for x in inner]),
        *(np.array([x[k][0] for x in inner]) for k in (1, 2)),
    )

    def angles(p):
        n = np.cross(p[faces[:, 1]] - p[faces[:, 0]], p[faces[:, 2]] - p[faces[:, 0]])
        n /= np.linalg.norm(n, axis=1)[:, None]
        along = p[e[:, 1]] - p[e[:, 0]]
        along /= np.linalg.norm(along, axis=1)[:, None]
        m, n = n[first], n[second]
        return np.arctan2((along * np.cross(m, n)).sum(1), (m * n).sum(1))

    change = (angles(posed) - angles(rest) + np.pi) % (2 * np.pi) - np.pi
    return float(np.degrees(np.sqrt(np.mean(change**2))))


def ring_twist(rest: np.ndarray, posed: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Angle about x by which each ring of a prism has turned, followed along the rings; radians."""
    old, new = (p[: rows * columns].reshape(rows, columns, 3)[:, :, 1:] for p in (rest, posed))
    new = new - new.mean(1, keepdims=True)
    cosine = (old * new).sum((1, 2))
    sine = (old[:, :, 0] * new[:, :, 1] - old[:, :, 1] * new[:, :, 0]).sum(1)
    return np.unwrap(np.arctan2(sine, cosine))
