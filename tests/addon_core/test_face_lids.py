"""Lids meet where they close, on every eye, and what turns about an eyeball stays outside of it."""

import numpy as np
import pytest
from lissom_addon_core import face_lids
from lissom_addon_core.face_lids import Axis, Lids, Shares

BACK = np.array([0.0, 1.0, 0.0])


def eye(wide, high, count=32, slant=0.0):
    """Rim on the front of a ball of radius 1, and its lids."""
    angle = np.arange(count) * 2 * np.pi / count
    x, z = wide * np.cos(angle), high * np.sin(angle)
    x, z = x * np.cos(slant) - z * np.sin(slant), x * np.sin(slant) + z * np.cos(slant)
    points = np.column_stack([x, -np.sqrt(1.2 - x**2 - z**2), z])
    return points, Lids.of(points, np.append(np.arange(count), 0))


@pytest.mark.parametrize(("wide", "high"), [(0.5, 0.2), (0.5, 0.5), (0.4, 0.8)])
@pytest.mark.parametrize("share", [1.0, 0.8, 0.5, 0.1])
def test_lids_that_close_meet_and_do_not_pass_the_corners(wide, high, share):
    points, lids = eye(wide, high, slant=0.2)
    shares = Shares(*(np.full(face_lids.PLACES, one) for one in (share, 1 - share)))
    moved = points.copy()
    moved[np.concatenate(lids)] += face_lids.steps(lids, points, np.zeros_like(points), shares)
    assert np.abs(lids.gaps(moved)).max() < 0.03 * high
    middle = lids.gaps(points)[face_lids.PLACES // 2]
    went = (moved - points)[lids.upper[len(lids.upper) // 2]]
    assert abs(went @ middle / (middle @ middle) - share) < 0.05
    # Beside the corners both meet at the middle of what was between them, so that no skin turns over there.
    beside = moved[lids.upper[1]], (points[lids.upper[1]] + points[lids.lower[1]]) / 2
    assert np.linalg.norm(beside[0] - beside[1]) < 0.2 * np.linalg.norm(
        points[lids.upper[1]] - points[lids.lower[1]]
    )


def test_what_opens_is_told_by_vertices_that_lie_opposite_each_other():
    points, lips = eye(0.5, 0.1)
    offsets = np.random.default_rng(0).normal(size=points.shape)
    opened = lips.opened(points, offsets)
    assert np.abs(opened[[0, -1]]).max() < 1e-12
    np.testing.assert_allclose(opened, offsets[lips.lower] - offsets[lips.upper], atol=1e-9)


def test_what_opens_an_eye_is_left():
    points, lids = eye(0.5, 0.3)
    offsets = np.random.default_rng(0).normal(size=points.shape)
    shares = Shares(*(np.full(face_lids.PLACES, one) for one in (-0.3, 0.01)))
    found = face_lids.steps(lids, points, offsets, shares)
    np.testing.assert_array_equal(found, offsets[np.concatenate(lids)])


@pytest.mark.parametrize("ball", [True, False])
def test_coordinates_about_an_eye_lead_to_where_the_steps_do(ball):
    points, lids = eye(0.5, 0.4, slant=0.3)
    balls = [(np.zeros(3), 1.0), (np.array([0, 0.3, 0.2]), 2.0)] if ball else []
    axis = Axis.of(lids, points, BACK, balls)
    assert axis.clear == (face_lids.CLEAR if ball else 0)
    steps = np.random.default_rng(1).normal(size=points.shape) * 0.02 + [0, -0.2, 0.1]
    motion = axis.motion(points, steps)
    np.testing.assert_allclose(axis.moved(points, motion), steps, atol=1e-12)
    if ball:
        inward = axis.moved(points, axis.motion(points, -0.9 * points))
        least = np.minimum(np.linalg.norm(points, axis=1), face_lids.CLEAR)
        assert (np.linalg.norm(points + inward, axis=1) > least - 1e-9).all()
        turn = np.zeros_like(points)
        turn[:, 1] = -0.7
        around = np.linalg.norm(points + axis.moved(points, turn), axis=1)
        np.testing.assert_allclose(around, np.linalg.norm(points, axis=1), atol=1e-12)
