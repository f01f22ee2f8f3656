"""Pose a mesh as armature, keys and modifiers show it: what Apply makes goes back through them."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from mathutils import Matrix
from numpy.testing import assert_allclose

DIAGONAL = np.linalg.norm([2, 2, 6])


def arm(preserve=False, degrees=120.0):
    """A tube skinned to two bones, the upper one bent; returns tube and rig."""
    obj = scene.tube()
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    lower, upper = data.edit_bones.new("lower"), data.edit_bones.new("upper")
    lower.head, lower.tail, upper.tail = (0, 0, -3), (0, 0, 0), (0, 0, 3)
    upper.head, upper.parent = (0, 0, 0), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    heights = scene.points(obj.data.vertices)[:, 2]
    share = np.clip(heights / 2 + 0.5, 0, 1)
    for name, weights in (("lower", 1 - share), ("upper", share)):
        group = obj.vertex_groups.new(name=name)
        for index, weight in enumerate(weights.tolist()):
            group.add([index], weight, "REPLACE")
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object, modifier.use_deform_preserve_volume = rig, preserve
    bone = rig.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler.x = np.radians(degrees)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj, rig


def handles(obj, **options):
    """A handle at either end, bound."""
    scene.group(obj, "bottom", lambda co: co.z < -2.5)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    for name in ("bottom", "top"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
        obj.lissom_pose.handles[name].turns_by_itself = False
    bpy.ops.lissom.pose_bind(object=obj.name, **options)


def members(obj, name):
    group = obj.vertex_groups[name].index
    return [v.index for v in obj.data.vertices if any(own.group == group for own in v.groups)]


def lift(obj, name="top", by=(0.3, -0.2, 0.4)):
    scene.empty(obj, name).matrix_world = Matrix.Translation(by) @ scene.empty(obj, name).matrix_world
    bpy.context.view_layer.update()


@pytest.mark.parametrize("preserve", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 75.0, 120.0])
def test_handles_are_born_where_the_mesh_is_seen_and_move_it_their_way(preserve, degrees):
    obj, _ = arm(preserve, degrees)
    seen = scene.shown(obj)
    handles(obj)
    top = members(obj, "top")
    assert_allclose(scene.empty(obj, "top").matrix_world.translation, seen[top].mean(axis=0), atol=1e-5)
    assert_allclose(scene.shown(obj), seen, atol=1e-5 * DIAGONAL)
    lift(obj)
    assert_allclose(scene.shown(obj)[top], seen[top] + [0.3, -0.2, 0.4], atol=1e-5 * DIAGONAL)
    bottom = members(obj, "bottom")
    assert_allclose(scene.shown(obj)[bottom], seen[bottom], atol=1e-5 * DIAGONAL)


@pytest.mark.parametrize("preserve", [False, True])
def test_what_apply_makes_shows_the_pose_through_the_skin(preserve):
    obj, rig = arm(preserve)
    scene.add_key(obj, "bulge", scene.points(obj.data.vertices) * [1.2, 1.2, 1], value=0.7)
    handles(obj)
    lift(obj)
    bpy.ops.lissom.pose_update(object=obj.name)
    posed = scene.shown(obj)
    bpy.ops.lissom.pose_apply(object=obj.name, name="Bent")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    off = np.linalg.norm(scene.shown(obj) - posed, axis=1).max() / DIAGONAL
    print(f"round trip: {off:.1e} of the diagonal")
    assert off < 1e-5
    obj.data.shape_keys.key_blocks["Bent"].value = 0.0
    rig.pose.bones["upper"].rotation_euler.x = 0.0
    bpy.context.view_layer.update()
    rest = scene.key_points(obj, "Basis")
    assert_allclose(scene.shown(obj), rest + 0.7 * (scene.key_points(obj, "bulge") - rest), atol=1e-5)


def test_it_is_bound_anew_after_a_file_was_loaded(tmp_path):
    obj, _ = arm()
    handles(obj)
    lift(obj)
    bpy.ops.lissom.pose_update(object=obj.name)
    posed = scene.shown(obj)
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Tube"]
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(scene.shown(obj), posed, atol=1e-4)
    lift(obj, by=(0, 0, 0.2))
    top = members(obj, "top")
    assert_allclose(scene.shown(obj)[top], posed[top] + [0, 0, 0.2], atol=1e-4)


def test_a_rig_that_moves_meanwhile_is_said_and_put_back_is_well():
    obj, rig = arm()
    handles(obj)
    bone = rig.pose.bones["upper"]
    bone.rotation_euler.x += 0.3
    bpy.context.view_layer.update()
    with scene.refused("stands elsewhere than at Bind"):
        bpy.ops.lissom.pose_update(object=obj.name)
    bone.rotation_euler.x -= 0.3
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_update(object=obj.name)


def test_vertices_that_the_skin_collapses_are_named_selected_and_stay(capfd):
    obj, _ = arm(degrees=180.0)  # linear blending: half way between both bones nothing is left across
    handles(obj)
    assert "No key can move" in capfd.readouterr().out
    chosen = [v.index for v in obj.data.vertices if v.select]
    heights = scene.points(obj.data.vertices)[chosen, 2]
    assert len(chosen) == 40 and np.abs(heights).max() < 1e-6
    seen = scene.shown(obj)
    lift(obj, by=(0, 0, 0.3))
    assert np.isfinite(scene.shown(obj)).all()
    assert_allclose(scene.shown(obj)[chosen], seen[chosen], atol=1e-5)


def test_a_mesh_without_modifiers_is_as_before_and_off_poses_the_rest_shape():
    obj = scene.bound_tube()
    assert not obj.lissom_pose.stood and obj.session_uid not in session.skins
    obj, _ = arm()
    obj.name = "Arm"
    obj.lissom_pose.stands = False
    handles(obj, stands=False)
    assert not obj.lissom_pose.stood
    rest = scene.points(obj.data.vertices)
    assert_allclose(
        scene.empty(obj, "top").matrix_world.translation, rest[members(obj, "top")].mean(axis=0), atol=1e-5
    )


def test_binding_leaves_no_trace_on_the_mesh():
    obj, _ = arm()
    handles(obj)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert obj.data.shape_keys is None
    scene.add_key(obj, "a", scene.points(obj.data.vertices) + 0.1, value=1.0)
    scene.add_key(obj, "b", scene.points(obj.data.vertices))
    obj.active_shape_key_index = 1
    before = scene.snapshot()["Tube"][4]
    bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert scene.snapshot()["Tube"][4] == before and obj.active_shape_key_index == 1


def test_what_plays_a_cache_heeds_no_keys_and_is_said_instead(tmp_path, capfd):
    obj = scene.tube(rings=12, around=8)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    cache = obj.modifiers.new("Cache", "MESH_CACHE")
    cache.cache_format, cache.filepath = "PC2", str(tmp_path / "none.pc2")
    points = scene.points(obj.data.vertices).astype(np.float32)
    header = b"POINTCACHE2\0" + np.array([1, len(points)], "<i4").tobytes()
    header += np.array([0, 1], "<f4").tobytes() + np.array([2], "<i4").tobytes()
    (tmp_path / "none.pc2").write_bytes(header + np.stack([points + 1, points + 1]).astype("<f4").tobytes())
    cache.deform_mode = "OVERWRITE"
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert not obj.lissom_pose.stood
    assert "modifier 'Cache' moves the mesh, not the Empties" in capfd.readouterr().out


def test_apply_and_next_leaves_the_mesh_at_rest_and_names_count_up():
    obj = scene.bound_tube()
    rest = scene.shown(obj)
    for name in ("Pose", "Pose.001", "Pose.002"):
        lift(obj)
        bpy.ops.lissom.pose_apply(object=obj.name, name="Pose", value=0.0)
        assert obj.data.shape_keys.key_blocks[name].value == 0.0
        assert_allclose(scene.shown(obj), rest, atol=1e-6)
