"""Names of face keys in other places, as sums of ICT FaceKit's."""

import pathlib

import numpy as np
import pytest
from lissom import data, names


@pytest.fixture(scope="module")
def ict():
    return list(data.face().expression_names)


def test_arkits_52_are_apples_in_their_order(ict):
    known = names.TABLES["ARKIT"]
    assert len(known) == 52 and len(set(known)) == 52
    offsets = np.random.default_rng(0).normal(size=(len(ict), 7, 3))
    found, keys, left = names.combined("ARKIT", ict, offsets)
    assert left == ["tongueOut"] and found == [name for name in known if name != "tongueOut"]
    assert found[:3] == ["eyeBlinkLeft", "eyeLookDownLeft", "eyeLookInLeft"] and found[-1] == "noseSneerRight"
    used = [part for parts in known.values() for part in parts]
    assert len(used) == len(set(used)) and set(used) - {"tongueOut"} == set(ict), "each of ICT's once"
    both = offsets[ict.index("browInnerUp_L")] + offsets[ict.index("browInnerUp_R")]
    assert np.array_equal(keys[found.index("browInnerUp")], both)
    assert np.array_equal(keys[found.index("mouthLeft")], offsets[ict.index("mouthLeft")])
    assert np.array_equal(keys[found.index("eyeBlinkRight")], offsets[ict.index("eyeBlink_R")])


def test_every_set_has_a_table_and_a_row_in_the_manual():
    assert set(names.TABLES) == set(names.SETS) - {"ICT"}, (
        "each of SETS is a sum of ICT's, but these themselves"
    )
    page = pathlib.Path(__file__).parents[2] / "docs" / "face_keys_elsewhere.md"
    told = page.read_text(encoding="utf-8")
    for label, _ in names.SETS.values():
        assert f"\n| {label} |" in told, f"{label} is missing in the table of {page.name}"


@pytest.mark.parametrize(("kind", "count"), [("VRM", 18), ("VISEMES", 15)])
def test_other_sets_are_sums_of_keys_that_there_are(ict, kind, count):
    offsets = np.eye(len(ict))
    found, keys, left = names.combined(kind, ict, offsets)
    assert len(found) == count and not left
    for name, row in zip(found, keys, strict=True):
        assert (row >= 0).all() and (row <= 1).all()
        assert row.any() != (name in ("neutral", "viseme_sil")), name
        mirror = {key: row[ict.index(key)] for key in ict if key.endswith("_L")}
        sided = any(word in name for word in ("Left", "Right"))
        same = all(row[ict.index(key[:-2] + "_R")] == value for key, value in mirror.items())
        assert same != sided, name


def test_icts_own_stay_and_others_are_refused(ict):
    offsets = np.eye(len(ict))
    found, keys, left = names.combined("ICT", ict, offsets)
    assert found == ict and keys is offsets and left == []
    with pytest.raises(ValueError, match="expected one of ARKIT"):
        names.combined("FACS", ict, offsets)


def test_what_is_made_of_missing_keys_is_left_out_and_told():
    found, keys, left = names.combined("VISEMES", ["jawOpen"], np.ones((1, 2)))
    assert found == ["viseme_sil"] and not keys.any()
    assert len(left) == 14
