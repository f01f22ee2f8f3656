"""What a brush touches, and the rigid motion of it."""

import numpy as np
import pytest
from lissom_addon_core.brush import rigid, touched


def sheets():
    """Two grids, one close above the other and not joined to it: points, edges."""
    x, y = np.meshgrid(np.arange(21.0), np.arange(21.0))
    low = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    number = np.arange(441).reshape(21, 21)
    edges = np.concatenate(
        [np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], 1),
         np.stack([number[:-1].ravel(), number[1:].ravel()], 1)]
    )  # fmt: skip
    return np.concatenate([low, low + [0, 0, 0.1]]), np.concatenate([edges, edges + 441])


@pytest.mark.parametrize("radius", [1.5, 4.2, 100.0])
def test_it_touches_what_is_near_and_joined_and_not_the_sheet_beside(radius):
    points, edges = sheets()
    found, weights = touched(points, edges, 220, radius)
    away = np.linalg.norm(points[:441] - points[220], axis=1)
    assert found.tolist() == np.flatnonzero(away < radius).tolist()
    assert ((weights > 0) & (weights <= 1)).all()
    assert (weights[away[found] <= radius / 2] == 1).all()
    assert (np.diff(weights[np.argsort(away[found], kind="stable")]) <= 1e-12).all()


def test_a_brush_smaller_than_an_edge_touches_the_vertex_alone():
    points, edges = sheets()
    for radius in (0.0, 0.5):
        found, weights = touched(points, edges, 220, radius)
        assert found.tolist() == [220] and weights.tolist() == [1.0]


def test_a_rigid_motion_is_found_and_never_a_mirror_image():
    random = np.random.default_rng(4)
    for flat in (1.0, 0.0):
        for _ in range(50):
            points = random.normal(size=(12, 3)) * [1, 1, flat]
            turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
            turn[:, 0] *= np.linalg.det(turn)
            shift = random.normal(size=3)
            matrix = rigid(points, points @ turn.T + shift)
            assert np.allclose(matrix[:3, :3], turn, atol=1e-9) and np.allclose(
                matrix[:3, 3], shift, atol=1e-9
            )
    mirrored = rigid(points, points * [1, 1, -1])
    assert np.linalg.det(mirrored[:3, :3]) > 0.999
