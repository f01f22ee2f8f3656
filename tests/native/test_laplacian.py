"""Laplacian editing: exactness, dense least squares, responses, and how handles hold."""

import lissom
import numpy as np
import pytest
from dense import surface_diagonal
from shapes import diagonal, ends, moved, rigid, tube
from test_arap import half_cotangents

MOTION = rigid((0, 0, 1), 0.8, (0.2, 0.5, 0.1))


def laplacian_rows(v, f, weights):
    """The rows whose squares Laplacian editing sums, as a dense matrix."""
    n = len(v)
    matrix = np.zeros((n, n))
    if weights == "uniform":
        for a, b in ((0, 1), (1, 2), (2, 0)):
            matrix[f[:, a], f[:, b]] = matrix[f[:, b], f[:, a]] = -1
        matrix /= -matrix.sum(1)[:, None]
        np.fill_diagonal(matrix, 1)
        return matrix
    cotangents = half_cotangents(v, f)
    mass = np.zeros(n)
    area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1) / 2
    for c in range(3):
        j, k = f[:, (c + 1) % 3], f[:, (c + 2) % 3]
        for a, b in ((j, k), (k, j)):
            np.add.at(matrix, (a, b), -cotangents[:, c])
            np.add.at(matrix, (a, a), cotangents[:, c])
        np.add.at(mass, f[:, c], area / 3)
    return matrix / np.sqrt(mass)[:, None]


def least_squares(rows, delta, given, targets, weight=None):
    """min |A x - delta|^2, with x given exactly, or pulled by weight^2 |x - target|^2."""
    n = rows.shape[1]
    if weight is not None:
        pull = np.zeros((len(given), n))
        pull[np.arange(len(given)), given] = weight
        rows, delta = np.concatenate([rows, pull]), np.concatenate([delta, weight * targets])
        return np.linalg.lstsq(rows, delta, rcond=None)[0]
    free = np.setdiff1d(np.arange(n), given)
    x = np.empty((n, 3))
    x[given] = targets
    x[free] = np.linalg.lstsq(rows[:, free], delta - rows[:, given] @ targets, rcond=None)[0]
    return x


@pytest.mark.parametrize("weights", ["uniform", "cotangent"])
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_agrees_with_dense_least_squares(weights, constraints):
    vertices, faces = tube(rows=18, columns=12, bumps=0.1)
    unit = vertices / surface_diagonal(vertices, faces)
    low, high = ends(vertices)
    given = np.concatenate([low, high])
    targets = np.concatenate([vertices[low], moved(MOTION, vertices[high])])
    rows = laplacian_rows(unit, faces, weights)
    soft = 3.0 if constraints == "soft" else None
    expected = least_squares(rows, rows @ vertices, given, targets, soft)
    options = {"weights": weights, "constraints": constraints} | ({"weight": soft} if soft else {})
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [low, high], method="laplacian", **options)
    result = pose.solve([np.eye(4), MOTION])
    assert np.abs(result.vertices - expected).max() < 1e-8 * diagonal(vertices)
    by_points = pose.solve_points(targets)
    assert np.abs(by_points.vertices - expected).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("weights", ["uniform", "cotangent"])
def test_a_translation_is_reproduced(weights):
    vertices, faces = tube()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="laplacian", weights=weights)
    shift = rigid(offset=(1, -2, 3))
    assert np.abs(pose.solve([shift] * 2).vertices - moved(shift, vertices)).max() < 1e-8 * diagonal(vertices)


def test_membership_softens_the_edge_of_a_handle():
    vertices, faces = tube()
    low, high = ends(vertices, 0.2)
    x = vertices[high, 0]
    share = np.clip((x - x.min()) / np.ptp(x) * 2, 0.05, 1.0)
    mesh = lissom.Mesh(vertices, faces)
    lift = rigid(offset=(0, 0, 1.0))
    soft = lissom.Pose(mesh, [low, high], method="laplacian", handle_weights=[None, share])
    result = soft.solve([np.eye(4), lift]).vertices
    wholly, partly = high[share == 1], high[share < 0.5]
    assert np.allclose(result[wholly], vertices[wholly] + (0, 0, 1), rtol=0, atol=1e-13)
    lag = np.abs(result[partly] - vertices[partly] - (0, 0, 1)).max()
    assert 1e-4 < lag < 0.5
    everything = soft.solve([lift, lift]).vertices
    assert np.abs(everything - vertices - (0, 0, 1)).max() < 1e-8


@pytest.mark.parametrize(
    ("weights", "error", "text"),
    [
        ([None, [0.5]], lissom.InvalidConstraint, "1 weights for 256 vertices of handle 1"),
        ([None, np.full(256, 0.0)], lissom.InvalidConstraint, "above 0 and at most 1"),
        ([None, np.full(256, np.nan)], lissom.InvalidConstraint, "above 0 and at most 1"),
        ([None], ValueError, "expected 2 items, got 1"),
    ],
)
def test_bad_membership(weights, error, text):
    vertices, faces = tube()
    with pytest.raises(error, match=text):
        lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), handle_weights=weights)


def test_options_are_checked():
    vertices, faces = tube()
    mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
    with pytest.raises(
        TypeError, match="'laplacian' has no option colour; it has weights, constraints, weight"
    ):
        lissom.Pose(mesh, handles, method="laplacian", colour=1)
    with pytest.raises(lissom.InvalidValue, match="weights: 'mean' is none of cotangent, uniform"):
        lissom.Pose(mesh, handles, method="laplacian", weights="mean")
    with pytest.raises(lissom.InvalidValue, match="weight: must be a positive number"):
        lissom.Pose(mesh, handles, constraints="soft", weight=-1)
    with pytest.raises(TypeError, match="weight: cannot be 'much'"):
        lissom.Pose(mesh, handles, weight="much")
