"""Multiresolution editing: exactness, a dense implementation, and that details come through."""

import lissom
import numpy as np
import pytest
from dense import surface_diagonal
from figures import edge_error
from shapes import bend, diagonal, ends, moved, prism, rigid, tube
from test_arap import half_cotangents
from test_laplacian import laplacian_rows, least_squares

DETAILS = ["gradients", "offsets"]
BASES = [
    {"base": "poisson"},
    {"base": "poisson", "border": 1},
    {"base": "rotation_invariant", "frames": "principal"},
    {"base": "arap"},
]


def bound(vertices, faces, handles, roi=None, **options):
    return lissom.Pose(lissom.Mesh(vertices, faces), handles, roi=roi, method="multiresolution", **options)


def gradients(v, f, x):
    """(t, 3, 3): edges to edges, unit normal to unit normal."""

    def edges(p):
        a, b = p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]]
        n = np.cross(a, b)
        return np.stack([a, b, n / np.linalg.norm(n, axis=1)[:, None]], 2)

    return edges(x) @ np.linalg.inv(edges(v))


def areas(v, f):
    return np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1) / 2


def stitched(v, f, targets, given, positions):
    """min sum w |e(x) - C e(v)|^2, row by row."""
    w, free = half_cotangents(v, f), np.setdiff1d(np.arange(len(v)), given)
    matrix, side = np.zeros((len(v), len(v))), np.zeros_like(v)
    for c in range(3):
        j, k = f[:, (c + 1) % 3], f[:, (c + 2) % 3]
        row = np.zeros((len(f), len(v)))
        row[np.arange(len(f)), k] = 1
        row[np.arange(len(f)), j] = -1
        weighted = row.T * w[:, c]
        matrix += weighted @ row
        side += weighted @ np.einsum("tab,tb->ta", targets, v[k] - v[j])
    x = np.empty_like(v)
    x[given] = positions
    inner = matrix[np.ix_(free, free)]
    x[free] = np.linalg.solve(inner, side[free] - matrix[np.ix_(free, given)] @ positions)
    return x


def dense(v, f, given, targets, smoothing, details):
    """The base by dense fairing, posed by Laplacian editing, and the details put back; unit diagonal."""
    n, rows = len(v), laplacian_rows(v, f, "cotangent")
    mass = np.zeros(n)
    for c in range(3):
        np.add.at(mass, f[:, c], areas(v, f) / 3)
    stiffness = (smoothing / (2 * np.pi)) ** 4
    free = np.setdiff1d(np.arange(n), given)
    matrix = np.diag(mass) + stiffness * rows.T @ rows
    base = v.copy()
    side = mass[:, None] * v - matrix[:, given] @ v[given]
    base[free] = np.linalg.solve(matrix[np.ix_(free, free)], side[free])
    rows = laplacian_rows(base, f, "cotangent")
    posed = least_squares(rows, rows @ base, given, targets)
    q = gradients(base, f, posed)
    if details == "gradients":
        return base, stitched(v, f, q, given, targets)
    mean = np.zeros((n, 3, 3))
    for c in range(3):
        np.add.at(mean, f[:, c], q * areas(base, f)[:, None, None])
    u, _, vt = np.linalg.svd(mean)
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    return base, posed + np.einsum("nab,nb->na", u @ vt, v - base)


@pytest.mark.parametrize("details", DETAILS)
def test_agrees_with_a_dense_implementation(details):
    vertices, faces = tube(rows=18, columns=12, bumps=0.1)
    vertices /= surface_diagonal(vertices, faces)
    low, high = ends(vertices)
    motion = rigid((0, 0, 1), 0.8, (0.05, 0.1, 0.02))
    given = np.concatenate([low, high])
    targets = np.concatenate([vertices[low], moved(motion, vertices[high])])
    base, expected = dense(vertices, faces, given, targets, 0.3, details)
    assert np.abs(base - vertices).max() > 1e-3
    pose = bound(vertices, faces, [low, high], base="laplacian", smoothing=0.3, details=details)
    result = pose.solve([np.eye(4), motion]).vertices
    assert np.abs(result - expected).max() < 1e-8


@pytest.mark.parametrize("details", DETAILS)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_rigid_motions_are_reproduced(base, details, constraints):
    vertices, faces = tube()
    pose = bound(vertices, faces, ends(vertices), details=details, constraints=constraints, **base)
    for motion in (np.eye(4), rigid(offset=(1, -2, 3)), rigid((1, 2, -1), 2.9, (5, 0, -1))):
        result = pose.solve([motion] * 2, warm_start=False)
        assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("details", DETAILS)
def test_without_smoothing_it_is_the_base_method(details):
    vertices, faces = tube()
    goal = [np.eye(4), rigid((0, 1, 0), 1.2, (0, 1, -1))]
    mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
    plain = lissom.Pose(mesh, handles, method="poisson").solve(goal).vertices
    result = bound(vertices, faces, handles, smoothing=0.0, details=details).solve(goal).vertices
    assert np.abs(result - plain).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("details", DETAILS)
def test_details_turn_with_the_base(details):
    # A smooth bar and a rough one: after the same bend, the roughness is that of rest, turned along.
    rows, columns = 120, 40
    smooth, faces = prism(rows, columns)
    outward = smooth * (0, 1, 1)
    bumps = np.sin(12 * smooth[:, :1]) * np.cos(8 * np.arctan2(smooth[:, 1:2], smooth[:, 2:]))
    inner = (smooth[:, :1] > 0.7) & (smooth[:, :1] < 5.3)
    rough = smooth + 0.06 * bumps * outward * inner
    goal = [np.eye(4), bend(smooth, np.pi / 2)]
    pose = bound(rough, faces, ends(rough), smoothing=0.3, details=details)
    result = pose.solve(goal).vertices
    carrier = lissom.Pose(lissom.Mesh(smooth, faces), ends(smooth), method="poisson").solve(goal).vertices
    kept = np.linalg.norm((result - carrier) - (rough - smooth), axis=1)
    height = np.linalg.norm(result - carrier, axis=1)
    expected = np.linalg.norm(rough - smooth, axis=1)
    bumpy = expected > 0.01
    assert abs(height[bumpy].mean() / expected[bumpy].mean() - 1) < 0.15
    assert kept[bumpy].max() > 0.02  # they did turn
    assert edge_error(rough, result, faces) < 0.25


def test_the_base_takes_its_own_options():
    vertices, faces = tube()
    goal = [np.eye(4), rigid((1, 0, 0), 1.2)]
    handles = ends(vertices)
    by_order = [bound(vertices, faces, handles, border=k).solve(goal).vertices for k in (0, 1)]
    assert np.abs(by_order[0] - by_order[1]).max() > 1e-2
    arap = bound(vertices, faces, handles, base="arap").solve(goal)
    assert arap.report["iterations"] > 1 and arap.report["energy"] > 0


def test_options_are_checked():
    vertices, faces = tube()
    handles = ends(vertices)
    with pytest.raises(lissom.InvalidValue, match="base: must be another method"):
        bound(vertices, faces, handles, base="multiresolution")
    with pytest.raises(lissom.InvalidValue, match="base: no method named 'spline', there are laplacian"):
        bound(vertices, faces, handles, base="spline")
    with pytest.raises(lissom.InvalidValue, match="border: must be 0, 1 or 2, got 7"):
        bound(vertices, faces, handles, border=7)
    with pytest.raises(lissom.InvalidValue, match="details: 'none' is none of gradients, offsets"):
        bound(vertices, faces, handles, details="none")
    for smoothing in (-0.1, np.nan, np.inf):
        with pytest.raises(lissom.InvalidValue, match="smoothing: must be 0 or more"):
            bound(vertices, faces, handles, smoothing=smoothing)
    with pytest.raises(
        TypeError, match="'multiresolution' has no option frames; it has smoothing, details, base"
    ):
        bound(vertices, faces, handles, frames="uniform")
