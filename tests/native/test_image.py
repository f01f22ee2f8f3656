"""Images: where the target's vertices lie on the fitted source, markers as points, and what anchors do."""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square, triangulate
from shapes import moved, rigid, tube

VERTICES, FACES = tube(rows=60, columns=40, bumps=0.1)
MARKED = np.arange(0, len(VERTICES), 60)


def on_source(fit, values):
    """(n_target, 3): values at the source's vertices, at the images."""
    return np.einsum("nk,nkc->nc", fit.image_weights, values[FACES[fit.image_triangles]])


def test_the_images_of_a_mesh_on_itself_are_its_vertices():
    mesh = lissom.Mesh(VERTICES, FACES)
    fit = lissom.fit_correspondence(mesh, mesh, np.column_stack([MARKED, MARKED]))
    assert (fit.image_triangles >= 0).all()
    assert np.allclose(fit.image_weights.sum(1), 1) and fit.image_weights.min() >= 0
    assert np.abs(on_source(fit, VERTICES) - VERTICES).max() < 1e-6


def test_keys_come_over_vertex_by_vertex():
    # The same surface, a third as dense: pairs of whole triangles would shift keys by half a triangle.
    coarse = np.arange(len(VERTICES)).reshape(60, 40)[::2, ::2]
    rows, columns = coarse.shape
    _, faces = tube(rows=rows, columns=columns)
    vertices = VERTICES[coarse.ravel()]
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(vertices, faces)
    picked = np.arange(0, len(vertices), 25)
    fit = lissom.fit_correspondence(source, target, np.column_stack([coarse.ravel()[picked], picked]))
    key = VERTICES + 0.2 * np.sin(2 * VERTICES[:, [1, 2, 0]])
    expected = key[coarse.ravel()] - vertices
    errors = {}
    for name, pairs in (("images", fit), ("pairs", fit.pairs)):
        result = lissom.Transfer(source, target, pairs).apply([key]).vertices[0] - vertices
        drift = (result - expected).mean(axis=0)
        errors[name] = root_mean_square(result - expected - drift) / root_mean_square(expected)
    assert errors["images"] < 0.03
    assert errors["images"] < 0.5 * errors["pairs"]


def test_a_marker_may_be_any_point_of_the_target():
    source = lissom.Mesh(VERTICES, FACES)
    target = lissom.Mesh(VERTICES * 3 + 1, FACES)
    middle = VERTICES[FACES[::200]].mean(axis=1) * 3 + 1
    pairs = np.column_stack([FACES[::200, 0], FACES[::200, 1]])
    fit = lissom.fit_correspondence(source, target, pairs, middle, marker_tolerance=0)
    assert np.abs(fit.fitted_vertices[pairs[:, 0]] - middle).max() < 1e-12 * diagonal(VERTICES * 3)


def test_the_same_triangles_need_no_markers():
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(2 * VERTICES + [0, 0, 1], FACES)
    fit = lissom.fit_correspondence(source, target, np.zeros((0, 2), int))
    assert np.array_equal(fit.pairs, np.column_stack([np.arange(len(FACES))] * 2))
    assert np.array_equal(on_source(fit, VERTICES), VERTICES)
    key = VERTICES + 0.1 * np.sin(3 * VERTICES)
    result = lissom.Transfer(source, target, fit).apply([key]).vertices[0]
    assert np.abs(result - (2 * key + [0, 0, 1])).max() < 1e-6
    other = lissom.Mesh(VERTICES, FACES[::-1])
    with pytest.raises(lissom.InvalidConstraint, match="markers: none given"):
        lissom.fit_correspondence(source, other, np.zeros((0, 2), int))


@pytest.mark.parametrize(
    ("points", "text"),
    [(np.zeros((2, 3)), "2 for 3 markers"), (np.full((3, 3), np.nan), r"points.*not finite \(at 0, 1, 2; 3")],
)
def test_rows_03_and_09_points_that_cannot_be_used(points, text):
    mesh = lissom.Mesh(VERTICES, FACES)
    with pytest.raises(lissom.Error, match=text):
        lissom.fit_correspondence(mesh, mesh, [[0, 0], [70, 70], [900, 900]], points)


@pytest.mark.parametrize("anchor", [0, -1, np.nan])
def test_row_03_an_anchor_that_is_no_length(anchor):
    mesh = lissom.Mesh(VERTICES, FACES)
    with pytest.raises(lissom.InvalidValue, match="anchor: must be a positive number"):
        lissom.Transfer(mesh, mesh, [[0, 0]], anchor=anchor)


@pytest.mark.parametrize("anchor", [0.05, 1.0, np.inf])
def test_similarities_are_exact_whatever_the_anchor(anchor):
    source = lissom.Mesh(VERTICES, FACES)
    vertices, faces = tube(rows=45, columns=30)
    target = lissom.Mesh(vertices * 5, faces)
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    pairs = [
        (int(r * 59) * 40 + int(40 * a / (2 * np.pi)), int(r * 44) * 30 + int(30 * a / (2 * np.pi)))
        for r in (0, 0.5, 1)
        for a in angle
    ]
    fit = lissom.fit_correspondence(source, target, pairs)
    motion = rigid((1, 2, 3), 2.0, (4, 0, -1))
    result = lissom.Transfer(source, target, fit, anchor=anchor).apply(moved(motion, VERTICES * 1.5)[None])
    result = result.vertices[0]
    edges = (result - result[0]) - 1.5 * (5 * vertices - 5 * vertices[0]) @ motion[:3, :3].T
    assert np.abs(edges).max() < 1e-7 * diagonal(5 * vertices)


def test_eyeballs_and_teeth_stay_rigid_on_another_face(data):
    archive = data("ict_face")
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    faces, other = (triangulate(archive["loops"], archive["counts"], turn=turn) for turn in (0, 1))
    vertices = neutral + archive["identities"][0]
    source, target = lissom.Mesh(neutral, faces), lissom.Mesh(vertices, other)
    fit = lissom.fit_correspondence(source, target, np.column_stack([landmarks, landmarks]))
    # Neutral teeth and eyeballs, turned about an axis behind them; the face stays.
    key = neutral.copy()
    loose = slice(17039, 24591)
    key[loose] = moved(rigid((1, 0.2, 0), 0.3, (0, 8, -3)), neutral[loose])
    result = lissom.Transfer(source, target, fit).apply(key[None]).vertices[0]
    pieces = components(len(neutral), faces)
    checked = [np.flatnonzero(pieces == piece) for piece in np.unique(pieces[loose]) if piece >= loose.start]
    assert len(checked) > 20
    for of in checked:
        assert off_rigid(neutral[of], key[of]) < 1e-12
        assert off_rigid(vertices[of], result[of]) < 1e-6
        turned = np.linalg.norm(result[of] - vertices[of], axis=1)
        assert 0.7 < turned.mean() / np.linalg.norm(key[of] - neutral[of], axis=1).mean() < 1.3


def components(count, faces):
    """(count,) the lowest vertex of the component of each vertex."""
    joined = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    label = np.arange(count)
    while True:
        lower = np.minimum(label[joined[:, 0]], label[joined[:, 1]])
        before = label.copy()
        np.minimum.at(label, joined[:, 0], lower)
        np.minimum.at(label, joined[:, 1], lower)
        if np.array_equal(before, label):
            return label


def off_rigid(rest, posed):
    """Largest distance of posed (n, 3) from the rigid motion of rest that fits best, over its extent."""
    a, b = rest - rest.mean(0), posed - posed.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return np.abs(a @ turn - b).max() / diagonal(rest)
