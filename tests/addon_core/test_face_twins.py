"""Twins left and right are found by their places, and keys are made alike on both sides."""

import numpy as np
from lissom_addon_core import face_twins
from lissom_addon_core.face_twins import Plane

X = Plane(np.array([1.0, 0, 0]), 7.0)


def symmetric(seed):
    """A slit sheet whose two lips lie on each other: vertices, triangles and twins."""
    steps = np.linspace(-1, 1, 15)
    x, z = np.meshgrid(steps * [1], np.concatenate([steps[steps >= 0], -steps[steps >= 0]]), indexing="ij")
    wave = np.cos(3 * x) * np.sin(2 * z + 1)
    points = np.stack([x, 0.3 * wave, z], axis=2)
    number = np.arange(x.size).reshape(x.shape)
    half = x.shape[1] // 2
    triangles = []
    for rows in (number[:, :half], number[:, half:][:, ::-1]):
        a, b, c, d = rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]
        triangles += [np.stack([a, b, c], axis=2).reshape(-1, 3), np.stack([a, c, d], axis=2).reshape(-1, 3)]
    points[:, 0, 1] += 0.05
    points[:, half, 1] += 0.05
    order = np.random.default_rng(seed).permutation(x.size)
    place = np.argsort(order)
    twins = np.empty(x.size, dtype=int)
    twins[place] = place[number[::-1].ravel()]
    return points.reshape(-1, 3)[order] + [7, 0, 0], place[np.concatenate(triangles)], twins


def turned(degrees):
    a, b = np.radians([degrees, degrees / 3])
    c, s, d, t = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, d, -t], [0, t, d]])


def test_twins_are_found_whatever_the_order_and_a_little_off():
    for seed in range(5):
        points, triangles, known = symmetric(seed)
        off = points + np.random.default_rng(seed).normal(size=points.shape) * 1e-6
        assert np.array_equal(face_twins.twins(points, triangles, X), known)
        assert np.array_equal(face_twins.twins(off, triangles, X), known)


def test_what_is_not_symmetric_has_none():
    points, triangles, _ = symmetric(0)
    points[:50, 2] += 0.01
    assert face_twins.twins(points, triangles, X) is None


def test_a_plane_is_found_between_rims_whichever_way_they_go():
    turn = turned(20)
    angle = np.sort(np.random.default_rng(4).uniform(0, 2 * np.pi, 17))
    left = np.column_stack([0.5 + 0.2 * np.cos(angle), -0.1 * np.cos(angle + 1), 0.15 * np.sin(angle)])
    right = np.roll(left * [-1, 1, 1], 5, axis=0)
    for one, other in ((left, right), (left[::-1], right), (left, right[::-1])):
        plane = Plane.of_rims(3 * one @ turn.T + 4, 3 * other @ turn.T + 4)
        there = plane.image(3 * left @ turn.T + 4)
        np.testing.assert_allclose(there, 3 * (left * [-1, 1, 1]) @ turn.T + 4, atol=1e-9)
    assert Plane.of_rims(left, right[1:]) is None


def test_keys_become_alike_and_those_that_are_stay():
    points, triangles, twins = symmetric(3)
    turn = turned(25)
    plane = Plane(turn[:, 0], 7.0)
    assert np.array_equal(face_twins.twins(points @ turn.T, triangles, plane), twins)
    random = np.random.default_rng(9)
    names = ["eyeBlinkLeft", "eyeBlinkRight", "jawOpen", "mouthLeft", "mouthRight"]
    names += ["noseSneer_L", "noseSneer_R"]
    keys = face_twins.alike(names, random.normal(size=(7, len(points), 3)), twins, plane, triangles)
    for one, other in ((0, 1), (2, 2), (3, 4), (5, 6)):
        image = (keys[one][twins] @ turn * [-1, 1, 1]) @ turn.T
        np.testing.assert_allclose(image, keys[other], atol=1e-14)
    again = face_twins.alike(names, keys, twins, plane, triangles)
    np.testing.assert_allclose(again, keys, atol=1e-14)


def test_a_few_without_a_twin_go_with_what_is_beside_them():
    points, triangles, known = symmetric(1)
    few = np.random.default_rng(2).choice(len(points), 6, replace=False)
    scarred = points.copy()
    scarred[few] += [0.02, 0, 0.01]
    twins = face_twins.twins(scarred, triangles, X)
    lost = np.flatnonzero(twins < 0)
    assert set(few) <= set(lost) <= {*few, *known[few]}
    random = np.random.default_rng(3)
    smooth = (np.sin(points @ random.normal(size=(3, 3))) * 0.1)[None]
    found, wanted = (
        face_twins.alike(["jawOpen"], smooth, some, X, triangles) - smooth for some in (twins, known)
    )
    others = np.setdiff1d(np.arange(len(points)), lost)
    np.testing.assert_allclose(found[:, others], wanted[:, others], atol=1e-15)
    assert np.abs(found - wanted).max() < 0.15 * np.abs(wanted).max()
    assert np.abs(wanted[:, lost]).max() > 0.3 * np.abs(wanted).max()
