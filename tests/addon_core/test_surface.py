"""Points on surfaces, found and through deformation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lissom_addon_core.surface import Point, closest

SEEDS = st.integers(0, 2**32 - 1)


def soup(seed, count=40):
    """Random triangles: vertices (n, 3) and triangles (count, 3)."""
    random = np.random.default_rng(seed)
    return random.normal(size=(30, 3)), np.array([random.permutation(30)[:3] for _ in range(count)])


@given(SEEDS)
def test_the_closest_points_are_as_far_as_they_say(seed):
    vertices, triangles = soup(seed)
    places = np.random.default_rng(seed).normal(size=(4, 3)) * 2
    points, away = closest(vertices, triangles, places)
    at = np.array([point.position(vertices) for point in points])
    off = np.linalg.norm(at - places, axis=1) - away
    assert np.abs(off).max() < 2e-4 * np.ptp(vertices, axis=0).max()


@given(SEEDS)
def test_a_point_goes_with_its_surface_and_is_found_there_again(seed):
    random = np.random.default_rng(seed)
    vertices, triangles = soup(seed)
    weights = random.dirichlet([1, 1, 1])
    point = Point.of(triangles[7], weights)
    turned = np.linalg.qr(random.normal(size=(3, 3)))[0]
    moved = vertices @ turned.T + [1, 2, 3]
    assert np.allclose(point.position(moved), turned @ point.position(vertices) + [1, 2, 3])
    assert np.allclose(point.position(vertices), weights @ vertices[triangles[7]], atol=1e-3)
    (again,), away = closest(vertices, triangles, [point.position(vertices)])
    assert away[0] < 1e-9 and np.allclose(again.position(vertices), point.position(vertices), atol=1e-3)


@given(SEEDS, st.permutations(range(3)))
def test_one_place_is_one_point_also_in_single_precision(seed, order):
    random = np.random.default_rng(seed)
    corners, weights = random.permutation(9)[:3], random.dirichlet([0.3, 0.3, 0.3])
    point = Point.of(corners, weights)
    assert sum(point.weights) == pytest.approx(1, abs=1e-9) and min(point.weights) >= 0
    assert Point.of(corners[order], weights[order]) == point
    assert Point.of(point.corners, np.float32(point.weights)) == point
    assert point.vertex == corners[weights.argmax()] or np.ptp(np.sort(weights)[-2:]) < 1e-5


def test_points_at_vertices_and_on_edges():
    assert Point.of([4, 7, 2], [0, 1e-6, 3]) == Point.at(2) and Point.at(2).is_vertex
    edge = Point.of([9, 4, 7], [0.25, 0.75, 0])
    assert edge == Point((4, 9, 4), (0.75, 0.25, 0.0)) and edge.vertex == 4 and not edge.is_vertex
    assert edge == Point.of([9, 1, 4], [0.25, 0, 0.75])
