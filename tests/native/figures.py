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


def closed_volume(points: np.ndarray, faces: np.ndarray) -> float:
    """Volume, with a cone from the centre of all border vertices over every border."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    n = len(points)
    alone = ~np.isin(sides[:, 0] * n + sides[:, 1], sides[:, 1] * n + sides[:, 0])
    if not alone.any():
        return volume(points, faces)
    border = sides[alone]
    apex = points[np.unique(border)].mean(axis=0)
    cone = np.column_stack([border[:, ::-1], np.full(len(border), n)])
    return volume(np.vstack([points, apex]), np.vstack([faces, cone]))


def dihedral_angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Signed angle between the normals of every two neighbours, in radians; edges in ascending order."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    triangle = np.tile(np.arange(len(faces)), 3)
    n = len(points)
    code, back = sides[:, 0] * n + sides[:, 1], sides[:, 1] * n + sides[:, 0]
    order = np.argsort(code)
    ahead = np.flatnonzero((sides[:, 0] < sides[:, 1]) & np.isin(code, back))
    ahead = ahead[np.argsort(code[ahead])]
    other = order[np.searchsorted(code[order], back[ahead])]
    normal = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    first, second = normal[triangle[ahead]], normal[triangle[other]]
    along = points[sides[ahead, 1]] - points[sides[ahead, 0]]
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.arctan2((along * np.cross(first, second)).sum(1), (first * second).sum(1))


def dihedral_change(rest: np.ndarray, posed: np.ndarray, faces: np.ndarray) -> float:
    """Root mean square change of dihedral angles, in degrees."""
    change = dihedral_angles(posed, faces) - dihedral_angles(rest, faces)
    change = (change + np.pi) % (2 * np.pi) - np.pi
    return float(np.degrees(np.sqrt(np.mean(change**2))))


def smallest_dihedral(points: np.ndarray, faces: np.ndarray) -> float:
    """Angle between the two faces at the sharpest edge, in degrees: 180 is flat, 0 folded onto itself."""
    return float(180 - np.degrees(np.abs(dihedral_angles(points, faces)).max()))


def ring_twist(rest: np.ndarray, posed: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Angle about x by which each ring of a prism has turned, followed along the rings; radians."""
    old, new = (p[: rows * columns].reshape(rows, columns, 3)[:, :, 1:] for p in (rest, posed))
    new = new - new.mean(1, keepdims=True)
    cosine = (old * new).sum((1, 2))
    sine = (old[:, :, 0] * new[:, :, 1] - old[:, :, 1] * new[:, :, 0]).sum(1)
    return np.unwrap(np.arctan2(sine, cosine))
