"""Landmarks: the sets, against the landmarks of a face whose order is known."""

import re

import lissom
import numpy as np
import pytest
from lissom_addon_core import landmarks, marker_places


@pytest.mark.parametrize("kind", landmarks.SETS)
def test_names_are_unique_and_every_side_has_the_other(kind):
    found = {one.name: one.spot for one in landmarks.SETS[kind]}
    assert len(found) == len(landmarks.SETS[kind])
    for name, (x, y) in found.items():
        other = marker_places.flipped(name)
        if re.match("left|right", name):
            assert found[other] == (-x, y)
        else:
            assert x == 0, "without a side, and not in the middle"


@pytest.mark.parametrize(("kind", "count"), [("FACE_7", 7), ("FACE_24", 24), ("FACE_68", 68), ("BODY", 26)])
def test_sets_have_as_many_places_as_they_say(kind, count):
    assert len(landmarks.SETS[kind]) == count


def test_the_68_are_where_a_face_has_them():
    """In the order of the landmarks that faces come with: the picture is the face from the front."""
    shown = np.array([one.spot for one in landmarks.FACE], dtype=float)
    face = lissom.data.face()
    spots = face.neutral[face.landmarks][:, [0, 2]]
    low, high = spots.min(axis=0), spots.max(axis=0)
    assert np.abs(shown - 100 * (spots - (low + high) / 2) / (high - low).max()).max() < 1.0


def test_lines_go_through_places_that_there_are():
    for kind in landmarks.SETS:
        spots = {one.spot for one in landmarks.SETS["BODY" if kind == "BODY" else "FACE_68"]}
        assert all(spot in spots for line in landmarks.picture(kind) for spot in line)
    assert landmarks.picture("OWN") == []


def test_the_next_place_is_the_first_that_is_neither_marked_nor_skipped():
    names = ["a", "b", "c"]
    assert landmarks.upcoming(names, set(), set()) == "a"
    assert landmarks.upcoming(names, {"a"}, {"b"}) == "c"
    assert landmarks.upcoming(names, {"a", "c"}, {"b"}) is None


@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("chin", True),
        ("Marker 3", False),
        ("Suggested 12", False),
        ("Marker", True),
        ("", False),
        ("Marker x", True),
    ],
)
def test_numbers_are_no_names(name, own):
    assert landmarks.is_own_name(name) == own
