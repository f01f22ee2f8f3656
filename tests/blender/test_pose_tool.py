"""Handles made on the mesh by the tool. Its events are checked in a window."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import brush, empties, groups, poses
from bl_ext.user_default.lissom.jobs import touch
from bl_ext.user_default.lissom.operators.pose_tool import PoseTool
from mathutils import Matrix, Vector


def click(obj, vertex, radius=40, pixel=0.02, pin=False):
    found = brush.Hit(vertex, obj.matrix_world @ obj.data.vertices[vertex].co, pixel)
    return touch.add(bpy.context, obj, found, radius, pin)


def middle(obj):
    """A vertex half way up."""
    heights = scene.points(obj.data.vertices)
    return int(np.abs(heights - [1, 0, 0.4]).sum(axis=1).argmin())


def test_a_click_makes_a_soft_group_with_its_empty_in_the_middle():
    obj = scene.tube()
    obj.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    row = click(obj, middle(obj))
    group = obj.vertex_groups[row.name]
    weights = {v.index: v.groups[0].weight for v in obj.data.vertices if v.groups}
    points = 2 * scene.points(obj.data.vertices)
    away = np.linalg.norm(points - points[middle(obj)], axis=1)
    assert set(weights) == set(np.flatnonzero(away < 0.8).tolist())
    assert max(weights.values()) == 1.0 and 0 < min(weights.values()) < 0.2
    assert (
        group.name == "Touch"
        and (row.empty.matrix_world.translation - Vector(points[middle(obj)])).length < 0.1
    )


def test_a_handle_added_to_a_posed_mesh_holds_it_where_it_is():
    obj = scene.bound_tube()
    top = scene.empty(obj, "top")
    top.matrix_world = Matrix.Translation((1.0, 0, 0.5)) @ Matrix.Rotation(0.6, 4, "Y") @ top.matrix_world
    bpy.context.view_layer.update()
    before = scene.key_points(obj, "Lissom Pose")
    assert np.abs(before - scene.points(obj.data.vertices)).max() > 0.5
    row = click(obj, middle(obj))
    bpy.ops.lissom.pose_update(object=obj.name)
    after = scene.key_points(obj, "Lissom Pose")
    own = list(groups.members(obj, [row.name])[row.name])
    assert len(own) > 20
    assert np.abs(after - before).max() < 0.05  # of a radius of 1
    row.empty.location.x += 0.5
    bpy.context.view_layer.update()
    assert np.abs(scene.key_points(obj, "Lissom Pose")[own, 0].mean() - after[own, 0].mean()) > 0.4


def test_two_clicks_never_share_a_vertex():
    obj = scene.tube()
    first = click(obj, middle(obj)).name
    near = middle(obj) + 3 * 40
    second = click(obj, near).name
    assert second == "Touch.001" and brush.handle_of(obj, near) in (first, second)
    both = [v.index for v in obj.data.vertices if len(v.groups) > 1]
    assert not both
    bpy.ops.lissom.pose_bind(object=obj.name, use_weights=True)


def test_scripts_are_told_what_to_call_instead():
    scene.tube()
    with scene.refused("scripts use lissom.pose_handle_add"):
        bpy.ops.lissom.pose_touch()


@pytest.mark.parametrize("scaled", [False, True])
def test_a_pin_of_a_turned_and_scaled_object_is_where_it_was_clicked(scaled):
    obj = scene.tube()
    obj.matrix_world = (
        Matrix.Translation((3, 1, 2)) @ Matrix.Rotation(0.8, 4, "X") @ Matrix.Scale(1 + scaled, 4)
    )
    bpy.context.view_layer.update()
    row = click(obj, middle(obj), pin=True)
    spot = obj.matrix_world @ obj.data.vertices[middle(obj)].co
    assert (row.empty.matrix_world.translation - spot).length < 0.2
    assert empties.is_alive(row.empty) and row.name == "Pin"


def test_the_tool_has_keys_for_operators_that_there_are():
    for name, _, _ in PoseTool.bl_keymap:
        module, operator = name.split(".")
        getattr(getattr(bpy.ops, module), operator).get_rna_type()


def test_what_is_far_stays_until_something_else_holds_the_mesh():
    obj = scene.monkey()
    rest = scene.points(obj.data.vertices)
    places = [np.abs(rest - place).sum(axis=1).argmin() for place in ([1.3, 0.3, 0.4], [0, -0.6, -0.95])]
    for number, vertex in enumerate(places):
        found = brush.Hit(int(vertex), obj.matrix_world @ obj.data.vertices[vertex].co, 0.005)
        made = touch.on(bpy.context, obj, found, 40)
        empty = obj.lissom_pose.handles[made.handle].empty
        empty.location.z += (0.4, -0.3)[number]
        bpy.context.view_layer.update()
        bpy.ops.lissom.pose_update(object=obj.name)
        moved = scene.key_points(obj, "Lissom Pose") - rest
        assert np.abs(moved[places[: number + 1]]).max() > 0.25
        assert not moved[rest[:, 0] < -0.6].any(), "the other ear stays where it is"
        assert poses.is_adrift(obj.lissom_pose)
    found = brush.Hit(*(lambda v: (v, obj.data.vertices[v].co))(int(rest[:, 0].argmin())), 0.005)
    touch.on(bpy.context, obj, found, 40, pin=True)
    assert not poses.is_adrift(obj.lissom_pose)
