"""Whole turns, against paths whose turns are known."""

import numpy as np
import pytest
from lissom import rotation_vectors
from lissom_addon_core import turns
from numpy.testing import assert_allclose
from shapes import rotation

X, Z = np.eye(3)[[0, 2]]


@pytest.mark.parametrize("whole", [0.4, -3.3, 4 * np.pi, -27.0])
def test_a_turn_about_one_axis_is_counted(whole):
    axis = np.array([0.6, 0.0, 0.8])
    path = np.array([rotation(axis, t * whole) for t in np.linspace(0, 1, 200)])
    assert_allclose(turns.along(path), whole * axis, atol=1e-9)
    assert_allclose(turns.explained(path, 2.5 * np.eye(3), path[-1]), whole * axis, atol=1e-9)


def test_another_rotation_is_not_explained():
    path = np.array([rotation(Z, t) for t in np.linspace(0, 7, 50)])
    assert turns.explained(path, np.eye(3), path[-1] @ rotation(X, 0.2)) is None


def test_a_mirrored_space_turns_the_other_way():
    path = np.array([rotation(Z, t) for t in np.linspace(0, 7, 50)])
    mirror = np.diag([-1.0, 1.0, 1.0])
    assert_allclose(turns.explained(path, mirror, mirror @ path[-1] @ mirror), [0, 0, -7], atol=1e-9)


@pytest.mark.parametrize(
    ("angles", "told"),
    [
        ((0, 0, 3), False),
        ((0, 0, 3.2), True),
        ((0.3, -7, 1), True),
        ((3.3, 0, 3.3), False),
        ((2, 0, 7), False),
    ],
)
def test_which_angles_have_one_story(angles, told):
    assert turns.is_told_by_angles(np.array(angles)) is told


def test_turns_are_counted_from_look_to_look_without_drift():
    tracker, count = turns.Tracker(), 400
    for k in range(count + 1):
        t = k / count
        matrix = np.eye(4)
        matrix[:3, :3] = rotation(Z, 20 * t) @ rotation(X, 0.4 * np.sin(60 * t))  # it wobbles
        found = tracker.turns(np.array([matrix, np.eye(4)]), [None, None])
    assert np.linalg.norm(found[0] - [0, 0, 20]) < np.pi
    own = rotation_vectors(matrix[:3, :3])
    lifted = own / np.linalg.norm(own) * (np.linalg.norm(own) + 2 * np.pi * np.array([-4, -3, 3, 4])[:, None])
    assert np.linalg.norm(lifted - found[0], axis=1).min() < 1e-6  # a branch of the matrix's own, to the end
    assert_allclose(found[1], 0, atol=1e-12)


def test_less_than_half_a_turn_is_left_to_the_matrix():
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(X, 3.0)
    assert turns.Tracker().turns(matrix[None], [None]) is None
    told = turns.Tracker().turns(matrix[None], [np.array([3.0 - 2 * np.pi, 0, 0])])
    assert_allclose(told, [[3.0 - 2 * np.pi, 0, 0]])
