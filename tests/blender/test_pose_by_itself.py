"""Handles whose Empties are only moved turn by themselves until they are rotated."""

import bpy
import lissom
import numpy as np
import scene
from bl_ext.user_default.lissom.bridge import meshes, poses
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
