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


def neighbours(loops, counts, count):
    """{vertex: its neighbours along edges of polygons}, for polygons of the first `count` vertices."""
    beside: dict[int, set] = {}
    for start, size in zip(np.cumsum(counts) - counts, counts, strict=True):
        polygon = loops[start : start + size].tolist()
        if max(polygon) < count:
            for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
                beside.setdefault(a, set()).add(b)
                beside.setdefault(b, set()).add(a)
    return beside


def loop_through(vertices, beside):
    """The loop of edges that these vertices form, in order; it ends with its first."""
    left, path = set(vertices), [min(vertices)]
    while left - set(path):
        path.append(min((beside[path[-1]] & left) - set(path)))
    return [*path, path[0]]


def rings_from_border(triangles, beside, rings):
    """The loops of edges `rings` away from each border of a surface, as sets, the shortest border first."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1)
    edges, times = np.unique(edges, axis=0, return_counts=True)
    left = set(edges[times == 1].ravel().tolist())
    found = []
    while left:
        border = {left.pop()}
        while grown := {v for b in border for v in beside[b]} & left:
            border |= grown
            left -= grown
        found.append(border)
    seen = [set(border) for border in found]
    for _ in range(rings):
        found = [{v for b in ring for v in beside[b]} - old for ring, old in zip(found, seen, strict=True)]
        seen = [old | ring for ring, old in zip(found, seen, strict=True)]
    return sorted(found, key=len)
