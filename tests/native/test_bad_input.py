"""What each bad input gets; the numbers are those of the table in docs/bad_input.md."""

import lissom
import numpy as np
import pytest
from shapes import rigid, tube

VERTICES, FACES = tube(rows=24, columns=16)
N = len(VERTICES)
LOW, HIGH = np.arange(16), np.arange(N - 16, N)


def mesh(vertices=VERTICES, faces=FACES, **options):
    return lissom.Mesh(vertices, faces, **options)


def pose(handles=(LOW, HIGH), m=None, **options):
    return lissom.Pose(m or mesh(), list(handles), **options)


def bent(p, angle=0.9):
    return p.solve([np.eye(4), rigid((0, 0, 1), angle, (0, 1, 0))], warm_start=False)


@pytest.mark.parametrize(
    ("vertices", "faces", "text"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no vertices"),
        (VERTICES, np.zeros((0, 3), int), "no faces"),
        ([], [], "expected shape"),
    ],
)
def test_row_01_empty(vertices, faces, text):
    with pytest.raises((lissom.InvalidMesh, ValueError), match=text):
        mesh(vertices, faces)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_row_02_vertices_that_are_not_finite(value):
    broken = VERTICES.copy()
    broken[[5, 9, 17], 1] = value
    with pytest.raises(lissom.InvalidMesh, match=r"vertices: not finite \(at 5, 9, 17; 3 in all\)") as caught:
        mesh(broken)
    assert caught.value.argument == "vertices"
    assert (caught.value.indices, caught.value.count) == ([5, 9, 17], 3)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_row_03_targets_and_matrices_that_are_not_finite(value):
    p = pose()
    before = bent(p).vertices
    matrix = np.eye(4)
    matrix[0, 3] = value
    with pytest.raises(lissom.InvalidConstraint, match=r"transforms: not finite \(at 1; 1 in all\)"):
        p.solve([np.eye(4), matrix])
    targets = VERTICES[np.concatenate([LOW, HIGH])]
    targets[3, 0] = value
    with pytest.raises(lissom.InvalidConstraint, match=r"targets: not finite \(at 3; 1 in all\)"):
        p.solve_points(targets)
    with pytest.raises(lissom.InvalidValue, match="tolerance"):
        p.solve([np.eye(4)] * 2, tolerance=np.nan)
    assert np.array_equal(bent(p).vertices, before), "the bound pose outlives the error"


def test_row_03_matrices_that_are_not_affine():
    with pytest.raises(lissom.InvalidConstraint, match="not affine"):
        pose().solve([np.eye(4), np.ones((4, 4))])


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0), (1e20, 0), (1.0, 1e6), (1e-6, 1e-3)])
def test_row_04_and_05_huge_and_tiny_coordinates(scale, offset):
    reference = bent(pose()).vertices
    there = VERTICES * scale + offset
    shift = np.eye(4)
    shift[:3, 3] = offset
    motion = rigid((0, 0, 1), 0.9, (0, scale, 0))
    motion = shift @ motion @ np.linalg.inv(shift)
    result = pose(m=mesh(there)).solve([np.eye(4), motion])
    rounding = 1e-6 + 1e-13 * abs(offset) / scale
    assert np.abs((result.vertices - offset) / scale - reference).max() < 20 * rounding


def test_row_04_overflow_on_the_way_out():
    far = np.eye(4)
    far[0, 3] = 1.7e308
    with pytest.raises(lissom.SolveFailed, match="overflow"):
        pose(m=mesh(VERTICES * 1e307)).solve([np.eye(4), far])


@pytest.mark.parametrize("points", [np.ones((N, 3)), VERTICES * [1, 0, 0], VERTICES[:, :1] * [1, 2, 3] + 5])
def test_row_06_coincident_and_collinear_points(points):
    with pytest.raises(lissom.InvalidMesh, match=r"coincide|one line"):
        mesh(points)


def test_row_07_slivers():
    flat = VERTICES.copy()
    flat[200] = 0.5 * (flat[201] + flat[199])
    flat[201] = flat[200]
    m = mesh(flat)
    assert any("mollified" in w for w in m.warnings)
    rigidly = pose(m=m).solve([rigid((1, 1, 0), 2.0)] * 2).vertices
    assert np.abs(rigidly - flat @ rigid((1, 1, 0), 2.0)[:3, :3].T).max() < 1e-8


def test_row_08_faces_that_repeat_a_vertex():
    faces = np.concatenate([[[1, 1, 2], [4, 5, 4]], FACES])
    m = mesh(faces=faces)
    assert any("repeat a vertex (at 0, 1; 2 in all)" in w for w in m.warnings)
    with pytest.raises(lissom.InvalidMesh, match="every face"):
        mesh(faces=[[1, 1, 2]])


@pytest.mark.parametrize("index", [N, -1, 2**31, 2**40])
def test_row_09_indices_out_of_range(index):
    faces = FACES.copy().astype(np.int64)
    faces[7, 2] = index
    with pytest.raises(lissom.InvalidMesh, match=r"triangles: .* \(at 7; 1 in all\)"):
        mesh(faces=faces)
    with pytest.raises(lissom.InvalidConstraint, match="handles"):
        pose([LOW, [index]])
    with pytest.raises(lissom.InvalidConstraint, match="roi"):
        pose(roi=[index])


def test_row_10_duplicate_faces():
    m = mesh(faces=np.concatenate([FACES, FACES[3:5]]))
    assert any("again" in w and "2 in all" in w for w in m.warnings)


def test_row_11_weld_joins_what_is_near():
    vertices, faces = VERTICES[FACES].reshape(-1, 3), np.arange(3 * len(FACES)).reshape(-1, 3)
    noise = np.random.default_rng(2).uniform(-1e-4, 1e-4, size=vertices.shape)
    assert mesh(vertices, faces).components == len(FACES)
    assert mesh(vertices + noise, faces, weld=0.0).components == len(FACES)
    welded = mesh(vertices + noise, faces, weld=1e-3)
    assert welded.components == 1
    assert np.array_equal(welded.vertices, vertices + noise)
    assert not any("in no face" in w for w in welded.warnings)
    with pytest.raises(lissom.InvalidMesh, match="every face repeats a vertex"):
        mesh(weld=100.0)
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(lissom.InvalidValue, match="weld: must be a distance"):
            mesh(weld=wrong)
    with pytest.raises(TypeError, match="weld"):
        mesh(weld=True)


def test_row_11_a_chain_of_near_vertices_is_not_drawn_together():
    rows = np.linspace(0, 1, 1001)
    strip = np.concatenate(
        [np.stack([rows, 0 * rows, 0 * rows], 1), np.stack([rows, 0 * rows + 1, 0 * rows], 1)]
    )
    k = np.arange(1000)
    m = mesh(strip, np.stack([k, k + 1, k + 1001], 1), weld=0.01)
    repeats = next(w for w in m.warnings if "repeat a vertex" in w)
    assert m.components == 1 and int(repeats.split("; ")[1].split()[0]) < 950


def test_row_11_zero_has_two_signs():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [1, 0, 0], [0, -1, 0]])
    assert mesh(vertices, [[0, 1, 2], [3, 4, 5]], weld=0.0).components == 1


def test_row_12_isolated_vertices_are_named():
    m = mesh(np.concatenate([VERTICES, [[9, 9, 9], [8, 8, 8]]]))
    assert any(f"in no face (at {N}, {N + 1}; 2 in all)" in w for w in m.warnings)


def test_row_13_an_edge_with_three_faces():
    extra = np.concatenate([FACES, [[FACES[50, 0], FACES[50, 1], N]]])
    m = mesh(np.concatenate([VERTICES, [VERTICES[FACES[50, 0]] * 1.5]]), extra)
    assert any("more than two faces" in w for w in m.warnings)


def test_row_14_a_bow_tie():
    vertices = np.concatenate([VERTICES, VERTICES + (10, 0, 0)])
    faces = np.concatenate([FACES, np.where(FACES == 0, N - 1, FACES + N)])
    m = mesh(vertices, faces)
    assert any("bow-tie" in w for w in m.warnings)


def test_row_15_inconsistent_winding():
    faces = FACES.copy()
    faces[40] = faces[40, ::-1]
    m = mesh(faces=faces)
    assert any("wound against each other" in w for w in m.warnings)


def test_row_16_an_open_boundary():
    assert mesh().warnings == []
    assert bent(pose()).report["converged"]


@pytest.mark.parametrize(("handles", "text"), [([], "no handle"), ([LOW, []], r"empty handle \(at 1")])
def test_row_19_no_handle_or_an_empty_one(handles, text):
    with pytest.raises(lissom.InvalidConstraint, match=text):
        pose(handles)


def test_row_21_a_component_without_handle():
    m = mesh(np.concatenate([VERTICES, VERTICES + 10]), np.concatenate([FACES, FACES + N]))
    p = pose(m=m)
    assert any("without a handle follow the nearest surface" in w and "1 in all" in w for w in p.warnings)
    assert any("without a handle" in w for w in bent(p).report["warnings"])


def test_row_23_a_vertex_twice_in_one_handle():
    with pytest.raises(lissom.InvalidConstraint, match=r"twice in handle 0 \(at 5; 1 in all\)"):
        pose([[5, 6, 5]])


@pytest.mark.parametrize(
    "convert",
    [
        lambda a: a.astype(np.float32),
        lambda a: a.astype(np.float16),
        lambda a: a.astype(">f8"),
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a.tolist(),
    ],
)
def test_row_43_other_arrays_are_converted(convert):
    given = convert(VERTICES)
    result = bent(pose(m=mesh(given)))
    expected = bent(pose(m=mesh(np.asarray(given, dtype=np.float64))))
    assert np.array_equal(result.vertices, expected.vertices)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, ">i4", np.uint64])
def test_row_43_other_integers_are_converted(kind):
    faces = FACES[FACES.max(1) < 200]
    assert lissom.Mesh(VERTICES, faces.astype(kind)).components == 1


@pytest.mark.parametrize(
    ("vertices", "faces", "name"),
    [
        (VERTICES.astype(bool), FACES, "vertices"),
        (VERTICES.astype(object), FACES, "vertices"),
        (VERTICES.astype(complex), FACES, "vertices"),
        (VERTICES.astype(str), FACES, "vertices"),
        (VERTICES, FACES.astype(bool), "triangles"),
        (VERTICES, FACES.astype(float), "triangles"),
        (VERTICES, FACES.astype(object), "triangles"),
        (None, FACES, "vertices"),
        ([[1, 2], [3]], FACES, "vertices"),
    ],
)
def test_row_43_other_types_are_refused(vertices, faces, name):
    with pytest.raises(TypeError, match=name):
        lissom.Mesh(vertices, faces)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: lissom.Mesh(VERTICES[:, :2], FACES), r"vertices: expected shape \(n, 3\), got \(384, 2\)"),
        (lambda: lissom.Mesh(VERTICES, FACES.ravel()), r"triangles: expected shape \(n, 3\)"),
        (lambda: pose([LOW[None]]), r"handles\[0\]: expected shape \(n,\)"),
        (lambda: pose(roi=[[1]]), "roi: expected shape"),
        (lambda: pose().solve(np.eye(4)), r"transforms: expected shape \(n, 4, 4\)"),
        (lambda: pose().solve_points(np.zeros(3)), "targets: expected shape"),
    ],
)
def test_row_43_wrong_shapes_name_the_argument(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_the_wrong_number_of_matrices_or_points():
    with pytest.raises(lissom.InvalidConstraint, match="3 matrices for 2 handles"):
        pose().solve([np.eye(4)] * 3)
    with pytest.raises(lissom.InvalidConstraint, match="5 points for 32 handle vertices"):
        pose().solve_points(np.zeros((5, 3)))
    with pytest.raises(lissom.InvalidValue, match="no method named 'magic'"):
        pose(method="magic")


@pytest.mark.parametrize("method", ["laplacian", "laplacian_fitted"])
def test_row_39_responses_that_do_not_fit(method, monkeypatch):
    """Sixteen handles on a mesh whose factor is the smaller part."""
    p = pose([[v] for v in range(0, N, N // 16)][:16], method=method, roi=np.arange(N // 2, N))
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "50000")
    with pytest.raises(lissom.OutOfMemory, match="the responses would take"):
        p.solve([rigid(offset=(1, 0, 0))] * 16)
    monkeypatch.delenv("LISSOM_MEMORY_LIMIT")
    shift = rigid(offset=(1, 0, 0))
    handles = np.arange(0, N, N // 16)[:16]
    moved = p.solve([shift] * 16).vertices[handles]
    assert np.allclose(moved, VERTICES[handles] + (1, 0, 0), rtol=0, atol=1e-12), "and life goes on"


def test_row_39_inputs_are_weighed_before_they_are_copied(monkeypatch):
    """As they are by one copy, converted or from every other row by another."""
    vertices, faces = np.zeros((10_000, 3)), np.zeros((20_000, 3), int)
    for given, bytes_each in [
        (vertices, 8),
        (vertices.astype(np.float32), 16),
        (vertices.astype(vertices.dtype.newbyteorder()), 16),
        (np.repeat(vertices, 2, axis=0)[::2], 16),
        (np.broadcast_to(np.zeros(3), vertices.shape), 16),
    ]:
        needed = bytes_each * vertices.size
        monkeypatch.setenv("LISSOM_MEMORY_LIMIT", str(needed - 1))
        with pytest.raises(lissom.OutOfMemory, match="a copy of vertices would take") as caught:
            lissom.Mesh(given, faces)
        assert (caught.value.needed, caught.value.available) == (needed, needed - 1)
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", str(12 * faces.size - 1))
    with pytest.raises(lissom.OutOfMemory, match="a copy of triangles would take"):
        lissom.Mesh(vertices, faces.astype(np.int32))
    with pytest.raises(lissom.InvalidMesh):
        lissom.Mesh(vertices, faces)


def test_row_39_a_limit_that_is_no_number(monkeypatch):
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "much")
    with pytest.raises(lissom.InvalidValue, match="'much' is not a number of bytes"):
        pose()


def test_row_44_a_panic_is_an_internal_error(capfd):
    with pytest.raises(lissom.InternalError, match="a bug in lissom: asked to"):
        lissom._panic()
    assert bent(pose()).report["converged"], "and life goes on"
