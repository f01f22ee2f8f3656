"""ARAP: exactness, an independent dense implementation, and the survey's poses."""

from itertools import pairwise

import lissom
import numpy as np
import pytest
from shapes import diagonal, ends, grid_faces, moved, rigid, tube

# Energies that libigl 2.6.3 (spokes and rims) has after 1000 iterations from the rest pose,
# in the units of the data: what a converged solve must not exceed.
PLAIN = {"rotation_smoothing": 0.0, "smoothness": 0.0}
SURVEY = {"bar": 78.206, "cactus": 0.0042867, "cylinder": 1.53800, "plane": 4.5853}


def half_cotangents(v, f):
    """Half the cotangent at each corner, straight from dot and cross products."""
    weights = np.empty(f.shape)
    for c in range(3):
        a, b = v[f[:, (c + 1) % 3]] - v[f[:, c]], v[f[:, (c + 2) % 3]] - v[f[:, c]]
        weights[:, c] = 0.5 * (a * b).sum(1) / np.linalg.norm(np.cross(a, b), axis=1)
    return weights


def cell_covariances(v, f, x):
    """Covariance of each vertex's cell (spokes and rims) and the size of all edges, weighted."""
    weights = half_cotangents(v, f)
    triangles, size = np.zeros((len(f), 3, 3)), 0.0
    for c in range(3):
        j, k = f[:, (c + 1) % 3], f[:, (c + 2) % 3]
        old, new, w = v[k] - v[j], x[k] - x[j], weights[:, c]
        triangles += w[:, None, None] * new[:, :, None] * old[:, None, :]
        size += 3 * (w * ((old**2).sum(1) + (new**2).sum(1))).sum()
    cells = np.zeros((len(v), 3, 3))
    for c in range(3):
        np.add.at(cells, f[:, c], triangles)
    return cells, size


def best_rotations(cells):
    u, s, vt = np.linalg.svd(cells)
    sign = np.sign(np.linalg.det(u @ vt))
    u[:, :, 2] *= sign[:, None]
    s[:, 2] *= sign
    return u @ vt, s.sum(1)


def energy(v, f, x):
    """The spokes-and-rims energy in the units of the data, independent of the core."""
    cells, size = cell_covariances(v, f, x)
    return size - 2 * best_rotations(cells)[1].sum()


def dense_arap(v, f, given, x, iterations):
    """Local/global by dense matrices."""
    n = len(v)
    laplacian = np.zeros((n, n))
    weights = half_cotangents(v, f)
    for c in range(3):
        j, k = f[:, (c + 1) % 3], f[:, (c + 2) % 3]
        for a, b in ((j, k), (k, j)):
            np.add.at(laplacian, (a, b), -weights[:, c])
            np.add.at(laplacian, (a, a), weights[:, c])
    free = np.setdiff1d(np.arange(n), given)
    inverse = np.linalg.inv(laplacian[np.ix_(free, free)])
    for _ in range(iterations):
        rotations = best_rotations(cell_covariances(v, f, x)[0])[0]
        rhs = np.zeros((n, 3))
        for c in range(3):
            j, k = f[:, (c + 1) % 3], f[:, (c + 2) % 3]
            edge = np.einsum("tij,tj->ti", rotations[f].mean(1), v[k] - v[j]) * weights[:, c, None]
            np.add.at(rhs, k, edge)
            np.add.at(rhs, j, -edge)
        x = x.copy()
        x[free] = inverse @ (rhs[free] - laplacian[np.ix_(free, given)] @ x[given])
    return x


@pytest.mark.parametrize("by_points", [False, True])
@pytest.mark.parametrize("angle", [0.0, 1.0, 2.9, 3.14159])
def test_a_rigid_motion_of_all_handles_is_reproduced(angle, by_points):
    vertices, faces = tube()
    motion = rigid((1, 2, -1), angle, (3, -2, 0.5))
    handles = ends(vertices)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles)
    if by_points:
        result = pose.solve_points(moved(motion, vertices[np.concatenate(handles)]))
    else:
        result = pose.solve([motion, motion])
    assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)
    assert result.report["converged"]


def test_handles_of_single_points_reproduce_a_rigid_motion_together():
    vertices, faces = tube()
    motion = rigid((0, 1, 1), 2.0, (1, 0, 0))
    corners = [[v] for v in (0, 8, 16, 2000, 2550)]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), corners)
    result = pose.solve_points(moved(motion, vertices[np.concatenate(corners)]))
    assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


def test_the_rest_pose_stays():
    vertices, faces = tube()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices))
    result = pose.solve([np.eye(4), np.eye(4)])
    assert np.abs(result.vertices - vertices).max() < 1e-12
    assert result.report["energy"] < 1e-14


def test_the_region_is_solved_as_if_the_rest_were_one_more_handle():
    vertices, faces = tube()
    _, high = ends(vertices)
    outside = np.flatnonzero(vertices[:, 0] <= 2.0)
    mesh = lissom.Mesh(vertices, faces)
    motion = rigid((0, 0, 1), 1.2)
    roi = np.flatnonzero(vertices[:, 0] > 2.0)
    exact = {"tolerance": 1e-12, "max_iterations": 3000}
    by_roi = lissom.Pose(mesh, [high], roi=roi).solve([motion], **exact)
    by_handle = lissom.Pose(mesh, [high, outside]).solve([motion, np.eye(4)], **exact)
    assert np.abs(by_roi.vertices - by_handle.vertices).max() < 1e-5 * diagonal(vertices)


def test_agrees_with_a_dense_implementation():
    vertices, faces = tube(rows=12, columns=8, bumps=0.1)
    low, high = ends(vertices)
    motion = rigid((0, 0, 1), 0.8, (0.2, 0.5, 0))
    given = np.concatenate([low, high])
    start = vertices.copy()
    start[high] = moved(motion, vertices[high])
    expected = dense_arap(vertices, faces, given, start, 5000)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [low, high], **PLAIN)
    result = pose.solve([np.eye(4), motion], tolerance=1e-14, max_iterations=5000)
    assert np.abs(result.vertices - expected).max() < 1e-5 * diagonal(vertices)
    found = energy(vertices, faces, result.vertices)
    assert found <= energy(vertices, faces, expected) * (1 + 1e-9)
    assert np.isclose(found, result.report["energy"] * diagonal(vertices) ** 2, rtol=1e-9)


def test_the_energy_never_rises_and_a_warm_start_goes_on():
    vertices, faces = tube()
    low, high = ends(vertices)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [low, high])
    goal = [np.eye(4), rigid((0, 1, 0), 2.0, (0, 1, -2))]
    few = [pose.solve(goal, max_iterations=k, tolerance=0, warm_start=False) for k in (0, 1, 5, 20, 60)]
    energies = [r.report["energy"] for r in few]
    assert all(b <= a * (1 + 1e-12) for a, b in pairwise(energies))
    again = pose.solve(goal, max_iterations=1, tolerance=0)
    assert again.report["energy"] <= energies[-1] * (1 + 1e-12)


@pytest.mark.parametrize("name", list(SURVEY))
def test_survey(data, name):
    archive = data("survey")
    v, f, status = (archive[f"{name}_{part}"] for part in ("vertices", "faces", "status"))
    handles = [np.flatnonzero(status == 0), np.flatnonzero(status == 2)]
    pose = lissom.Pose(lissom.Mesh(v, f), handles, **PLAIN)
    result = pose.solve([np.eye(4), archive[f"{name}_transform"]], max_iterations=400)
    assert energy(v, f, result.vertices) <= SURVEY[name]


VARIANTS = [PLAIN, {"cells": "spokes"}, {"rotation_smoothing": 0.1}, {"smoothness": 0.1}]


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_variant_reproduces_a_rigid_motion(variant):
    vertices, faces = tube()
    motion = rigid((1, 2, -1), 2.5, (3, -2, 0.5))
    result = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), **variant).solve([motion] * 2)
    assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


def test_spokes_are_stationary_for_their_own_energy():
    """The gradient of the spokes energy, written edge by edge, vanishes at the free vertices."""
    vertices, faces = tube(rows=20, columns=14)
    low, high = ends(vertices)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [low, high], cells="spokes", **PLAIN)
    goal = [np.eye(4), rigid((0, 0, 1), 1.0, (0, 0.5, 0))]
    x = pose.solve(goal, tolerance=1e-15, max_iterations=3000).vertices
    n, weights = len(vertices), half_cotangents(vertices, faces)
    w = np.zeros((n, n))
    for c in range(3):
        j, k = faces[:, (c + 1) % 3], faces[:, (c + 2) % 3]
        np.add.at(w, (j, k), weights[:, c])
        np.add.at(w, (k, j), weights[:, c])
    w = np.maximum(w, 0)
    i, j = np.nonzero(w)
    cells = np.zeros((n, 3, 3))
    old, new = vertices[j] - vertices[i], x[j] - x[i]
    np.add.at(cells, i, w[i, j][:, None, None] * new[:, :, None] * old[:, None, :])
    rotations = best_rotations(cells)[0]
    force = np.zeros((n, 3))
    turned = np.einsum("eij,ej->ei", rotations[i] + rotations[j], old) / 2
    np.add.at(force, i, w[i, j][:, None] * (new - turned))
    free = np.setdiff1d(np.arange(n), np.concatenate([low, high]))
    size = np.abs(w[i, j][:, None] * new).max()
    assert np.abs(force[free]).max() < 1e-5 * size


def limb(seed, fineness):
    """A tube of random cross section, triangulated at random, its vertices shifted along it."""
    rng = np.random.default_rng(seed)
    waves = 0.5 * rng.uniform(-1, 1, (2, 3)) / np.arange(2, 5) ** 1.5
    rings, around = 30 * fineness, 20 * fineness
    angle = 2 * np.pi * np.arange(around) / around
    radius = 0.5 + 0.5 * sum(
        a * np.cos(k * angle) + b * np.sin(k * angle) for k, a, b in zip((2, 3, 4), *waves, strict=True)
    )
    height = (
        np.repeat(np.linspace(-3, 3, rings + 1), around)
        + rng.uniform(-0.3, 0.3, (rings + 1) * around) * 6 / rings
    )
    section = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    vertices = np.column_stack([np.tile(section, (rings + 1, 1)), height])
    corner = np.arange(rings * around).reshape(rings, around)
    p, q = corner.ravel(), np.roll(corner, -1, 1).ravel()
    s, t = q + around, p + around
    pairs = (np.array([(p, q, s), (p, s, t)]), np.array([(p, q, t), (q, s, t)]))
    faces = np.where(rng.random(len(p)) < 0.5, *pairs).transpose(2, 0, 1).reshape(-1, 3)
    return vertices, faces, around


def thinnest(vertices, posed, around):
    """The second singular value of the thinnest ring, over its rest value."""

    def second(x):
        rings = x.reshape(-1, around, 3)
        return np.linalg.svd(rings - rings.mean(1, keepdims=True), compute_uv=False)[:, 1]

    return (second(posed) / second(vertices)).min()


@pytest.mark.parametrize("seed", range(5))
def test_an_elbow_keeps_its_thickness_however_fine_the_mesh(seed):
    rng = np.random.default_rng(seed)
    motion = rigid(np.append(rng.normal(size=2), 0), rng.uniform(0.5, 1.6))
    kept = []
    for fineness in (2, 3, 4):
        vertices, faces, around = limb(seed, fineness)
        handles = [np.flatnonzero(vertices[:, 2] < -2.5), np.flatnonzero(vertices[:, 2] > 2.5)]
        result = lissom.Pose(lissom.Mesh(vertices, faces), handles).solve([np.eye(4), motion])
        assert result.report["converged"]
        kept.append(thinnest(vertices, result.vertices, around))
    assert min(kept) > 0.65
    assert np.ptp(kept) < 0.05


@pytest.mark.parametrize("amount", [0.001, 0.01, 0.1])
@pytest.mark.parametrize("degrees", [45, 90, 135, 165, 180])
def test_rotation_smoothing_converges_and_holds_at_half_a_turn(amount, degrees):
    vertices, faces, around = limb(0, 2)
    handles = [np.flatnonzero(vertices[:, 2] < -2.5), np.flatnonzero(vertices[:, 2] > 2.5)]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, rotation_smoothing=amount)
    goal = [np.eye(4), rigid((0, 1, 0), np.radians(degrees))]
    result = pose.solve(goal)
    assert result.report["converged"]
    exact = pose.solve(goal, max_iterations=3000, tolerance=1e-13, warm_start=False)
    assert np.abs(result.vertices - exact.vertices).max() < 1e-2
    assert thinnest(vertices, result.vertices, around) > 0.2


def test_rotation_smoothing_brings_neighbours_rotations_together():
    vertices, faces = tube()
    goal = [np.eye(4), rigid((0, 0, 1), 2.0, (-1, 3, 0))]
    spreads = []
    for amount in (0.0, 0.0005, 0.005):
        pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), rotation_smoothing=amount)
        x = pose.solve(goal, max_iterations=500).vertices
        rotations = best_rotations(cell_covariances(vertices, faces, x)[0])[0]
        spreads.append(
            sum(((rotations[faces[:, c]] - rotations[faces[:, c - 1]]) ** 2).sum() for c in range(3))
        )
    assert spreads[1] < 0.8 * spreads[0]
    assert spreads[2] < 0.6 * spreads[0]


@pytest.mark.parametrize("side", [31, 61])
def test_smoothness_takes_the_spike_off_a_single_moved_vertex(side):
    grid = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, side)], indexing="ij"), -1).reshape(-1, 2)
    vertices = np.column_stack([grid, np.zeros(len(grid))])
    border = np.flatnonzero((grid.min(1) < 0.07) | (grid.max(1) > 0.93))
    middle = [len(grid) // 2]
    targets = np.concatenate([vertices[border], vertices[middle] + (0, 0, 0.25)])

    def slope_at_peak(smoothness):
        mesh = lissom.Mesh(vertices, grid_faces(side, side))
        pose = lissom.Pose(mesh, [border, middle], smoothness=smoothness)
        height = pose.solve_points(targets, max_iterations=500).vertices[:, 2]
        return (height[middle[0]] - height[middle[0] + 1]) * (side - 1)

    assert slope_at_peak(0.0) > 0.8
    assert slope_at_peak(0.1) < 0.6 * slope_at_peak(0.0)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"rotation_smoothing": -1.0}, "rotation_smoothing: must be 0 or more"),
        ({"rotation_smoothing": np.nan}, "rotation_smoothing: must be 0 or more"),
        ({"smoothness": 1.0}, "smoothness: must be from 0 to below 1"),
        ({"cells": "rims"}, "cells: 'rims' is none of spokes_and_rims, spokes"),
    ],
)
def test_options_out_of_range(options, text):
    vertices, faces = tube(rows=10, columns=8)
    with pytest.raises(lissom.InvalidValue, match=text):
        lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices, 0.2), **options)


def test_handles_that_move_on_need_no_solve():
    """As whole handles they go on from responses, as points by a solve: the same start."""
    v, f = tube(24, 31)
    handles = [*ends(v), np.flatnonzero(np.abs(v[:, 0] - v[31 * 12, 0]) < 1e-9)[:5]]
    before, after = (
        [rigid([0.0, 0.0, 1.0], a, [0.1 * a, 0.0, 0.0]) for a in angles]
        for angles in ([0.0, 0.6, 0.2], [0.05, 0.7, 0.1])
    )
    for options in ({}, {"constraints": "soft"}, {"smoothness": 0.1}):
        starts = []
        for by_points in (False, True):
            pose = lissom.Pose(lissom.Mesh(v, f), handles, **options)
            pose.solve(before)
            if by_points:
                points = np.concatenate([moved(m, v[h]) for h, m in zip(handles, after, strict=True)])
                starts.append(pose.solve_points(points, max_iterations=0))
            else:
                starts.append(pose.solve(after, max_iterations=0))
        one, other = starts
        assert np.abs(one.vertices - other.vertices).max() < 1e-11 * diagonal(v)
        assert one.report.energy == pytest.approx(other.report.energy, rel=1e-9)
