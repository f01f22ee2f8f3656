"""Transfer: real keys carried over to other triangles, and what must stay as it is."""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square, slid, triangulate
from shapes import grid_faces, moved, rigid, tube

VERTICES, FACES = tube(rows=24, columns=16)
SAME = np.column_stack([np.arange(len(FACES))] * 2)


@pytest.fixture(scope="module")
def tubes():
    """Two tubes of different triangles and size, and a transfer between them."""
    source = lissom.Mesh(VERTICES, FACES)
    vertices, faces = tube(rows=33, columns=20)
    target = lissom.Mesh(vertices * 12 + 5, faces)
    markers = [[0, 0], [8, 10], [192, 340], [368, 640], [376, 650]]
    fit = lissom.fit_correspondence(source, target, markers)
    return source, target, vertices * 12 + 5, fit


def test_cat_to_lion(data):
    archive = data("cat_lion")
    cat = lissom.Mesh(archive["cat_reference"], archive["cat_faces"])
    lion = lissom.Mesh(archive["lion_reference"], archive["lion_faces"])
    fit = lissom.fit_correspondence(cat, lion, archive["markers"])
    result = lissom.Transfer(cat, lion, fit).apply(archive["cat_poses"]).vertices
    errors = result - archive["lion_poses"]
    errors -= errors.mean(axis=1, keepdims=True)
    size = diagonal(archive["lion_reference"])
    mean = np.mean([root_mean_square(error) for error in errors]) / size
    print(f"cat to lion: {mean:.5f} of the diagonal")
    # Measured: 0.00882.
    assert mean <= 0.0090


def test_expressions_of_the_ict_face_on_another_identity_of_other_triangles(data):
    archive = data("ict_face")
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    offsets = archive["expressions"][:53].astype(float)
    identity = neutral + archive["identities"][0]
    source = lissom.Mesh(neutral, triangulate(archive["loops"], archive["counts"]))
    # The other diagonal of every quad, and every vertex but the landmarks somewhere else.
    corners, weights = slid(identity, triangulate(archive["loops"], archive["counts"], turn=1), landmarks)
    blend = lambda values: np.einsum("nk,nkc->nc", weights, values[corners])  # noqa: E731
    vertices = blend(identity)
    target = lissom.Mesh(vertices, triangulate(archive["loops"], archive["counts"], turn=1))
    fit = lissom.fit_correspondence(source, target, np.column_stack([landmarks, landmarks]))
    result = lissom.Transfer(source, target, fit).apply(neutral + offsets).vertices
    face, size = slice(0, 9409), diagonal(vertices)
    relative, absolute = [], []
    for shape, offset in zip(result, offsets, strict=True):
        expected = blend(offset)
        error = shape - vertices - expected
        absolute.append(root_mean_square(error) / size)
        if root_mean_square(expected[face]) > 1e-4 * size:
            relative.append(root_mean_square(error[face]) / root_mean_square(expected[face]))
    median, ninetieth = np.median(relative), np.percentile(relative, 90)
    print(f"ICT, relative on the face: median {median:.4f}, 90th percentile {ninetieth:.4f}")
    print(f"ICT, of the diagonal, all parts: mean {np.mean(absolute):.6f}, largest {max(absolute):.6f}")
    # Measured: 0.046 and 0.054 (the face is 4.5 % smaller, and the data does not scale), 0.0021 for jawOpen.
    assert median < 0.05 and ninetieth < 0.06
    assert max(absolute) < 0.0025


def test_keys_do_not_depend_on_their_company(tubes):
    source, target, _, fit = tubes
    transfer = lissom.Transfer(source, target, fit)
    keys = np.stack([moved(rigid((0, 0, 1), 0.1 * k), VERTICES) for k in range(19)])
    together = transfer.apply(keys).vertices
    assert np.abs(transfer.apply(keys[7:8]).vertices[0] - together[7]).max() < 1e-9
    assert transfer.apply(np.zeros((0, *VERTICES.shape))).vertices.shape == (0, *together.shape[1:])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_row_03_poses_that_are_not_finite(tubes, value):
    source, target, _, fit = tubes
    poses = np.stack([VERTICES, VERTICES])
    poses[1, 3] = value
    transfer = lissom.Transfer(source, target, fit)
    with pytest.raises(lissom.InvalidValue, match=r"poses\[1\]: not finite \(at 3; 1 in all\)"):
        transfer.apply(poses)
    with pytest.raises(ValueError, match="poses"):
        transfer.apply(poses[:, :-1])


def test_row_04_a_result_out_of_range(tubes):
    source, target, _, fit = tubes
    with pytest.raises(lissom.Error):
        lissom.Transfer(source, target, fit).apply(VERTICES[None] * 1e307)


def test_row_11_seams_of_the_target_stay_closed():
    corners = FACES.ravel()
    soup = lissom.Mesh(VERTICES[corners], np.arange(len(corners)).reshape(-1, 3), weld=0.0)
    mesh = lissom.Mesh(VERTICES, FACES)
    key = VERTICES + np.sin(VERTICES)
    expected = lissom.Transfer(mesh, mesh, SAME).apply([key]).vertices[:, corners]
    assert np.abs(lissom.Transfer(mesh, soup, SAME).apply([key]).vertices - expected).max() < 1e-9
    assert np.abs(lissom.Transfer(soup, soup, SAME).apply([key[corners]]).vertices - expected).max() < 1e-9


def test_row_39_more_keys_than_fit(monkeypatch):
    mesh = lissom.Mesh(VERTICES, FACES)
    transfer = lissom.Transfer(mesh, mesh, SAME)
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e6")
    with pytest.raises(lissom.OutOfMemory, match=r"the keys would take 1\.8 MB") as caught:
        transfer.apply(np.repeat(VERTICES[None], 100, axis=0))
    assert (caught.value.needed, caught.value.available) == (2 * 24 * len(VERTICES) * 100, 10**6)
    assert np.array_equal(transfer.apply([VERTICES]).vertices[0], VERTICES)


@pytest.mark.parametrize(
    ("pairs", "text"),
    [
        (np.zeros((0, 2), int), "no source triangle is matched"),
        ([[0, 0], [10**6, 0]], r"source triangle out of range, the mesh has 736 \(at 1; 1 in all\)"),
        ([[0, 10**6]], "target triangle out of range"),
    ],
)
def test_row_09_pairs_that_cannot_be_used(pairs, text):
    mesh = lissom.Mesh(VERTICES, FACES)
    with pytest.raises(lissom.InvalidConstraint, match=text):
        lissom.Transfer(mesh, mesh, pairs)


def spoiled(vertices, faces, how):
    """A mesh with one fault of the table of bad inputs, in the same vertices or more."""
    if how == "soup":
        return vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3)
    if how == "fin":
        fin = [[faces[100, 0], faces[100, 1], len(vertices)]]
        return np.concatenate([vertices, [vertices[faces[100, 0]] * 1.2]]), np.concatenate([faces, fin])
    if how == "bow-tie":
        tip = vertices[faces[100, 0]]
        return np.concatenate([vertices, [tip * 1.1, tip * 1.1 + 0.1]]), np.concatenate(
            [faces, [[faces[100, 0], len(vertices), len(vertices) + 1]]]
        )
    turned = faces.copy()
    turned[100:130] = turned[100:130, ::-1]
    return vertices, turned


@pytest.mark.parametrize("side", ["source", "target"])
@pytest.mark.parametrize(
    ("how", "told"),
    [("soup", "in the same place"), ("fin", "more than two"), ("bow-tie", "bow-tie"), ("winding", "wound")],
)
def test_rows_11_and_13_to_15_transfer_says_what_is_doubtful(how, told, side):
    vertices, faces = tube(rows=30, columns=24)
    whole, faulty = (vertices, faces), spoiled(vertices, faces, how)
    ends = (faulty, whole) if side == "source" else (whole, faulty)
    marked = np.arange(0, len(vertices), 31)
    if how == "soup":
        corner = np.array([np.flatnonzero(faces.ravel() == v)[0] for v in marked])
        pairs = np.column_stack([corner, marked] if side == "source" else [marked, corner])
    else:
        pairs = np.column_stack([marked, marked])
    source, target = (lissom.Mesh(*end) for end in ends)
    fit = lissom.fit_correspondence(source, target, pairs)
    assert any(line.startswith(f"{side}: ") and told in line for line in fit.report["warnings"])
    key = ends[0][0] + 0.1 * np.sin(2 * ends[0][0])
    transfer = lissom.Transfer(source, target, fit)
    result = transfer.apply([key]).vertices
    assert np.isfinite(result).all()
    quality = transfer.quality([key], result)
    numbers = [values for values in quality.values() if isinstance(values, np.ndarray)]
    assert len(numbers) == len(quality) - 3 and all(np.isfinite(values).all() for values in numbers)
    if how != "soup":  # whose triangles all go their own way
        known = ends[1][0] + 0.1 * np.sin(2 * ends[1][0])
        off = np.linalg.norm(result[0] - known, axis=1)[: len(vertices)]
        assert np.median(off) < 0.02 * 0.1


def test_row_26_a_fit_of_other_faces(tubes):
    source, target, vertices, fit = tubes
    faces = tube(rows=33, columns=20)[1]
    other = lissom.Mesh(vertices, faces[::-1])
    for ends in ((source, other), (target, target)):
        with pytest.raises(lissom.InvalidConstraint, match="fit: was made for meshes of other faces"):
            lissom.Transfer(*ends, fit)
    lissom.Transfer(source, lissom.Mesh(vertices * 2, faces), fit)


def test_local_frames_turn_keys_with_the_surface():
    """A sheet whose far half is bent down: what rises from it rises along its own normal by option."""
    x, y = np.meshgrid(np.linspace(0, 2, 41), np.linspace(0, 1, 21), indexing="ij")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    turn = rigid((0, 1, 0), 0.8)[:3, :3]
    bent = np.where(flat[:, :1] > 1, (flat - [1, 0, 0]) @ turn.T + [1, 0, 0], flat)
    faces = grid_faces(41, 21)
    height = 0.1 * np.exp(-20 * ((flat - [1.5, 0.5, 0]) ** 2).sum(1))
    source, target = lissom.Mesh(flat, faces), lissom.Mesh(bent, faces)
    fit = lissom.fit_correspondence(source, target)
    risen, expected = flat + height[:, None] * [0, 0, 1], bent + height[:, None] * (turn @ [0, 0, 1])
    off = {}
    for frames in ("global", "local"):
        transfer = lissom.Transfer(source, target, fit, frames=frames, anchor=np.inf)
        off[frames] = root_mean_square(transfer.apply([risen]).vertices[0] - expected)
    size = root_mean_square(height[:, None])
    print(f"bump on a slope, of its size: {off['global'] / size:.3f} global, {off['local'] / size:.3f} local")
    # Measured: 0.565 and 0.225, of where the directions change from one half to the other.
    assert off["global"] > 0.5 * size and off["local"] < 0.3 * size


def test_a_target_that_spans_a_slit_of_the_source_makes_no_rag():
    """A sheet with a slit whose lips part on the source, and one without: nothing is stretched there that
    much.
    """
    x, y = np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 21), indexing="ij")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    faces = grid_faces(21, 21)
    lip = np.flatnonzero((np.abs(flat[:, 0] - 0.5) < 1e-9) & (flat[:, 1] > 0.31))
    other = np.arange(len(flat))
    other[lip] = len(flat) + np.arange(len(lip))
    right = flat[faces].mean(axis=1)[:, 0] > 0.5
    slit = np.where(right[:, None], other[faces], faces)
    vertices = np.concatenate([flat, flat[lip]])
    beside = (vertices[:, 0] > 0.51) | (np.arange(len(vertices)) >= len(flat))
    posed = vertices + (beside * np.clip(vertices[:, 1] - 0.3, 0, None))[:, None] * [0, 0, 1]
    source, target = lissom.Mesh(vertices, slit), lissom.Mesh(flat, faces)
    fit = lissom.fit_correspondence(source, target, overlap=True)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    rest = np.linalg.norm(np.diff(flat[ends], axis=1), axis=2)
    longest = {}
    for stretch in (2.0, np.inf):
        found = lissom.Transfer(source, target, fit, stretch=stretch).apply([posed]).vertices[0]
        longest[stretch] = (np.linalg.norm(np.diff(found[ends], axis=1), axis=2) / rest).max()
    print(f"longest edge: {longest[np.inf]:.2f} times, limited {longest[2.0]:.2f}")
    assert longest[np.inf] > 5 and longest[2.0] < 2.05
