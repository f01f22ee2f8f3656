"""A key driven by a bone: 0 at rest, 1 where the bone was, 0 the other way, whatever else the bone does."""

import bpy
import numpy as np
import pytest
import scene
from mathutils import Euler, Matrix, Quaternion
from test_pose_stands import arm


def driven(rotation, motion):
    """An arm with a key driven by its upper bone, which was turned so; tube, rig, key."""
    obj, rig = arm(degrees=0.0)
    bone = rig.pose.bones["upper"]
    bone.rotation_mode = "QUATERNION"
    bone.rotation_quaternion = rotation
    bpy.context.view_layer.update()
    key = scene.add_key(obj, "Corrective", scene.points(obj.data.vertices) * 1.1)
    bpy.ops.lissom.pose_drive(object=obj.name, key="Corrective", motion=motion)
    return rig, key


def at(rig, key, rotation):
    rig.pose.bones["upper"].rotation_quaternion = rotation
    bpy.context.view_layer.update()
    return key.value


@pytest.mark.parametrize("seed", range(6))
def test_swing_goes_from_rest_to_now_and_not_the_other_way(seed):
    random = np.random.default_rng(seed)
    direction = random.uniform(0, 2 * np.pi)
    axis, angle = (np.cos(direction), 0, np.sin(direction)), random.uniform(0.3, 2.5)
    rig, key = driven(Quaternion(axis, angle), "SWING")
    for share in (0.0, 0.25, 0.5, 1.0):
        assert abs(at(rig, key, Quaternion(axis, share * angle)) - share) < (
            1e-4 if share in (0, 1) else 0.02
        )
    assert at(rig, key, Quaternion(axis, -0.7 * angle)) == 0.0
    assert abs(at(rig, key, Quaternion((0, 1, 0), 1.0))) < 1e-4, "a twist is no swing"


@pytest.mark.parametrize("angle", [-1.7, 0.4, 2.0])
def test_twist_goes_from_rest_to_now_and_does_not_heed_swing(angle):
    rig, key = driven(Quaternion((0, 1, 0), angle), "TWIST")
    for share in (0.0, 0.5, 1.0):
        assert abs(at(rig, key, Quaternion((0, 1, 0), share * angle)) - share) < 1e-4
    assert abs(at(rig, key, Quaternion((1, 0, 0), 1.0))) < 1e-4


def test_the_bone_is_found_and_what_cannot_be_driven_is_said():
    obj, _ = arm(degrees=60.0)
    scene.add_key(obj, "a", scene.points(obj.data.vertices))
    obj.active_shape_key_index = 0
    with scene.refused("other than the Basis"):
        bpy.ops.lissom.pose_drive(object=obj.name)
    with scene.refused("There is no bone 'none'"):
        bpy.ops.lissom.pose_drive(object=obj.name, key="a", bone="none")
    with scene.refused("does not twist now"):
        bpy.ops.lissom.pose_drive(object=obj.name, key="a", motion="TWIST")
    bpy.ops.lissom.pose_drive(object=obj.name, key="a")
    (curve,) = obj.data.shape_keys.animation_data.drivers
    assert curve.driver.variables[0].targets[0].bone_target == "upper"
    assert curve.driver.is_valid
    bpy.ops.lissom.pose_drive(object=obj.name, key="a")  # again, in place of the first
    assert len(obj.data.shape_keys.animation_data.drivers) == 1
    other = scene.tube(name="Other")
    scene.add_key(other, "a", scene.points(other.data.vertices))
    with scene.refused("No armature moves 'Other'"):
        bpy.ops.lissom.pose_drive(object="Other", key="a")


def test_a_bent_arm_becomes_a_driven_corrective():
    """As an artist does it: bend, bind, pose, apply, drive, straighten."""
    obj, rig = arm()
    scene.group(obj, "elbow", lambda co: abs(co.z) < 0.4 and co.y < -0.7)
    scene.group(obj, "ends", lambda co: abs(co.z) > 2.0)
    for name in ("ends", "elbow"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
        obj.lissom_pose.handles[name].turns_by_itself = False
    bpy.ops.lissom.pose_bind(object=obj.name)
    empty = scene.empty(obj, "elbow")
    empty.matrix_world = Matrix.Translation((0, -0.3, 0)) @ empty.matrix_world
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_update(object=obj.name)
    posed = scene.shown(obj)
    bpy.ops.lissom.pose_apply(object=obj.name, name="Elbow")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.ops.lissom.pose_drive(object=obj.name, key="Elbow")
    bpy.context.view_layer.update()
    assert np.abs(scene.shown(obj) - posed).max() < 1e-3
    rig.pose.bones["upper"].rotation_euler = Euler((0, 0, 0))
    bpy.context.view_layer.update()
    assert np.abs(scene.shown(obj) - scene.key_points(obj, "Basis")).max() < 1e-4


@pytest.mark.parametrize("degrees", [180.0, 200.0, -185.0])
def test_half_a_turn_and_more_is_refused(degrees):
    obj, rig = arm(degrees=0.0)
    bone = rig.pose.bones["upper"]
    bone.rotation_mode, bone.rotation_euler.x = "XYZ", np.radians(degrees)
    bpy.context.view_layer.update()
    scene.add_key(obj, "Corrective", scene.points(obj.data.vertices) * 1.1)
    with scene.refused("turns by half a turn or more"):
        bpy.ops.lissom.pose_drive(object=obj.name, key="Corrective")
