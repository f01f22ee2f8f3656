"""Markers found again, and completed by symmetry."""

import numpy as np
import pytest
from lissom_addon_core import marks
from lissom_addon_core.markers import Marker


def sphere(count=3000, seed=0):
    """Points of the unit sphere and their mirror images: vertex i + count is that of vertex i."""
    half = np.random.default_rng(seed).normal(size=(count, 3))
    half /= np.linalg.norm(half, axis=1)[:, None]
    half[:, 0] = np.abs(half[:, 0])
    return np.concatenate([half, half * [-1, 1, 1]])


def test_the_image_of_a_vertex_is_its_like_on_the_other_side():
    vertices = sphere()
    marked = np.flatnonzero(np.abs(vertices[:, 0]) > 0.1)[::97]
    found = marks.mirrored(vertices, marked, 0)
    assert np.array_equal(found, (marked + 3000) % 6000)
    turned = vertices[:, [2, 0, 1]]
    assert np.array_equal(marks.mirrored(turned, marked, 1), found)


def test_the_middle_is_its_own_image_and_half_a_mesh_has_none():
    vertices = sphere()[:3000]
    vertices[7] = [0.001, 0, 1]
    away = int(np.argmax(vertices[:, 0]))
    assert marks.mirrored(vertices, [7, away], 0).tolist() == [7, -1]


def test_pairs_are_completed_once_and_only_where_asked():
    pairs = [
        Marker("left eye", 1, 11),
        Marker("nose", 2, 12),
        Marker("mouth.L", 3, 13),
        Marker("mouth.R", 4, 14),
        Marker("scar", 5, 15, mirror=False),
        Marker("left ear", 6, 16),
    ]
    sources, targets = [21, 2, 4, 3, 25, -1], [31, 12, 14, 13, 35, 36]
    added, lost = marks.completed(pairs, sources, targets)
    assert added == [Marker("right eye", 21, 31)] and lost == ["left ear"]
    again = marks.completed([*pairs, *added], [*sources, 1], [*targets, 11])
    assert again == ([], ["left ear"])


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
    assert marks.flipped(name) == other


def test_neighbours_in_the_list_have_different_colours():
    colours = np.array([marks.colour(number) for number in range(100)])
    assert ((colours >= 0) & (colours <= 1)).all()
    for step in (1, 2, 3):
        assert np.linalg.norm(colours[step:] - colours[:-step], axis=1).min() > 0.2
