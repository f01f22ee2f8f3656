"""Rows of the list of handles: renamed as one with group and Empty, chosen as one with the Empty."""

import bpy
import numpy as np
import scene
from bl_ext.user_default.lissom.bridge import groups
from test_panels import draw


def size(obj, name):
    return len(groups.members(obj, [name])[name])


def active(obj):
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj


def test_a_double_click_renames_group_empty_and_what_refers_to_them():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    modifier = obj.modifiers.new("Smooth", "SMOOTH")
    modifier.vertex_group = "top"
    other = bpy.data.objects.new("Follower", None)
    constraint = other.constraints.new("COPY_LOCATION")
    constraint.target, constraint.subtarget = obj, "top"
    handle = obj.lissom_pose.handles["top"]
    members = size(obj, "top")
    handle.label = "Head"
    assert handle.name == handle.label == "Head"
    assert handle.empty.name == "Tube Head"
    assert "top" not in obj.vertex_groups and size(obj, "Head") == members
    assert modifier.vertex_group == constraint.subtarget == "Head"


def test_a_name_that_is_taken_is_numbered_and_none_changes_nothing():
    obj = scene.bound_tube()
    top = obj.lissom_pose.handles["top"]
    top.label = "bottom"
    assert top.name == "bottom.001" and obj.vertex_groups["bottom.001"]
    top.label = "  "
    assert top.name == "bottom.001"


def test_a_bound_mesh_follows_its_renamed_handle():
    obj = scene.bound_tube()
    obj.lissom_pose.handles["top"].label = "Head"
    before = scene.shown(obj)
    scene.empty(obj, "Head").location.x += 1.0
    bpy.context.view_layer.update()
    moved = np.abs(scene.shown(obj) - before).max()
    assert moved > 0.5


def test_row_and_empty_select_each_other():
    obj = scene.bound_tube()
    settings = obj.lissom_pose
    active(scene.empty(obj, "bottom"))
    assert settings.chosen_handle == settings.active_handle == 0
    active(scene.empty(obj, "top"))
    assert settings.active_handle == 1
    settings.chosen_handle = 0
    empty = scene.empty(obj, "bottom")
    assert bpy.context.object == empty
    assert [other for other in bpy.context.view_layer.objects if other.select_get()] == [empty]


def test_in_edit_mode_a_row_is_chosen_without_leaving_it():
    obj = active(scene.bound_tube())
    bpy.ops.lissom.pose_unbind(object=obj.name)
    active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    obj.lissom_pose.chosen_handle = 0
    assert obj.lissom_pose.active_handle == 0 and bpy.context.object == obj and obj.mode == "EDIT"


def test_the_list_has_names_to_double_click():
    obj = scene.bound_tube()
    drawn = draw(bpy.types.LISSOM_UL_handles, obj.lissom_pose, obj.lissom_pose.handles[0], 0, None, "")
    assert drawn["settings"] == ["label"]
