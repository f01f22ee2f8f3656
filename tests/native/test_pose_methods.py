"""What every method promises alike: exactness, repetition, and the bad inputs by their numbers."""

import resource

import lissom
import numpy as np
import pytest
from figures import volume
from shapes import diagonal, ends, grid_faces, moved, prism, rigid, tube

VERTICES, FACES = tube(rows=40, columns=20)
N = len(VERTICES)
LOW, HIGH = ends(VERTICES)
MOTION = rigid((0, 0, 1), 0.6, (0, 0.5, 0))
OPTIONS = {"max_iterations": 2000, "tolerance": 1e-10, "warm_start": False}

pytestmark = pytest.mark.parametrize("method", lissom.POSE_METHODS)


def bent(method, vertices=VERTICES, faces=FACES, motion=MOTION, **options):
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [LOW, HIGH], method=method, **options)
    return pose.solve([np.eye(4), motion], **OPTIONS).vertices


def test_a_translation_is_reproduced(method):
    vertices, faces = tube()
    shift = rigid(offset=(1, -2, 3))
    result = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method=method).solve([shift] * 2)
    assert np.abs(result.vertices - moved(shift, vertices)).max() < 1e-8 * diagonal(vertices)


def test_the_rest_pose_stays(method):
    assert np.abs(bent(method, motion=np.eye(4)) - VERTICES).max() < 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_volume_is_kept_away_from_the_handles(method, seed):
    rng = np.random.default_rng(seed)
    vertices, faces = prism(rows=40, columns=16, square=seed == 0)
    handles, mesh = ends(vertices), lissom.Mesh(vertices, faces)
    goal = [np.eye(4), rigid(rng.normal(size=3), rng.uniform(0.3, 1.2), rng.uniform(-0.5, 0.5, 3))]
    poses = [lissom.Pose(mesh, handles, method=method, preserve_volume=keeps) for keeps in (False, True)]
    free, kept = (pose.solve(goal).vertices for pose in poses)
    assert abs(volume(free, faces) / volume(vertices, faces) - 1) > 1e-4
    assert abs(volume(kept, faces) / volume(vertices, faces) - 1) < 1e-6
    given = np.concatenate(handles)
    assert np.array_equal(kept[given], free[given])
    correction = np.linalg.norm(kept - free, axis=1)
    beside = np.setdiff1d(faces[np.isin(faces, given).any(1)], given)
    assert correction[beside].max() < 0.1 * correction.max()
    still = [pose.solve([np.eye(4)] * 2, warm_start=False).vertices for pose in poses]
    assert np.abs(still[1] - still[0]).max() < 1e-9
    follow = lissom.Pose(
        mesh, handles[1:], method=method, preserve_volume=True, roi=np.flatnonzero(vertices[:, 0] > 2)
    )
    outside = follow.solve(goal[1:]).vertices[vertices[:, 0] <= 2]
    assert np.array_equal(outside, vertices[vertices[:, 0] <= 2])


def test_an_open_sheet_has_no_volume_to_keep(method):
    vertices = np.array([(x, y, 0.1 * x * y) for x in range(6) for y in range(6)], float)
    faces = grid_faces(6, 6)
    pose = lissom.Pose(
        lissom.Mesh(vertices, faces), [[0, 1, 6], [34, 35, 29]], method=method, preserve_volume=True
    )
    assert any("preserve_volume: open components" in warning for warning in pose.warnings)
    assert np.isfinite(pose.solve([np.eye(4), MOTION]).vertices).all()


def test_results_repeat_to_the_last_bit(method):
    assert np.array_equal(bent(method), bent(method))


@pytest.mark.parametrize("seed", range(3))
def test_results_do_not_depend_on_how_the_mesh_lies(method, seed):
    """With every choice, and with the numbers that have a length in them."""
    random = np.random.default_rng(seed)
    vertices = VERTICES * random.uniform(0.5, 2, 3) + random.normal(size=VERTICES.shape) * 0.01
    motion = rigid(random.normal(size=3), 1.2, random.normal(size=3))
    turn = rigid(random.normal(size=3), random.uniform(0, np.pi), random.normal(size=3))
    back = np.linalg.inv(turn)
    varied = [{}, {"constraints": "soft", "weight": 3.0}]
    for option in lissom.options():
        if option.owner == f"pose.{method}":
            varied += [{option.name: choice} for choice, _ in option.choices]
            varied += [{option.name: 0.5 * option.default}] if option.kind == "float" else []
    for options in varied:
        straight = bent(method, vertices, motion=motion, **options)
        turned = bent(method, moved(turn, vertices), motion=turn @ motion @ back, **options)
        assert np.abs(moved(back, turned) - straight).max() < 1e-9 * diagonal(vertices), options


def test_handles_are_copied_exactly_and_all_outside_the_region_stays(method):
    roi = np.flatnonzero(VERTICES[:, 0] > 2.0)
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [HIGH], roi=roi, method=method)
    result = pose.solve([MOTION]).vertices
    outside = np.setdiff1d(np.arange(N), roi)
    assert np.array_equal(result[outside], VERTICES[outside])
    assert np.allclose(result[HIGH], moved(MOTION, VERTICES[HIGH]), rtol=0, atol=1e-14)
    between = np.setdiff1d(roi, HIGH)
    assert np.abs(result[between] - VERTICES[between]).max() > 0.5


def test_moving_as_wholes_and_by_points_agree(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    by_points = pose.solve_points(np.concatenate([VERTICES[LOW], moved(MOTION, VERTICES[HIGH])]), **OPTIONS)
    assert np.abs(by_points.vertices - bent(method)).max() < 1e-5 * diagonal(VERTICES)


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0), (1e20, 0), (1.0, 1e6)])
def test_row_04_and_05_huge_and_tiny_coordinates(method, scale, offset):
    shift = np.eye(4)
    shift[:3, 3] = offset
    motion = MOTION.copy()
    motion[:3, 3] *= scale
    result = bent(method, VERTICES * scale + offset, motion=shift @ motion @ np.linalg.inv(shift))
    # An offset of 1e6 leaves 1e-10 of each coordinate to the rounding of the input, which the
    # fourth-order energies raise by the square of the number of vertices across.
    assert np.abs((result - offset) / scale - bent(method)).max() < 1e-3 * diagonal(VERTICES)


def assert_carried(method, vertices, faces):
    """Where all handles move alike, so does everything between them."""
    shift = rigid(offset=(1, -2, 3))
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [LOW, HIGH], method=method)
    result = pose.solve([shift] * 2).vertices
    assert np.abs(result - moved(shift, vertices)).max() < 1e-8 * diagonal(vertices)


def test_row_07_slivers(method):
    flat = VERTICES.copy()
    flat[400] = 0.5 * (flat[401] + flat[399])
    flat[401] = flat[400]
    assert_carried(method, flat, FACES)
    # The two that were moved by a step of the grid are a step off, and no more.
    assert np.abs(bent(method, flat) - bent(method)).max() < 0.06 * diagonal(VERTICES)


@pytest.mark.parametrize(
    ("faces", "change"),
    [
        (np.concatenate([FACES, [[1, 1, 2]]]), 0),
        (np.concatenate([FACES, FACES[500:502]]), 0.02),
        (np.concatenate([FACES, [[FACES[500, 0], FACES[500, 1], FACES[900, 2]]]]), 0.02),
        (np.concatenate([FACES[:300, ::-1], FACES[300:]]), 1e-9),
    ],
    ids=["row 8: repeats a vertex", "row 10: duplicate", "row 13: three faces", "row 15: winding"],
)
def test_rows_08_10_13_15_odd_faces(method, faces, change):
    assert_carried(method, VERTICES, faces)
    assert np.abs(bent(method, faces=faces) - bent(method)).max() <= change * diagonal(VERTICES)


def unwelded():
    """The tube with three vertices of its own for each face, in the order of the faces."""
    return VERTICES[FACES].reshape(-1, 3), np.arange(3 * len(FACES)).reshape(-1, 3)


def test_row_11_a_soup_of_triangles_is_welded(method):
    vertices, faces = unwelded()
    corners = FACES.ravel()
    mesh = lissom.Mesh(vertices, faces, weld=0.0)
    assert any("welded to another in the same place (at 3, " in w for w in mesh.warnings)
    handles = [np.flatnonzero(np.isin(corners, h)) for h in (LOW, HIGH)]
    roi = np.flatnonzero(VERTICES[corners, 0] < 5.8)
    pose = lissom.Pose(mesh, handles, roi=roi, method=method)
    result = pose.solve([np.eye(4), MOTION], **OPTIONS)
    joined = lissom.Pose(
        lissom.Mesh(VERTICES, FACES), [LOW, HIGH], roi=np.flatnonzero(VERTICES[:, 0] < 5.8), method=method
    )
    expected = joined.solve([np.eye(4), MOTION], **OPTIONS).vertices[corners]
    assert np.abs(result.vertices - expected).max() < 1e-6 * diagonal(VERTICES)
    first = {tuple(v): i for i, v in reversed(list(enumerate(vertices)))}
    together = [first[tuple(v)] for v in vertices]
    assert np.array_equal(result.vertices, result.vertices[together]), "seams stay closed to the last bit"
    targets = np.concatenate([vertices[handles[0]], moved(MOTION, vertices[handles[1]])])
    by_points = pose.solve_points(targets, **OPTIONS).vertices
    assert np.abs(by_points - expected).max() < 1e-5 * diagonal(VERTICES)


def test_row_11_without_weld_a_soup_is_told(method):
    vertices, faces = unwelded()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [np.arange(30)], method=method)
    message = "vertices: in the same place as another and not joined to it; weld= joins them (at 3, "
    assert any(w.startswith(message) for w in pose.warnings)
    result = pose.solve([MOTION]).vertices
    assert np.allclose(result[:30], moved(MOTION, vertices[:30]), rtol=0, atol=1e-14)
    assert np.abs(result - moved(MOTION, vertices)).max() < 1e-9 * diagonal(vertices)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [np.arange(30)], method=method, unheld="rest")
    assert np.array_equal(pose.solve([MOTION]).vertices[30:], vertices[30:])


def test_row_12_isolated_vertices_follow_or_stay(method):
    alone = np.concatenate([VERTICES, [[9, 9, 9]]])
    assert np.abs(bent(method, alone)[N] - 9).max() > 0.1
    result = bent(method, alone, unheld="rest")
    assert np.array_equal(result[N], [9, 9, 9])
    assert np.abs(result[:N] - bent(method)).max() < 1e-3


def test_row_14_a_bow_tie(method):
    """A second tube that hangs at one vertex does not hold the first."""
    vertices = np.concatenate([VERTICES, VERTICES[1:] + (10, 0, 0)])
    faces = np.concatenate([FACES, FACES + N - 1])
    # Its length would be another part of the new diagonal.
    options = {"estimate": 0.0} if method == "laplacian_rotated" else {}
    result = bent(method, vertices, faces, **options)
    assert np.abs(result[:N] - bent(method, **options)).max() < 5e-3 * diagonal(VERTICES)
    if method != "laplacian_fitted":  # to which the second is as good turned and scaled about the vertex
        assert_carried(method, vertices, faces)
    assert np.abs(result).max() < 3 * diagonal(vertices)


def test_row_18_self_intersection(method):
    folded = VERTICES * (0.01, 1, 1)
    assert_carried(method, folded, FACES)
    assert np.abs(bent(method, folded) - folded).max() < 0.5 * diagonal(folded)


def test_row_20_every_vertex_in_a_handle(method):
    targets = np.random.default_rng(1).normal(size=(N, 3))
    result = lissom.Pose(lissom.Mesh(VERTICES, FACES), [np.arange(N)], method=method).solve_points(targets)
    assert np.array_equal(result.vertices, targets)


def test_row_21_a_component_without_handle(method):
    two = np.concatenate([VERTICES, VERTICES + 10])
    faces = np.concatenate([FACES, FACES + N])
    assert np.array_equal(bent(method, two, faces, unheld="rest")[N:], VERTICES + 10)
    followed = bent(method, two, faces)[N:]
    lengths = [np.linalg.norm(x[FACES[:, 0]] - x[FACES[:, 1]], axis=1) for x in (followed, VERTICES)]
    assert np.abs(lengths[0] - lengths[1]).max() < 1e-9
    assert np.abs(followed - VERTICES - 10).max() > 0.1


def test_row_22_a_component_held_by_a_point(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [[7]], method=method)
    assert any("ambiguous" in w for w in pose.warnings)
    result = pose.solve([rigid(offset=(1, 2, 3))]).vertices
    assert np.abs(result - VERTICES - (1, 2, 3)).max() < 1e-5


def test_row_23_a_vertex_in_two_handles(method):
    with pytest.raises(lissom.InvalidConstraint, match=r"first in 0 and 1 \(at 3, 4; 2 in all\)"):
        lissom.Pose(lissom.Mesh(VERTICES, FACES), [[3, 4, 5], [3, 4]], method=method)


def test_row_23_targets_that_contradict(method):
    seam = np.concatenate([VERTICES, VERTICES[:1]])
    pose = lissom.Pose(
        lissom.Mesh(seam, np.concatenate([FACES[1:], [[N, *FACES[0, 1:]]]]), weld=0.0),
        [[0, 5, N], HIGH],
        method=method,
    )
    targets = seam[[0, 5, N, *HIGH]]
    assert np.abs(pose.solve_points(targets).vertices - seam).max() < 1e-9
    targets[2] += (0, 0, 0.1)
    with pytest.raises(lissom.InvalidConstraint, match=r"targets: .* go apart \(at 2; 1 in all\)"):
        pose.solve_points(targets)


def test_row_24_a_handle_outside_the_region_and_an_empty_region(method):
    mesh = lissom.Mesh(VERTICES, FACES)
    with pytest.raises(lissom.InvalidConstraint, match="roi: the region of interest is empty"):
        lissom.Pose(mesh, [LOW], roi=[], method=method)
    pose = lissom.Pose(mesh, [LOW, HIGH], roi=np.setdiff1d(np.arange(N), HIGH), method=method)
    assert any("outside the region" in w and f"{len(HIGH)} in all" in w for w in pose.warnings)
    result = pose.solve([np.eye(4), MOTION], **OPTIONS).vertices
    assert np.allclose(result[HIGH], moved(MOTION, VERTICES[HIGH]), rtol=0, atol=1e-12)


def test_row_38_a_system_that_is_singular_to_rounding_is_told(method):
    options = {"method": method, "constraints": "soft", "weight": 1e-9}
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], **options)
    result = pose.solve([np.eye(4), MOTION])
    assert np.isfinite(result.vertices).all()
    assert np.abs(result.vertices - VERTICES).max() < diagonal(VERTICES)
    assert any("singular to rounding" in w for w in pose.warnings)
    assert any("singular to rounding" in w for w in result.report["warnings"])
    sound = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], **(options | {"weight": 1.0}))
    assert sound.warnings == []


def test_row_38_an_iteration_that_does_not_converge_tells_its_residual(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    report = pose.solve([np.eye(4), MOTION], max_iterations=1, tolerance=1e-12).report
    told = [w for w in report["warnings"] if "not converged after 1 iterations" in w]
    assert report["converged"] == (method != "arap")
    assert len(told) == (method == "arap")
    for line in told:
        residual = float(line.split("lowered the energy by ")[1].split()[0])
        assert 1e-12 < residual < 10


def test_row_39_more_memory_than_there_is(method, monkeypatch):
    mesh = lissom.Mesh(VERTICES, FACES)
    pose = lissom.Pose(mesh, [LOW, HIGH], method=method)
    needed = pose.info["factor_nonzeros"] // 3 * 8
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e4")
    with pytest.raises(
        lissom.OutOfMemory, match=r"the (factor|matrix) would take .*, there are 10000 bytes"
    ) as caught:
        lissom.Pose(mesh, [LOW, HIGH], method=method)
    assert isinstance(caught.value, MemoryError) and isinstance(caught.value, lissom.Error)
    assert caught.value.available == 10_000
    assert needed <= caught.value.needed < 100 * needed
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "2e9")
    again = lissom.Pose(mesh, [LOW, HIGH], method=method)
    answers = [p.solve([np.eye(4), MOTION], **OPTIONS).vertices for p in (pose, again)]
    assert np.array_equal(*answers)


@pytest.mark.parametrize("degree", [6000, 9000])
def test_row_39_a_vertex_of_high_degree_is_refused_by_counting(method, degree, monkeypatch):
    """Second differences at a vertex of so many triangles make a full matrix, which is not formed first."""
    angle = np.linspace(0, 2 * np.pi, degree, endpoint=False)
    around = [np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle]) for r in (1.0, 1.1)]
    i = np.arange(degree)
    j = (i + 1) % degree
    triangles = [
        [0 * i, 1 + i, 1 + j],
        [1 + i, 1 + degree + i, 1 + j],
        [1 + j, 1 + degree + i, 1 + degree + j],
    ]
    faces = np.concatenate([np.column_stack(t) for t in triangles])
    mesh = lissom.Mesh(np.concatenate([[[0, 0, 0.5]], *around]), faces)
    handles = [np.arange(1 + degree, 1 + 2 * degree), [0]]
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e8")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        pose = lissom.Pose(mesh, handles, method=method)
    except lissom.OutOfMemory as error:
        assert error.needed > 1e8
    else:
        assert pose.info["factor_bytes"] < 1e8
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2e5


def test_what_binding_made(method):
    """A factor of n unknowns has n values on its diagonal, and one for each edge of the mesh at least."""
    info = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method).info
    free = N - len(LOW) - len(HIGH)
    systems = {"laplacian_fitted": 3, "laplacian_rotated": 2, "multiresolution": 2}.get(method, 1)
    rotations = 760 if method == "arap" else 0  # of the vertices beside free ones, too
    assert info["unknowns"] == systems * free + rotations
    assert info["factor_nonzeros"] > 3 * info["unknowns"]
    assert 8 * info["factor_nonzeros"] < info["factor_bytes"] < 13 * info["factor_nonzeros"]
    assert 0 < info["bind_seconds"] < 60


def test_row_03_nothing_is_lost_after_an_error(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    with pytest.raises(lissom.InvalidConstraint):
        pose.solve([np.eye(4), np.full((4, 4), np.nan)])
    assert np.array_equal(pose.solve([np.eye(4), MOTION], **OPTIONS).vertices, bent(method))


def test_row_40_cancelled(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    job = pose.start_solve([np.eye(4), MOTION], max_iterations=10**9, tolerance=0.0)
    job.cancel()
    with pytest.raises(lissom.Cancelled):
        job.result()
