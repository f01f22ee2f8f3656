"""Landmarks of an outside detector are read by name or in the order of Multi-PIE, and nothing else is."""

import json

import pytest
from lissom_addon_core import landmark_file
from lissom_addon_core.landmarks import FACE
from lissom_addon_core.refused import Refused

NAMES = [mark.name for mark in FACE]
PLACES = [[float(k), 0.5, -1.0] for k in range(len(FACE))]


@pytest.mark.parametrize("under", [None, "landmarks", "points"])
def test_the_68_are_read_in_their_order(tmp_path, under):
    path = tmp_path / "found.json"
    path.write_text(json.dumps(PLACES if under is None else {under: PLACES, "image": "head.png"}))
    found = landmark_file.load(str(path), NAMES)
    assert list(found) == NAMES and found["left eye, outer corner"] == (45.0, 0.5, -1.0)


def test_some_are_read_by_name():
    text = json.dumps(dict(zip(NAMES[30:34], PLACES, strict=False)))
    assert landmark_file.read(text, NAMES) == dict(zip(NAMES[30:34], map(tuple, PLACES), strict=False))


@pytest.mark.parametrize(
    ("found", "why"),
    [
        (PLACES[:5], "a list of 5 points: expected 68"),
        ({"chin of a cow": [0, 0, 0]}, "no landmarks of a face: 'chin of a cow'"),
        ({NAMES[0]: [0, 0]}, "three finite numbers for 'right ear'"),
        ({NAMES[0]: [0, 0, float("inf")]}, "three finite numbers"),
        ({NAMES[0]: [0, 0, 0], NAMES[1]: [0, 0, 1]}, "2 landmarks: 3 are needed"),
        ("text", "by name, or a list"),
    ],
)
def test_what_is_none_is_refused(found, why):
    with pytest.raises(Refused, match=why):
        landmark_file.read(json.dumps(found), NAMES)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    with pytest.raises(Refused, match="does not exist"):
        landmark_file.load(str(tmp_path / "none.json"), NAMES)
    path = tmp_path / "large.json"
    path.write_bytes(b" " * (landmark_file.MOST_BYTES + 1))
    with pytest.raises(Refused, match="larger than 1 MiB"):
        landmark_file.load(str(path), NAMES)
    path.write_bytes(b"\xff\xfe[")
    with pytest.raises(Refused, match=r"large\.json"):
        landmark_file.load(str(path), NAMES)
