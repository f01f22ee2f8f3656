"""Random meshes through every call: finite positions or a typed error, what rests rests, and again the same.

Meshes are soups of triangles, grids and fans, with parts many magnitudes smaller than others, vertices in one
place, faces twice or turned over. What fails is shrunk. Draw many more by --hypothesis-profile=search.
"""

import lissom
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from shapes import grid_faces, rigid

UNIT = st.floats(-1, 1, allow_subnormal=False)
# Such sizes meet in one mesh; the smallest are far below what squares of lengths can hold.
SIZES = st.sampled_from([1.0, 1.0, 1.0, 1e-3, 1e-9, 1e-60, 1e-150])


def points(n):
    """(n, 3) in -1 to 1."""
    return hnp.arrays(float, (n, 3), elements=UNIT)


@st.composite
def soups(draw):
    n = draw(st.integers(3, 24))
    vertices = draw(points(n)) * draw(hnp.arrays(float, (n, 1), elements=SIZES))
    return vertices, draw(hnp.arrays(np.int64, (draw(st.integers(1, 40)), 3), elements=st.integers(0, n - 1)))


@st.composite
def grids(draw):
    rows, columns = draw(st.integers(2, 7)), draw(st.integers(3, 7))
    faces = grid_faces(rows, columns, closed=draw(st.booleans()))
    even = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), [0.0], indexing="ij"), -1).reshape(-1, 3)
    vertices = even + draw(points(len(even))) * draw(SIZES)
    turned = draw(hnp.arrays(bool, len(faces)))
    return vertices, np.where(turned[:, None], faces[:, ::-1], faces)


@st.composite
def fans(draw):
    n = draw(st.integers(3, 20))
    rim = np.arange(1, n)
    faces = np.column_stack([0 * rim, rim, np.roll(rim, -1)])
    twice = draw(st.lists(st.integers(0, n - 2), max_size=4))
    return draw(points(n)) * draw(SIZES), np.concatenate([faces, faces[twice]])


def torn(faces):
    """Which faces repeat a vertex; they are left out."""
    return (faces[:, [0, 0, 1]] == faces[:, [1, 2, 2]]).any(axis=1)


def on_a_line(refused):
    return any(text in str(refused) for text in ("all points coincide", "all points lie on one line"))


@st.composite
def meshes(draw):
    """A mesh that is accepted, its vertices and faces."""
    vertices, faces = draw(soups() | grids() | fans())
    try:
        return lissom.Mesh(vertices, faces), vertices, faces
    except lissom.InvalidMesh as refused:
        assert torn(faces).all() or on_a_line(refused) or np.ptp(vertices) < 1e-140, refused
        assume(False)


@st.composite
def motions(draw):
    axis = draw(points(1))[0]
    assume(np.linalg.norm(axis) > 1e-3)
    return rigid(axis, draw(st.floats(-3.5, 3.5)), draw(points(1))[0])


@given(soups() | grids() | fans())
def test_a_mesh_keeps_its_vertices_or_names_what_is_wrong(drawn):
    vertices, faces = drawn
    try:
        mesh = lissom.Mesh(vertices, faces)
    except lissom.InvalidMesh as refused:
        assert refused.argument in ("vertices", "triangles")
        return
    assert np.array_equal(mesh.vertices, vertices)
    assert 1 <= mesh.components <= len(vertices)
    assert np.isclose(mesh.diagonal, np.linalg.norm(np.ptp(vertices[np.unique(faces[~torn(faces)])], axis=0)))


@given(hnp.arrays(hnp.scalar_dtypes(), hnp.array_shapes(max_dims=3, max_side=4)), st.data())
def test_row_43_any_array_makes_a_mesh_or_an_error_that_is_not_a_bug(array, data):
    """InternalError, which says that the bug is ours, is none of those."""
    other = data.draw(hnp.arrays(hnp.scalar_dtypes(), hnp.array_shapes(max_dims=3, max_side=4)))
    for vertices, faces in ((array, other), (np.eye(3), array), (array, np.arange(3)[None])):
        try:
            mesh = lissom.Mesh(vertices, faces)
        except (TypeError, ValueError, lissom.InvalidMesh):
            continue
        assert np.isfinite(mesh.vertices).all()


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
@given(meshes(), st.data())
def test_row_38_a_pose_is_finite_and_rests_where_it_should(method, drawn, data):
    mesh, vertices, _ = drawn
    n = len(vertices)
    order = np.array(data.draw(st.permutations(range(n))))
    held = data.draw(st.integers(2, n))
    handles = [order[: held // 2], order[held // 2 : held]]
    roi = order[: data.draw(st.integers(held, n))]
    transforms = [np.eye(4), data.draw(motions())]

    def solved():
        return lissom.Pose(mesh, handles, roi, method).solve(transforms, max_iterations=20).vertices

    result = solved()
    assert np.isfinite(result).all()
    outside = np.setdiff1d(np.arange(n), roi)
    assert np.array_equal(result[outside], vertices[outside])
    assert np.array_equal(result[handles[0]], vertices[handles[0]]), "a handle that stays"
    assert np.array_equal(result, solved())


@given(meshes(), meshes(), st.data())
def test_a_fit_is_finite_or_refused(source, target, data):
    (source, rest, _), (target, vertices, _) = source, target
    count = data.draw(st.integers(0, min(6, len(rest), len(vertices))))
    marked = [data.draw(st.permutations(range(len(points))))[:count] for points in (rest, vertices)]

    exact = data.draw(st.booleans())
    tolerance = {"marker_tolerance": 0.0} if exact else {}

    def fitted():
        return lissom.fit_correspondence(
            source, target, np.column_stack(marked), steps=2, rounds=2, **tolerance
        )

    try:
        fit = fitted()
    except lissom.InvalidConstraint as refused:
        assert refused.argument == "markers"
        return
    except lissom.SolveFailed:
        assert source.warnings
        return
    assert np.isfinite(fit.fitted_vertices).all() and np.isfinite(fit.image_weights).all()
    gaps = fit.fitted_vertices[marked[0]] - vertices[marked[1]]
    assert fit.marker_distances == pytest.approx(np.linalg.norm(gaps, axis=1), abs=1e-9 * target.diagonal)
    if exact:
        assert np.abs(gaps).max(initial=0) < 1e-12 * target.diagonal
    again = fitted()
    assert np.array_equal(fit.fitted_vertices, again.fitted_vertices)
    assert np.array_equal(fit.pairs, again.pairs)


@given(meshes(), meshes(), st.data())
def test_row_38_transferred_keys_are_finite_and_nothing_gives_nothing(source, target, data):
    (source, rest, faces), (target, vertices, others) = source, target
    pair = st.tuples(st.integers(0, len(faces) - 1), st.integers(0, len(others) - 1))
    pairs = np.array(data.draw(st.lists(pair, min_size=1, max_size=40)))
    keys = np.stack([rest, data.draw(points(len(rest)))])
    options = {
        "weighting": data.draw(st.sampled_from(["pairs", "area"])),
        "contact": data.draw(st.booleans()),
    }

    def carried():
        return lissom.Transfer(source, target, pairs, **options).apply(keys).vertices

    if (torn(faces)[pairs[:, 0]] | torn(others)[pairs[:, 1]]).all():
        with pytest.raises(lissom.InvalidConstraint, match="no source triangle is matched"):
            carried()
        return
    try:
        result = carried()
    except lissom.SolveFailed:
        assert any("without area" in line for line in target.warnings)
        return
    assert np.isfinite(result).all()
    assert np.array_equal(result[0], vertices)
    assert np.array_equal(result, carried())


@pytest.mark.parametrize("rotation", ["consistent", "shortest", "relative"])
@given(meshes(), st.data())
def test_row_38_in_betweens_are_finite_and_what_stays_stays(rotation, drawn, data):
    mesh, start, _ = drawn
    end = data.draw(points(len(start)) | st.just(start * (1, 1, -1)) | st.just(start[::-1].copy()))
    still = data.draw(hnp.arrays(bool, len(start)))
    end = np.where(still[:, None], start, end)
    refinement = data.draw(st.integers(0, 2))

    def path():
        return lissom.Inbetween(mesh, start, end, rotation, refinement=refinement).at([0.0, 0.3, 0.5, 1.0])

    try:
        shapes = path()
    except lissom.InvalidValue as refused:
        assert on_a_line(refused), refused
        return
    assert np.isfinite(shapes).all()
    assert np.array_equal(shapes[[0, -1]], [start, end])
    assert np.array_equal(shapes[:, still], np.broadcast_to(start[still], (4, still.sum(), 3)))
    assert np.array_equal(shapes, path())
