"""What stays where one handle is all that holds a mesh: the first try, one handle and G."""

import bpy
import numpy as np
import pytest
import scene
from mathutils import Matrix
from numpy.testing import assert_allclose, assert_array_equal


def held_by_one(obj, where, **options):
    members = scene.group(obj, "only", where)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="only")
    bpy.ops.lissom.pose_bind(object=obj.name, **options)
    return members


def lift(obj, offset=(0, 0, 0.4)):
    handle = scene.empty(obj, "only")
    handle.matrix_world = Matrix.Translation(offset) @ handle.matrix_world
    bpy.context.view_layer.update()
    return scene.shown(obj) - scene.key_points(obj, "Basis")


def test_the_head_does_not_fly_off_with_the_ear():
    obj = scene.monkey()
    ear = held_by_one(obj, lambda co: co.x > 1.2)
    assert 0 < obj.lissom_pose.reach < 2
    moved = lift(obj)
    rest = scene.key_points(obj, "Basis")
    # It is only moved, so it turns by itself about its centre.
    assert_allclose(moved[ear].mean(axis=0), [0, 0, 0.4], atol=1e-6)
    arms = [x[ear] - x[ear].mean(axis=0) for x in (rest + moved, rest)]
    assert_allclose(*(np.linalg.norm(x, axis=1) for x in arms), atol=1e-6)
    assert_array_equal(moved[rest[:, 0] < 0], 0)
    assert np.isfinite(moved).all()
    between = np.abs(moved).max(axis=1)
    assert ((between > 0.05) & (between < 0.35)).sum() > 20, "the ear's root bends"


def test_how_far_is_far_may_change_while_bound():
    obj = scene.tube()
    held_by_one(obj, lambda co: co.z > 2.9)
    free = []
    for reach in (1.0, 3.0):
        obj.lissom_pose.reach = reach
        bpy.ops.lissom.pose_reset(object=obj.name)
        moved = lift(obj, (0.5, 0, 0))
        bpy.ops.lissom.pose_update(object=obj.name)
        moved = scene.shown(obj) - scene.key_points(obj, "Basis")
        free.append(scene.key_points(obj, "Basis")[np.abs(moved).max(axis=1) > 0, 2].min())
    assert 1.7 < free[0] < 2.2
    assert -0.3 < free[1] < 0.2


def test_nothing_stays_where_that_is_asked_or_where_a_region_says_it():
    obj = scene.tube()
    held_by_one(obj, lambda co: co.z > 2.9, stays="NOTHING")
    assert_allclose(lift(obj), [[0, 0, 0.4]] * len(obj.data.vertices), atol=2e-5)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    scene.group(obj, "region", lambda co: co.z > 1)
    obj.lissom_pose.roi = "region"
    bpy.ops.lissom.pose_bind(object=obj.name)
    moved, rest = lift(obj), scene.key_points(obj, "Basis")
    assert_array_equal(moved[rest[:, 2] <= 1], 0)
    assert (np.abs(moved[rest[:, 2] > 1.15]).max(axis=1) > 0).all()


def test_open_borders_stay_and_a_closed_mesh_has_none():
    obj = scene.tube()
    held_by_one(obj, lambda co: abs(co.z) < 0.05, stays="BORDER")
    moved, rest = lift(obj, (0.5, 0, 0)), scene.key_points(obj, "Basis")
    rims = np.abs(rest[:, 2]) > 2.99
    assert_array_equal(moved[rims], 0)
    assert (np.abs(moved[~rims]).max(axis=1) > 0).all()
    bpy.ops.mesh.primitive_uv_sphere_add()
    ball = bpy.context.object
    with pytest.raises(RuntimeError, match="no open border"):
        held_by_one(ball, lambda co: co.z > 0.9, stays="BORDER")
    assert not ball.lissom_pose.bound


def test_two_handles_hold_as_before():
    obj = scene.bound_tube()
    assert obj.lissom_pose.reach == 0


def test_loose_parts_follow_and_rest_by_option():
    obj = scene.monkey()
    for name, where in (("low", lambda co: co.z < -0.8), ("high", lambda co: co.z > 0.8)):
        scene.group(obj, name, where)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name)
    for handle in obj.lissom_pose.handles:
        handle.empty.matrix_world = Matrix.Translation((0, 0, 1)) @ handle.empty.matrix_world
    bpy.context.view_layer.update()
    assert_allclose(
        scene.shown(obj) - scene.key_points(obj, "Basis"), [[0, 0, 1]] * len(obj.data.vertices), atol=1e-5
    )
