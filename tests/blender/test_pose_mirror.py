"""The Mirror modifier and Symmetry: both sides move alike, and the seam stays on the plane."""

import bmesh
import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from mathutils import Euler, Matrix
from numpy.testing import assert_allclose, assert_array_equal

MOVE = Matrix.Translation((0.4, 0.2, 0.7)) @ Euler((0.3, 0.5, -0.2)).to_matrix().to_4x4()
FLIP = np.array([-1.0, 1, 1])


def ball(half, name="Ball"):
    """A sphere, or its half on x >= 0 under a Mirror modifier; one handle aside, one at the bottom."""
    mesh = bpy.data.meshes.new(name)
    edit = bmesh.new()
    bmesh.ops.create_uvsphere(edit, u_segments=24, v_segments=16, radius=1.0)
    for vertex in edit.verts:
        vertex.co.x = 0.0 if abs(vertex.co.x) < 1e-6 else vertex.co.x
    outside = [vertex for vertex in edit.verts if vertex.co.x < 0]
    bmesh.ops.delete(edit, geom=outside, context="VERTS")
    bmesh.ops.triangulate(edit, faces=edit.faces[:])
    if not half:
        bmesh.ops.mirror(edit, geom=[*edit.verts, *edit.edges, *edit.faces], axis="X", merge_dist=1e-5)
    edit.to_mesh(mesh)
    edit.free()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    if half:
        obj.modifiers.new("Mirror", "MIRROR")
    scene.group(obj, "low", lambda co: co.z < -0.8)
    scene.group(obj, "left", lambda co: co.x > 0.8 and co.z > 0.1)
    for handle in ("low", "left"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=handle)
    return obj


def move(obj, handle, motion=MOVE):
    empty = scene.empty(obj, handle)
    empty.matrix_world = motion @ empty.matrix_world
    bpy.context.view_layer.update()


def rest(obj):
    return scene.key_points(obj, "Basis")


def preview(obj):
    return scene.key_points(obj, "Lissom Pose")


def twins(points):
    """For each point the place of its mirror image."""
    off = np.linalg.norm(points[:, None] * FLIP - points[None], axis=2)
    assert off.min(1).max() < 1e-5
    return off.argmin(1)


def test_the_seam_of_a_mirrored_mesh_stays_on_the_plane_to_the_last_bit():
    obj = ball(half=True)
    bpy.ops.lissom.pose_bind(object=obj.name)
    move(obj, "left")
    seam = rest(obj)[:, 0] == 0
    posed = preview(obj)
    assert np.abs(posed - rest(obj)).max() > 0.5
    assert (posed[seam, 0] == 0).all()
    assert len(scene.shown(obj)) == 2 * len(posed) - seam.sum()
    free = ball(half=True, name="Free")
    free.modifiers.clear()
    bpy.ops.lissom.pose_bind(object=free.name)
    move(free, "left")
    assert np.abs(preview(free)[seam, 0]).max() > 0.01


@pytest.mark.parametrize("method", ["arap", "laplacian_fitted"])
def test_a_half_under_a_mirror_is_posed_as_the_whole_by_symmetry(method):
    half, whole = ball(half=True), ball(half=False, name="Whole")
    bpy.ops.lissom.pose_bind(object=half.name, method=method)
    bpy.ops.lissom.pose_bind(object=whole.name, method=method, symmetry="X")
    for obj in (half, whole):
        move(obj, "left")
    posed, image = preview(whole), twins(rest(whole))
    assert_allclose(posed[image], posed * FLIP, atol=1e-6)
    place = np.linalg.norm(rest(half)[:, None] - rest(whole)[None], axis=2).argmin(1)
    assert_allclose(preview(half), posed[place], atol=1e-5)


def test_symmetry_is_changed_live_survives_the_file_and_is_undone(tmp_path):
    obj = ball(half=False)
    bpy.ops.lissom.pose_bind(object=obj.name)
    move(obj, "left")
    right = rest(obj)[:, 0] < -0.8
    alone = preview(obj)
    image = twins(rest(obj))
    assert np.abs(alone[image] - alone * FLIP).max() > 0.5
    obj.lissom_pose.symmetry = "X"
    scene.empty(obj, "left").location.z += 0.01
    bpy.context.view_layer.update()
    both = preview(obj)
    assert_allclose(both[image], both * FLIP, atol=1e-6)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "ball.blend"))
    session.poses.clear()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "ball.blend"))
    obj = bpy.data.objects["Ball"]
    assert obj.lissom_pose.symmetry == "X"
    assert_array_equal(preview(obj), both)
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(preview(obj), both, atol=1e-3)
    assert_allclose(preview(obj)[image], preview(obj) * FLIP, atol=1e-6)
    obj.lissom_pose.symmetry = "OFF"
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(preview(obj)[right], alone[right], atol=0.02)


def test_a_modifier_that_is_added_or_hidden_counts_from_the_next_move_on():
    obj = ball(half=True)
    modifier = obj.modifiers["Mirror"]
    modifier.show_viewport = False
    bpy.ops.lissom.pose_bind(object=obj.name)
    move(obj, "left")
    seam = rest(obj)[:, 0] == 0
    assert np.abs(preview(obj)[seam, 0]).max() > 0.01
    modifier.show_viewport = True
    bpy.ops.lissom.pose_update(object=obj.name)
    assert (preview(obj)[seam, 0] == 0).all()


def test_a_scaled_object_that_lies_askew_keeps_its_seam():
    obj = ball(half=True)
    obj.matrix_world = Matrix.LocRotScale((3, 4, 5), Euler((0.3, 0.2, 0.1)), (0.5, 2.0, 1.5))
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_bind(object=obj.name)
    move(obj, "left", Matrix.Translation((0.3, 0.4, 0.5)))
    seam = rest(obj)[:, 0] == 0
    assert np.abs(preview(obj)[seam, 0]).max() < 1e-7
    assert np.abs(preview(obj) - rest(obj)).max() > 0.2


def test_baked_frames_and_arcs_keep_the_seam():
    obj = ball(half=True)
    bpy.ops.lissom.pose_bind(object=obj.name)
    empty = scene.empty(obj, "left")
    empty.keyframe_insert("location", frame=1)
    empty.location.z += 0.8
    empty.location.x += 0.4
    empty.keyframe_insert("location", frame=5)
    seam = rest(obj)[:, 0] == 0
    bpy.ops.lissom.pose_apply(object=obj.name, name="Up", reset=False)
    bpy.ops.lissom.pose_bake(object=obj.name, frame_start=1, frame_end=5)
    made = [key.name for key in obj.data.shape_keys.key_blocks if key.name not in ("Basis", "Up")]
    assert len(made) == 5
    for name in made:
        assert (scene.key_points(obj, name)[seam, 0] == 0).all()
    turned = rest(obj)
    angle = 1.2 * np.clip(0.5 - turned[:, 2], 0, 1)
    turned = np.stack(
        [
            turned[:, 0],
            np.cos(angle) * turned[:, 1] - np.sin(angle) * turned[:, 2],
            np.sin(angle) * turned[:, 1] + np.cos(angle) * turned[:, 2],
        ],
        1,
    )
    scene.add_key(obj, "Turned", turned)
    for mirror in (True, False):
        obj.modifiers["Mirror"].show_viewport = mirror
        bpy.ops.lissom.inbetween_bake(object=obj.name, end="Turned", count=4, slider="arc")
        keys = [key.name for key in obj.lissom_inbetween.arcs["arc"].keys]
        off = max(np.abs(scene.key_points(obj, name)[seam, 0]).max() for name in keys)
        assert off == 0 if mirror else off > 1e-4


def test_a_mirror_about_another_object_or_with_bisect_is_told_at_bind():
    obj = ball(half=True)
    modifier = obj.modifiers["Mirror"]
    modifier.mirror_object = bpy.data.objects.new("Centre", None)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert "mirrors about 'Centre': clear its Mirror Object" in obj.lissom_pose.warnings
    bpy.ops.lissom.pose_unbind(object=obj.name)
    modifier.mirror_object = None
    modifier.use_bisect_axis = (True, False, False)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert "turn off Bisect" in obj.lissom_pose.warnings


def test_a_mesh_that_is_not_symmetric_is_refused_and_left_alone():
    obj = ball(half=True)
    obj.modifiers.clear()
    before = scene.snapshot()
    with pytest.raises(RuntimeError, match="the mesh is not symmetric"):
        bpy.ops.lissom.pose_bind(object=obj.name, symmetry="X")
    assert scene.snapshot() == before
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.collection.objects.link(parent)
    parent.scale = (1, 1, 3)
    obj.parent = parent
    obj.rotation_euler = (0.3, 0.5, 0)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="'Ball' is sheared by its parents"):
        bpy.ops.lissom.pose_bind(object=obj.name, symmetry="X")
