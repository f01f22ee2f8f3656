"""A solve runs beside the window: what was done to the object meanwhile counts, not the solve."""

import time

import bpy
import pytest
import scene
from bl_ext.user_default.lissom import live, session
from bl_ext.user_default.lissom.jobs import bound
from numpy.testing import assert_allclose, assert_array_equal

PREVIEW = "Lissom Pose"


@pytest.fixture
def moved():
    """A bound tube, its handle moved up by 1, and the work that solves it."""
    obj = scene.bound_tube()
    with session.paused():
        scene.empty(obj, "top").location.z += 1
        bpy.context.view_layer.update()
    return obj, bound.following(obj, 1 / 60)


def ended(work):
    """Whether it wants more, once it is done."""
    while not work.poll():
        time.sleep(1e-3)
    return work.result


def test_it_is_shown_once_it_is_done(moved):
    obj, work = moved
    assert_array_equal(scene.key_points(obj, PREVIEW), scene.key_points(obj, "Basis"))
    while ended(work):
        assert scene.key_points(obj, PREVIEW)[-1, 2] > 3.9
        work = bound.following(obj, 1 / 60)
    assert_allclose(scene.key_points(obj, PREVIEW)[-1, 2], 4, atol=1e-4)


def test_what_moves_while_it_runs_is_solved_too(monkeypatch):
    monkeypatch.setattr(live, "PATIENCE", 0.0)
    obj, ran = scene.bound_tube(), 0
    with session.paused():
        for _ in range(10):
            scene.empty(obj, "top").location.z += 0.1
            bpy.context.view_layer.update()
            live._due.add(obj.session_uid)
            live._flush()
            ran += bool(live._running)
        while live._flush():
            time.sleep(1e-3)
    assert ran and not live._running
    assert_allclose(scene.key_points(obj, PREVIEW)[-1, 2], 4, atol=1e-4)


def test_a_reset_holds(moved):
    obj, work = moved
    bpy.ops.lissom.pose_reset(object=obj.name)
    rest = scene.key_points(obj, "Basis")
    assert ended(work)
    assert_array_equal(scene.key_points(obj, PREVIEW), rest)
    bound.follow(obj)
    assert_allclose(scene.key_points(obj, PREVIEW), rest, atol=1e-5)


def test_what_is_being_edited_is_not_touched_and_follows_later(moved):
    obj, work = moved
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    assert ended(work)
    assert_array_equal(scene.key_points(obj, PREVIEW), scene.key_points(obj, "Basis"))
    bpy.ops.object.mode_set(mode="OBJECT")
    bound.follow(obj)
    assert_allclose(scene.key_points(obj, PREVIEW)[-1, 2], 4, atol=1e-4)


def test_what_is_released_stays_so(moved):
    obj, work = moved
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert ended(work) and obj.data.shape_keys is None
    assert not ended(bound.following(obj))


def test_what_is_removed_is_forgotten(moved):
    obj, work = moved
    bpy.data.objects.remove(obj)
    assert not ended(work)
