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
NAMES = {"residual", "flipped_triangles", "contacts", "contact_gap", "round_trip", "motion"}


def itself():
    mesh = lissom.Mesh(VERTICES, FACES)
    fit = lissom.fit_correspondence(mesh, mesh, np.zeros((0, 2), int))
    return lissom.Transfer(mesh, mesh, fit)


def test_a_transfer_onto_itself_has_nothing_to_say():
    transfer = itself()
    quality = transfer.quality(KEYS, transfer.apply(KEYS).vertices)
    assert set(quality) == NAMES
    for name in ("residual", "round_trip"):
        assert quality[name].shape == (2,) and quality[name].max() < 1e-6, name
    assert not quality["flipped_triangles"].any()
    motion = np.linalg.norm(KEYS - VERTICES, axis=2).max(axis=1)
    assert np.allclose(quality["motion"], 100 * motion / diagonal(VERTICES))


def test_row_31_a_key_that_moves_nothing_has_zeros():
    transfer = itself()
    quality = transfer.quality(VERTICES[None], transfer.apply(VERTICES[None]).vertices)
    assert all(not values.any() for values in quality.values())


def test_what_is_wrong_with_a_key_shows():
    transfer = itself()
    good = transfer.apply(KEYS).vertices
    noise = np.random.default_rng(1).normal(scale=0.002, size=VERTICES.shape)
    spoiled = np.stack([good[0] + noise, good[1]])
    quality = transfer.quality(KEYS, spoiled)
    assert quality["residual"][0] > 100 * quality["residual"][1]
    assert quality["round_trip"][0] > 0.01 > quality["round_trip"][1]
    pushed = good.copy()
    around = FACES[(FACES == 700).any(axis=1)]
    pushed[0, 700] += 3 * (good[0, around[0]].mean(axis=0) - good[0, 700])
    quality = transfer.quality(KEYS, pushed)
    assert 1 <= quality["flipped_triangles"][0] <= len(around) and not quality["flipped_triangles"][1]


def test_the_round_trip_is_the_way_back_by_hand():
    vertices, faces = tube(rows=37, columns=24, bumps=0.1)
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(vertices, faces)
    pairs = [(int(r * 49) * 32 + 4 * k, int(r * 36) * 24 + 3 * k) for r in (0, 0.5, 1) for k in range(8)]
    there = lissom.Transfer(source, target, lissom.fit_correspondence(source, target, pairs))
    carried = there.apply(KEYS).vertices
    found = there.quality(KEYS, carried)["round_trip"]
    assert (found > 0).all() and found.max() < 0.1
    back = lissom.Transfer(
        target, source, lissom.fit_correspondence(target, source, np.array(pairs)[:, ::-1])
    )
    error = np.linalg.norm(back.apply(carried).vertices - KEYS, axis=2)
    own = np.linalg.norm(KEYS - VERTICES, axis=2)
    by_hand = np.sqrt((error**2).sum(1) / (own**2).sum(1))
    assert (found < 2 * by_hand + 0.01).all() and (by_hand < 2 * found + 0.01).all()


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
    assert np.allclose(fit.stretch, np.maximum(singular[:, 0] / usual, usual / singular[:, 1]), rtol=0.01)
    assert fit.report["stretched_triangles"] > 100
    assert fit.report["stretched_triangles"] == (fit.stretch > 3).sum()
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
