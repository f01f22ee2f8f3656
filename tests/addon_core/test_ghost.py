"""Outlines and trails of shapes."""

import numpy as np
from lissom_addon_core import ghost
from numpy.testing import assert_allclose, assert_array_equal


def ball(rings=24, around=48):
    """A unit sphere, open at its poles."""
    polar = np.linspace(0, np.pi, rings + 2)[1:-1]
    turn = 2 * np.pi * np.arange(around) / around
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    heights = np.repeat(np.cos(polar)[:, None, None], around, axis=1)
    vertices = np.concatenate([np.sin(polar)[:, None, None] * circle, heights], axis=-1)
    grid = np.arange(rings * around).reshape(rings, around)
    a, b = grid[:-1], grid[1:]
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    triangles = np.concatenate([np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (c, b, d))])
    return vertices.reshape(-1, 3), triangles


def test_the_outline_of_a_ball_is_a_circle_that_does_not_jump():
    vertices, triangles = ball()
    unit = ghost.normals(vertices, triangles)
    assert_allclose(np.abs(np.einsum("ij,ij->i", unit, vertices)), 1, atol=0.03)
    lengths = []
    for turn in np.linspace(0, 0.2, 9):
        eye = np.array([np.cos(turn), np.sin(turn), 0.0, 0.0])
        pieces = ghost.outline(vertices, unit, triangles, eye)
        assert_allclose(pieces @ eye[:3], 0, atol=0.03)  # on the great circle, between vertices too
        lengths.append(np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1).sum())
    rims = 2 * (np.pi - 2 * np.arcsin(np.sin(np.pi / 25)))  # the caps of the poles are open
    assert_allclose(lengths, rims, rtol=0.03)


def test_a_near_eye_sees_less_of_a_ball():
    vertices, triangles = ball()
    unit = ghost.normals(vertices, triangles)
    pieces = ghost.outline(vertices, unit, triangles, np.array([2.0, 0.0, 0.0, 1.0]))
    assert_allclose(pieces[..., 0], 0.5, atol=0.03)  # the circle whose tangents meet at 2


def test_an_eye_that_sees_all_from_one_side_gets_no_outline_but_the_border():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    unit = ghost.normals(vertices, triangles)
    assert ghost.outline(vertices, unit, triangles, np.array([0, 0, 1.0, 0])).shape == (0, 2, 3)
    assert_array_equal(ghost.borders(triangles), [[0, 1], [0, 3], [1, 2], [2, 3]])


def test_trails_are_of_what_moves_most_and_not_side_by_side():
    line = np.zeros((101, 3))
    line[:, 0] = np.linspace(0, 1, 101)
    moved = line + [0, 0, 1] * np.linspace(-1, 1, 101)[:, None].clip(0)  # the right half rises
    shapes = np.stack([line, (line + moved) / 2, moved])
    chosen = ghost.trailed(shapes, 4)
    assert chosen[0] == 100 and (line[chosen, 0] > 0.5).all()
    assert np.diff(np.sort(line[chosen, 0])).min() > 0.05
    assert not len(ghost.trailed(np.stack([line, line])))


def test_between_is_straight_between_the_times():
    shapes = np.arange(3, dtype=np.float32)[:, None, None] * np.ones((1, 2, 3), dtype=np.float32)
    times = np.array([0.0, 0.25, 1.0])
    for time, value in ((0, 0), (0.125, 0.5), (0.25, 1), (0.625, 1.5), (1, 2)):
        assert_allclose(ghost.between(times, shapes, time), value)
