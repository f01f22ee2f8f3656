"""Laplacian editing with fitted transformations: exactness, the thesis's equations assembled densely."""

import lissom
import numpy as np
import pytest
from dense import laplacian_and_mass, minimise, neighbours, surface_diagonal, window
from shapes import diagonal, ends, grid_faces, moved, rigid, rotation, tube


def similarity(s, h, offset):
    """The matrix of (s I + [h]x) v + offset."""
    matrix = np.eye(4)
    matrix[:3, :3] = s * np.eye(3) + np.cross(np.eye(3), np.asarray(h, float))
    matrix[:3, 3] = offset
    return matrix


def fitted_rows(v, f, weights, scale):
    """Rows of sum |L(x)_i - T_i(x) delta_i|^2 (thesis 2-10), 3n x 3n, x0 y0 z0 x1 ...

    T_i = s I + [h]x by least squares over i and its neighbours, as in 2-13 but with a translation.
    """
    n = len(v)
    if weights == "uniform":
        laplacian = np.eye(n)
        for i, ring in enumerate(neighbours(f, n)):
            laplacian[i, ring] = -1 / max(len(ring), 1)
    else:
        laplacian, mass = laplacian_and_mass(v, f)
        laplacian /= np.sqrt(mass)[:, None]
    delta = laplacian @ v
    rows = np.kron(laplacian, np.eye(3))
    for i, ring in enumerate(neighbours(f, n)):
        cell = [i, *ring]
        # x_j = s v_j + h x v_j + t, unknowns (s, h, t)
        equations = np.concatenate(
            [np.column_stack([v[j], np.cross(np.eye(3), v[j]).T, np.eye(3)]) for j in cell]
        )
        fit = np.linalg.pinv(equations)
        grow = delta[i] if scale else np.zeros(3)
        detail = np.column_stack([grow, np.cross(np.eye(3), delta[i]).T]) @ fit[:4]
        for k, j in enumerate(cell):
            rows[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] -= detail[:, 3 * k : 3 * k + 3]
    return rows


def test_the_reference_knows_the_cross_product():
    s, h, p = 1.5, (0.2, -0.4, 0.3), np.array([1.0, 2.0, -0.5])
    assert np.allclose(similarity(s, h, 0)[:3, :3] @ p, s * p + np.cross(h, p))
    assert np.allclose(np.cross(np.eye(3), p).T @ h, np.cross(h, p))


@pytest.mark.parametrize(("weights", "scale"), [("uniform", True), ("cotangent", True), ("uniform", False)])
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_agrees_with_the_dense_equations(weights, scale, constraints):
    vertices, faces = tube(bumps=0.1)
    assert len(vertices) > 2000
    row = np.arange(len(vertices)) // 32
    roi, handle = np.flatnonzero((row > 30) & (row < 44)), np.flatnonzero(row == 37)
    soft = 3.0 if constraints == "soft" else None
    motion = rigid((0.2, 1, 0.3), 0.5, (0.1, 0.4, 0.2))
    targets = moved(motion, vertices[handle])

    ids, local = window(faces, roi, 2)
    size = surface_diagonal(vertices, faces)
    unit = vertices[ids] / size
    place = {v: k for k, v in enumerate(ids)}
    inside = np.array([place[v] for v in handle])
    outside = np.array([k for k, v in enumerate(ids) if v not in set(roi)])
    axes = lambda k: (3 * k[:, None] + np.arange(3)).ravel()  # noqa: E731
    rows = fitted_rows(unit, local, weights, scale)
    # Rows whose cells are cut off at the rim of the window name no free vertex.
    touched = np.abs(rows[:, axes(np.setdiff1d(np.arange(len(ids)), outside))]).sum(1) > 0
    # Without scale T_i v_i = v_i + h x v_i, and the first term is on the right.
    delta = np.zeros(len(rows)) if scale else rows @ unit.ravel()
    fixed = outside if soft else np.concatenate([outside, inside])
    values = unit[fixed].copy()
    if not soft:
        values[len(outside) :] = targets / size
    pull = (axes(inside), soft, (targets / size).ravel()) if soft else None
    expected = minimise(rows[touched], delta[touched], axes(fixed), values.ravel(), pull)

    options = {"weights": weights, "scale": scale, "constraints": constraints} | (
        {"weight": soft} if soft else {}
    )
    mesh = lissom.Mesh(vertices, faces)
    pose = lissom.Pose(mesh, [handle], roi=roi, method="laplacian_fitted", **options)
    for result in (pose.solve([motion]), pose.solve_points(targets)):
        error = np.abs(result.vertices[ids] - expected.reshape(-1, 3) * size).max()
        assert error < 1e-8 * size
        assert np.array_equal(np.delete(result.vertices, roi, 0), np.delete(vertices, roi, 0))


@pytest.mark.parametrize("weights", ["uniform", "cotangent"])
@pytest.mark.parametrize("constraints", ["hard", "soft"])
@pytest.mark.parametrize(
    "motion",
    [
        rigid(offset=(1, -2, 3)),
        similarity(2.5, (0, 0, 0), (0, 0, 0)),
        similarity(0.7, (0.3, -1.1, 0.6), (5, 1, -2)),
        similarity(0.0, (3.0, 0.1, -0.2), (0, 0, 1)),
    ],
)
def test_similar_handles_take_everything_along(weights, constraints, motion):
    vertices, faces = tube()
    mesh = lissom.Mesh(vertices, faces)
    pose = lissom.Pose(
        mesh, ends(vertices), method="laplacian_fitted", weights=weights, constraints=constraints
    )
    expected = moved(motion, vertices)
    by_matrix = pose.solve([motion] * 2).vertices
    by_points = pose.solve_points(np.concatenate([expected[handle] for handle in ends(vertices)])).vertices
    for result in (by_matrix, by_points):
        assert np.abs(result - expected).max() < 1e-8 * diagonal(vertices)


def test_without_scale_small_turns_are_reproduced():
    vertices, faces = tube()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="laplacian_fitted", scale=False)
    motion = similarity(1.0, (0.3, -1.1, 0.6), (5, 1, -2))
    error = np.abs(pose.solve([motion] * 2).vertices - moved(motion, vertices)).max()
    assert error < 1e-8 * diagonal(vertices)


def test_details_turn_where_plain_laplacians_do_not():
    vertices, faces = tube(bumps=0.1)
    turn = rigid((1, 0, 0), 0.3)
    expected = moved(turn, vertices)
    mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
    error = {
        method: np.abs(lissom.Pose(mesh, handles, method=method).solve([turn] * 2).vertices - expected).max()
        for method in ("laplacian", "laplacian_fitted")
    }
    # A rotation is cos I + [sin u]x + (1 - cos) u u^T: exact but for the last term along the axis.
    assert error["laplacian_fitted"] < 0.3 * error["laplacian"]


@pytest.mark.parametrize("weights", ["uniform", "cotangent"])
def test_flat_and_straight_neighbourhoods(weights):
    rows, columns = 50, 45
    x, y = np.meshgrid(np.arange(rows) * 0.1, np.arange(columns) * 0.1, indexing="ij")
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    # One more triangle without area: its tip has neighbours on a line only.
    edge = vertices[[0, 1]]
    vertices = np.concatenate([vertices, [edge.mean(0)]])
    faces = np.concatenate([grid_faces(rows, columns), [[1, 0, len(vertices) - 1]]])
    mesh = lissom.Mesh(vertices, faces)
    pose = lissom.Pose(mesh, ends(vertices), method="laplacian_fitted", weights=weights)
    motion = similarity(1.2, (0.3, 0.2, -0.5), (0, 0, 1))
    result = pose.solve([motion] * 2).vertices
    assert np.abs(result - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)
    bent = pose.solve([np.eye(4), rigid((0, 1, 0), 1.0)])
    assert np.isfinite(bent.vertices).all()
    assert np.abs(bent.vertices).max() < 3 * diagonal(vertices)


@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_one_point_carries_the_mesh(constraints):
    vertices, faces = tube()
    pose = lissom.Pose(
        lissom.Mesh(vertices, faces), [[7]], method="laplacian_fitted", constraints=constraints
    )
    result = pose.solve_points(vertices[[7]] + (1, 2, 3))
    assert any("rotation is ambiguous" in warning for warning in result.report["warnings"])
    assert np.abs(result.vertices - vertices - (1, 2, 3)).max() < 1e-6 * diagonal(vertices)


def test_answers_are_the_same_in_any_frame_of_the_handles():
    """The energy does not change when everything turns, so neither does the shape."""
    vertices, faces = tube(bumps=0.1)
    turn = rotation((1, 2, -1), 1.9)
    motion = rigid((0, 0, 1), 0.6, (0.2, 0.5, 0.1))
    around = np.eye(4)
    around[:3, :3] = turn
    straight = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="laplacian_fitted")
    turned = lissom.Pose(lissom.Mesh(vertices @ turn.T, faces), ends(vertices), method="laplacian_fitted")
    first = straight.solve([np.eye(4), motion]).vertices
    second = turned.solve([np.eye(4), around @ motion @ around.T]).vertices
    assert np.abs(first @ turn.T - second).max() < 1e-8 * diagonal(vertices)


def test_options_are_checked():
    vertices, faces = tube()
    mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
    with pytest.raises(
        TypeError, match="'laplacian_fitted' has no option k_s; it has weights, scale, constraints, weight"
    ):
        lissom.Pose(mesh, handles, method="laplacian_fitted", k_s=1)
    with pytest.raises(lissom.InvalidValue, match="weights: 'mean' is none of uniform, cotangent"):
        lissom.Pose(mesh, handles, method="laplacian_fitted", weights="mean")
