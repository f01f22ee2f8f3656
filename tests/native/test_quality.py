"""What a fit and a transfer say about themselves."""

import lissom
import numpy as np
import pytest
from faces import diagonal, slid, triangulate
from shapes import tube

VERTICES, FACES = tube(rows=50, columns=32, bumps=0.1)
KEYS = np.array([VERTICES + size * np.sin(2 * VERTICES[:, [1, 2, 0]]) for size in (0.05, 0.2)])
UPPER = [49, 50, 51, 52, 53, 61, 62, 63, 37, 38, 43, 44]  # landmarks of lips and lids
LOWER = [55, 56, 57, 58, 59, 65, 66, 67, 40, 41, 46, 47]
FACE = 9409  # vertices of the face come first
NUMBERS = {"flipped_triangles", "torn_triangles", "contacts", "contact_gap", "closing", "amplitude"}
NUMBERS |= {"crooked", "covered", "motion", "residual"}


def itself():
    mesh = lissom.Mesh(VERTICES, FACES)
    fit = lissom.fit_correspondence(mesh, mesh, np.zeros((0, 2), int))
    return lissom.Transfer(mesh, mesh, fit)


def test_a_transfer_onto_itself_has_nothing_to_say():
    transfer = itself()
    quality = transfer.quality(KEYS, transfer.apply(KEYS).vertices)
    assert set(quality) == NUMBERS | {"verdict", "reasons", "faces"}
    assert quality.verdict == ["good", "good"] and quality.reasons == [[], []]
    assert all(len(faces) == 0 and faces.dtype == np.int64 for faces in quality.faces)
    assert quality.residual.shape == (2,) and quality.residual.max() < 1e-6
    assert not quality.flipped_triangles.any() and not quality.torn_triangles.any()
    assert np.allclose(quality.amplitude, 1) and (quality.closing == 1).all() and (quality.covered == 1).all()
    motion = np.linalg.norm(KEYS - VERTICES, axis=2).max(axis=1)
    assert np.allclose(quality.motion, 100 * motion / diagonal(VERTICES))


def test_row_31_a_key_that_moves_nothing_is_good():
    transfer = itself()
    quality = transfer.quality(VERTICES[None], transfer.apply(VERTICES[None]).vertices)
    assert (
        quality.verdict == ["good"] and quality.amplitude[0] == quality.closing[0] == quality.covered[0] == 1
    )
    assert not any(quality[name].any() for name in NUMBERS - {"amplitude", "closing", "covered"})


def turned(rest, pose, patch):
    """The pose with the inner vertices of a patch mirrored through its middle: its faces turn over."""
    inner = np.setdiff1d(FACES[patch], np.delete(FACES, patch, axis=0))
    assert len(inner) > 3
    middle = pose[inner].mean(0)
    normal = np.cross(*(pose[FACES[patch[0]]][1:] - pose[FACES[patch[0]]][0]))
    tangent = np.cross(normal, [1, 0, 0]) / np.linalg.norm(np.cross(normal, [1, 0, 0]))
    spoiled = pose.copy()
    spoiled[inner] -= 2 * ((pose[inner] - middle) @ tangent)[:, None] * tangent
    return spoiled


def test_a_patch_that_is_turned_over_is_bad_and_named():
    transfer = itself()
    good = transfer.apply(KEYS).vertices
    centres = VERTICES[FACES].mean(axis=1)
    patch = np.flatnonzero(np.linalg.norm(centres - centres[700], axis=1) < 0.6)
    quality = transfer.quality(KEYS, np.stack([turned(VERTICES, good[0], patch), good[1]]))
    assert quality.verdict == ["bad", "good"]
    count = quality.flipped_triangles[0]
    assert quality.reasons[0][0] == f"{count} triangles turned over" and count > len(patch) / 4
    assert np.isin(quality.faces[0], patch).all() and len(quality.faces[0]) >= count
    assert (np.diff(quality.faces[0]) > 0).all()


def test_one_triangle_that_is_turned_over_deserves_a_look():
    transfer = itself()
    pushed = transfer.apply(KEYS).vertices
    around = FACES[(FACES == 700).any(axis=1)]
    corner = around[0]
    middle = pushed[0, np.setdiff1d(corner, 700)].mean(axis=0)
    pushed[0, 700] += 1.2 * (middle - pushed[0, 700])
    quality = transfer.quality(KEYS, pushed)
    assert quality.verdict[1] == "good" and quality.verdict[0] != "good"
    assert 1 <= quality.flipped_triangles[0] <= 2
    assert "turned over" in quality.reasons[0][0]


@pytest.mark.parametrize(
    ("part", "verdict", "text"),
    [
        (0.1, "bad", "moves only 10 % as far as on the source"),
        (0.5, "look", "moves only 50 % as far as on the source"),
        (0.9, "good", None),
        (1.2, "good", None),
        (2.0, "look", "moves 200 % as far as on the source"),
        (3.0, "bad", "moves 300 % as far as on the source"),
    ],
)
def test_a_key_with_a_part_of_its_motion(part, verdict, text):
    transfer = itself()
    good = transfer.apply(KEYS[:1]).vertices
    quality = transfer.quality(KEYS[:1], VERTICES + part * (good - VERTICES))
    assert np.isclose(quality.amplitude[0], part)
    assert quality.verdict == [verdict] and quality.reasons == [[text] if text else []]


def test_what_somebody_else_has_led_says_nothing_about_the_amplitude():
    transfer = itself()
    good = transfer.apply(KEYS[:1]).vertices
    up = VERTICES[:, 2:] - np.median(VERTICES[:, 2])
    times = 1 + 4 * np.clip(up / up.max(), 0, 1) ** 2
    further, led = VERTICES + times * (good - VERTICES), np.flatnonzero(times > 1)
    assert transfer.quality(KEYS[:1], further).amplitude[0] > 1.5
    assert np.isclose(transfer.quality(KEYS[:1], further, led).amplitude[0], 1)
    assert np.isclose(transfer.quality(KEYS[:1], further, np.arange(len(VERTICES))).amplitude[0], 1)
    with pytest.raises(lissom.InvalidConstraint, match="led") as error:
        transfer.quality(KEYS[:1], good, [0, len(VERTICES)])
    assert error.value.indices == [len(VERTICES)]


@pytest.mark.parametrize(("scale", "amplitude"), [("target", 1), ("source", 1)])
def test_amplitude_counts_from_the_scale_that_was_asked_for(scale, amplitude):
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(3 * VERTICES, FACES)
    fit = lissom.fit_correspondence(source, target, np.zeros((0, 2), int))
    transfer = lissom.Transfer(source, target, fit, scale=scale)
    quality = transfer.quality(KEYS, transfer.apply(KEYS).vertices)
    assert np.allclose(quality.amplitude, amplitude) and quality.verdict == ["good", "good"]


def test_a_torn_triangle_is_named():
    transfer = itself()
    torn = transfer.apply(KEYS).vertices
    corner = FACES[900]
    normal = np.cross(torn[0, corner[1]] - torn[0, corner[0]], torn[0, corner[2]] - torn[0, corner[0]])
    torn[0, corner[0]] += 1.5 * normal / np.linalg.norm(normal)
    quality = transfer.quality(KEYS, torn)
    assert quality.torn_triangles[0] >= 4 and quality.verdict[0] != "good"
    assert "torn" in " ".join(quality.reasons[0]) and 900 in quality.faces[0]


def test_a_small_key_is_judged_as_a_large_one_is():
    # What is lost on the way back was once told relative to the key, and grew beyond all bounds.
    transfer = itself()
    small = VERTICES + 1e-3 * (KEYS - VERTICES)
    noise = np.random.default_rng(1).normal(scale=2e-5, size=VERTICES.shape)
    quality = transfer.quality(small, transfer.apply(small).vertices + noise)
    assert quality.verdict == ["good", "good"]


def test_left_and_right_are_compared_where_both_meshes_and_the_key_are_even():
    vertices, faces = tube(rows=50, columns=32, bumps=0)
    mesh = lissom.Mesh(vertices, faces)
    transfer = lissom.Transfer(mesh, mesh, lissom.fit_correspondence(mesh, mesh, np.zeros((0, 2), int)))
    x, y, z = vertices.T
    end = np.clip(np.cos(x), 0, 1)
    bulge = np.exp(-((x - 3) ** 2))
    even = vertices + 0.1 * np.column_stack([np.sin(2 * y + 1) * end, 0.5 * np.cos(y) * end, z * bulge])
    good = transfer.apply(even[None]).vertices
    assert transfer.quality(even[None], good).crooked[0] < 0.02
    weaker = vertices + (good - vertices) * np.where(z > 0, 1.0, 0.75)[:, None]
    quality = transfer.quality(even[None], weaker)
    assert quality.verdict == ["look"] and quality.crooked[0] > 0.2
    assert any("left and right differ" in reason for reason in quality.reasons[0])
    # A key that is of one side already is not measured by the other.
    one = vertices + (even - vertices) * (z > 0)[:, None]
    assert transfer.quality(one[None], transfer.apply(one[None]).vertices).crooked[0] == 0


def test_a_blink_that_does_not_close_is_told(data):
    archive = data("ict_face")
    neutral = archive["neutral"].astype(float)
    keys = neutral + archive["expressions"].astype(float)
    faces = triangulate(archive["loops"], archive["counts"])
    mesh = lissom.Mesh(neutral, faces)
    transfer = lissom.Transfer(mesh, mesh, lissom.fit_correspondence(mesh, mesh, np.zeros((0, 2), int)))
    carried = transfer.apply(keys).vertices
    quality = transfer.quality(keys, carried)
    assert quality.verdict == ["good"] * len(keys), "a perfect transfer"
    assert (quality.closing > 0.99).all() and (quality.contacts > 10).sum() > 3
    blink = archive["expression_names"].tolist().index("eyeBlink_L")
    for part, verdict in ((0.85, "look"), (0.5, "bad")):
        half = neutral + part * (carried[[blink]] - neutral)
        quality = transfer.quality(keys[[blink]], half)
        assert quality.verdict == [verdict]
        assert any(reason.startswith("closes only") for reason in quality.reasons[0])
        assert len(quality.faces[0]) > 20
        lids = neutral[faces[quality.faces[0]]].reshape(-1, 3)
        assert np.ptp(lids[:, 0]) < 0.2 * np.ptp(neutral[:, 0]), "the faces are those of one eye"


def test_row_03_other_numbers_of_keys_and_values_that_are_not_finite():
    transfer = itself()
    with pytest.raises(lissom.InvalidValue, match="vertices: 1 for 2 poses"):
        transfer.quality(KEYS, KEYS[:1])
    with pytest.raises(ValueError, match="vertices"):
        transfer.quality(KEYS, KEYS[:, :-1])
    with pytest.raises(lissom.InvalidValue, match=r"vertices\[0\]: not finite"):
        transfer.quality(KEYS, np.where(np.arange(len(VERTICES))[:, None] == 5, np.nan, KEYS))


def test_a_fit_says_how_good_it_is_where():
    source = lissom.Mesh(VERTICES, FACES)
    larger = VERTICES * [1, 1, 12] * 3
    mesh = lissom.Mesh(larger, FACES[::-1])
    marked = np.arange(0, len(VERTICES), 7)
    fit = lissom.fit_correspondence(
        source, mesh, np.column_stack([marked, marked]), source_mask=np.arange(3), target_mask=np.arange(5)
    )
    assert np.isnan(fit.distances[:3]).all() and np.isnan(fit.image_distances[:5]).all()
    assert np.isclose(np.nanmean(fit.distances), fit.report["distance_mean"])
    assert np.isclose(np.nanmax(fit.distances), fit.report["distance_max"])
    told = fit.image_triangles >= 0
    assert np.array_equal(told, np.isfinite(fit.image_distances))
    at = np.einsum("nk,nkc->nc", fit.image_weights, fit.fitted_vertices[FACES[fit.image_triangles]])
    assert np.allclose(np.linalg.norm(at - larger, axis=1)[told], fit.image_distances[told], atol=1e-9)
    singular = np.linalg.svd(
        in_plane(fit.fitted_vertices) @ np.linalg.inv(in_plane(VERTICES)), compute_uv=False
    )
    usual = np.median(np.sqrt(singular.prod(axis=1)))
    assert np.allclose(fit.distortion, np.maximum(singular[:, 0] / usual, usual / singular[:, 1]), rtol=0.01)
    assert fit.report["distorted_triangles"] > 100
    assert fit.report["distorted_triangles"] == (fit.distortion > 3).sum()
    assert fit.report["flipped_triangles"] == len(fit.flipped)


def in_plane(vertices):
    """(m, 2, 2): two edges of each triangle as columns, in a frame of its own plane."""
    a, b = (vertices[FACES[:, k]] - vertices[FACES[:, 0]] for k in (1, 2))
    along = a / np.linalg.norm(a, axis=1, keepdims=True)
    x = (b * along).sum(1)
    y = np.linalg.norm(b - x[:, None] * along, axis=1)
    return np.moveaxis(np.array([[np.linalg.norm(a, axis=1), x], [0 * x, y]]), 2, 0)


def test_lips_and_lids_match_their_own_side_with_mouth_and_eyes_closed(data):
    archive = data("ict_face")
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    names = archive["expression_names"].tolist()
    offsets = dict(zip(names, archive["expressions"].astype(float), strict=True))
    faces, other = (triangulate(archive["loops"], archive["counts"], turn=turn) for turn in (0, 1))
    shut = ("eyeBlink_L", "eyeBlink_R", "mouthPress_L", "mouthPress_R")
    pose = sum(offsets[name] for name in shut)
    side = sides(neutral, faces, landmarks)
    assert (side > 0).sum() > 500 and (side < 0).sum() > 500
    corners, weights = slid(neutral, other, landmarks)
    at_rest, shut = (
        np.einsum("nk,nkc->nc", weights, (neutral + archive["identities"][0] + offset)[corners])
        for offset in (0, pose)
    )
    few = landmarks[[8, 19, 24, 30, 36, 45, 48, 54]]
    for name, start, end, markers, most in (
        ("both closed", neutral + pose, shut, landmarks, 0),
        ("both closed, eight markers", neutral + pose, shut, few, 0.005),
        ("onto the closed", neutral, shut, landmarks, 0.005),
        ("onto the open", neutral + pose, at_rest, landmarks, 0.005),
    ):
        fit = lissom.fit_correspondence(
            lissom.Mesh(start, faces), lissom.Mesh(end, other), np.column_stack([markers, markers])
        )
        on = (fit.image_weights * side[faces[fit.image_triangles]]).sum(1)
        asked = (side != 0) & (fit.image_triangles >= 0)
        wrong = (on * side < 0)[asked].mean()
        assert asked.sum() > 1500
        assert wrong <= most, f"{name}: {wrong:.4f} on the wrong side"


def sides(vertices, faces, landmarks):
    """(n,) 1 near the upper lips and lids, -1 near the lower ones, along the face; 0 elsewhere."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    found = []
    for seeds in (UPPER, LOWER):
        distance = np.full(len(vertices), np.inf)
        distance[landmarks[seeds]] = 0
        for _ in range(60):  # edges: far beyond what counts as near
            np.minimum.at(distance, edges[:, 1], distance[edges[:, 0]] + lengths)
        found.append(distance)
    upper, lower = found
    near = (np.minimum(upper, lower) < 1.2) & (np.arange(len(vertices)) < FACE)
    return np.where(near & (upper < 0.6 * lower), 1, 0) - np.where(near & (lower < 0.6 * upper), 1, 0)


def test_what_has_no_counterpart_is_counted_and_told():
    """Only the end that hardly moves is matched."""
    mesh = lissom.Mesh(VERTICES, FACES)
    far = VERTICES[FACES].mean(axis=1)[:, 0]
    same = np.column_stack([np.arange(len(FACES))] * 2)[far < np.quantile(far, 0.3)]
    transfer = lissom.Transfer(mesh, mesh, same)
    key = VERTICES + 0.05 * VERTICES[:, :1] ** 2 * [0, 0, 1]
    quality = transfer.quality(key[None], transfer.apply(key[None]).vertices)
    assert quality.covered[0] < 0.5 and quality.verdict != ["good"]
    percent = round(100 * quality.covered[0])
    assert f"only {percent} % of what moves on the source has a counterpart" in quality.reasons[0]
