"""Pose: transforms applied, or the origin set, on an object that is bound."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import poses
from mathutils import Euler, Matrix
from numpy.testing import assert_allclose

TURN = Matrix.Translation((0.5, 0.3, 0.2)) @ Euler((0.2, 0.5, 0.3)).to_matrix().to_4x4()


def world(obj):
    """(n, 3): what is shown, in the scene."""
    matrix = np.array(obj.matrix_world)
    return scene.shown(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def apply(**parts):
    given = {"location": False, "rotation": False, "scale": False} | parts
    assert bpy.ops.object.transform_apply(**given) == {"FINISHED"}


def to_cursor():
    bpy.context.scene.cursor.location = (1, -2, 0.5)
    assert bpy.ops.object.origin_set(type="ORIGIN_CURSOR") == {"FINISHED"}


CHANGES = {
    "scale": lambda: apply(scale=True),
    "rotation": lambda: apply(rotation=True),
    "rotation and scale": lambda: apply(rotation=True, scale=True),
    "all": lambda: apply(location=True, rotation=True, scale=True),
    "origin to cursor": to_cursor,
    "origin to geometry": lambda: bpy.ops.object.origin_set(type="ORIGIN_GEOMETRY"),
}


def placement(draw):
    """Some matrix of an object, its scales other than each other."""
    return Matrix.LocRotScale(draw.normal(size=3), Euler(draw.normal(size=3)), draw.uniform(0.5, 2, size=3))


def bound_tube(draw, later, **options):
    """A tube placed somewhere, bound; where ``later``, it is turned and moved after that."""
    obj = scene.tube(rings=16, around=12)
    obj.data.transform(Matrix.Translation((0.4, 0.2, 0.3)))
    obj.matrix_world = placement(draw)
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.4)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name, **options)
    if later:
        obj.matrix_world = TURN @ obj.matrix_world
    bpy.context.view_layer.update()
    return obj


def move(obj, motion):
    """Turns the upper handle about itself, and moves it."""
    empty = scene.empty(obj, "top")
    centre = Matrix.Translation(empty.matrix_world.translation)
    place(empty, centre @ motion @ centre.inverted() @ empty.matrix_world)


def place(empty, matrix):
    """Puts an Empty somewhere as the transform tools do, whose angles go on from those before."""
    before = empty.rotation_euler.copy()
    empty.matrix_world = matrix
    after = empty.rotation_euler.copy()
    after.make_compatible(before)
    empty.rotation_euler = after
    bpy.context.view_layer.update()


def activate(obj):
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj


@pytest.mark.parametrize("method", ["arap", "thin_shell"])
@pytest.mark.parametrize("later", [False, True])
@pytest.mark.parametrize("change", CHANGES)
def test_the_pose_stays_where_it_is_in_the_scene_and_goes_on(change, later, method):
    draw = np.random.default_rng(list(CHANGES).index(change))
    obj = bound_tube(draw, later, method=method)
    rest = world(obj)
    move(obj, TURN)
    posed, before = world(obj), scene.empty(obj, "top").matrix_world.copy()
    move(obj, TURN)
    further = world(obj)
    place(scene.empty(obj, "top"), before)
    assert np.abs(further - posed).max() > 0.1
    before = scene.key_points(obj, "Basis")
    activate(obj)
    CHANGES[change]()
    bpy.context.view_layer.update()
    assert np.abs(scene.key_points(obj, "Basis") - before).max() > 0.1
    off = 2e-3  # an iteration stops a little short, and solutions answer to rounding
    assert_allclose(world(obj), posed, atol=off)
    move(obj, TURN)
    assert_allclose(world(obj), further, atol=off)
    bpy.ops.lissom.pose_reset(object=obj.name)
    bpy.context.view_layer.update()
    assert_allclose(world(obj), rest, atol=1e-5)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.context.view_layer.update()
    assert_allclose(world(obj), rest, atol=1e-5)


@pytest.mark.parametrize("later", [False, True])
@pytest.mark.parametrize("change", CHANGES)
def test_whole_turns_are_counted_from_the_rest_as_before(change, later):
    obj = bound_tube(np.random.default_rng(7), later, method="rotation_invariant")
    activate(obj)
    CHANGES[change]()
    bpy.context.view_layer.update()
    empty = scene.empty(obj, "top")
    start = empty.rotation_euler.copy()
    for angle in (5.0, 8.0, -8.0):
        empty.rotation_euler.z = start.z + angle
        bpy.context.view_layer.update()
        assert np.linalg.norm(poses.motion(obj).turns[1]) == pytest.approx(
            8.0 if angle < 0 else angle, abs=1e-5
        )


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 2])
@pytest.mark.parametrize("change", ["scale", "origin to cursor", "origin to geometry"])
def test_turns_that_were_made_before_the_change_are_kept(change, turns):
    obj = scene.bound_tube(rings=16, around=12)
    obj.data.transform(Matrix.Translation((0.4, 0.2, 0.3)), shape_keys=True)
    obj.scale = (1, 2, 0.7)
    scene.empty(obj, "top").rotation_euler = (0.1, 0.2, 0.3 + 2 * np.pi * turns)
    bpy.context.view_layer.update()
    told = poses.motion(obj).turns
    activate(obj)
    CHANGES[change]()
    bpy.context.view_layer.update()
    after = poses.motion(obj).turns
    if turns:
        assert np.linalg.norm(after[1]) == pytest.approx(np.linalg.norm(told[1]), abs=0.3)
    else:
        assert told is None and after is None


def test_after_undo_and_redo_it_is_posed_as_then():
    obj = bound_tube(np.random.default_rng(1), False)
    move(obj, TURN)
    posed = world(obj)
    activate(obj)
    bpy.ops.ed.undo_push(message="posed")
    apply(rotation=True, scale=True)
    bpy.ops.ed.undo_push(message="applied")
    bpy.context.view_layer.update()
    for step in (bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.undo):
        step()
        bpy.context.view_layer.update()
        obj = bpy.data.objects["Tube"]
        assert_allclose(world(obj), posed, atol=2e-3)
        move(obj, Matrix.Identity(4))
        bpy.ops.lissom.pose_update(object=obj.name)
        assert_allclose(world(obj), posed, atol=2e-3)


def test_an_opened_file_follows_too(tmp_path):
    obj = bound_tube(np.random.default_rng(2), False)
    move(obj, TURN)
    posed = world(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "posed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "posed.blend"))
    obj = bpy.data.objects["Tube"]
    activate(obj)
    apply(scale=True)
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(world(obj), posed, atol=2e-3)


def test_a_rest_shape_that_is_scaled_in_edit_mode_is_an_edit():
    obj = bound_tube(np.random.default_rng(3), False)
    rests = [tuple(handle.rest) for handle in obj.lissom_pose.handles]
    activate(obj)
    obj.data.shape_keys.reference_key.points.foreach_set(
        "co", np.float32(1.5 * scene.key_points(obj, "Basis")).ravel()
    )
    obj.data.update()
    bpy.context.view_layer.update()
    assert [tuple(handle.rest) for handle in obj.lissom_pose.handles] == rests


def test_an_uneven_scale_set_after_bind_is_said():
    draw = np.random.default_rng(8)
    for _ in range(5):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        obj = bound_tube(draw, True)
        scale = obj.scale.copy()
        for factors, said in (
            ((2, 2, 2), False),
            ((-1, 1, 1), False),
            ((1, 1.1, 1), True),
            ((1, 1, 1), False),
        ):
            obj.scale = [a * b for a, b in zip(scale, factors, strict=True)]
            bpy.context.view_layer.update()
            assert ("scaled unevenly since Bind" in poses.rescaled(obj)) == said
