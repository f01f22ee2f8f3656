"""Twins left and right are found by their places, and keys are made alike on both sides."""

import numpy as np
from lissom_addon_core import face_twins


def symmetric(seed):
    half = np.random.default_rng(seed).uniform(0.1, 1, size=(200, 3))
    middle = np.random.default_rng(seed + 1).uniform(0.1, 1, size=(20, 3)) * [0, 1, 1]
    order = np.random.default_rng(seed + 2).permutation(420)
    points = np.concatenate([half, half * [-1, 1, 1], middle])[order]
    place = np.argsort(order)
    twins = np.empty(420, dtype=int)
    twins[place] = place[np.concatenate([np.arange(200, 400), np.arange(200), np.arange(400, 420)])]
    return points + [7, 0, 0], twins


def test_twins_are_found_whatever_the_order_and_a_little_off():
    for seed in range(5):
        points, known = symmetric(seed)
        off = points + np.random.default_rng(seed).normal(size=points.shape) * 1e-6
        assert np.array_equal(face_twins.twins(points), known)
        assert np.array_equal(face_twins.twins(off), known)


def test_what_is_not_symmetric_has_none():
    points, _ = symmetric(0)
    points[:50, 2] += 0.01
    assert face_twins.twins(points) is None


def test_keys_become_alike_and_those_that_are_stay():
    _, twins = symmetric(3)
    random = np.random.default_rng(9)
    names = ["eyeBlinkLeft", "eyeBlinkRight", "jawOpen", "mouthLeft", "mouthRight"]
    names += ["noseSneer_L", "noseSneer_R"]
    keys = face_twins.alike(names, random.normal(size=(7, 420, 3)), twins)
    for one, other in ((0, 1), (2, 2), (3, 4), (5, 6)):
        np.testing.assert_allclose(keys[one][twins] * [-1, 1, 1], keys[other], atol=1e-15)
    np.testing.assert_allclose(face_twins.alike(names, keys, twins), keys, atol=1e-15)
