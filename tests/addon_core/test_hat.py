import numpy as np
from lissom_addon_core import hat
from numpy.testing import assert_allclose, assert_array_equal

KNOTS = [0.0, 0.1, 0.45, 0.8, 1.0]


def test_each_hat_is_one_at_its_knot_and_zero_at_the_others():
    assert_array_equal(hat.weights(KNOTS, KNOTS), np.eye(5))


def test_the_hats_add_up_to_one_everywhere():
    times = np.linspace(-0.5, 1.5, 101)
    assert_allclose(hat.weights(KNOTS, times).sum(axis=1), 1.0, atol=1e-15)


def test_weighted_keys_play_the_polygon_through_them():
    keys = np.random.default_rng(0).normal(size=(5, 3))
    assert_allclose(hat.weights(KNOTS, [0.3]) @ keys, [keys[1] + 0.2 / 0.35 * (keys[2] - keys[1])])


def test_the_corners_are_those_of_the_hat():
    times = np.linspace(0, 1, 97)
    for index in range(5):
        corner_times, values = zip(*hat.points(KNOTS, index), strict=True)
        assert_allclose(
            np.interp(times, corner_times, values), hat.weights(KNOTS, times)[:, index], atol=1e-15
        )


def test_the_first_and_the_last_hat_have_two_corners():
    assert hat.points(KNOTS, 0) == [(0.0, 1.0), (0.1, 0.0)]
    assert hat.points(KNOTS, 4) == [(0.8, 0.0), (1.0, 1.0)]


def test_uniform_knots_count_the_in_betweens_only():
    assert_allclose(hat.uniform_knots(3), [0, 0.25, 0.5, 0.75, 1])
