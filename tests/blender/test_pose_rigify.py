"""A pose on Rigify's own arm, whose deforming bones are bent ones that constraints move."""

import addon_utils
import bpy
import numpy as np
import pytest
import scene
from mathutils import Matrix

# As an artist skins it: what lies between two bones within this length of the arm goes with both.
BLEND = 0.08


def rigify_arm(preserve, degrees):
    """A sleeve skinned to an arm that Rigify made, its forearm bent by its own control; sleeve and rig."""
    addon_utils.enable("rigify", default_set=True)
    data = bpy.data.armatures.new("Meta")
    meta = bpy.data.objects.new("Meta", data)
    bpy.context.collection.objects.link(meta)
    bpy.context.view_layer.objects.active = meta
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.armature.metarig_sample_add(metarig_type="limbs.arm")
    bpy.ops.object.mode_set(mode="OBJECT")
    shown = data.collections[0] if data.collections else data.collections.new("Arm")
    shown.rigify_ui_row = 1
    for bone in data.bones:
        shown.assign(bone)
    bpy.ops.pose.rigify_generate()
    rig = bpy.context.object
    obj = sleeve(rig)
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object, modifier.use_deform_preserve_volume = rig, preserve
    rig.pose.bones["upper_arm_parent.L"]["IK_FK"] = 1.0
    control = rig.pose.bones["forearm_fk.L"]
    control.rotation_mode = "XYZ"
    control.rotation_euler.x = np.radians(degrees)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj, rig


def sleeve(rig):
    """A tube round the deforming bones, from the shoulder to the wrist."""
    bones = [bone for bone in rig.data.bones if bone.use_deform and "arm" in bone.name]
    corners = np.array([bone.head_local for bone in bones] + [bones[-1].tail_local])
    lengths = np.concatenate([[0], np.linalg.norm(np.diff(corners, axis=0), axis=1).cumsum()])
    obj = scene.tube(rings=48, around=16, name="Sleeve")
    tube = scene.points(obj.data.vertices)
    along = (tube[:, 2] - tube[:, 2].min()) / np.ptp(tube[:, 2]) * lengths[-1]
    axis = (corners[-1] - corners[0]) / np.linalg.norm(corners[-1] - corners[0])
    side = np.cross(axis, [0, 0, 1])
    side /= np.linalg.norm(side)
    centre = np.column_stack([np.interp(along, lengths, corners[:, k]) for k in range(3)])
    moved = centre + 0.045 * (tube[:, :1] * side + tube[:, 1:2] * np.cross(axis, side))
    obj.data.vertices.foreach_set("co", moved.ravel())
    shares = np.diff(
        np.vstack(
            [np.ones(len(along))]
            + [np.clip((along - joint) / BLEND + 0.5, 0, 1) for joint in lengths[1:-1]]
            + [np.zeros(len(along))]
        ),
        axis=0,
    )
    for bone, weights in zip(bones, -shares, strict=True):
        group = obj.vertex_groups.new(name=bone.name)
        for index, weight in enumerate(weights.tolist()):
            if weight:
                group.add([index], weight, "REPLACE")
    return obj


@pytest.mark.parametrize("preserve", [False, True])
def test_a_corrective_on_a_bent_arm_goes_back_through_the_rig_and_is_driven(preserve):
    obj, rig = rigify_arm(preserve, 120.0)
    rest = scene.points(obj.data.vertices)
    diagonal = np.linalg.norm(np.ptp(rest, axis=0))
    elbow = np.array(rig.data.bones["DEF-forearm.L"].head_local)
    away = np.linalg.norm(rest - elbow, axis=1)
    ends = np.flatnonzero(away > 0.2)
    bulge = np.flatnonzero((away < 0.07) & (rest[:, 1] > elbow[1]))
    for name, members in (("ends", ends), ("bulge", bulge)):
        obj.vertex_groups.new(name=name).add(members.tolist(), 1.0, "REPLACE")
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
        obj.lissom_pose.handles[name].turns_by_itself = False
    bent = scene.shown(obj)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert np.abs(scene.shown(obj) - bent).max() < 1e-5 * diagonal
    empty = scene.empty(obj, "bulge")
    empty.matrix_world = Matrix.Translation((0.02, 0.03, 0.01)) @ empty.matrix_world
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_update(object=obj.name)
    posed = scene.shown(obj)
    assert np.abs(posed - bent).max() > 0.03
    bpy.ops.lissom.pose_apply(object=obj.name, name="Elbow")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    off = np.linalg.norm(scene.shown(obj) - posed, axis=1).max() / diagonal
    print(f"round trip: {off:.1e} of the diagonal")
    assert off < 1e-5
    bpy.ops.lissom.pose_drive(object=obj.name, key="Elbow")
    bpy.context.view_layer.update()
    assert np.abs(scene.shown(obj) - posed).max() < 1e-3 * diagonal
    rig.pose.bones["forearm_fk.L"].rotation_euler.x = 0.0
    bpy.context.view_layer.update()
    assert abs(obj.data.shape_keys.key_blocks["Elbow"].value) < 1e-3
