"""Rotations, components and closest points, against numpy's dense ones."""

import lissom
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from shapes import rotation

SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1.0, 3.0, np.pi - 1e-7, np.pi])
def test_rotation_vectors_invert_the_exponential(angle):
    for axis in np.random.default_rng(3).normal(size=(20, 3)):
        axis /= np.linalg.norm(axis)
        found = lissom.rotation_vectors(rotation(axis, angle))
        sign = np.sign(found @ axis) if angle > 3.1 else 1.0  # half a turn has two
        assert_allclose(sign * found, angle * axis, atol=1e-8)


def test_rotation_vectors_are_told_whole_turns_by_what_is_near():
    axis = np.array([0.6, 0.0, 0.8])
    angles = np.array([[0.4, -3.3], [4 * np.pi + 0.1, -27.0]])
    turns = angles[..., None] * axis
    rotations = np.array([[rotation(axis, angle) for angle in row] for row in angles])
    assert_allclose(lissom.rotation_vectors(rotations, near=turns + 0.2), turns, atol=1e-9)
    with pytest.raises(ValueError, match="near"):
        lissom.rotation_vectors(rotations, near=turns[0])


@given(SEEDS)
def test_no_rotation_is_nearer(seed):
    maps = np.random.default_rng(seed).normal(size=(2, 3, 3, 3))
    u, _, vt = np.linalg.svd(maps)
    u[..., 2] *= np.linalg.det(u @ vt)[..., None]
    assert_allclose(lissom.nearest_rotations(maps), u @ vt, atol=1e-7)


@given(SEEDS)
def test_components_are_those_that_a_search_reaches(seed):
    random = np.random.default_rng(seed)
    triangles = random.integers(0, 40, size=(12, 3))
    found = lissom.components(41, triangles)
    reached = np.eye(41, dtype=bool)
    for triangle in triangles:
        reached[np.ix_(triangle, triangle)] = True
    for _ in range(6):
        reached = reached @ reached
    used = np.unique(triangles)
    assert set(np.flatnonzero(found >= 0)) == set(used)
    assert np.array_equal(found[used, None] == found[used], reached[np.ix_(used, used)])
    assert set(found[used]) == set(range(found.max() + 1))


@given(SEEDS)
def test_no_point_of_a_surface_is_nearer(seed):
    random = np.random.default_rng(seed)
    vertices, places = random.normal(size=(30, 3)), 2 * random.normal(size=(4, 3))
    triangles = np.array([random.permutation(30)[:3] for _ in range(20)])
    vertices[triangles[1, 2]] = vertices[triangles[1]][:2].mean(axis=0)  # on a line
    vertices[triangles[0]] = vertices[triangles[0, 0]]  # in one place
    found, weights, distances = lissom.closest_points(vertices, triangles, places)
    assert (weights >= 0).all() and np.allclose(weights.sum(axis=1), 1)
    at = np.einsum("kc,kcx->kx", weights, vertices[triangles[found]])
    assert_allclose(np.linalg.norm(at - places, axis=1), distances, atol=1e-9)
    shares = np.vstack([random.dirichlet([0.5, 0.5, 0.5], size=300), np.eye(3)])
    points = (shares @ vertices[triangles]).reshape(-1, 3)
    assert (np.linalg.norm(points - places[:, None], axis=2) >= distances[:, None] - 1e-9).all()


def test_what_cannot_be_is_refused():
    for call in (
        lambda: lissom.components(3, [(0, 1, 3)]),
        lambda: lissom.closest_points(np.eye(3), [(0, 1, 3)], np.eye(3)),
        lambda: lissom.closest_points(np.eye(3), np.empty((0, 3), int), np.eye(3)),
    ):
        with pytest.raises(lissom.InvalidMesh, match="triangles"):
            call()
    with pytest.raises(ValueError, match="maps"):
        lissom.nearest_rotations(np.eye(4))
