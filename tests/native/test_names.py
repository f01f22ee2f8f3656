"""Names of facial shape keys, and the sums that they stand for."""

import lissom
import numpy as np
import pytest
from lissom import names

# As Apple's headers declare them, `ARBlendShapeLocation...` left out.
APPLE = [
    "eyeBlinkLeft", "eyeLookDownLeft", "eyeLookInLeft", "eyeLookOutLeft", "eyeLookUpLeft", "eyeSquintLeft",
    "eyeWideLeft", "eyeBlinkRight", "eyeLookDownRight", "eyeLookInRight", "eyeLookOutRight", "eyeLookUpRight",
    "eyeSquintRight", "eyeWideRight", "jawForward", "jawLeft", "jawRight", "jawOpen", "mouthClose",
    "mouthFunnel", "mouthPucker", "mouthLeft", "mouthRight", "mouthSmileLeft", "mouthSmileRight",
    "mouthFrownLeft", "mouthFrownRight", "mouthDimpleLeft", "mouthDimpleRight", "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper",
    "mouthPressLeft", "mouthPressRight", "mouthLowerDownLeft", "mouthLowerDownRight", "mouthUpperUpLeft",
    "mouthUpperUpRight", "browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft",
    "browOuterUpRight", "cheekPuff", "cheekSquintLeft", "cheekSquintRight", "noseSneerLeft", "noseSneerRight",
    "tongueOut",
]  # fmt: skip


@pytest.fixture(scope="module")
def ict():
    face = lissom.data.face()
    return list(face.expression_names), face.expressions


def test_arkit_is_apples_52_in_order():
    assert len(APPLE) == 52
    assert list(names.ARKIT) == APPLE


def test_of_the_face_all_are_made_but_the_tongues(ict):
    made, offsets, lacking = names.combined("ARKIT", *ict)
    assert made == APPLE[:-1] and lacking == {"tongueOut": ["tongueOut"]}
    of = dict(zip(ict[0], ict[1], strict=True))
    used = [part for name in made for part in names.ARKIT[name]]
    assert sorted(used) == sorted(ict[0])  # each once
    for name, offset in zip(made, offsets, strict=True):
        assert np.array_equal(offset, sum(of[part] for part in names.ARKIT[name]))


@pytest.mark.parametrize("kind", ["VRM", "VISEMES"])
def test_combinations_are_the_same_from_either_names(ict, kind):
    made, offsets, lacking = names.combined(kind, *ict)
    assert made == list(names.SETS[kind]) and lacking == {}
    arkit, keys, _ = names.combined("ARKIT", *ict)
    again, others, _ = names.combined(kind, arkit, keys)
    assert again == made and np.allclose(others, offsets, rtol=0, atol=1e-14)
    assert set().union(*names.SETS[kind].values()) <= set(APPLE)
    assert all(0 < weight <= 1 for row in names.SETS[kind].values() for weight in row.values())


def test_sums_are_linear_and_say_what_they_lack():
    table = {"a": {"jawOpen": 0.5, "browInnerUp": 2.0}, "b": {"mouthClose": 1.0}, "c": {}}
    given = np.arange(18.0).reshape(3, 2, 3)
    made, offsets, lacking = names.combined(table, ["jawOpen", "browInnerUp_L", "browInnerUp_R"], given)
    assert made == ["a", "c"] and lacking == {"b": ["mouthClose"]}
    assert np.array_equal(offsets[0], 0.5 * given[0] + 2 * given[1] + 2 * given[2])
    assert not offsets[1].any()


def test_arkit_of_arkit_is_itself(ict):
    arkit, keys, _ = names.combined("ARKIT", *ict)
    again, same, lacking = names.combined("ARKIT", arkit, keys)
    assert again == arkit and np.array_equal(same, keys) and list(lacking) == ["tongueOut"]


def test_bad_input():
    with pytest.raises(ValueError, match=r"offsets: shape \(1, 2, 3\) with 2 names"):
        names.combined("ARKIT", ["a", "b"], np.zeros((1, 2, 3)))
    with pytest.raises(ValueError, match="names: 'a' comes twice"):
        names.combined("ARKIT", ["a", "a"], np.zeros((2, 2, 3)))
    with pytest.raises(KeyError):
        names.combined("FACS", ["a"], np.zeros((1, 2, 3)))
