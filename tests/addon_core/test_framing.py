"""What a view looks at lies in the middle of what is free of it."""

import numpy as np
import pytest
from lissom_addon_core import framing


def test_bars_at_either_edge_are_left_out_and_those_beside_the_view_are_not_missed():
    assert framing.free_span(800, []) == (0, 800)
    assert framing.free_span(800, [(500, 800), (0, 58)]) == (58, 500)
    assert framing.free_span(800, [(800, 1100), (-58, 0)]) == (0, 800)
    assert framing.free_span(300, [(100, 300), (0, 120)]) == (0, 300)  # nothing is free


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_points_fill_the_free_pixels_and_lie_in_their_middle(seed, perspective):
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[:, 2] *= np.linalg.det(turn)
    points = 5 * rng.normal(size=3) + rng.normal(size=(20, 3))
    size, free, pixel = (800, 600), (58, 500), rng.uniform(2e-4, 2e-3)
    location, distance = framing.framed(points, turn, size, free, pixel, perspective)
    own = (points - location) @ turn
    away = distance - own[:, 2:] if perspective else distance
    assert np.all(np.asarray(away) > 0)
    seen = own[:, :2] / (pixel * away) + np.divide(size, 2)
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle, room = np.array([np.mean(free), size[1] / 2]), np.array([free[1] - free[0], size[1]])
    filled = np.maximum(high - middle, middle - low) / (room / 2) * framing.MARGIN
    np.testing.assert_allclose(filled.max(), 1)
    tight = filled.argmax()
    np.testing.assert_allclose((low + high)[tight] / 2, middle[tight])


@pytest.mark.parametrize("seed", range(8))
def test_a_view_stands_upright_whichever_way_it_looks(seed):
    random = np.random.default_rng(seed)
    for way in (random.normal(size=3), *np.eye(3), *-np.eye(3)):
        turn = framing.upright(way)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) > 0
        np.testing.assert_allclose(turn[:, 2], -way / np.linalg.norm(way), atol=1e-12)
        assert abs(turn[2, 0]) < 1e-3 and turn[2, 1] > -1e-12
