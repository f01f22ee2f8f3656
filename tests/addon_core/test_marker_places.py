"""Markers found again, and completed by symmetry."""

import numpy as np
import pytest
from lissom_addon_core import marker_places
from lissom_addon_core.markers import Marker
from lissom_addon_core.surface import Point


def half_sphere(rings=12, around=24):
    """One half of a sphere by its other, x > 0: vertices (n, 3) and triangles (m, 3)."""
    up, turn = np.meshgrid(np.linspace(0.1, 3.0, rings), np.linspace(0, np.pi, around), indexing="ij")
    vertices = np.stack([np.sin(up) * np.sin(turn), np.sin(up) * np.cos(turn), np.cos(up)], axis=-1)
    corner = np.arange(rings * around).reshape(rings, around)
    quads = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    a, b, c, d = (quad.ravel() for quad in quads)
    return vertices.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def sphere():
    """Both halves; vertex i + n is the mirror image of vertex i."""
    vertices, triangles = half_sphere()
    return np.concatenate([vertices, vertices * [-1, 1, 1]]), np.concatenate(
        [triangles, triangles[:, ::-1] + len(vertices)]
    )


def inside(triangles, seed, count=20):
    """Random points of random triangles."""
    random = np.random.default_rng(seed)
    rows = random.choice(triangles, count)
    return [
        Point.of(row, weights) for row, weights in zip(rows, random.dirichlet([1, 1, 1], count), strict=True)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_the_image_of_a_point_is_its_like_on_the_other_side(seed):
    vertices, triangles = sphere()
    n = len(vertices) // 2
    points = [point for point in inside(triangles, seed) if abs(point.position(vertices)[0]) > 0.05]
    found = marker_places.mirrored(vertices, triangles, points, 0)
    for point, image in zip(points, found, strict=True):
        assert np.allclose(image.position(vertices), point.position(vertices) * [-1, 1, 1], atol=2e-4)
        assert {(corner + n) % (2 * n) for corner in point.corners} == set(image.corners)
    turned = vertices[:, [2, 0, 1]]
    assert marker_places.mirrored(turned, triangles, points, 1) == found


def test_the_middle_is_its_own_image_and_half_a_mesh_has_none():
    vertices, triangles = half_sphere()
    middle = next(p for p in inside(triangles, 1, 999) if 1e-3 < p.position(vertices)[0] < 0.02)
    away = Point.at(int(np.argmax(vertices[:, 0])))
    assert marker_places.mirrored(vertices, triangles, [middle, away], 0) == [middle, None]


def test_what_was_moved_off_the_surface_is_not_found_again():
    vertices, triangles = half_sphere()
    points = inside(triangles, 2)
    places = np.array([point.position(vertices) for point in points])
    places[3] *= 1.2
    places[5] *= 1.01
    found = marker_places.found_again(vertices, triangles, places)
    assert [number for number, point in enumerate(found) if point is None] == [3]
    assert np.allclose(found[5].position(vertices), places[5] / 1.01, atol=2e-3)
    assert marker_places.found_again(vertices, triangles[:0], places) == [None] * len(places)


@pytest.mark.parametrize("seed", range(5))
def test_pairs_are_completed_once_and_only_where_asked(seed):
    vertices, triangles = sphere()
    own = half_sphere()[1]
    points = [point for point in inside(own, seed, 99) if point.position(vertices)[0] > 0.2][:6]
    others = inside(own, seed + 50, 99)
    others = [point for point in others if point.position(vertices)[0] > 0.2][:6]
    pairs = [Marker.between(f"left {n}", *ends) for n, ends in enumerate(zip(points, others, strict=True))]
    pairs[2] = pairs[2]._replace(mirror=False)

    def images(pairs):
        return [
            marker_places.mirrored(vertices, triangles, [marker.point(side) for marker in pairs], 0)
            for side in ("source", "target")
        ]

    rests = vertices, vertices
    added, lost = marker_places.completed(pairs, images(pairs), rests)
    assert [marker.name for marker in added] == [f"right {n}" for n in (0, 1, 3, 4, 5)] and not lost
    whole = [*pairs, *added]
    assert marker_places.completed(whole, images(whole), rests) == ([], [])
    nothing = images(pairs)
    nothing[1][4] = None
    assert marker_places.completed(pairs, nothing, rests)[1] == ["left 4"]


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("left corner of the mouth", "right corner of the mouth"),
        ("Eye_R", "Eye_L"),
        ("lid.l.upper", "lid.r.upper"),
        ("Right Ear", "Left Ear"),
        ("EYE_LEFT", "EYE_RIGHT"),
        ("lower lip", "lower lip mirrored"),
        ("leftover", "leftover mirrored"),
    ],
)
def test_names_of_the_other_side(name, other):
    assert marker_places.flipped(name) == other


def test_neighbours_in_the_list_have_different_colours():
    colours = np.array([marker_places.colour(number) for number in range(1, 101)])
    assert ((colours >= 0) & (colours <= 1)).all()
    for step in (1, 2, 3):
        assert np.linalg.norm(colours[step:] - colours[:-step], axis=1).min() > 0.2
