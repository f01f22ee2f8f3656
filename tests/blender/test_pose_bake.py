"""Whole turns of handles, and baking their animation."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import poses
from bl_ext.user_default.lissom.jobs.bound import follow
from mathutils import Matrix, Quaternion
from numpy.testing import assert_allclose, assert_array_equal

FRAMES = range(3, 12)
SINGLE = 3e-6  # of the diagonal


def twist(obj):
    """Degrees from the lower to the upper end of the tube, as it is shown, with whole turns."""
    rings = scene.shown(obj).reshape(-1, obj["around"], 3)
    spokes = rings[:, 0] - rings.mean(axis=1)
    angles = np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0]))
    return np.degrees(angles[-1] - angles[0])


def slender(rings=200, around=20):
    """A tube that can be twisted several times and stays a tube."""
    obj = scene.tube(rings=rings, around=around)
    obj.data.transform(Matrix.Diagonal((0.2, 0.2, 1, 1)))
    obj["around"] = around
    return obj


def bound(method="poisson", rings=200, **options):
    obj = slender(rings)
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.8)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name, method=method, **options)
    return obj


@pytest.mark.parametrize("method", ["poisson", "rotation_invariant", "multiresolution", "arap"])
def test_an_empty_that_turned_twice_twists_the_mesh_twice(method):
    obj = bound(method)
    scene.empty(obj, "top").rotation_euler.z = np.radians(720)
    bpy.context.view_layer.update()
    assert abs(twist(obj) - 720) < 1
    scene.empty(obj, "top").rotation_euler.z = np.radians(360)
    bpy.context.view_layer.update()
    assert abs(twist(obj) - 360) < 1
    scene.empty(obj, "top").rotation_euler.z = 0
    bpy.context.view_layer.update()
    assert abs(twist(obj)) < 1


def test_turns_that_the_mesh_does_not_make_are_told_where_the_artist_looks():
    obj = bound("laplacian")
    for degrees, wanted in ((90, False), (720, True), (90, False)):
        scene.empty(obj, "top").rotation_euler.z = np.radians(degrees)
        bpy.context.view_layer.update()
        icon, text = session.status[obj.session_uid]
        assert ("has unwound" in text, icon == "ERROR") == (wanted, wanted)
        bpy.ops.lissom.pose_update(object=obj.name)
        assert ("has unwound" in session.status[obj.session_uid][1]) == wanted


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (1, 1, -2)])
def test_turns_are_those_of_the_scene_whatever_the_scale(scale):
    obj = slender()
    obj.matrix_world = Matrix.LocRotScale((1, 2, 3), Quaternion((1, 1, 0), 0.7), scale)
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.8)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name, method="poisson")
    scene.empty(obj, "top").rotation_euler.z = np.radians(500)
    bpy.context.view_layer.update()
    assert abs(abs(twist(obj)) - 500) < 1  # the other way round would not end where the handle is


def test_axis_and_angle_hold_turns_too():
    obj = bound()
    top = scene.empty(obj, "top")
    top.rotation_mode = "AXIS_ANGLE"
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.ops.lissom.pose_bind(object=obj.name, method="poisson")
    top.rotation_axis_angle = (np.radians(-600), 0, 0, 1)
    bpy.context.view_layer.update()
    assert abs(twist(obj) + 600) < 1


def test_where_a_constraint_turns_the_empty_its_channels_tell_nothing():
    obj = bound()
    top = scene.empty(obj, "top")
    limit = top.constraints.new("LIMIT_ROTATION")
    limit.use_limit_z, limit.max_z, limit.owner_space = True, np.radians(30), "LOCAL"
    top.rotation_euler.z = np.radians(700)
    bpy.context.view_layer.update()
    assert poses.motion(obj).turns is None


def animate(obj, degrees=540):
    """The upper handle goes up and turns, over FRAMES."""
    top, scene_ = scene.empty(obj, "top"), bpy.context.scene
    start = top.location.z
    for frame, t in ((FRAMES[0], 0.0), (FRAMES[-1], 1.0)):
        top.location.z = start + t
        top.rotation_euler.z = np.radians(degrees) * t
        top.keyframe_insert("location", frame=frame)
        top.keyframe_insert("rotation_euler", frame=frame)
    scene_.frame_start, scene_.frame_end = FRAMES[0], FRAMES[-1]
    scene_.frame_set(FRAMES[0])


def live_shapes(obj):
    found = []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        follow(obj)
        found.append(scene.shown(obj))
    bpy.context.scene.frame_set(FRAMES[0])
    return np.array(found)


def played(obj, frames=FRAMES):
    found = []
    for frame in frames:
        whole = int(np.floor(frame))
        bpy.context.scene.frame_set(whole, subframe=frame - whole)
        found.append(scene.shown(obj))
    return np.array(found)


@pytest.mark.parametrize("output", ["KEYS", "CACHE"])
@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 0.5, 2)])
def test_the_baked_animation_plays_what_was_live(output, scale, tmp_path):
    obj = bound()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    obj.scale, obj.location = scale, (4, 5, 6)
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_bind(object=obj.name, method="poisson", border=1)
    animate(obj)
    expected = live_shapes(obj)
    diagonal = np.linalg.norm(np.ptp(expected[0], axis=0))
    bpy.context.scene.frame_set(5)
    path = tmp_path / "tube.pc2"
    more = {"filepath": str(path)} if output == "CACHE" else {}
    assert bpy.ops.lissom.pose_bake(object=obj.name, output=output, **more) == {"FINISHED"}
    assert bpy.context.scene.frame_current == 5
    assert not obj.lissom_pose.bound
    assert_allclose(played(obj), expected, atol=SINGLE * diagonal)
    # Straight lines between the frames, and the ends are kept outside.
    between = played(obj, [FRAMES[2] + 0.25])[0]
    assert_allclose(between, 0.75 * expected[2] + 0.25 * expected[3], atol=2 * SINGLE * diagonal)
    assert_allclose(played(obj, [0, 50]), expected[[0, -1]], atol=SINGLE * diagonal)
    assert abs(abs(twist(obj)) - 540) < 1  # the last frame still


@pytest.mark.parametrize("output", ["KEYS", "CACHE"])
def test_every_other_frame(output, tmp_path):
    obj = bound("laplacian")
    animate(obj, degrees=40)
    expected = live_shapes(obj)[::2]
    more = {"filepath": str(tmp_path / "a.pc2")} if output == "CACHE" else {}
    bpy.ops.lissom.pose_bake(object=obj.name, output=output, step=2, **more)
    assert_allclose(played(obj, FRAMES[::2]), expected, atol=2e-5)


def test_turns_that_no_channel_tells_are_counted_from_frame_to_frame():
    obj = bound()
    top = scene.empty(obj, "top")
    top.rotation_mode = "QUATERNION"
    for frame in FRAMES:
        top.rotation_quaternion = Quaternion((0, 0, 1), np.radians(75) * (frame - FRAMES[0]))
        top.keyframe_insert("rotation_quaternion", frame=frame)
    bpy.ops.lissom.pose_bake(object=obj.name, frame_start=FRAMES[0], frame_end=FRAMES[-1], step=4)
    bpy.context.scene.frame_set(FRAMES[-1])
    assert abs(twist(obj) - 75 * (len(FRAMES) - 1)) < 1


def test_bound_again_the_baked_motion_is_silent_and_baked_again_replaced():
    obj = bound("laplacian")
    animate(obj, degrees=30)
    bpy.ops.lissom.pose_bake(object=obj.name, name="Walk")
    first = obj.data.shape_keys.key_blocks.keys()
    assert first == ["Basis", *(f"Walk {frame:04d}" for frame in FRAMES)]
    bpy.context.scene.frame_set(FRAMES[0])
    bpy.ops.lissom.pose_bind(object=obj.name, method="laplacian")
    assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis"), atol=1e-6)
    expected = live_shapes(obj)
    bpy.ops.lissom.pose_bake(object=obj.name, name="Walk", step=4)
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Walk 0003", "Walk 0007", "Walk 0011"]
    assert_allclose(played(obj, [3, 7, 11]), expected[[0, 4, 8]], atol=2e-5)
    bpy.ops.lissom.pose_bind(object=obj.name, method="laplacian")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert not obj.data.shape_keys.key_blocks["Walk 0003"].mute


def test_keys_take_the_place_of_an_earlier_cache(tmp_path):
    obj = bound("laplacian")
    animate(obj, degrees=30)
    bpy.ops.lissom.pose_bake(object=obj.name, output="CACHE", filepath=str(tmp_path / "a.pc2"))
    bpy.context.scene.frame_set(FRAMES[0])
    bpy.ops.lissom.pose_bind(object=obj.name, method="laplacian")
    scene.empty(obj, "top").location.x += 1
    scene.empty(obj, "top").keyframe_insert("location", frame=FRAMES[-1])
    expected = live_shapes(obj)
    bpy.ops.lissom.pose_bake(object=obj.name)
    assert not obj.modifiers
    assert_allclose(played(obj), expected, atol=2e-5)


def test_what_cannot_be_baked_changes_nothing(tmp_path):
    obj = bound("laplacian", rings=20)
    animate(obj)
    bake = bpy.ops.lissom.pose_bake
    scene.add_key(obj, "Pose 0004", scene.key_points(obj, "Basis"))
    with scene.refused("The last frame, 2, is before the first, 3"):
        bake(object=obj.name, frame_end=2)
    with scene.refused("Shape key 'Pose 0004' exists"):
        bake(object=obj.name)
    with scene.refused("Save the file first"):
        bake(object=obj.name, output="CACHE")
    with scene.refused("There is no folder"):
        bake(object=obj.name, output="CACHE", filepath=str(tmp_path / "none" / "a.pc2"))
    (tmp_path / "folder.pc2").mkdir()
    with scene.refused("cannot be written"):
        bake(object=obj.name, output="CACHE", filepath=str(tmp_path / "folder.pc2"))
    text = tmp_path / "text.pc2"
    text.write_text("my notes, which are no cache")
    with scene.refused("is no point cache"):
        bake(object=obj.name, output="CACHE", filepath=str(text))
    bpy.ops.lissom.pose_unbind(object=obj.name)
    with scene.refused("is not bound"):
        bake(object=obj.name)
    assert list(tmp_path.glob("*.part")) == []


def test_the_cache_lies_beside_the_file(tmp_path):
    obj = bound("laplacian", rings=20)
    animate(obj, degrees=20)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.lissom.pose_bake(object=obj.name, output="CACHE")
    assert (tmp_path / "Tube.pc2").exists()
    (modifier,) = obj.modifiers
    assert modifier.filepath == "//Tube.pc2"
    before = played(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert_array_equal(played(bpy.data.objects["Tube"]), before)
