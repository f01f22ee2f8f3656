"""What every method promises alike: exactness, repetition, and the bad inputs by their numbers."""

import lissom
import numpy as np
import pytest
from shapes import diagonal, ends, moved, rigid, tube

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


def test_results_repeat_to_the_last_bit(method):
    assert np.array_equal(bent(method), bent(method))


def test_handles_are_copied_exactly_and_all_outside_the_region_stays(method):
    roi = np.flatnonzero(VERTICES[:, 0] > 2.0)
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [HIGH], roi=roi, method=method)
    result = pose.solve([MOTION]).vertices
    outside = np.setdiff1d(np.arange(N), roi)
    assert np.array_equal(result[outside], VERTICES[outside])
    assert np.allclose(result[HIGH], moved(MOTION, VERTICES[HIGH]), rtol=0, atol=1e-14)


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


def test_row_07_slivers(method):
    flat = VERTICES.copy()
    flat[400] = 0.5 * (flat[401] + flat[399])
    flat[401] = flat[400]
    assert np.isfinite(bent(method, flat)).all()
    assert np.abs(bent(method, flat) - flat).max() < 10


@pytest.mark.parametrize(
    "faces",
    [
        np.concatenate([FACES, [[1, 1, 2]]]),
        np.concatenate([FACES, FACES[3:5]]),
        np.concatenate([FACES, [[FACES[500, 0], FACES[500, 1], FACES[900, 2]]]]),
        np.concatenate([FACES[:300, ::-1], FACES[300:]]),
    ],
    ids=["row 8: repeats a vertex", "row 10: duplicate", "row 13: three faces", "row 15: winding"],
)
def test_rows_08_10_13_15_odd_faces(method, faces):
    result = bent(method, faces=faces)
    assert np.isfinite(result).all()
    assert np.abs(result - VERTICES).max() < 10


def test_row_12_isolated_vertices_stay(method):
    result = bent(method, np.concatenate([VERTICES, [[9, 9, 9]]]))
    assert np.array_equal(result[N], [9, 9, 9])


def test_row_14_a_bow_tie(method):
    faces = np.concatenate([FACES, np.where(FACES == 0, N - 1, FACES + N)])
    assert np.isfinite(bent(method, np.concatenate([VERTICES, VERTICES + (10, 0, 0)]), faces)).all()


def test_row_18_self_intersection(method):
    folded = VERTICES * (0.01, 1, 1)
    assert np.isfinite(bent(method, folded)).all()


def test_row_20_every_vertex_in_a_handle(method):
    targets = np.random.default_rng(1).normal(size=(N, 3))
    result = lissom.Pose(lissom.Mesh(VERTICES, FACES), [np.arange(N)], method=method).solve_points(targets)
    assert np.array_equal(result.vertices, targets)


def test_row_21_a_component_without_handle(method):
    two = np.concatenate([VERTICES, VERTICES + 10])
    result = bent(method, two, np.concatenate([FACES, FACES + N]))
    assert np.array_equal(result[N:], VERTICES + 10)


def test_row_22_a_component_held_by_a_point(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [[7]], method=method)
    assert any("ambiguous" in w for w in pose.warnings)
    result = pose.solve([rigid(offset=(1, 2, 3))]).vertices
    assert np.abs(result - VERTICES - (1, 2, 3)).max() < 1e-5


def test_row_03_nothing_is_lost_after_an_error(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    with pytest.raises(lissom.InvalidConstraint):
        pose.solve([np.eye(4), np.full((4, 4), np.nan)])
    assert np.array_equal(pose.solve([np.eye(4), MOTION], **OPTIONS).vertices, bent(method))


def test_row_40_cancelled(method):
    pose = lissom.Pose(lissom.Mesh(VERTICES, FACES), [LOW, HIGH], method=method)
    job = pose.start([np.eye(4), MOTION], max_iterations=10**9, tolerance=0.0)
    job.cancel()
    with pytest.raises(lissom.Cancelled):
        job.result()
