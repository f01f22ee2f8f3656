"""Rotation-invariant coordinates: exactness, the thesis's own equations, whole turns, principal frames."""

import itertools

import lissom
import numpy as np
import pytest
from figures import edge_error, edges, ring_twist
from shapes import bend, diagonal, ends, moved, prism, rigid, rotation, tube

MOTION = rigid((0, 1, 2), 0.8, (0.2, 0.5, 0.1))
EVERY = [
    {"interpolation": i, "project": p, "frames": f, "weights": w}
    for i, p, f, w in itertools.product(
        ("rotation_vector", "matrix"), (True, False), ("uniform", "principal"), ("cotangent", "uniform")
    )
]


def bound(vertices, faces, handles, roi=None, **options):
    return lissom.Pose(lissom.Mesh(vertices, faces), handles, roi=roi, method="rotation_invariant", **options)


def rest_frames(v, f, random):
    """(n, 3, 3), columns b1, b2, N: area-weighted normal (3-14), b1 along some neighbour, projected."""
    normals = np.zeros_like(v)
    cross = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    for c in range(3):
        np.add.at(normals, f[:, c], cross)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    pairs = edges(f)
    pairs = random.permutation(np.concatenate([pairs, pairs[:, ::-1]]))
    neighbour = np.empty(len(v), int)
    neighbour[pairs[:, 0]] = pairs[:, 1]
    b1 = v[neighbour] - v
    b1 -= (b1 * normals).sum(1)[:, None] * normals
    b1 /= np.linalg.norm(b1, axis=1)[:, None]
    return np.stack([b1, np.cross(b1, normals), normals], 2)


def eliminate(rows, rhs, given, values):
    free = np.setdiff1d(np.arange(rows.shape[1]), given)
    x = np.empty((rows.shape[1], 3))
    x[given] = values
    x[free] = np.linalg.lstsq(rows[:, free], rhs - rows[:, given] @ values, rcond=None)[0]
    return x


def thesis(v, f, given, rotations, targets, project, random):
    """Equations 3-17 for frames (3n unknown vectors), then 3-18 for positions, by dense least squares."""
    n, frames = len(v), rest_frames(v, f, random)
    directed = np.concatenate([edges(f), edges(f)[:, ::-1]])
    rows = np.zeros((3 * len(directed), 3 * n))
    for r, (i, j) in enumerate(directed):
        coordinates = frames[i].T @ frames[j]
        for k in range(3):
            rows[3 * r + k, 3 * j + k] += 1
            rows[3 * r + k, 3 * i : 3 * i + 3] -= coordinates[:, k]
    at = (3 * given[:, None] + np.arange(3)).ravel()
    values = (rotations @ frames[given]).transpose(0, 2, 1).reshape(-1, 3)
    solved = eliminate(rows, np.zeros((len(rows), 3)), at, values).reshape(n, 3, 3).transpose(0, 2, 1)
    if project:
        u, _, vt = np.linalg.svd(solved @ frames.transpose(0, 2, 1))
        u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
        solved = u @ vt @ frames
    i, j = directed.T
    local = np.einsum("nak,na->nk", frames[i], v[j] - v[i])
    rows = np.zeros((len(directed), n))
    rows[np.arange(len(directed)), j] = 1
    rows[np.arange(len(directed)), i] = -1
    return eliminate(rows, np.einsum("nak,nk->na", solved[i], local), given, targets)


@pytest.mark.parametrize("project", [True, False])
@pytest.mark.parametrize("seed", [1, 2])
def test_agrees_with_the_frame_equations_whatever_the_tangents(project, seed):
    vertices, faces = tube(rows=18, columns=12, bumps=0.1)
    low, high = ends(vertices)
    given = np.concatenate([low, high])
    targets = np.concatenate([vertices[low], moved(MOTION, vertices[high])])
    turns = np.concatenate([np.tile(np.eye(3), (len(low), 1, 1)), np.tile(MOTION[:3, :3], (len(high), 1, 1))])
    random = np.random.default_rng(seed)
    expected = thesis(vertices, faces, given, turns, targets, project, random)
    pose = bound(vertices, faces, [low, high], weights="uniform", interpolation="matrix", project=project)
    result = pose.solve([np.eye(4), MOTION])
    assert np.abs(result.vertices - expected).max() < 1e-8 * diagonal(vertices)
    by_points = pose.solve_points(targets)
    assert np.abs(by_points.vertices - expected).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("options", EVERY)
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_rigid_motions_are_reproduced(options, constraints):
    vertices, faces = tube()
    pose = bound(vertices, faces, ends(vertices), constraints=constraints, **options)
    for motion in (np.eye(4), rigid(offset=(1, -2, 3)), rigid((1, 2, -1), 2.9, (5, 0, -1))):
        result = pose.solve([motion] * 2)
        assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("interpolation", ["rotation_vector", "matrix"])
def test_half_a_turn_of_points_is_reproduced(interpolation):
    # Here rounding decides the sign of each handle's rotation vector.
    vertices, faces = tube()
    handles = np.array_split(np.concatenate(ends(vertices)), 6)
    pose = bound(vertices, faces, handles, interpolation=interpolation)
    random = np.random.default_rng(3)
    for axis in random.normal(size=(5, 3)):
        motion = rigid(axis, np.pi, (1, 0, 2))
        targets = moved(motion, vertices[np.concatenate(handles)])
        result = pose.solve_points(targets + random.normal(size=targets.shape) * 1e-13)
        assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


def test_without_projection_affine_motions_are_reproduced():
    vertices, faces = tube()
    motion = rigid((1, 0, 1), 1.0, (1, 2, 3))
    motion[:3, :3] @= np.array([[2, 0.3, 0], [0, 0.5, 0.2], [0, 0, -1.5]])
    pose = bound(vertices, faces, ends(vertices), interpolation="matrix", project=False)
    result = pose.solve([motion] * 2)
    assert np.abs(result.vertices - moved(motion, vertices)).max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("turns", [0.9, 1.5, 2.0, -2.0])
def test_whole_turns_come_out_whole(turns):
    rows, columns, angle = 200, 24, 2 * np.pi * turns
    vertices, faces = prism(rows, columns, length=12, square=True)
    pose = bound(vertices, faces, ends(vertices, 0.05))
    goal = [np.eye(4), rigid((1, 0, 0), angle)]
    result = pose.solve(goal, turns=[[0, 0, 0], [angle, 0, 0]]).vertices
    twist = ring_twist(vertices, result, rows, columns)
    assert np.isclose(twist[-1] - twist[0], angle, rtol=0, atol=1e-9)
    middle = twist[20:-20]
    assert np.allclose(np.diff(middle), np.diff(middle).mean(), rtol=0.08, atol=0)
    # Least squares thins a twisted bar, by about one over 1 + (radius times twist per length)^2.
    rings = result[: rows * columns].reshape(rows, columns, 3)[:, :, 1:]
    rest = vertices[: rows * columns].reshape(rows, columns, 3)[:, :, 1:]
    ratio = np.linalg.norm(rings - rings.mean(1, keepdims=True), axis=2) / np.linalg.norm(rest, axis=2)
    corner = np.sqrt(0.5) * np.diff(middle).mean() / (12 / (rows - 1))
    assert ratio.min() > 0.95 / (1 + corner**2) and ratio.max() < 1 + 1e-9
    # Without turns, the matrix alone says the least rotation.
    least = ring_twist(vertices, pose.solve(goal).vertices, rows, columns)
    expected = abs(angle - 2 * np.pi * np.round(turns))
    assert np.isclose(abs(least[-1] - least[0]), expected, rtol=0, atol=1e-9)


def test_matrices_lose_shape_half_way_to_half_a_turn_and_vectors_do_not():
    rows, columns = 100, 32
    vertices, faces = prism(rows, columns)
    goal = [np.eye(4), rigid((1, 0, 0), np.pi * 0.98)]
    narrowest = {}
    for name, options in {
        "vector": {},
        "matrix": {"interpolation": "matrix"},
        "thesis": {"interpolation": "matrix", "project": False},
    }.items():
        result = bound(vertices, faces, ends(vertices), **options).solve(goal).vertices
        rings = result[: rows * columns].reshape(rows, columns, 3)[:, :, 1:]
        narrowest[name] = np.linalg.norm(rings - rings.mean(1, keepdims=True), axis=2).mean(1).min() / 0.5
    assert narrowest["vector"] > 0.85
    assert narrowest["thesis"] < 0.1
    assert 0.2 < narrowest["matrix"] < 0.5


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    # Of a cylinder all edges along x weigh the same, and so no weights can change how frames turn along
    # it; on a box and a bumpy tube they do, by less than one hundredth of the diagonal.
    [("cylinder", 0, 1e-10), ("box", 1e-4, 1e-2), ("bumpy", 1e-4, 1e-2)],
)
def test_what_principal_frames_change(shape, low, high):
    vertices, faces = tube(bumps=0.1) if shape == "bumpy" else prism(square=shape == "box")
    twist = [[0, 0, 0], [4 * np.pi, 0, 0]]
    goal, turns = ([np.eye(4)] * 2, twist) if shape == "box" else ([np.eye(4), bend(vertices, np.pi)], None)
    uniform, principal = (
        bound(vertices, faces, ends(vertices), frames=frames).solve(goal, turns=turns).vertices
        for frames in ("uniform", "principal")
    )
    assert low <= np.abs(uniform - principal).max() / diagonal(vertices) <= high


def test_a_cylinder_bends_by_half_a_turn():
    vertices, faces = prism()
    goal = [np.eye(4), bend(vertices, np.pi)]
    for frames in ("uniform", "principal"):
        result = bound(vertices, faces, ends(vertices), frames=frames).solve(goal).vertices
        assert edge_error(vertices, result, faces) < 0.2
        # The middle of the arc is as far out as a bend without stretch takes it.
        arc = 0.8 * 6 / np.pi
        middle = result[50 * 32 : 51 * 32].mean(0)
        assert np.abs(middle - (0.6 + arc, arc, 0)).max() < 0.1


def test_handles_that_turn_past_half_a_turn_together_agree():
    vertices, faces = tube()
    pose = bound(vertices, faces, ends(vertices))
    base = rotation((0, 0, 1), np.radians(179))
    goal = [rigid((0, 0, 1), np.radians(179)), rigid((0, 0, 1), np.radians(182))]
    result = pose.solve(goal).vertices @ base
    gentle = pose.solve([np.eye(4), rigid((0, 0, 1), np.radians(3))]).vertices
    assert np.abs(result - gentle).max() < 1e-8 * diagonal(vertices)


def test_options_are_checked():
    vertices, faces = tube()
    handles = ends(vertices)
    with pytest.raises(lissom.InvalidValue, match="frames: 'best' is none of uniform, principal"):
        bound(vertices, faces, handles, frames="best")
    with pytest.raises(lissom.InvalidValue, match="interpolation: 'log' is none of rotation_vector, matrix"):
        bound(vertices, faces, handles, interpolation="log")
    with pytest.raises(TypeError, match="project: cannot be 'yes'"):
        bound(vertices, faces, handles, project="yes")
    with pytest.raises(
        TypeError, match="has no option border; it has weights, frames, interpolation, project"
    ):
        bound(vertices, faces, handles, border=1)
    with pytest.raises(lissom.InvalidConstraint, match="1 rotation vectors for 2 handles"):
        bound(vertices, faces, handles).solve([MOTION] * 2, turns=[[0, 0, 1]])
