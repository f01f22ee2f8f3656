"""The face that comes along."""

import importlib.resources

import lissom
import numpy as np
import pytest
from faces import diagonal

PARTS = ("face", "head_and_neck", "mouth_socket", "eye_sockets")
PARTS += ("gums_and_tongue", "teeth", "eyeball_left", "eyeball_right")


@pytest.fixture(scope="module")
def face():
    return lissom.data.face()


def test_it_is_as_it_says(face):
    n = len(face.neutral)
    assert face.expressions.shape == (len(face.expression_names), n, 3) == (53, 22991, 3)
    assert face.modes.shape == (37, n, 3)
    assert face.counts.sum() == len(face.loops) and set(face.counts) == {3, 4}
    assert len(face.triangles) == (face.counts - 2).sum()
    assert sorted(np.concatenate([face.regions[part] for part in PARTS])) == list(range(n))
    assert lissom.Mesh(face.neutral, face.triangles).warnings == []
    with pytest.raises(ValueError, match="read-only"):
        face.neutral[0] = 0


def test_it_is_small_and_has_its_licence_beside_it():
    files = importlib.resources.files("lissom.data")
    assert len((files / "face.npz").read_bytes()) < 3e6
    assert "Permission is hereby granted" in (files / "LICENSE").read_text()


def test_it_looks_along_minus_y_with_z_up_and_its_left_at_positive_x(face):
    chin, nose, forehead = face.neutral[face.landmarks[[8, 30, 27]]]
    assert chin[2] < nose[2] < forehead[2]
    assert nose[1] == pytest.approx(face.neutral[face.landmarks, 1].min())
    for name in ("eyeball", "brow", "upper_lid", "lower_lid"):
        left, right = (face.neutral[face.regions[f"{name}_{side}"]].mean(0) for side in ("left", "right"))
        assert left[0] > 0 and left == pytest.approx(right * (-1, 1, 1), abs=0.05)


def test_regions_are_what_expressions_move(face):
    """A blink moves the upper lid most, an open jaw lowers what is below the mouth and nothing above."""

    def moves(expression, region):
        offsets = face.expressions[face.expression_names.index(expression)]
        return np.linalg.norm(offsets[face.regions[region]], axis=1)

    assert moves("eyeBlink_L", "upper_lid_left").mean() > 5 * moves("eyeBlink_L", "brow_left").mean()
    assert moves("browOuterUp_R", "brow_right").mean() > 5 * moves("browOuterUp_R", "upper_lip").mean()
    for above, below in (("upper_lip", "lower_lip"), ("upper_teeth", "lower_teeth")):
        assert moves("jawOpen", below).mean() > 3 * moves("jawOpen", above).mean()
    assert moves("jawOpen", "tongue").min() > 10 * moves("jawOpen", "upper_teeth").max()


def test_curves_go_along_edges_and_close(face):
    ends = np.stack([face.triangles, np.roll(face.triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges = set(map(tuple, np.sort(ends).tolist()))
    for name, curve in face.curves.items():
        assert curve[0] == curve[-1] and len(set(curve.tolist())) == len(curve) - 1
        pairs = np.sort(np.stack([curve[:-1], curve[1:]], axis=1))
        assert set(map(tuple, pairs.tolist())) <= edges, name


def test_a_part_of_it_is_the_same_face(face):
    eye = face.only("eyeball_left")
    kept = face.regions["eyeball_left"]
    assert np.array_equal(eye.neutral, face.neutral[kept])
    assert len(eye.triangles) == np.isin(face.triangles, kept).all(axis=1).sum()
    assert list(eye.regions) == ["eyeball_left"] and eye.curves == {}
    skin = face.only("face", "head_and_neck")
    assert np.array_equal(skin.neutral[skin.landmarks], face.neutral[face.landmarks])
    assert np.array_equal(skin.neutral[skin.curves["lips"]], face.neutral[face.curves["lips"]])


def test_it_is_the_face_that_was_packed(face, data):
    """To the rounding that it states, against the archives it was made of."""
    full, people = data("ict_face"), data("ict_identities")
    kept = np.r_[0:22221, 23021:23791]

    def away(own, theirs):
        x, y, z = np.moveaxis(theirs[:, kept].astype(float), -1, 0)
        return np.abs(own - np.stack([x, -z, y], axis=-1)).max()

    standard = np.isin(full["expression_names"], face.expression_names)
    assert away(face.neutral, full["neutral"][None]) < 0.51e-4
    assert away(face.expressions, full["expressions"][standard]) < 2.6e-4
    assert away(face.modes, people["modes"]) < 2.6e-3 < 1e-4 * diagonal(face.neutral)
