"""What a view shows where, and what the mouse is on."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from lissom_addon_core.picking import Picking, View, grabbed, near_edges
from lissom_addon_core.surface import Point

SEEDS = st.integers(0, 2**32 - 1)


def view(seed, perspective):
    """A view from somewhere at the origin, 4 to 9 away, and where its eye is."""
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    away, (near, far) = random.uniform(4, 9), (0.1, 100.0)
    placing = np.eye(4)
    placing[:3, :3], placing[2, 3] = turn, -away
    lens = np.diag([1.5, 2.0, 0.0, 0.0])
    if perspective:
        lens[2, 2:], lens[3, 2] = (-(far + near) / (far - near), -2 * far * near / (far - near)), -1
    else:
        lens[2, 2:], lens[3, 3] = (-2 / (far - near), -(far + near) / (far - near)), 1
        lens[:2] /= 4
    return View(lens @ placing, (800, 600)), turn.T @ [0, 0, away]


@given(SEEDS, st.booleans())
def test_a_ray_through_a_pixel_meets_what_is_shown_there(seed, perspective):
    shown, eye = view(seed, perspective)
    places = np.random.default_rng(seed).uniform(-1, 1, size=(9, 3))
    spots, depths = shown.project(places)
    assert (depths > 0).all()
    origins, ways = shown.rays(spots)
    along = np.einsum("kx,kx->k", places - origins, ways)
    assert (along > 0).all() and np.allclose(origins + along[:, None] * ways, places, atol=1e-6)
    if perspective:
        assert np.allclose(np.cross(origins - eye, ways), 0, atol=1e-6)
    else:
        assert np.allclose(ways, ways[0])


def test_nothing_is_shown_behind_the_eye():
    shown, eye = view(1, True)
    assert np.isnan(shown.project([2 * eye])[0]).all()
    assert near_edges(shown, np.array([[2 * eye, 3 * eye]]), (400, 300), 1e9) == []


@given(SEEDS, st.booleans(), st.floats(1, 100))
def test_near_edges_are_those_and_their_places(seed, perspective, reach):
    shown, _ = view(seed, perspective)
    random = np.random.default_rng(seed)
    ends, mouse = random.uniform(-1, 1, size=(40, 2, 3)), random.uniform((200, 150), (600, 450))
    shares = np.linspace(0, 1, 501)[:, None]
    away = []
    for a, b in ends:
        spots, _ = shown.project((1 - shares) * a + shares * b)
        away.append(np.linalg.norm(spots - mouse, axis=1).min())
    assume(np.abs(np.array(away) - reach).min() > 1)
    found = near_edges(shown, ends, mouse, reach)
    assert sorted(edge for edge, _ in found) == np.flatnonzero(np.array(away) < reach).tolist()
    last = 0.0
    for edge, share in found:
        (spot,), _ = shown.project([(1 - share) * ends[edge, 0] + share * ends[edge, 1]])
        off = np.linalg.norm(spot - mouse)
        assert off == pytest.approx(away[edge], abs=0.5) and off >= last - 1e-6
        last = off


def test_a_mark_that_is_seen_is_taken_before_one_that_is_hidden():
    spots = [(10, 10), (12, 10), (30, 10)]
    assert grabbed(spots, [False, False, False], (10.5, 10)) == 0
    assert grabbed(spots, [True, False, False], (10, 10)) == 1
    assert grabbed(spots, [True, True, True], (12, 10)) == 1
    assert grabbed([], [], (0, 0)) is None


def test_two_clicks_make_a_pair_in_either_order():
    a, b, c = map(Point.at, (1, 2, 3))
    for first, second in (("source", "target"), ("target", "source")):
        picking = Picking()
        assert picking.take(first, a) is None and picking.take(first, b) is None
        assert (picking.side, picking.point) == (first, b), "again on the same side it moves"
        assert picking.take(second, c) == {first: b, second: c}
        assert picking.side is None and picking.point is None
        picking.take(first, a)
        picking.drop()
        assert picking.take(second, c) is None
