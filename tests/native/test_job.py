"""Jobs: progress, cancellation, signals, the interpreter released."""

import copy
import json
import signal
import subprocess
import sys
import threading
import time

import lissom
import numpy as np
import pytest
from shapes import ends, moved, rigid, tube

GOAL = [np.eye(4), rigid((0, 1, 0), 2.5, (0, 1, -2))]
ENDLESS = {"max_iterations": 10**9, "tolerance": 0.0}

VERTICES, FACES = tube(rows=24, columns=16)
MESH = lissom.Mesh(VERTICES, FACES)
SAME = np.column_stack([np.arange(len(FACES))] * 2)
MARKERS = [[0, 0], [7, 7], [200, 200], [370, 370], [380, 380]]
KEYS = np.stack([VERTICES + np.sin(VERTICES), VERTICES])
TURNED = moved(rigid((1, 1, 0), 2.0), VERTICES)
# Options of all kinds, that they arrive by both ways.
BINDING = {
    "handles": ends(VERTICES),
    "roi": np.flatnonzero(VERTICES[:, 0] > 0.2),
    "method": "arap",
    "handle_weights": [None, np.full(len(ends(VERTICES)[1]), 0.5)],
    "cells": "spokes",
}
SOLVING = {"max_iterations": 20, "tolerance": 0.0, "warm_start": False}


def bound():
    return lissom.Pose(MESH, **BINDING)


def prepared():
    return lissom.Transfer(MESH, MESH, SAME)


def by_fit():
    return lissom.Transfer(MESH, MESH, lissom.fit_correspondence(MESH, MESH, np.zeros((0, 2), int)))


def path():
    return lissom.Inbetween(MESH, VERTICES, TURNED)


# Every call that may take long: what it returns, and the job of it.
CALLS = {
    "Pose": (bound, lambda: lissom.start_pose(MESH, **BINDING)),
    "Pose.solve": (lambda: bound().solve(GOAL, **SOLVING), lambda: bound().start_solve(GOAL, **SOLVING)),
    "Mesh.linings": (MESH.linings, MESH.start_linings),
    "Mesh.limit_stretch": (
        lambda: MESH.limit_stretch(3 * KEYS, 1.5, [0, 5]),
        lambda: MESH.start_limit_stretch(3 * KEYS, 1.5, [0, 5]),
    ),
    "fit_correspondence": (
        lambda: lissom.fit_correspondence(MESH, MESH, MARKERS, steps=2, target_mask=[9]),
        lambda: lissom.start_fit(MESH, MESH, MARKERS, steps=2, target_mask=[9]),
    ),
    "Transfer": (
        lambda: lissom.Transfer(MESH, MESH, SAME[:-9], unmatched="rest"),
        lambda: lissom.start_transfer(MESH, MESH, SAME[:-9], unmatched="rest"),
    ),
    "Transfer.apply": (lambda: prepared().apply(KEYS), lambda: prepared().start_apply(KEYS)),
    "Transfer.quality": (
        lambda: prepared().quality(KEYS, KEYS[::-1]),
        lambda: prepared().start_quality(KEYS, KEYS[::-1]),
    ),
    "Transfer.attributes": (
        lambda: by_fit().attributes(VERTICES),
        lambda: by_fit().start_attributes(VERTICES),
    ),
    "Transfer.corner_attributes": (
        lambda: by_fit().corner_attributes(VERTICES[FACES]),
        lambda: by_fit().start_corner_attributes(VERTICES[FACES]),
    ),
    "Inbetween": (
        lambda: lissom.Inbetween(MESH, VERTICES, TURNED, "shortest", stretch="logarithmic"),
        lambda: lissom.start_inbetween(MESH, VERTICES, TURNED, "shortest", stretch="logarithmic"),
    ),
    "Inbetween.at": (lambda: path().at([0.3, 0.8]), lambda: path().start_at([0.3, 0.8])),
    "Inbetween.keyframes, tolerance": (
        lambda: path().keyframes(0.01),
        lambda: path().start_keyframes(0.01),
    ),
    "Inbetween.keyframes, count": (
        lambda: path().keyframes(count=4),
        lambda: path().start_keyframes(count=4),
    ),
}


def parts(result):
    """What a call found, as arrays, lists and numbers; of what it prepared, what that answers."""
    if isinstance(result, lissom.Pose):
        return [result.warnings, *parts(result.solve(GOAL, **SOLVING))]
    if isinstance(result, lissom.Transfer):
        return [result.warnings, *parts(result.apply(KEYS))]
    if isinstance(result, lissom.Inbetween):
        return [result.warnings, result.at([0.3, 0.8])]
    if isinstance(result, dict):
        return [result[name] for name in sorted(result) if "seconds" not in name]
    if isinstance(result, lissom.Fit):
        return [result.pairs, result.fitted_vertices, result.image_weights, *parts(result.report)]
    if hasattr(result, "report"):
        return [result.vertices, *parts(result.report)]
    return [getattr(result, "times", result)]


@pytest.mark.parametrize("name", CALLS)
def test_a_job_finds_what_the_call_finds(name):
    call, start = CALLS[name]
    job = start()
    result = job.result()
    assert job.done
    assert job.progress[0] == 1.0 or name not in ("Pose", "fit_correspondence")
    assert job.result() is result
    expected = call()
    assert type(result) is type(expected) or isinstance(result, lissom.Keyframes)
    found, expected = parts(result), parts(expected)
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


@pytest.fixture(scope="module")
def pose():
    vertices, faces = tube(rows=400, columns=60)
    x = vertices[:, 0]
    mesh = lissom.Mesh(vertices, faces)
    return lissom.Pose(mesh, [np.flatnonzero(x < 0.3), np.flatnonzero(x > 5.7)])


def test_progress_grows(pose):
    job = pose.start_solve(GOAL, max_iterations=60, tolerance=0.0)
    seen = []
    while not job.done:
        seen.append(job.progress)
        time.sleep(0.005)
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] > 0.1
    assert seen[-1][1] == "posing"


def test_row_40_cancel_within_a_fifth_of_a_second(pose):
    before = pose.solve(GOAL, max_iterations=5, warm_start=False)
    taken = []
    for _ in range(3):
        job = pose.start_solve(GOAL, **ENDLESS)
        time.sleep(0.1)
        begin = time.perf_counter()
        job.cancel()
        with pytest.raises(lissom.Cancelled):
            job.result()
        taken.append(time.perf_counter() - begin)
    assert max(taken) < 0.2
    after = pose.solve(GOAL, max_iterations=5, warm_start=False)
    assert np.array_equal(before.vertices, after.vertices)


def test_row_40_ctrl_c_gets_through():
    script = """
import signal, sys, numpy as np, lissom
sys.path.insert(0, sys.argv[1])
from shapes import rigid, tube
# A job in the background of a shell inherits that it ignores the signal, and Python leaves it at that.
signal.signal(signal.SIGINT, signal.default_int_handler)
vertices, faces = tube(rows=1200, columns=100)
x = vertices[:, 0]
pose = lissom.Pose(lissom.Mesh(vertices, faces), [np.flatnonzero(x < 0.3), np.flatnonzero(x > 5.7)])
print("ready", flush=True)
try:
    while True:  # it ends where rounding lets nothing fall any further
        goal = [np.eye(4), rigid((0, 1, 0), 2.5)]
        pose.solve(goal, max_iterations=10**9, tolerance=0.0, warm_start=False)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    here = __file__.rsplit("/", 1)[0]
    child = subprocess.Popen([sys.executable, "-c", script, here], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    begin = time.perf_counter()
    assert child.stdout.readline() == "interrupted\n"
    assert time.perf_counter() - begin < 1.0
    assert child.wait(10) == 0


def test_the_interpreter_is_released(pose):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    pose.solve(GOAL, max_iterations=60, tolerance=0.0, warm_start=False)
    stop.set()
    thread.join()
    assert len(ticks) > 10


def test_two_threads_may_wait_for_one_job(pose):
    job = pose.start_solve(GOAL, max_iterations=40, tolerance=0.0)
    found = []
    threads = [threading.Thread(target=lambda: found.append(job.result())) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert len(found) == 2
    assert found[0] is found[1]


def test_a_forked_process_can_work():
    """Threads of the parent do not survive a fork, so a child that waited for them would hang."""
    script = """
import multiprocessing, sys, numpy as np, lissom
sys.path.insert(0, sys.argv[1])
from shapes import ends, rigid, tube
vertices, faces = tube()
pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices))
def work(angle):
    return pose.solve([np.eye(4), rigid((0, 0, 1), angle)], warm_start=False).vertices.sum()
expected = work(0.5)
with multiprocessing.get_context("fork").Pool(2) as pool:
    assert pool.map(work, [0.5, 0.5, 0.5]) == [expected] * 3
"""
    here = __file__.rsplit("/", 1)[0]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script, here], timeout=60, capture_output=True
    )
    assert done.returncode == 0, done.stderr.decode()


def test_a_forked_process_does_not_wait_for_what_its_parent_does():
    """A job, and a pose that a job is busy with; poses and jobs that were done are of use in both."""
    script = """
import os, sys, time, numpy as np, lissom
sys.path.insert(0, sys.argv[1])
from shapes import ends, rigid, tube
vertices, faces = tube(rows=400, columns=60)
busy, idle = (lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices)) for _ in range(2))
goal = [np.eye(4), rigid((0, 0, 1), 0.5)]
done = idle.start_solve(goal)
done.result()
job = busy.start_solve(goal, max_iterations=10**9, tolerance=0.0)
time.sleep(0.02)
assert not job.done
child = os.fork()
if child == 0:
    failed = 0
    for use in (job.result, lambda: job.done, lambda: busy.solve(goal), lambda: busy.solve(goal)):
        try:
            use()
        except lissom.SolveFailed as error:
            failed += "forked" in str(error)
    same = (done.result().vertices == idle.solve(goal, max_iterations=0).vertices).all()
    os._exit(0 if failed == 4 and same else 1)
ended = os.waitpid(child, 0)[1]
job.cancel()
sys.exit(ended != 0)
"""
    here = __file__.rsplit("/", 1)[0]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script, here], timeout=60, capture_output=True
    )
    assert done.returncode == 0, done.stderr.decode()


def test_a_dropped_job_stops(pose):
    """The pose is free again at once, which it would not be while a solve went on."""
    job = pose.start_solve(GOAL, **ENDLESS)
    time.sleep(0.1)
    del job
    begin = time.perf_counter()
    pose.solve(GOAL, max_iterations=1)
    assert time.perf_counter() - begin < 5.0


def test_what_a_job_cannot_do_is_told_when_it_starts_or_by_its_result():
    """Other names and types at once, as by the call; what only the work finds out by the result."""
    with pytest.raises(TypeError, match="'arap' has no option sells"):
        lissom.start_pose(MESH, ends(VERTICES), sells="spokes")
    with pytest.raises(lissom.InvalidValue, match="rotation: 'widest' is none of"):
        lissom.start_inbetween(MESH, VERTICES, TURNED, rotation="widest")
    with pytest.raises(lissom.InvalidValue, match="stretch: 'cubic' is none of linear, logarithmic"):
        lissom.start_inbetween(MESH, VERTICES, TURNED, stretch="cubic")
    job = lissom.start_pose(MESH, [])
    with pytest.raises(lissom.InvalidConstraint, match="there is no handle"):
        job.result()


def test_warnings_of_a_job_come_with_its_result():
    few = path().start_keyframes(1e-9, 3).result()
    assert len(few.times) == 3 and "3 keys" in few.warnings[0]


def test_row_40_a_binding_is_left_behind_when_cancelled():
    """A factorization cannot stop, but nobody waits for it."""
    vertices, faces = tube(rows=250, columns=100)
    job = lissom.start_pose(lissom.Mesh(vertices, faces), ends(vertices), method="laplacian_fitted")
    while job.progress[1] != "factorization":
        assert not job.done
    begin = time.perf_counter()
    job.cancel()
    with pytest.raises(lissom.Cancelled):
        job.result()
    assert time.perf_counter() - begin < 0.2


def test_counts_are_checked(pose):
    with pytest.raises(lissom.InvalidValue, match="max_iterations: must not be negative, got -1"):
        pose.solve(GOAL, max_iterations=-1)


def test_errors_have_their_names():
    assert lissom.Error.__name__ == "Error"
    assert issubclass(lissom.InvalidValue, (lissom.Error, ValueError))


def test_reports_are_dicts_with_fields(pose):
    report = pose.solve(GOAL, max_iterations=2).report
    assert isinstance(report, lissom.PoseReport) and json.loads(json.dumps(report)) == report
    assert report["iterations"] == report.iterations == 2
    assert list(report) == ["iterations", "energy", "converged", "seconds", "warnings"]
    assert {**report} == report == copy.copy(report)
    with pytest.raises(AttributeError):
        report.energy = 0.0


def test_a_cancelled_solve_leaves_the_last_pose_to_go_on_from(pose):
    one = {"max_iterations": 1, "tolerance": 0.0}
    pose.solve(GOAL, max_iterations=30, warm_start=False)
    expected = pose.solve(GOAL, **one).vertices
    pose.solve(GOAL, max_iterations=30, warm_start=False)
    job = pose.start_solve([np.eye(4), rigid((0, 0, 1), 1.0)], **ENDLESS)
    time.sleep(0.1)
    job.cancel()
    with pytest.raises(lissom.Cancelled):
        job.result()
    assert np.array_equal(pose.solve(GOAL, **one).vertices, expected)


def test_what_fails_or_is_cancelled_at_any_time_forgets_no_turn():
    """A handle turned once round stays so: the next solve goes on from the last one that gave a result."""
    pose = bound()
    once = rigid((1, 0, 0), 0.3)
    pose.solve([np.eye(4), once], turns=[[0, 0, 0], [2 * np.pi, 0, 0]])
    rng = np.random.default_rng(7)
    for _ in range(12):
        expected = pose.solve([np.eye(4), once], max_iterations=0).vertices
        far = rigid(rng.normal(size=3), 3.0)
        with pytest.raises(lissom.SolveFailed):
            pose.solve([np.eye(4), far * [[1e308], [1e308], [1e308], [1]]])
        job = pose.start_solve([np.eye(4), far], max_iterations=10)
        time.sleep(rng.uniform(0, 0.01))
        job.cancel()
        try:
            expected = job.result().vertices
        except lissom.Cancelled:
            found = pose.solve([np.eye(4), once], max_iterations=0).vertices
        else:
            found = pose.solve([np.eye(4), far], max_iterations=0).vertices
        assert np.abs(found - expected).max() < 1e-9
        pose.solve([np.eye(4), once], turns=[[0, 0, 0], [2 * np.pi, 0, 0]], warm_start=False)
