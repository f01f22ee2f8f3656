"""Laplacian editing with estimated rotations: a dense reference, and what the second pass is for."""

import lissom
import numpy as np
import pytest
from dense import laplacian_and_mass, surface_diagonal
from shapes import diagonal, ends, moved, rigid, tube
from test_laplacian import laplacian_rows, least_squares

MOTION = rigid((0, 0, 1), 0.8, (0.2, 0.5, 0.1))


def gradients(v, f, x):
    """(m, 3, 3): edges to edges, normal to normal."""

    def frames(p):
        a, b = p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]]
        n = np.cross(a, b)
        return np.stack([a, b, n / np.linalg.norm(n, axis=1)[:, None]], -1)

    return frames(x) @ np.linalg.inv(frames(v))


def nearest_rotations(m):
    u, _, vt = np.linalg.svd(m)
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    return u @ vt


@pytest.mark.parametrize("weights", ["uniform", "cotangent"])
@pytest.mark.parametrize("estimate", [0.0, 0.1])
def test_agrees_with_a_dense_reference(weights, estimate):
    vertices, faces = tube(rows=18, columns=12, bumps=0.1)
    unit = vertices / surface_diagonal(vertices, faces)
    low, high = ends(unit)
    given = np.concatenate([low, high])
    motion = MOTION.copy()
    motion[:3, 3] /= surface_diagonal(vertices, faces)
    targets = np.concatenate([unit[low], moved(motion, unit[high])])
    rows = laplacian_rows(unit, faces, weights)
    first = least_squares(rows, rows @ unit, given, targets)

    laplacian, mass = laplacian_and_mass(unit, faces)
    a, b, c = (unit[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    mean = np.zeros((len(unit), 3, 3))
    for corner in range(3):
        np.add.at(mean, faces[:, corner], gradients(unit, faces, first) * areas[:, None, None] / 3)
    mean /= mass[:, None, None]
    mean[low], mean[high] = np.eye(3), motion[:3, :3]
    free = np.setdiff1d(np.arange(len(unit)), given)
    matrix = np.diag(mass) + estimate**2 * laplacian
    rhs = mass[:, None] * mean.reshape(-1, 9)
    flat = mean.reshape(-1, 9)
    flat[free] = np.linalg.solve(
        matrix[np.ix_(free, free)], rhs[free] - matrix[np.ix_(free, given)] @ flat[given]
    )
    turned = np.einsum("nij,nj->ni", nearest_rotations(flat.reshape(-1, 3, 3)), rows @ unit)
    expected = least_squares(rows, turned, given, targets)

    options = {"method": "laplacian_rotated", "weights": weights, "estimate": estimate}
    pose = lissom.Pose(lissom.Mesh(unit, faces), [low, high], **options)
    assert np.abs(pose.solve([np.eye(4), motion]).vertices - expected).max() < 1e-8


def stretched(vertices, faces, posed):
    """Root mean square change of the edges' lengths, of their own."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    before, after = (np.linalg.norm(x[sides[:, 1]] - x[sides[:, 0]], axis=1) for x in (vertices, posed))
    return np.sqrt(np.mean((after / before - 1) ** 2))


def bend_of_tube(angle):
    """The motion of the far end of a tube whose axis becomes an arc of its own length."""
    motion, radius = rigid((0, 0, 1), angle), 4.8 / angle
    arrives = np.array([0.6 + radius * np.sin(angle), radius * (1 - np.cos(angle)), 0])
    motion[:3, 3] = arrives - motion[:3, :3] @ [5.4, 0, 0]
    return motion


@pytest.mark.parametrize("angle", [np.pi / 3, np.pi / 2])
def test_details_turn_that_the_first_pass_shears(angle):
    vertices, faces = tube(bumps=0.1)
    mesh, goal = lissom.Mesh(vertices, faces), [np.eye(4), bend_of_tube(angle)]

    def error(method):
        pose = lissom.Pose(mesh, ends(vertices), method=method)
        return stretched(vertices, faces, pose.solve(goal).vertices)

    assert error("arap") < error("laplacian_rotated") < 0.75 * error("laplacian")


def test_a_mean_over_more_smooths_the_turns():
    vertices, faces = tube(bumps=0.1)
    mesh, goal = lissom.Mesh(vertices, faces), [np.eye(4), bend_of_tube(np.pi / 3)]
    plain, barely, mean = (
        lissom.Pose(mesh, ends(vertices), method="laplacian_rotated", estimate=length).solve(goal).vertices
        for length in (0.0, 1e-5, 0.05)
    )
    assert np.abs(barely - plain).max() < 1e-4 * diagonal(vertices) < np.abs(mean - plain).max()


def test_row_03_the_length_must_not_be_negative():
    vertices, faces = tube()
    for length in (-0.1, np.nan, np.inf):
        with pytest.raises(lissom.InvalidValue, match="estimate: must be 0 or more"):
            lissom.Pose(
                lissom.Mesh(vertices, faces), ends(vertices), method="laplacian_rotated", estimate=length
            )
