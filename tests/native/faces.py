"""The measured meshes that transfer is tested on."""

import numpy as np


def triangulate(loops, counts, turn: int = 0) -> np.ndarray:
    """Triangles of polygons, each a fan from its corner number `turn`."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    triangles = []
    for count in np.unique(counts):
        corners = loops[starts[counts == count][:, None] + (np.arange(count) + turn) % count]
        triangles += [corners[:, [0, k, k + 1]] for k in range(1, count - 1)]
    return np.concatenate(triangles)


def slid(vertices, triangles, keep, seed: int = 0, reach: float = 0.3):
    """Weights (n, 3) and vertices (n, 3) that move every vertex but `keep` on its surface.

    Each new vertex is a point of one of the triangles at the old one; `reach` bounds its share of the
    other two corners.
    """
    random = np.random.default_rng(seed)
    corners = np.arange(len(vertices))[:, None].repeat(3, 1)
    for triangle in random.permutation(triangles):
        for k in range(3):
            corners[triangle[k]] = np.roll(triangle, -k)
    away = random.uniform(0, reach, (len(vertices), 2)) / 2
    away[keep] = 0
    return corners, np.column_stack([1 - away.sum(1), away])


def root_mean_square(offsets) -> float:
    return float(np.sqrt((offsets**2).sum(-1).mean()))


def diagonal(vertices) -> float:
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))
