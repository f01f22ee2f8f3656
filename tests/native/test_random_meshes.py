"""Random meshes through every call: finite positions or a typed error, what rests rests, and again the same.

What fails is shrunk. Draw many more by --hypothesis-profile=search.
"""

import lissom
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from random_meshes import fans, grids, meshes, motions, on_a_line, points, soups, torn


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
