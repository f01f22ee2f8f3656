"""Handles that are moved and not turned, and turn by themselves (thesis 3.4.2, figure 3-4)."""

import lissom
import numpy as np
import pytest
from figures import closed_volume, edge_error, volume
from shapes import bend, diagonal, ends, moved, prism, rigid, rotation, tube

DIRECT = [method for method in lissom.POSE_METHODS if method != "arap"]
TO_THE_END = {"max_iterations": 3000, "tolerance": 1e-11, "warm_start": False}


def untwisted(motion, centre):
    """The motion of a handle that is moved to where `motion` takes its centre, and not turned."""
    return rigid(offset=moved(motion, centre) - centre)


def turned(motion, centre, turn):
    """The same, then turned about the centre by a (3, 3) rotation."""
    matrix = np.eye(4)
    matrix[:3, :3] = turn @ motion[:3, :3]
    matrix[:3, 3] = moved(motion, centre) - matrix[:3, :3] @ centre
    return matrix


def vector(turn):
    """Axis times angle of a (3, 3) rotation below half a turn."""
    axial = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine = np.linalg.norm(axial)
    angle = np.arctan2(sine, (np.trace(turn) - 1) / 2)
    return axial * (angle / sine if sine > 1e-12 else 1.0)


def exponential(r):
    """The (3, 3) rotation of a rotation vector."""
    angle = np.linalg.norm(r)
    return rotation(r, angle) if angle > 1e-12 else np.eye(3)


def placed(rng, vertices):
    """The same shape, somewhere and turned somehow, with its placement."""
    place = rigid(rng.normal(size=3), rng.uniform(0, 3), rng.normal(size=3))
    return moved(place, vertices), place


def a_bend(seed):
    """A random prism, placed at random: vertices, faces, handles, the second handle's motion and centre."""
    rng = np.random.default_rng(seed)
    vertices, faces = prism(rows=40, columns=16, length=rng.uniform(6, 10), square=seed % 2 == 1)
    handles = ends(vertices)
    motion = bend(vertices, rng.uniform(0.4, 2.2))
    vertices, place = placed(rng, vertices)
    motion = place @ motion @ np.linalg.inv(place)
    return vertices, faces, handles, motion, vertices[handles[1]].mean(axis=0)


@pytest.mark.parametrize("method", ["rotation_invariant", "poisson", "multiresolution", "arap"])
def test_the_thesis_s_figure(method):
    vertices, faces = prism(rows=100, columns=32, length=6)
    handles, motion = ends(vertices), bend(vertices, np.pi / 2)
    centre = vertices[handles[1]].mean(axis=0)
    goal = [np.eye(4), untwisted(motion, centre)]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
    figures = [
        (edge_error(vertices, posed, faces), closed_volume(posed, faces) / closed_volume(vertices, faces))
        for posed in (
            pose.solve(goal, warm_start=False).vertices,
            pose.solve(goal, by_itself=[1], warm_start=False).vertices,
        )
    ]
    if method != "arap":  # whose rotations do not come from the handles
        assert figures[0][0] > 0.13
        assert figures[0][1] < 0.67
    assert figures[1][0] <= 0.065
    assert figures[1][1] >= 0.96


@pytest.mark.parametrize("seed", range(4))
def test_the_error_over_the_angle_has_its_minimum_at_the_true_angle(seed):
    """Lengths of edges are not what is minimised: they judge."""
    vertices, faces, handles, motion, centre = a_bend(seed)
    true = vector(motion[:3, :3])
    for method in lissom.POSE_METHODS:
        pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
        goal = [np.eye(4), untwisted(motion, centre)]
        posed = pose.solve(goal, by_itself=[1], warm_start=False)
        found = vector(posed.transforms[1][:3, :3])
        as_given = pose.solve(goal, warm_start=False)
        if method == "arap":  # like a rod whose end is free to turn, which bends less there
            assert posed.report.energy < as_given.report.energy
            assert 0.6 < found @ true / (true @ true) < 1
            continue
        error = edge_error(vertices, posed.vertices, faces)
        if method != "laplacian_fitted":  # which swells where handles turn
            assert error < edge_error(vertices, as_given.vertices, faces)
        assert np.linalg.norm(found - true) < 0.05 * np.linalg.norm(true)
        for off in (0.5, 0.75, 1.25, 1.5):
            axis, angle = true / np.linalg.norm(true), off * np.linalg.norm(true)
            given = [np.eye(4), turned(goal[1], centre, rotation(axis, angle))]
            there = edge_error(vertices, pose.solve(given).vertices, faces)
            if method in ("rotation_invariant", "poisson", "multiresolution"):
                assert error < there
            else:  # their own errors, of details that do not turn, hardly depend on the angle
                assert error < 1.25 * there


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
@pytest.mark.parametrize("seed", range(3))
def test_a_rigid_motion_of_the_places_is_one_of_the_mesh(method, seed):
    rng = np.random.default_rng(seed)
    vertices, faces = tube(rows=30, columns=12)
    vertices, _ = placed(rng, vertices)
    x = np.arange(len(vertices)) // 12
    handles = [np.flatnonzero(x < 3), np.flatnonzero((x > 12) & (x < 16)), np.flatnonzero(x > 26)]
    motion = rigid(rng.normal(size=3), rng.uniform(0.3, 2.5), rng.normal(size=3))
    goal = [motion] + [untwisted(motion, vertices[handle].mean(axis=0)) for handle in handles[1:]]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
    posed = pose.solve(goal, by_itself=[1, 2], **TO_THE_END)
    if method not in ("laplacian", "laplacian_fitted", "laplacian_rotated", "thin_shell"):
        assert np.abs(posed.vertices - moved(motion, vertices)).max() < 1e-6 * diagonal(vertices)
    assert np.allclose(posed.transforms, [motion] * 3, rtol=0, atol=1e-5)
    assert np.array_equal(posed.transforms[0], motion)


class Dense:
    """The energy of turns, with a target for every triangle and a dense solve."""

    def __init__(self, vertices, faces, handles):
        n = len(vertices)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        tangent = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        weights = [((q - p) * (r - p)).sum(1) / tangent / 2 for p, q, r in ((a, b, c), (b, c, a), (c, a, b))]
        self.weights = np.concatenate(weights)
        self.ends = np.concatenate([faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]])
        self.triangle = np.tile(np.arange(len(faces)), 3)
        self.edges = np.zeros((len(self.ends), n))
        rows = np.arange(len(self.ends))
        self.edges[rows, self.ends[:, 0]], self.edges[rows, self.ends[:, 1]] = 1, -1
        self.laplacian = self.edges.T @ (self.weights[:, None] * self.edges)
        self.given = np.concatenate(handles)
        self.free = np.setdiff1d(np.arange(n), self.given)
        fields = np.zeros((n, len(handles)))
        for h, handle in enumerate(handles):
            fields[handle, h] = 1
        fields = self.extended(fields, np.zeros_like(fields))
        self.blend = fields[faces].mean(axis=1)
        self.vertices, self.handles = vertices, handles

    def extended(self, x, rhs):
        block = self.laplacian[np.ix_(self.free, self.free)]
        right = rhs[self.free] - self.laplacian[np.ix_(self.free, self.given)] @ x[self.given]
        x = x.copy()
        x[self.free] = np.linalg.solve(block, right)
        return x

    def energy(self, motions, vectors):
        """Of motions without turns, and rotation vectors (h, 3) about the handles' centres."""
        x = self.vertices.copy()
        for handle, motion, r in zip(self.handles, motions, vectors, strict=True):
            centre = self.vertices[handle].mean(axis=0)
            x[handle] = moved(turned(motion, centre, exponential(r)), self.vertices[handle])
        targets = np.array([exponential(r) for r in self.blend @ np.asarray(vectors)])
        asked = np.einsum("eij,ej->ei", targets[self.triangle], self.edges @ self.vertices)
        x = self.extended(x, self.edges.T @ (self.weights[:, None] * asked))
        return float((self.weights[:, None] * (self.edges @ x - asked) ** 2).sum())


def lowest(energy, start, rng, reach=1.5):
    """Brute force: the best of many random places, then of ever smaller steps."""
    best, value = start, energy(start)
    for _ in range(400):
        trial = start + rng.uniform(-reach, reach, start.shape)
        if (there := energy(trial)) < value:
            best, value = trial, there
    step = 0.3
    while step > 1e-5:
        trials = [
            best + sign * step * axis.reshape(best.shape) for axis in np.eye(best.size) for sign in (1, -1)
        ]
        values = [energy(trial) for trial in trials]
        if min(values) < value:
            best, value = trials[int(np.argmin(values))], min(values)
        else:
            step /= 2
    return best, value


@pytest.mark.parametrize("free", [[1], [1, 2], [0, 2]])
def test_no_rotation_is_better_than_the_one_found(free):
    """Below 48 triangles every one has a target of its own, and the energy is exact."""
    rng = np.random.default_rng(7)
    vertices, faces = prism(rows=6, columns=4, length=5)
    vertices += rng.normal(scale=0.03, size=vertices.shape)
    ring = np.arange(24) // 4
    handles = [
        np.append(np.flatnonzero(ring == 0), 24),
        np.flatnonzero(ring == 3),
        np.append(np.flatnonzero(ring == 5), 25),
    ]
    goal = [rigid(offset=offset) for offset in ((0, 0, 0), (-0.4, 0.7, 0.2), (-0.5, 1.5, 0.4))]
    dense = Dense(vertices, faces, handles)

    def energy(vectors):
        of_all = np.zeros((3, 3))
        of_all[free] = vectors
        return dense.energy(goal, of_all)

    best, value = lowest(energy, np.zeros((len(free), 3)), rng)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method="poisson")
    posed = pose.solve(goal, by_itself=free)
    found = np.array([vector(posed.transforms[h][:3, :3]) for h in free])
    assert energy(found) <= value * (1 + 1e-7)
    assert np.allclose(found, best, rtol=0, atol=1e-3)
    assert energy(found) < 0.7 * energy(np.zeros_like(found))


@pytest.mark.parametrize("seed", range(3))
def test_clusters_of_triangles_find_what_single_ones_do(seed):
    vertices, faces, handles, motion, centre = a_bend(seed)
    vertices, faces = vertices.copy(), faces
    goal = [np.eye(4), untwisted(motion, centre)]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method="poisson")
    found = vector(pose.solve(goal, by_itself=[1]).transforms[1][:3, :3])
    dense = Dense(vertices, faces, handles)
    energy = [dense.energy(goal, [np.zeros(3), found * stretch]) for stretch in (0.97, 1, 1.03, 0)]
    assert energy[1] < min(energy[0], energy[2])
    assert energy[1] < 0.5 * energy[3]


@pytest.mark.parametrize(
    "options", [{}, {"rotation_smoothing": 0.0}, {"smoothness": 0.1}, {"cells": "spokes"}]
)
@pytest.mark.parametrize("free", [[1], [1, 2]])
def test_arap_finds_the_minimum_over_shapes_and_turns(options, free):
    rng = np.random.default_rng(3)
    vertices, faces = prism(rows=30, columns=12, length=8, square=True)
    ring = np.arange(len(vertices) - 2) // 12
    handles = [np.flatnonzero(ring < 3), np.flatnonzero((ring > 13) & (ring < 17)), np.flatnonzero(ring > 26)]
    goal = [rigid(offset=offset) for offset in ((0, 0, 0), (-0.3, 1.2, 0.4), (-1.2, 2.6, 0.5))]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, **options)
    as_given = pose.solve(goal, **TO_THE_END).report
    posed = pose.solve(goal, by_itself=free, **TO_THE_END)
    assert posed.report.converged
    assert posed.report.energy < as_given.energy
    # The same shape, held where it turned to, stays; turned any other way it costs more.
    on = TO_THE_END | {"warm_start": True}
    again = pose.solve(posed.transforms, **on)
    assert np.isclose(again.report.energy, posed.report.energy, rtol=1e-6)
    for h in free:
        centre = vertices[handles[h]].mean(axis=0)
        for axis in (*np.eye(3), rng.normal(size=3)):
            for angle in (0.03, -0.03):
                other = posed.transforms.copy()
                other[h] = turned(other[h], centre, rotation(axis, angle))
                assert pose.solve(other, **on).report.energy > posed.report.energy


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_as_given_is_as_it_was(method):
    vertices, faces, handles, motion, centre = a_bend(0)
    goal = [np.eye(4), untwisted(motion, centre)]
    pose, other = (lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method) for _ in range(2))
    cold = {"warm_start": False}
    first = pose.solve(goal, **cold)
    by_itself = pose.solve(goal, by_itself=[1], **cold)
    assert np.array_equal(first.transforms, goal)
    for again in (pose.solve(goal, by_itself=[], **cold), other.solve(goal, **cold)):
        assert np.array_equal(again.vertices, first.vertices)
    assert np.abs(by_itself.vertices - first.vertices).max() > 0.01
    # What was found, given: the same mesh.
    given = pose.solve(by_itself.transforms, **cold).vertices
    off = np.abs(given - by_itself.vertices).max() / diagonal(vertices)
    assert off < (2e-3 if method == "arap" else 1e-12)
    assert np.array_equal(pose.solve(goal, by_itself=[1], **cold).vertices, by_itself.vertices)
    moved_to = moved(by_itself.transforms[1], vertices[handles[1]])
    assert np.allclose(by_itself.vertices[handles[1]], moved_to, rtol=0, atol=1e-14 * diagonal(vertices))
    assert np.allclose(moved_to.mean(axis=0), moved(goal[1], centre), rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", ["poisson", "arap"])
def test_a_drag_turns_a_handle_continuously(method):
    """Round to the other side and back again: no jump, and at the end as if it had never been away."""
    vertices, faces = prism(rows=40, columns=16, length=6)
    handles = ends(vertices)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
    centre = vertices[handles[1]].mean(axis=0)
    angles = np.concatenate(
        [np.linspace(0.05, 2, 40), np.linspace(1.95, -2, 80), np.linspace(-1.95, -0.4, 32)]
    )
    options = {"max_iterations": 1000, "tolerance": 1e-8}
    turns = []
    for angle in angles:
        goal = [np.eye(4), untwisted(bend(vertices, angle), centre)]
        turns.append(vector(pose.solve(goal, by_itself=[1], **options).transforms[1][:3, :3]))
    steps = np.linalg.norm(np.diff(turns, axis=0), axis=1)
    assert steps.max() < 3 * np.median(steps)
    assert np.abs(np.array(turns)[:, :2]).max() < 0.02, "about the axis of the bend alone"
    cold = pose.solve(goal, by_itself=[1], **TO_THE_END).transforms[1]
    assert np.linalg.norm(vector(cold[:3, :3]) - turns[-1]) < (0.02 if method == "arap" else 1e-6)


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_units_do_not_matter(method):
    vertices, faces, handles, motion, centre = a_bend(1)
    far, size = np.array([300.0, -200.0, 500.0]), 1e-3
    goal = untwisted(motion, centre)
    scaled = rigid(offset=goal[:3, 3] * size)
    found = [
        lissom.Pose(lissom.Mesh(v, faces), handles, method=method)
        .solve([np.eye(4), m], by_itself=[1], max_iterations=2000, tolerance=1e-10)
        .transforms[1][:3, :3]
        for v, m in ((vertices, goal), (far + size * vertices, scaled))
    ]
    assert np.abs(found[0] - found[1]).max() < 1e-4


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_soft_and_partial_handles_regions_and_volume(method):
    vertices, faces, handles, motion, centre = a_bend(2)
    goal = untwisted(motion, centre)
    mesh = lissom.Mesh(vertices, faces)
    part = np.clip(np.arange(len(handles[1]), 0, -1) / 20, 0.05, 1)
    for options, moving in (
        ({"constraints": "soft", "weight": 3.0}, [np.eye(4), goal]),
        ({"handle_weights": [None, part]}, [np.eye(4), goal]),
        ({"preserve_volume": True}, [np.eye(4), goal]),
        ({"roi": np.setdiff1d(np.arange(len(vertices)), handles[0])}, [goal]),
    ):
        pose = lissom.Pose(mesh, handles[-len(moving) :], method=method, **options)
        posed = pose.solve(moving, by_itself=[len(moving) - 1])
        rest = edge_error(vertices, pose.solve(moving, warm_start=False).vertices, faces)
        assert edge_error(vertices, posed.vertices, faces) < rest
        true, found = vector(motion[:3, :3]), vector(posed.transforms[-1][:3, :3])
        assert 0.4 < found @ true / (true @ true) < 1.1
        if "preserve_volume" in options:
            assert abs(volume(posed.vertices, faces) / volume(vertices, faces) - 1) < 1e-6


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_turns_that_nothing_tells_are_left_as_given(method):
    vertices, faces = prism(rows=20, columns=12)
    mesh = lissom.Mesh(vertices, faces)
    shift = rigid(offset=(0.3, 1.0, -0.2))
    last = len(vertices) - 1
    # A handle alone: nothing says how it should turn.
    alone = lissom.Pose(mesh, [ends(vertices)[1]], method=method).solve([shift], by_itself=[0])
    assert np.allclose(alone.transforms[0], shift, rtol=0, atol=1e-9)
    # A single vertex stays where it is asked to be, however it turns.
    for handles in ([ends(vertices)[0], [last]], [ends(vertices)[0], [last, last - 2]]):
        posed = lissom.Pose(mesh, handles, method=method).solve([np.eye(4), shift], by_itself=[1])
        centre = vertices[handles[1]].mean(axis=0)
        assert np.isfinite(posed.vertices).all()
        assert np.allclose(posed.vertices[handles[1]].mean(axis=0), moved(shift, centre), rtol=0, atol=1e-9)
    # At rest nothing turns.
    still = lissom.Pose(mesh, ends(vertices), method=method).solve([np.eye(4)] * 2, by_itself=[0, 1])
    assert np.abs(still.vertices - vertices).max() < 1e-9
    everything = lissom.Pose(mesh, [np.arange(len(vertices))], method=method)
    assert np.allclose(everything.solve([shift], by_itself=[0]).vertices, moved(shift, vertices))


@pytest.mark.parametrize(
    ("by_itself", "error", "text"),
    [
        ([2], lissom.InvalidConstraint, r"by_itself: number of a handle out of range, there are 2"),
        ([-1], lissom.InvalidConstraint, "by_itself"),
        ([1, 0, 1], lissom.InvalidConstraint, "by_itself: handle named twice \\(at 1"),
        ([0.5], TypeError, "by_itself"),
        ("all", TypeError, "by_itself"),
        ([[0, 1]], ValueError, "by_itself"),
    ],
)
def test_bad_handles(by_itself, error, text):
    vertices, faces = prism(rows=12, columns=8)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="poisson")
    goal = [np.eye(4), rigid(offset=(0, 1, 0))]
    before = pose.solve(goal, by_itself=[1])
    with pytest.raises(error, match=text):
        pose.solve(goal, by_itself=by_itself)
    after = pose.solve(goal, by_itself=[1])
    assert np.abs(after.vertices - before.vertices).max() < 1e-8
