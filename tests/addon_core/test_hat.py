"""Hats: the weights of keys between knots, and that keys play the polygon through them."""

import itertools

import numpy as np
import pytest
from lissom_addon_core import hat
from lissom_addon_core.easing import EASINGS
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


def cubic(corners, times):
    """The Bezier curve through corners, with handles at thirds of each span, at rising times."""
    values = np.full(len(times), np.nan)
    for start, end in itertools.pairwise(corners):
        third = (end.point[0] - start.point[0]) / 3
        assert_allclose(
            [start.right[0], end.left[0]], [start.point[0] + third, end.point[0] - third], atol=1e-15
        )
        s = (times - start.point[0]) / (3 * third)
        inside = (s >= -1e-12) & (s <= 1 + 1e-12)
        ordinates = start.point[1], start.right[1], end.left[1], end.point[1]
        basis = (1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3
        values[inside] = sum(b * y for b, y in zip(basis, ordinates, strict=True))[inside]
    return values


@pytest.mark.parametrize("knots", [KNOTS, [-0.5, *KNOTS], [*KNOTS, 1.7], [-0.2, *KNOTS, 3.0]])
@pytest.mark.parametrize("name", EASINGS)
def test_the_corners_hold_the_eased_hat_exactly(name, knots):
    easing, times = EASINGS[name], np.linspace(knots[0], knots[-1], 97)
    expected = hat.weights(knots, easing.value(times))
    for index in range(len(knots)):
        corners = hat.corners(knots, index, easing)
        inside = (times >= corners[0].point[0]) & (times <= corners[-1].point[0])
        assert_allclose(cubic(corners, times[inside]), expected[inside, index], atol=1e-14)
        assert not expected[~inside, index].any()


@pytest.mark.parametrize("name", EASINGS)
def test_an_easing_runs_from_0_to_1_and_back(name):
    easing, times = EASINGS[name], np.linspace(0, 1, 97)
    values = easing.value(times)
    assert (values[0], values[-1]) == (0, 1)
    assert (np.diff(values) > 0).all()
    assert_allclose(easing.inverse(values), times, atol=1e-7)
    assert_allclose(easing.slope(times), np.gradient(values, times, edge_order=2), atol=2e-3)


def test_the_first_and_the_last_hat_have_two_corners():
    linear = EASINGS["LINEAR"]
    assert [corner.point for corner in hat.corners(KNOTS, 0, linear)] == [(0.0, 1.0), (0.1, 0.0)]
    assert [corner.point for corner in hat.corners(KNOTS, 4, linear)] == [(0.8, 0.0), (1.0, 1.0)]


def test_uniform_knots_count_the_in_betweens_only():
    assert_allclose(hat.uniform_knots(3), [0, 0.25, 0.5, 0.75, 1])


def test_knots_give_way_to_those_that_are_fixed():
    draw = np.random.default_rng(5).uniform(size=(40, 3))
    for fixed in np.round(draw, 4):
        crowd = np.sort(np.random.default_rng(6).uniform(0, 2e-3, 40))
        for knots in (*map(hat.uniform_knots, (1, 9, 99)), crowd):
            found = hat.spread(knots, fixed)
            assert set(fixed) | {0.0, 1.0} <= set(found)
            if np.diff(np.unique(fixed)).min() > hat.NEAREST:
                assert np.diff(found).min() > 0.9 * hat.NEAREST
            assert np.abs(np.subtract.outer(knots, found)).min(axis=1).max() <= hat.NEAREST


@pytest.mark.parametrize(
    ("least", "most"), [(0, 1), (0.2, 0.9), (-0.5, 1), (0, 1.5), (-2, 3), (-1e-6, 1 + 1e-6)]
)
def test_beyond_its_ends_a_path_goes_on_straight(least, most):
    shapes = np.random.default_rng(1).normal(size=(5, 4, 3))
    knots, extended = hat.beyond(KNOTS, shapes, least, most)
    reach = [end for end in (least, most) if not -1e-3 < end < 1 + 1e-3]
    assert_array_equal(knots, sorted([*KNOTS, *reach]))
    for time in np.linspace(knots[0], knots[-1], 40):
        found = np.tensordot(hat.weights(knots, time)[0], extended, axes=1)
        within = np.clip(time, 0, 1)
        known = np.tensordot(hat.weights(KNOTS, within)[0], shapes, axes=1)
        speed = (shapes[1] - shapes[0]) / 0.1 if time < 0 else (shapes[4] - shapes[3]) / 0.2
        assert_allclose(found, known + (time - within) * speed, atol=1e-12)
