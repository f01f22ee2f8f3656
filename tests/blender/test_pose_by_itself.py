"""Handles whose Empties are only moved turn by themselves until they are rotated."""

import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import live
from bl_ext.user_default.lissom.bridge import meshes, poses
from mathutils import Vector
from numpy.testing import assert_allclose


def native(obj, **options):
    rest = scene.key_points(obj, "Basis")
    handles = [np.flatnonzero(rest[:, 2] < -2.5), np.flatnonzero(rest[:, 2] > 2.5)]
    pose = lissom.Pose(lissom.Mesh(rest, meshes.triangles(obj.data)), handles)
    return pose.solve(poses.motion(obj).transforms, **options).vertices


def test_a_moved_handle_turns_until_its_empty_is_rotated():
    obj = scene.bound_tube(by_itself=True)
    top = scene.empty(obj, "top")
    assert poses.motion(obj).by_itself == ()
    top.location.x += 2
    bpy.context.view_layer.update()
    assert poses.motion(obj).by_itself == (1,), "the other one was not moved"
    assert_allclose(scene.shown(obj), native(obj, by_itself=[1]), atol=1e-3)
    assert np.abs(scene.shown(obj) - native(obj)).max() > 0.1
    assert_allclose(top.rotation_euler, (0, 0, 0))
    top.rotation_euler.y = 0.2
    bpy.context.view_layer.update()
    assert poses.motion(obj).by_itself == ()
    assert_allclose(scene.shown(obj), native(obj), atol=1e-3)


def test_the_choice_of_a_handle_is_followed_at_once():
    obj = scene.bound_tube(by_itself=True)
    scene.empty(obj, "top").location.x += 2
    bpy.context.view_layer.update()
    obj.lissom_pose.handles["top"].turns_by_itself = False
    bpy.context.view_layer.update()
    assert poses.motion(obj).by_itself == ()
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(scene.shown(obj), native(obj), atol=1e-3)


def shift(obj, draw):
    """Moves the top's Empty sideways without turning it, and lets the mesh follow."""
    scene.empty(obj, "top").location += Vector((*draw.uniform(1, 2, size=2), draw.uniform(-1, 0)))
    bpy.context.view_layer.update()


@pytest.mark.parametrize("reset", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_apply_keeps_the_turn_that_is_seen(seed, reset):
    draw = np.random.default_rng(seed)
    obj = scene.bound_tube(by_itself=True, rings=24, around=16)
    for name in ("one", "two"):  # the second one starts at rest, or from the first one's pose
        shift(obj, draw)
        expected, seen = native(obj, by_itself=[1]), scene.shown(obj)
        assert np.abs(expected - native(obj)).max() > 0.05
        bpy.ops.lissom.pose_apply(object=obj.name, name=name, value=0.0, reset=reset)
        bpy.context.view_layer.update()
        assert_allclose(scene.key_points(obj, name), expected, atol=2e-3)
        assert_allclose(scene.key_points(obj, name), seen, atol=4e-3)
        assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis" if reset else name), atol=1e-6)
        assert poses.motion(obj).by_itself == (() if reset else (1,))
        assert_allclose(scene.empty(obj, "top").rotation_euler, (0, 0, 0), atol=1e-6)


def past(obj, place, turn):
    """What undo leaves, which needs a window itself: Empty and mesh of another time, then its handler."""
    top = scene.empty(obj, "top")
    top.location, top.rotation_euler = place, turn
    key = obj.data.shape_keys.key_blocks["Lissom Pose"]
    key.data.foreach_set("co", scene.key_points(obj, "Basis").ravel())
    live._on_history()
    bpy.context.view_layer.update()
    obj.location.x += 1  # any update
    bpy.context.view_layer.update()


@pytest.mark.parametrize("seed", range(3))
def test_after_undo_a_handle_turns_by_itself_as_its_empty_did_then(seed):
    draw = np.random.default_rng(seed)
    obj = scene.bound_tube(by_itself=True, rings=24, around=16)
    top = scene.empty(obj, "top")
    shift(obj, draw)
    moved = top.location.copy()
    moved_shape = native(obj, by_itself=[1])
    top.rotation_euler.y = draw.uniform(0.2, 0.6)
    bpy.context.view_layer.update()
    turned, turned_shape = top.rotation_euler.copy(), native(obj)
    for turn, shape, by_itself in (((0, 0, 0), moved_shape, (1,)), (turned, turned_shape, ())) * 2:
        past(obj, moved, turn)
        assert poses.motion(obj).by_itself == by_itself
        assert_allclose(scene.key_points(obj, "Lissom Pose"), shape, atol=2e-3)
        assert_allclose(scene.empty(obj, "top").rotation_euler, turn, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_an_opened_file_turns_by_itself_as_it_was_saved(seed, tmp_path):
    draw = np.random.default_rng(seed)
    obj = scene.bound_tube(by_itself=True, rings=24, around=16)
    obj.lissom_pose.handles["bottom"].turns_by_itself = False
    shift(obj, draw)
    seen = scene.shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    obj = bpy.data.objects["Tube"]
    assert [handle.turns_by_itself for handle in obj.lissom_pose.handles] == [False, True]
    assert poses.motion(obj).by_itself == (1,)
    assert_allclose(scene.shown(obj), seen, atol=1e-6)
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(scene.shown(obj), seen, atol=2e-3)
    shift(obj, draw)
    expected = native(obj, by_itself=[1])
    assert_allclose(scene.shown(obj), expected, atol=2e-3)
    bpy.ops.lissom.pose_apply(object=obj.name, name="Opened", value=0.0)
    assert_allclose(scene.key_points(obj, "Opened"), expected, atol=2e-3)
