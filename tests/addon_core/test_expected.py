"""Where a landmark is to be expected, by those that are borne already."""

import numpy as np
import pytest
from lissom_addon_core.expected import expected, reach
from numpy.testing import assert_allclose

NAMES = ("one", "two", "three", "four")


def guide(places):
    """Landmarks on a ball, whose normals lead out of it."""
    return {name: np.array([place, place]) for name, place in zip(NAMES, places, strict=True)}


def moved(marks, names):
    """Some of them turned, twice the size and shifted."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([5.0, -1.0, 2.0])
    place = {name: 2 * turn @ marks[name][0] + shift for name in marks}
    return {name: np.array([place[name], turn @ marks[name][1]]) for name in names}, place


BALL = np.random.default_rng(1).normal(size=(4, 3)) + [0, 0, 3]
BALL /= np.linalg.norm(BALL, axis=1, keepdims=True)
LINE = np.array([[-1, 0, 1], [0, 0, 1], [1, 0, 1], [0.5, 1, 1.0]])


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("places", [BALL, LINE], ids=["ball", "line"])
def test_it_is_where_the_other_mesh_bears_it(places, count):
    other = guide(places)
    marks, place = moved(other, NAMES[:count])
    assert_allclose(expected("four", marks, [{}, other]), place["four"], atol=1e-9)


def test_one_mark_tells_nothing_nor_do_two_at_one_place():
    other = guide(BALL)
    marks, _ = moved(other, NAMES[:1])
    assert expected("four", marks, [other]) is None
    assert expected("four", marks | {"two": marks["one"]}, [other]) is None
    assert expected("five", moved(other, NAMES[:3])[0], [other]) is None


def test_one_sees_a_part_of_what_is_marked_but_not_too_little():
    assert reach(np.array([[0, 0, 0], [3, 4, 0]]), 1.0) == 1.75
    assert reach(np.zeros((2, 3)), 1.0) == 0.05
