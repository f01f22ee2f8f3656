"""Jobs: progress, cancellation, signals, the interpreter released."""

import signal
import subprocess
import sys
import threading
import time

import lissom
import numpy as np
import pytest
from shapes import ends, rigid, tube

GOAL = [np.eye(4), rigid((0, 1, 0), 2.5, (0, 1, -2))]
ENDLESS = {"max_iterations": 10**9, "tolerance": 0.0}


@pytest.fixture(scope="module")
def pose():
    vertices, faces = tube(rows=400, columns=60)
    x = vertices[:, 0]
    mesh = lissom.Mesh(vertices, faces)
    return lissom.Pose(mesh, [np.flatnonzero(x < 0.3), np.flatnonzero(x > 5.7)])


def test_a_job_returns_what_the_call_returns(pose):
    options = {"max_iterations": 20, "tolerance": 0.0, "warm_start": False}
    job = pose.start(GOAL, **options)
    result = job.result()
    assert job.done
    assert job.result() is result
    assert np.array_equal(result.vertices, pose.solve(GOAL, **options).vertices)


def test_progress_grows(pose):
    job = pose.start(GOAL, max_iterations=60, tolerance=0.0)
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
        job = pose.start(GOAL, **ENDLESS)
        time.sleep(0.1)
        begin = time.perf_counter()
        job.cancel()
        with pytest.raises(lissom.Cancelled):
            job.result()
        taken.append(time.perf_counter() - begin)
    assert min(taken) < 0.2
    after = pose.solve(GOAL, max_iterations=5, warm_start=False)
    assert np.array_equal(before.vertices, after.vertices)


def test_row_40_ctrl_c_gets_through():
    script = """
import sys, time, numpy as np, lissom
sys.path.insert(0, sys.argv[1])
from shapes import rigid, tube
vertices, faces = tube(rows=400, columns=60)
x = vertices[:, 0]
pose = lissom.Pose(lissom.Mesh(vertices, faces), [np.flatnonzero(x < 0.3), np.flatnonzero(x > 5.7)])
print("ready", flush=True)
try:
    pose.solve([np.eye(4), rigid((0, 1, 0), 2.5)], max_iterations=10**9, tolerance=0.0)
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
    job = pose.start(GOAL, max_iterations=40, tolerance=0.0)
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


def test_a_dropped_job_stops(pose):
    """The pose is free again at once, which it would not be while a solve went on."""
    job = pose.start(GOAL, **ENDLESS)
    time.sleep(0.1)
    del job
    begin = time.perf_counter()
    pose.solve(GOAL, max_iterations=1)
    assert time.perf_counter() - begin < 5.0


def test_a_pose_bound_in_the_background():
    vertices, faces = tube(rows=40, columns=20)
    mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
    roi = np.flatnonzero(vertices[:, 0] > 1.0)
    options = {"handle_weights": [None, np.full(len(handles[1]), 0.5)], "cells": "spokes"}
    here = lissom.Pose(mesh, handles, roi, "arap", **options)
    job = lissom.start_pose(mesh, handles, roi, "arap", **options)
    there = job.result()
    assert isinstance(there, lissom.Pose)
    assert job.progress == (1.0, "ready")
    assert there.warnings == here.warnings != []
    assert np.array_equal(there.solve(GOAL).vertices, here.solve(GOAL).vertices)
    with pytest.raises(TypeError, match="'arap' has no option sells"):
        lissom.start_pose(mesh, handles, sells="spokes")
    with pytest.raises(lissom.InvalidConstraint, match="there is no handle"):
        lissom.start_pose(mesh, []).result()


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
