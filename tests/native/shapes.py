"""Meshes and motions for the tests."""

import numpy as np


def grid_faces(rows: int, columns: int, closed: bool = False) -> np.ndarray:
    """Triangles of a grid of rows x columns vertices; `closed` joins the last column to the first."""
    r, c = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij")
    r, c = r.ravel(), c.ravel()
    d = (c + 1) % columns
    corner, right, up, across = r * columns + c, r * columns + d, (r + 1) * columns + c, (r + 1) * columns + d
    return np.concatenate([np.stack([corner, right, across], 1), np.stack([corner, across, up], 1)])


def tube(rows: int = 80, columns: int = 32, length: float = 6.0, bumps: float = 0.05):
    """An open tube along x with a bumpy surface: vertices (rows * columns, 3), triangles."""
    x, angle = np.meshgrid(
        np.linspace(0, length, rows), np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij"
    )
    radius = 1 + bumps * np.sin(7 * x) * np.cos(5 * angle)
    vertices = np.stack([x, radius * np.cos(angle), radius * np.sin(angle)], -1).reshape(-1, 3)
    return vertices, grid_faces(rows, columns, closed=True)


def rotation(axis, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def rigid(axis=(0, 0, 1), angle: float = 0.0, offset=(0, 0, 0)) -> np.ndarray:
    """A 4 x 4 rigid motion."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(axis, angle)
    matrix[:3, 3] = offset
    return matrix


def moved(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def diagonal(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def ends(vertices: np.ndarray, share: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """The vertices in the first and in the last `share` of the extent along x."""
    x = vertices[:, 0]
    span = np.ptp(x)
    return np.flatnonzero(x < x.min() + share * span), np.flatnonzero(x > x.max() - share * span)


def prism(rows: int = 100, columns: int = 32, length: float = 6.0, square: bool = False):
    """A closed cylinder (radius 0.5) or box (1 x 1) along x: rows * columns + 2 vertices, triangles."""
    angle = np.linspace(0, 2 * np.pi, columns, endpoint=False) + np.pi / 4
    ring = 0.5 * np.stack([np.cos(angle), np.sin(angle)], 1)
    if square:
        side = np.linspace(-0.5, 0.5, columns // 4, endpoint=False)
        half = np.full(columns // 4, 0.5)
        ring = np.concatenate(
            [np.stack(p, 1) for p in ((half, side), (-side, half), (-half, -side), (side, -half))]
        )
    x = np.repeat(np.linspace(0, length, rows), columns)
    vertices = np.concatenate([np.column_stack([x, np.tile(ring, (rows, 1))]), [[0, 0, 0], [length, 0, 0]]])
    last, first, k = rows * columns, (rows - 1) * columns, np.arange(columns)
    caps = [np.stack([np.full(columns, last), (k + 1) % columns, k], 1)]
    caps += [np.stack([np.full(columns, last + 1), first + k, first + (k + 1) % columns], 1)]
    return vertices, np.concatenate([grid_faces(rows, columns, closed=True), *caps])


def bend(vertices: np.ndarray, angle: float, share: float = 0.1) -> np.ndarray:
    """Where the last `share` along x goes when the middle axis bends to an arc of its own length."""
    start, end = share * vertices[:, 0].max(), (1 - share) * vertices[:, 0].max()
    radius = (end - start) / angle
    turn = rigid((0, 0, 1), angle)
    turn[:3, 3] = (start + radius * np.sin(angle), radius * (1 - np.cos(angle)), 0) - turn[:3, 0] * end
    return turn
