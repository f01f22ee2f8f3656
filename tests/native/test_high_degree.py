"""Vertices with thousands of triangles: rows of second differences that would fill a matrix stay apart."""

import lissom
import numpy as np
import pytest
from dense import minimise, surface_diagonal
from shapes import grid_faces, moved, rigid
from test_laplacian_fitted import fitted_rows
from test_thin_shell import shell_rows

METHODS = ("laplacian", "laplacian_fitted", "laplacian_rotated", "thin_shell", "multiresolution")


def drum(degree, rings=3):
    """A vertex amid `degree` triangles, with rings around."""
    angle = np.linspace(0, 2 * np.pi, degree, endpoint=False)
    radii = 1 + 0.1 * np.arange(rings)
    around = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.1 * r * np.sin(3 * angle)]) for r in radii
    ]
    i = np.arange(degree)
    fan = np.column_stack([0 * i, 1 + i, 1 + (i + 1) % degree])
    vertices = np.concatenate([[[0, 0, 0.5]], *around])
    return vertices, np.concatenate([fan, 1 + grid_faces(rings, degree, closed=True)])


@pytest.mark.parametrize("border", [0, 1, 2])
@pytest.mark.parametrize("held", [False, True])
def test_a_thin_shell_agrees_with_dense_least_squares(border, held):
    degree = 300
    vertices, faces = drum(degree)
    last = np.arange(len(vertices) - degree, len(vertices))
    handles = [last[: degree // 2], last[degree // 2 :], *([[0]] if held else [])]
    given = np.concatenate(handles)
    motions = [np.eye(4), rigid((0, 1, 0), 0.4, (0, 0, 0.2)), rigid(offset=(0, 0, 0.3))][: len(handles)]
    targets = np.concatenate([moved(m, vertices[h]) for m, h in zip(motions, handles, strict=True)])
    scale = surface_diagonal(vertices, faces)
    free = np.setdiff1d(np.arange(len(vertices)), given)
    rows = shell_rows(vertices / scale, faces, 1.0, 2.0, border, free)
    lift = (targets - vertices[given]) / scale
    expected = vertices + scale * minimise(rows, np.zeros((len(rows), 3)), given, lift)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method="thin_shell", border=border)
    assert np.abs(pose.solve(motions).vertices - expected).max() < 1e-7 * scale


@pytest.mark.parametrize("scale", [True, False])
def test_fitted_laplacian_editing_agrees_with_the_dense_equations(scale):
    degree = 260
    vertices, faces = drum(degree, rings=2)
    last = np.arange(len(vertices) - degree, len(vertices))
    handles, motion = [last[:40], last[100:160]], rigid((0, 1, 0), 0.3, (0, 0, 0.2))
    given = np.concatenate(handles)
    rows = fitted_rows(vertices, faces, "uniform", scale)
    lift = (moved(motion, vertices[handles[1]]) - vertices[handles[1]]).ravel()
    delta = np.concatenate([np.zeros(3 * len(handles[0])), lift])
    unknowns = (3 * given[:, None] + np.arange(3)).ravel()
    expected = vertices + minimise(rows, np.zeros(len(rows)), unknowns, delta).reshape(-1, 3)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method="laplacian_fitted", scale=scale)
    assert np.abs(pose.solve([np.eye(4), motion]).vertices - expected).max() < 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_factors_do_not_grow_with_the_square_of_the_degree(method):
    """A product of the longest row alone has the square of 20,000 values."""
    degree = 20_000
    vertices, faces = drum(degree, rings=2)
    last = np.arange(len(vertices) - degree, len(vertices))
    handles = [last[: degree // 2], [0]]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
    assert pose.info["factor_nonzeros"] < 300 * len(vertices)
    posed = pose.solve([np.eye(4), rigid((0, 1, 0), 0.2, (0, 0, 0.2))]).vertices
    assert np.isfinite(posed).all()
    assert np.abs(posed - vertices).max() < 5
