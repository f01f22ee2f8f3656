"""Poisson editing: exactness, an independent dense implementation, whole turns."""

import lissom
import numpy as np
import pytest
from figures import ring_twist
from shapes import diagonal, ends, moved, prism, rigid, tube
from test_laplacian import laplacian_rows

ORDERS = [0, 1, 2]


def bound(vertices, faces, handles, roi=None, **options):
    return lissom.Pose(lissom.Mesh(vertices, faces), handles, roi=roi, method="poisson", **options)


def logarithm(r):
    angle = np.arccos((np.trace(r) - 1) / 2)
    return angle / (2 * np.sin(angle)) * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])


def exponential(vectors):
    angle = np.linalg.norm(vectors, axis=1)[:, None, None] + 1e-300
    x, y, z = (vectors / angle[:, :, 0]).T
    zero = np.zeros_like(x)
    k = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def dense_poisson(v, f, handles, motions, order):
    """Weights by dense least squares; gradients and stitching by a dense gradient operator."""
    given = np.concatenate(handles)
    free = np.setdiff1d(np.arange(len(v)), given)
    rows = laplacian_rows(v, f, "cotangent")  # M^(-1/2) L
    cross = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    area = np.linalg.norm(cross, axis=1) / 2
    normal = cross / (2 * area[:, None])
    gradient = np.zeros((len(f), 3, len(v)))
    for c in range(3):
        opposite = v[f[:, (c + 2) % 3]] - v[f[:, (c + 1) % 3]]
        gradient[np.arange(len(f)), :, f[:, c]] = np.cross(normal, opposite) / (2 * area[:, None])
    weighted = (np.sqrt(area)[:, None, None] * gradient).reshape(-1, len(v))
    energy = [weighted, rows][order]
    weights = np.zeros((len(v), len(handles)))
    for h, handle in enumerate(handles):
        weights[handle, h] = 1
    weights[free] = np.linalg.lstsq(energy[:, free], -energy[:, given] @ weights[given], rcond=None)[0]
    of_face = weights[f].mean(1)
    parts = []
    for m in motions:
        u, s, vt = np.linalg.svd(m[:3, :3])
        parts.append((logarithm(u @ vt), vt.T @ np.diag(s) @ vt))
    turn = exponential(of_face @ np.array([r for r, _ in parts]))
    stretch = np.eye(3) + np.einsum("th,hab->tab", of_face, np.array([s - np.eye(3) for _, s in parts]))
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    # Row k of a gradient holds the derivatives of all coordinates along axis k.
    target = (np.sqrt(area)[:, None, None] * (turn @ stretch @ tangent).transpose(0, 2, 1)).reshape(-1, 3)
    x = v.copy()
    for handle, m in zip(handles, motions, strict=True):
        x[handle] = moved(m, v[handle])
    x[free] = np.linalg.lstsq(weighted[:, free], target - weighted[:, given] @ x[given], rcond=None)[0]
    return x


@pytest.mark.parametrize("border", [0, 1])
def test_agrees_with_a_dense_implementation(border):
    vertices, faces = tube(rows=18, columns=12, bumps=0.1)
    low, high = ends(vertices)
    middle = np.flatnonzero(np.abs(vertices[:, 0] - 3) < 0.2)
    motions = [rigid((1, 0, 0), 0.3), rigid((0, 1, 0), 1.0, (0.3, 0, 0)), rigid((0, 1, 1), 1.7, (0, 1, 0))]
    motions[1][:3, :3] @= np.diag([1.2, 0.8, 1.0])
    handles = [low, middle, high]
    expected = dense_poisson(vertices, faces, handles, motions, border)
    result = bound(vertices, faces, handles, border=border).solve(motions).vertices
    assert np.abs(result - expected).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("border", ORDERS)
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_rigid_and_affine_motions_are_reproduced(border, constraints):
    vertices, faces = tube()
    pose = bound(vertices, faces, ends(vertices), border=border, constraints=constraints)
    affine = rigid((1, 0, 1), 1.0, (1, 2, 3))
    affine[:3, :3] @= np.array([[2, 0.3, 0], [0, 0.5, 0.2], [0, 0, 1.5]])
    for motion in (np.eye(4), rigid(offset=(1, -2, 3)), rigid((1, 2, -1), 2.9, (5, 0, -1)), affine):
        result = pose.solve([motion] * 2)
        assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("border", ORDERS)
def test_points_are_reproduced_also_by_half_a_turn(border):
    vertices, faces = tube()
    handles = np.array_split(np.concatenate(ends(vertices)), 5)
    pose = bound(vertices, faces, handles, border=border)
    for axis in ((1, 2, 3), (-1, 0.5, 0.1)):
        motion = rigid(axis, np.pi, (1, 0, 2))
        result = pose.solve_points(moved(motion, vertices[np.concatenate(handles)])).vertices
        assert np.abs(result - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("border", ORDERS)
@pytest.mark.parametrize("turns", [1.5, 2.0])
def test_whole_turns_come_out_whole(border, turns):
    rows, columns, angle = 200, 24, 2 * np.pi * turns
    vertices, faces = prism(rows, columns, length=12, square=True)
    pose = bound(vertices, faces, ends(vertices, 0.05), border=border)
    goal = [np.eye(4), rigid((1, 0, 0), angle)]
    result = pose.solve(goal, turns=[[0, 0, 0], [angle, 0, 0]]).vertices
    twist = ring_twist(vertices, result, rows, columns)
    assert np.isclose(twist[-1] - twist[0], angle, rtol=0, atol=1e-9)
    assert np.isclose(twist[rows // 2 - 1 : rows // 2 + 1].mean(), angle / 2, rtol=0.01)
    assert (np.diff(twist) > -1e-9).all()


def test_a_smoother_border_turns_off_more_gently():
    rows, columns = 100, 32
    vertices, faces = prism(rows, columns)
    start = []
    for border in ORDERS:
        goal = [np.eye(4), rigid((1, 0, 0), 1.5)]
        result = bound(vertices, faces, ends(vertices), border=border).solve(goal).vertices
        twist = ring_twist(vertices, result, rows, columns)
        start.append(np.diff(twist[10:14]).mean() / (1.5 / (0.8 * rows)))
    assert start[2] < start[1] < 0.6
    assert 0.9 < start[0] < 1.1


def test_a_scaled_handle_hands_its_stretch_on():
    vertices, faces = prism(100, 32)
    low, high = ends(vertices)
    larger = np.diag([1.0, 2.0, 2.0, 1.0])
    result = bound(vertices, faces, [low, high]).solve([np.eye(4), larger]).vertices
    radius = np.linalg.norm(result[:3200].reshape(100, 32, 3)[:, :, 1:], axis=2).mean(1) / 0.5
    expected = np.clip(1 + (np.linspace(0, 6, 100) - 0.6) / 4.8, 1, 2)
    assert np.abs(radius - expected).max() < 0.05


def test_options_are_checked():
    vertices, faces = tube()
    with pytest.raises(lissom.InvalidValue, match="border: must be 0, 1 or 2, got 3"):
        bound(vertices, faces, ends(vertices), border=3)
    with pytest.raises(lissom.InvalidValue, match="border: must not be negative, got -1"):
        bound(vertices, faces, ends(vertices), border=-1)
    with pytest.raises(
        TypeError, match="'poisson' has no option base; it has border, solid, constraints, weight"
    ):
        bound(vertices, faces, ends(vertices), base="arap")


@pytest.mark.parametrize("method", ["poisson", "rotation_invariant", "arap"])
def test_a_twist_with_a_tilt_keeps_its_turns(method):
    # Its matrix is that of the tilt alone, whose axis has nothing to do with the twist's.
    rows, columns = 200, 24
    vertices, faces = prism(rows, columns, length=12, square=True)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices, 0.05), method=method)
    turns = [[0, 0, 0], [4 * np.pi, 0, 0]]
    for tilt in (1e-7, 0.3):  # the first is what single precision makes of no tilt
        goal = [np.eye(4), rigid((0, 1, 0), tilt)]
        result = pose.solve(goal, turns=turns, max_iterations=20, warm_start=False).vertices
        twist = ring_twist(vertices, result, rows, columns)
        assert abs(twist[-1] - twist[0] - 4 * np.pi) < 0.05
        assert (np.diff(twist[15:-15]) > 0).all()
