"""Pose: handles, Bind, live update, Apply, Unbind."""

import types

import bmesh
import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import live, rebind, session
from bl_ext.user_default.lissom.bridge import meshes, poses
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.jobs.bound import follow
from bl_ext.user_default.lissom.jobs.pose import Bind, bind_asked
from mathutils import Euler, Matrix, Vector
from numpy.testing import assert_allclose, assert_array_equal

TURN = Matrix.Translation((0.7, -1.2, 0.4)) @ Euler((0.5, -1.1, 2.0)).to_matrix().to_4x4()
PREVIEW = "Lissom Pose"
SINGLE = 2e-6  # of the diagonal: Blender keeps positions and matrices in single precision


def moved(matrix, positions):
    matrix = np.array(matrix)
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def move_all(obj, motion):
    for handle in obj.lissom_pose.handles:
        handle.empty.matrix_world = motion @ handle.empty.matrix_world
    bpy.context.view_layer.update()


def test_empties_stand_at_the_centres_of_their_groups():
    obj = scene.tube()
    obj.location = (5, 0, 0)
    obj.scale = (1, 2, 3)
    bpy.context.view_layer.update()
    members = scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    bpy.context.view_layer.update()
    centre = scene.points(obj.data.vertices)[members].mean(axis=0)
    assert_allclose(
        scene.empty(obj, "top").matrix_world.translation, moved(obj.matrix_world, centre), atol=1e-5
    )
    assert_allclose(scene.empty(obj, "top").matrix_world.to_scale(), 1, atol=1e-6)


def test_a_rigid_motion_of_all_handles_is_reproduced():
    obj = scene.bound_tube()
    rest = scene.key_points(obj, "Basis")
    assert len(rest) > 2000
    move_all(obj, TURN)
    diagonal = np.linalg.norm(np.ptp(rest, axis=0))
    assert_allclose(scene.shown(obj), moved(TURN, rest), atol=SINGLE * diagonal)


@pytest.mark.parametrize("scale", [(0.5, 2.0, 1.0), (-1.0, 1.0, 1.0), (-2.0, 0.3, 1.0)])
def test_row_36_a_rigid_motion_is_one_in_the_scene_whatever_the_scale(scale):
    obj = scene.tube()
    obj.matrix_world = Matrix.LocRotScale((3, 4, 5), Euler((0.3, 0.2, 0.1)), scale)
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.5)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name)
    world = moved(obj.matrix_world, scene.key_points(obj, "Basis"))
    move_all(obj, TURN)
    diagonal = np.linalg.norm(np.ptp(world, axis=0))
    assert_allclose(moved(obj.matrix_world, scene.shown(obj)), moved(TURN, world), atol=5 * SINGLE * diagonal)


def test_the_pose_is_what_the_native_module_solves():
    obj = scene.bound_tube()
    bend = Matrix.Translation((0.5, 0, 0.2)) @ Euler((0, 0.5, 0.3)).to_matrix().to_4x4()
    scene.empty(obj, "top").matrix_world = bend @ scene.empty(obj, "top").matrix_world
    bpy.context.view_layer.update()
    rest = scene.key_points(obj, "Basis")
    mesh = lissom.Mesh(rest, meshes.triangles(obj.data))
    handles = [np.flatnonzero(rest[:, 2] < -2.5), np.flatnonzero(rest[:, 2] > 2.5)]
    transforms = poses.motion(obj).transforms  # not bend itself: a flat minimum answers to rounding
    assert_allclose(transforms, [np.eye(4), np.array(bend)], atol=1e-6)
    expected = lissom.Pose(mesh, handles).solve(transforms)
    assert expected.report["converged"]
    assert_allclose(scene.shown(obj), expected.vertices, atol=1e-5)
    assert_allclose(scene.shown(obj)[handles[0]], rest[handles[0]], atol=1e-6)
    assert_allclose(scene.shown(obj)[handles[1]], moved(bend, rest[handles[1]]), atol=1e-5)


def native(obj, transforms, membership=None, **options):
    """What the native module makes of the tube by itself."""
    rest = scene.key_points(obj, "Basis")
    mesh = lissom.Mesh(rest, meshes.triangles(obj.data))
    handles = [np.flatnonzero(rest[:, 2] < -2.5), np.flatnonzero(rest[:, 2] > 2.5)]
    if membership:
        options["handle_weights"] = [[membership(rest[v]) for v in handle] for handle in handles]
    return lissom.Pose(mesh, handles, **options).solve(transforms).vertices


# One choice of every method that is not its default.
CHOICES = [
    {"method": "laplacian", "weights": "uniform"},
    {"method": "laplacian_fitted", "weights": "cotangent", "scale": True},
    {"method": "rotation_invariant", "weights": "uniform", "interpolation": "matrix", "project": False},
    {"method": "thin_shell", "k_s": 3.3, "k_b": 0.1, "border": 2},
    {"method": "poisson", "border": 1, "constraints": "soft", "weight": 2.5},
    {"method": "multiresolution", "base": "thin_shell", "border": 0, "smoothing": 0.3, "details": "offsets"},
    {"method": "arap", "cells": "spokes", "smoothness": 0.1, "rotation_smoothing": 0.02},
]


def bound_by(choice):
    """The tube, bound so, with its upper end turned and moved."""
    obj = scene.bound_tube(rings=30, around=20)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert bpy.ops.lissom.pose_bind(object=obj.name, **choice) == {"FINISHED"}
    bend = Matrix.Translation((0.5, 0, 0.2)) @ Euler((0, 0.5, 0.3)).to_matrix().to_4x4()
    scene.empty(obj, "top").matrix_world = bend @ scene.empty(obj, "top").matrix_world
    bpy.context.view_layer.update()
    return obj


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice["method"])
def test_every_option_reaches_the_native_module_also_after_loading(choice, tmp_path):
    obj = bound_by(choice)
    expected = native(obj, poses.motion(obj).transforms, **choice)
    assert_allclose(scene.shown(obj), expected, atol=2e-5)
    default = native(obj, poses.motion(obj).transforms, method=choice["method"])
    assert np.abs(default - expected).max() > 1e-3
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    obj = bpy.data.objects["Tube"]
    assert not session.poses
    scene.empty(obj, "top").location.x += 0.5
    bpy.context.view_layer.update()
    expected = native(obj, poses.motion(obj).transforms, **choice)
    assert_allclose(scene.shown(obj), expected, atol=2e-5)
    asked = session.poses[obj.session_uid].asked
    assert choice.items() <= ({"method": asked.method} | asked.options).items()


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice["method"])
def test_after_undo_every_method_solves_from_the_handles_of_then(choice):
    """Undo itself needs a window (tests/blender/window.py); here its handler runs on what undo leaves."""
    obj = bound_by(choice)
    seen = scene.shown(obj)
    key = obj.data.shape_keys.key_blocks[PREVIEW]
    key.data.foreach_set("co", scene.key_points(obj, "Basis").ravel())  # a mesh of the past
    live._on_history()
    bpy.context.view_layer.update()
    obj.location.x += 1  # any update, with no handle moved
    bpy.context.view_layer.update()
    assert_allclose(scene.key_points(obj, PREVIEW), seen, atol=5e-3 if choice["method"] == "arap" else 2e-5)


def test_an_option_changed_while_bound_is_followed_at_once():
    obj = bound_by({"method": "laplacian_fitted"})
    settings = obj.lissom_pose
    assert settings.options.laplacian_fitted.scale is False  # unlike the core: the published energy swells
    transforms = poses.motion(obj).transforms
    for change in ({"scale": True}, {"weights": "cotangent"}):
        for name, value in change.items():
            setattr(settings.options.laplacian_fitted, name, value)
        bpy.context.view_layer.update()
        obj.location.x += 1  # any update
        bpy.context.view_layer.update()
    expected = native(obj, transforms, method="laplacian_fitted", scale=True, weights="cotangent")
    assert_allclose(scene.key_points(obj, PREVIEW), expected, atol=2e-5)


def test_a_window_binds_anew_beside_blender(monkeypatch):
    """Its timers do not run here (tests/blender/window.py has them): their function is called by hand."""
    obj = bound_by({"method": "thin_shell"})
    transforms, before = poses.motion(obj).transforms, scene.key_points(obj, PREVIEW)
    monkeypatch.setattr(rebind, "bpy", windowed := Windowed())
    options = obj.lissom_pose.options.thin_shell
    options.k_s, options.k_b = 5.0, 0.3
    for operator in ("update", "apply", "reset"):
        with scene.refused("'Tube' is still being bound anew: wait a moment"):
            getattr(bpy.ops.lissom, f"pose_{operator}")(object=obj.name)
    assert windowed.registered == [rebind._poll] * 2
    assert rebind._poll() == rebind.POLL_SECONDS or not session.rebinding
    options.k_s = 4.0  # while the work is under way
    while rebind._poll() is not None:
        pass
    assert_array_equal(scene.key_points(obj, PREVIEW), before)
    bpy.context.view_layer.update()
    follow(obj)
    expected = native(obj, transforms, method="thin_shell", k_s=4.0, k_b=0.3)
    assert_allclose(scene.shown(obj), expected, atol=2e-5)
    assert np.abs(expected - before).max() > 1e-3


def test_row_42_handles_or_faces_changed_while_bind_is_under_way():
    """Its two halves run one after the other here, and what is between them in a window is done by hand."""
    obj = scene.bound_tube(rings=30, around=20)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    for change, message in (
        (lambda: obj.lissom_pose.handles.move(0, 1), "handles of 'Tube' were changed meanwhile"),
        (lambda: reverse_a_face(obj), "was changed meanwhile"),
        (lambda: bpy.data.objects.remove(obj), "'Tube' is gone"),
    ):
        bind = Bind(bpy.context, bind_asked(obj))
        change()
        with pytest.raises(Refused, match=message):
            bind.write(bpy.context, bind.work.wait())
        assert "Tube" not in bpy.data.objects or obj.data.shape_keys is None


def reverse_a_face(obj):
    edit = bmesh.new()
    edit.from_mesh(obj.data)
    edit.faces.ensure_lookup_table()
    bmesh.ops.reverse_faces(edit, faces=edit.faces[:1])
    edit.to_mesh(obj.data)
    edit.free()


def test_row_42_unbound_or_deleted_while_it_is_bound_anew(monkeypatch):
    obj = bound_by({"method": "thin_shell"})
    monkeypatch.setattr(rebind, "bpy", Windowed())
    obj.lissom_pose.options.thin_shell.k_s = 5.0
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert not session.rebinding
    bpy.ops.lissom.pose_bind(object=obj.name)
    obj.lissom_pose.method = "poisson"
    rebind._poll()
    bpy.data.objects.remove(obj)
    while rebind._poll() is not None:
        pass
    assert not session.rebinding


class Windowed:
    """bpy as the module under test sees it in a window, with timers that only note."""

    data = bpy.data

    def __init__(self):
        self.registered = []
        self.app = types.SimpleNamespace(background=False, timers=self)

    def register(self, function, first_interval):
        self.registered.append(function)

    def unregister(self, function):
        pass

    def is_registered(self, function):
        return bool(self.registered)


def test_an_option_of_another_method_is_refused():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    with scene.refused(
        "'arap' has no option k_s; it has cells, rotation_smoothing, smoothness, solid, constraints"
    ):
        bpy.ops.lissom.pose_bind(object=obj.name, k_s=2.0)
    with scene.refused("'multiresolution' has no option k_s; it has smoothing, details, base, border"):
        bpy.ops.lissom.pose_bind(object=obj.name, method="multiresolution", k_s=2.0)
    bpy.ops.lissom.pose_bind(object=obj.name, method="multiresolution", base="thin_shell", k_s=2.0)
    assert obj.lissom_pose.options.thin_shell.k_s == 2.0


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_weights_of_the_groups_make_the_edges_of_the_handles_soft(method):
    obj = scene.tube(rings=30, around=20)
    weight = lambda co: 1.0 if abs(co[2]) > 2.7 else 0.25  # noqa: E731
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.5)
        for vertex in obj.data.vertices:
            if side * vertex.co.z > 2.5:
                obj.vertex_groups[name].add([vertex.index], weight(vertex.co), "REPLACE")
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    shown = {}
    for use_weights in (False, True):
        bpy.ops.lissom.pose_bind(object=obj.name, method=method, use_weights=use_weights)
        assert obj.lissom_pose.use_weights == use_weights
        scene.empty(obj, "top").location.x += 1
        scene.empty(obj, "top").rotation_euler.y = 0.4
        bpy.context.view_layer.update()
        given = {"scale": False} if method == "laplacian_fitted" else {}
        membership = weight if use_weights else None
        expected = native(obj, poses.motion(obj).transforms, membership, method=method, **given)
        shown[use_weights] = scene.shown(obj)
        assert_allclose(shown[use_weights], expected, atol=2e-5)
        bpy.ops.lissom.pose_unbind(object=obj.name)
    assert np.abs(shown[True] - shown[False]).max() > 1e-3
    wholly = np.abs(scene.points(obj.data.vertices)[:, 2]) > 2.7
    assert_allclose(shown[True][wholly], shown[False][wholly], atol=1e-5)


def test_moving_the_object_does_not_pose_it():
    obj = scene.bound_tube()
    obj.matrix_world = TURN
    bpy.context.view_layer.update()
    assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis"), atol=1e-5)


def test_only_the_region_moves():
    obj = scene.tube()
    scene.group(obj, "region", lambda co: co.z > 0)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    obj.lissom_pose.roi = "region"
    obj.lissom_pose.handles["top"].turns_by_itself = False
    bpy.ops.lissom.pose_bind(object=obj.name)
    scene.empty(obj, "top").location.x += 1
    bpy.context.view_layer.update()
    rest, now = scene.key_points(obj, "Basis"), scene.shown(obj)
    assert_array_equal(now[rest[:, 2] <= 0], rest[rest[:, 2] <= 0])
    assert_allclose((now - rest)[rest[:, 2] > 2.5], [[1, 0, 0]] * 200, atol=1e-5)


def test_live_off_waits_for_update():
    obj = scene.bound_tube()
    obj.lissom_pose.live = False
    scene.empty(obj, "top").location.x += 1
    bpy.context.view_layer.update()
    assert_array_equal(scene.key_points(obj, PREVIEW), scene.key_points(obj, "Basis"))
    assert bpy.ops.lissom.pose_update(object=obj.name) == {"FINISHED"}
    assert scene.shown(obj)[-1, 0] == pytest.approx(scene.key_points(obj, "Basis")[-1, 0] + 1, abs=1e-5)


def test_an_animated_empty_poses_every_frame():
    obj = scene.bound_tube()
    top = scene.empty(obj, "top")
    top.keyframe_insert("location", frame=1)
    top.location.z += 2
    top.keyframe_insert("location", frame=11)
    for frame, rise in ((11, 2.0), (1, 0.0), (11, 2.0)):
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        assert scene.shown(obj)[-1, 2] == pytest.approx(3 + rise, abs=1e-5)


def test_an_update_solves_once_and_none_where_nothing_moved(monkeypatch):
    obj = scene.bound_tube()
    solved = []
    bound = session.poses[obj.session_uid]
    monkeypatch.setattr(bound, "steps", lambda *a, **k: solved.append(1) or type(bound).steps(bound, *a, **k))
    scene.empty(obj, "top").location.x += 1
    for _ in range(3):
        bpy.context.view_layer.update()
    obj.location.x += 1
    bpy.context.view_layer.update()
    assert len(solved) == 1


def test_a_solve_within_a_budget_goes_on_until_it_has_converged():
    obj = scene.bound_tube()
    obj.lissom_pose.live = False
    scene.empty(obj, "top").location.x += 1
    bpy.context.view_layer.update()
    obj.lissom_pose.live = True
    rounds = 1
    while follow(obj, 1e-9):  # a few iterations at a time
        rounds += 1
        assert rounds < 500
    assert rounds > 3
    stepwise = scene.key_points(obj, PREVIEW)
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(scene.key_points(obj, PREVIEW), stepwise, atol=5e-3)
    bound = session.poses[obj.session_uid]
    here = bound._motion
    there = here._replace(transforms=here.transforms + 0.1)
    assert [bound.iterations_within(1e-9, motion) for motion in (here, there)] == [4, 1]
    assert bound.iterations_within(10.0, there) > 10


def test_apply_keeps_what_is_seen_as_a_key_and_puts_the_handles_back():
    obj = scene.bound_tube()
    place = scene.empty(obj, "top").matrix_world.copy()
    move_all(obj, TURN)
    seen = scene.shown(obj)
    assert bpy.ops.lissom.pose_apply(object=obj.name, name="Turned") == {"FINISHED"}
    key = obj.data.shape_keys.key_blocks["Turned"]
    assert (key.value, key.slider_min, key.slider_max, key.mute) == (1, 0, 1, False)
    assert_allclose(scene.points(key.data), seen, atol=1e-5)
    bpy.context.view_layer.update()
    assert_allclose(scene.shown(obj), seen, atol=1e-5)
    assert_allclose(scene.empty(obj, "top").matrix_world, place, atol=1e-6)
    assert_array_equal(scene.key_points(obj, PREVIEW), scene.key_points(obj, "Basis"))


@pytest.mark.parametrize(
    ("exists", "names"), [("UPDATE", ["Basis", PREVIEW, "K"]), ("RENAME", ["Basis", PREVIEW, "K", "K.001"])]
)
def test_row_32_a_key_of_that_name_exists(exists, names):
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_apply(object=obj.name, name="K")
    scene.empty(obj, "top").location.x += 1
    bpy.ops.lissom.pose_apply(object=obj.name, name="K", exists=exists, reset=False)
    assert obj.data.shape_keys.key_blocks.keys() == names
    assert scene.key_points(obj, names[-1])[-1, 0] == pytest.approx(1 + np.cos(2 * np.pi * 39 / 40), abs=1e-2)


def test_row_32_skip_refuses_to_overwrite():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_apply(object=obj.name, name="K")
    with scene.refused("If Exists is Skip"):
        bpy.ops.lissom.pose_apply(object=obj.name, name="K", exists="SKIP")
    with scene.refused("builds on"):
        bpy.ops.lissom.pose_apply(object=obj.name, name=PREVIEW, exists="UPDATE")


def test_reset_and_unbind_leave_the_mesh_as_it_was():
    obj = scene.bound_tube()
    rest = scene.points(obj.data.vertices)
    places = [handle.empty.matrix_world.copy() for handle in obj.lissom_pose.handles]
    move_all(obj, TURN)
    bpy.ops.lissom.pose_reset(object=obj.name)
    assert_array_equal(scene.shown(obj), rest)
    move_all(obj, TURN)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.context.view_layer.update()
    assert obj.data.shape_keys is None
    assert_array_equal(scene.points(obj.data.vertices), rest)
    for handle, place in zip(obj.lissom_pose.handles, places, strict=True):
        assert_allclose(handle.empty.matrix_world, place, atol=1e-6)
    bpy.ops.lissom.pose_bind(object=obj.name)


@pytest.mark.parametrize("chosen", [0, 1, 2])
def test_bind_and_unbind_leave_the_chosen_key_chosen(chosen):
    obj = scene.tube(rings=12, around=8)
    for number in range(2):
        scene.add_key(obj, f"key {number}", scene.points(obj.data.vertices))
    obj.active_shape_key_index = chosen
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert obj.active_shape_key_index == chosen


@pytest.mark.parametrize("seed", range(6))
def test_bind_apply_and_unbind_leave_other_keys_as_they_were(seed):
    draw = np.random.default_rng(seed)
    obj = scene.tube(rings=12, around=8)
    rest = scene.points(obj.data.vertices)
    for number in range(4):
        key = scene.add_key(obj, f"key {number}", rest + draw.normal(size=3), slider_min=-1, slider_max=2)
        key.value, key.mute = draw.uniform(-1, 2), bool(draw.integers(2))
    keys = obj.data.shape_keys.key_blocks
    keys["key 3"].relative_key = keys["key 1"]
    obj.active_shape_key_index = int(draw.integers(len(keys)))

    def state():
        made = (PREVIEW, "Mine")
        rows = [row for row in scene.snapshot()["Tube"][4] if row[0] not in made]
        return obj.active_shape_key.name, rows

    before, seen = state(), scene.shown(obj)
    for name, sign in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, sign=sign: sign * co.z > 2.5)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    for _ in range(2):
        bpy.ops.lissom.pose_bind(object=obj.name)
        assert state() == before
        assert_allclose(scene.shown(obj), seen, atol=1e-6)
        scene.empty(obj, "top").location += Vector(draw.normal(size=3))
        bpy.context.view_layer.update()
        bpy.ops.lissom.pose_apply(object=obj.name, name="Mine", exists="UPDATE")
        assert state() == before
        keys["Mine"].value = 0.0
        bpy.ops.lissom.pose_unbind(object=obj.name)
        bpy.context.view_layer.update()
        assert state() == before
        assert_allclose(scene.shown(obj), seen, atol=1e-6)


@pytest.mark.parametrize("mute", [False, True])
def test_what_the_artist_muted_of_a_baked_motion_stays_muted(mute):
    obj = scene.bound_tube(rings=12, around=8)
    bpy.context.scene.frame_end = 2
    bpy.ops.lissom.pose_bake(object=obj.name)
    keys = obj.data.shape_keys.key_blocks
    keys[-1].mute = mute
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert keys[1].mute and keys[2].mute
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert (keys[1].mute, keys[2].mute) == (False, mute)


@pytest.mark.parametrize("hidden", [(False, False), (True, False), (False, True)])
def test_a_cache_that_the_artist_hid_stays_hidden_until_it_is_baked_again(hidden, tmp_path):
    obj = scene.bound_tube(rings=12, around=8)
    bpy.context.scene.frame_end = 2
    cache = {"object": obj.name, "output": "CACHE", "filepath": str(tmp_path / "motion.pc2")}
    bpy.ops.lissom.pose_bake(**cache)
    modifier = obj.modifiers[0]
    modifier.show_viewport, modifier.show_render = (not one for one in hidden)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert not modifier.show_viewport and not modifier.show_render
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert (not modifier.show_viewport, not modifier.show_render) == hidden
    bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_bake(**cache)
    assert obj.modifiers[0].show_viewport and obj.modifiers[0].show_render


def test_unbind_keeps_applied_poses_and_other_keys():
    obj = scene.tube()
    scene.add_key(obj, "Other", scene.points(obj.data.vertices))
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_apply(object=obj.name, name="Mine")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Other", "Mine"]


def test_saved_and_opened_again_the_handles_still_pose(tmp_path):
    obj = scene.bound_tube()
    move_all(obj, TURN)
    before = scene.shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not session.poses
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    obj = bpy.data.objects["Tube"]
    assert_allclose(scene.shown(obj), before, atol=1e-6)
    move_all(obj, TURN.inverted())
    assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis"), atol=2e-5)
    bpy.ops.lissom.pose_unbind(object=obj.name)


def test_after_undo_the_next_move_solves_from_the_handles_of_then():
    """Undo itself needs a window (tests/blender/window.py); here its handler runs on what undo leaves."""
    obj = scene.bound_tube()
    move_all(obj, TURN)
    key = obj.data.shape_keys.key_blocks[PREVIEW]
    key.data.foreach_set("co", scene.key_points(obj, "Basis").ravel())  # a mesh of the past
    live._on_history()
    obj.location.x += 1  # any update, with no handle moved
    bpy.context.view_layer.update()
    assert_allclose(scene.key_points(obj, PREVIEW), moved(TURN, scene.key_points(obj, "Basis")), atol=2e-5)


def test_a_rest_shape_that_was_edited_is_bound_anew():
    obj = scene.bound_tube()
    basis = obj.data.shape_keys.reference_key
    rest = scene.points(basis.data) * [2, 1, 1]
    basis.data.foreach_set("co", rest.ravel())
    move_all(obj, TURN)
    assert_allclose(scene.key_points(obj, PREVIEW), moved(TURN, rest), atol=5e-5)


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_handle_is_made_of_the_selected_vertices(mode):
    obj = scene.tube()
    scene.select(obj, [vertex.index for vertex in obj.data.vertices if vertex.co.z > 2.5], mode)
    bpy.ops.lissom.pose_handle_add(object=obj.name)
    bpy.ops.lissom.pose_region_from_selection(object=obj.name, name="R")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert [handle.name for handle in obj.lissom_pose.handles] == ["Handle"]
    assert obj.lissom_pose.roi == "R"
    assert_allclose(scene.empty(obj, "Handle").matrix_basis.translation, [0, 0, 2.8], atol=1e-5)
    bpy.ops.lissom.pose_bind(object=obj.name)


def test_an_active_handle_stands_for_its_mesh():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_handle_select(object=obj.name, handle="top")
    assert bpy.context.object == scene.empty(obj, "top")
    bpy.ops.lissom.pose_apply(name="K")
    assert "K" in obj.data.shape_keys.key_blocks


def test_a_handle_goes_with_its_empty():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    name = scene.empty(obj, "top").name
    bpy.ops.lissom.pose_handle_remove(object=obj.name, handle="top")
    assert name not in bpy.data.objects
    assert [handle.name for handle in obj.lissom_pose.handles] == ["bottom"]
    assert "top" in obj.vertex_groups


# Bad input


def test_row_1_a_mesh_without_faces():
    mesh = bpy.data.meshes.new("Edges")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 3)], [(0, 1)], [])
    obj = bpy.data.objects.new("Edges", mesh)
    bpy.context.collection.objects.link(obj)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    with scene.refused("face"):
        bpy.ops.lissom.pose_bind(object=obj.name)


def test_row_2_a_vertex_that_is_not_finite():
    obj = scene.tube()
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    obj.data.vertices[7].co.x = float("nan")
    with scene.refused("not a finite number: 1 (7)"):
        bpy.ops.lissom.pose_bind(object=obj.name)


def test_row_19_no_handle_and_an_empty_group():
    obj = scene.tube()
    with scene.refused("There is no handle"):
        bpy.ops.lissom.pose_bind(object=obj.name)
    obj.vertex_groups.new(name="none")
    with scene.refused("'none' holds no vertices"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="none")


def test_row_23_handles_that_share_vertices_are_named():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    obj.vertex_groups["top"].add([17], 1.0, "REPLACE")
    with scene.refused("'bottom' and 'top' share vertices 17"):
        bpy.ops.lissom.pose_bind(object=obj.name)


def test_row_25_a_vertex_group_that_was_renamed_is_named():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    obj.vertex_groups["top"].name = "head"
    with scene.refused("Vertex group 'top' is missing"):
        bpy.ops.lissom.pose_bind(object=obj.name)
    with scene.refused("no vertex group named 'tail'"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="tail")


def test_row_26_faces_changed_since_bind_with_equal_counts():
    obj = scene.bound_tube()
    reverse_a_face(obj)
    scene.empty(obj, "top").location.x += 1
    bpy.context.view_layer.update()
    assert "remodelled since Bind" in session.status[obj.session_uid][1]
    for operator in (bpy.ops.lissom.pose_update, bpy.ops.lissom.pose_apply, bpy.ops.lissom.pose_reset):
        with scene.refused("was remodelled since Bind: press Unbind, then Bind"):
            operator(object=obj.name)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.ops.lissom.pose_bind(object=obj.name)


def test_row_34_edit_mode_absolute_keys_and_locked_keys():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_apply(object=obj.name, name="K")
    obj.data.shape_keys.key_blocks["K"].lock_shape = True
    with scene.refused("Shape key 'K' is locked"):
        bpy.ops.lissom.pose_apply(object=obj.name, name="K", exists="UPDATE")
    bpy.ops.object.mode_set(mode="EDIT")
    with scene.refused("is in edit mode: go to Object Mode first"):
        bpy.ops.lissom.pose_apply(object=obj.name, name="K")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.shape_keys.use_relative = False
    with scene.refused("turn on Relative"):
        bpy.ops.lissom.pose_update(object=obj.name)


@pytest.mark.parametrize("override", [False, True])
def test_row_34_linked_and_overridden_data(tmp_path, override):
    obj = scene.tube()
    scene.group(obj, "top", lambda co: co.z > 2.5)
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, into):
        into.objects = ["Tube"]
    obj = into.objects[0]
    if override:
        obj = obj.override_create()
    bpy.context.collection.objects.link(obj)
    with scene.refused("is a library override" if override else "is linked from another file"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    with bpy.context.temp_override(lissom_object=obj):  # as from the panel, whose button poll() disables
        with scene.refused("poll() Object 'Tube' is"):
            bpy.ops.lissom.pose_handle_add(vertex_group="top")
        with scene.refused("poll() Add a handle first"):
            bpy.ops.lissom.pose_bind()


def test_row_35_mesh_data_with_several_users_is_said(capfd):
    obj = scene.tube()
    scene.group(obj, "top", lambda co: co.z > 2.5)
    for _ in range(2):
        bpy.context.collection.objects.link(bpy.data.objects.new("Twin", obj.data))
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    assert bpy.ops.lissom.pose_bind(object=obj.name) == {"FINISHED"}
    assert "Warning: The mesh of 'Tube' is used by 3 objects" in capfd.readouterr().out


def rigged(obj):
    """An armature of one bone that moves all of the object; returns the pose bone."""
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    data.edit_bones.new("bone").tail = (0, 0.3, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    scene.group(obj, "bone", lambda co: True)
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    return rig.pose.bones["bone"]


@pytest.mark.parametrize(
    "seen", ["nothing", "key", "muted key", "rest", "pose", "constraint", "smooth", "hidden"]
)
def test_what_is_seen_and_not_posed_is_said_at_bind(seen, capfd):
    obj = scene.tube(rings=12, around=8)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    if "key" in seen:
        moved_key = scene.points(obj.data.vertices) + [1, 0, 0]
        scene.add_key(obj, "smile", moved_key, value=0.5, mute=seen == "muted key")
    if seen in ("rest", "pose", "constraint"):
        bone = rigged(obj)
        if seen == "pose":
            bone.location.x = 0.4
        if seen == "constraint":
            limit = bone.constraints.new("LIMIT_LOCATION")
            limit.use_min_x, limit.min_x = True, 0.3
    if seen in ("smooth", "hidden"):
        obj.modifiers.new("Smooth", "SMOOTH").show_viewport = seen == "smooth"
    bpy.context.view_layer.update()
    basis = scene.points(obj.data.vertices)
    moved_now = np.abs(scene.shown(obj) - basis).max() > 1e-6
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    assert bpy.ops.lissom.pose_bind(object=obj.name, stands=False) == {"FINISHED"}
    said = capfd.readouterr().out
    assert ("The pose starts from the Basis" in said) == moved_now
    assert ("The pose starts from the Basis" in obj.lissom_pose.warnings) == moved_now
    assert moved_now == (seen in ("key", "pose", "constraint", "smooth"))
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert "starts from the Basis" not in capfd.readouterr().out and obj.lissom_pose.stood == moved_now


@pytest.mark.parametrize("scale", [(1, 1, 0), (0, 0, 0)])
def test_row_36_a_scale_of_zero(scale):
    obj = scene.tube()
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    obj.scale = scale
    bpy.context.view_layer.update()
    with scene.refused("'Tube' is zero along an axis"):
        bpy.ops.lissom.pose_bind(object=obj.name)


@pytest.mark.parametrize(
    ("scale", "message"),
    [((1, 1, 0), "'Tube' is zero along an axis"), ((float("nan"), 1, 1), "'Tube' is not a finite number")],
)
def test_row_36_a_bad_scale_of_a_bound_object(scale, message, capfd):
    obj = scene.bound_tube()
    top = scene.empty(obj, "top")
    place = top.matrix_basis.copy()
    obj.scale = scale
    for _ in range(3):
        top.location.x += 0.5
        bpy.context.view_layer.update()
        assert message in session.status[obj.session_uid][1]
    assert "Traceback" not in capfd.readouterr().err
    for operator in ("update", "apply", "reset", "unbind"):
        with pytest.raises(RuntimeError, match=message) as caught:
            getattr(bpy.ops.lissom, f"pose_{operator}")(object=obj.name)
        assert "Traceback" not in str(caught.value)
    assert obj.lissom_pose.bound
    obj.scale = (1, 1, 1)
    bpy.context.view_layer.update()
    assert_allclose(scene.shown(obj)[-1] - scene.key_points(obj, "Basis")[-1], [1.5, 0, 0], atol=1e-5)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert_allclose(top.matrix_basis, place, atol=1e-6)


def test_an_empty_of_scale_zero_is_no_place_to_bind():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    scene.empty(obj, "top").scale.y = 0
    bpy.context.view_layer.update()
    with scene.refused("'Tube top' is zero along an axis"):
        bpy.ops.lissom.pose_bind(object=obj.name)


@pytest.mark.parametrize("value", [0.0, float("nan")])
def test_an_empty_that_is_scaled_to_nothing_makes_no_traceback(value, capfd):
    obj = scene.bound_tube()
    scene.empty(obj, "top").scale.y = value
    for _ in range(2):
        bpy.context.view_layer.update()
    assert "Traceback" not in capfd.readouterr().err
    assert np.isfinite(scene.key_points(obj, PREVIEW)).all()
    scene.empty(obj, "top").scale.y = 1
    scene.empty(obj, "top").location.x += 1
    bpy.context.view_layer.update()
    assert scene.shown(obj)[-1, 0] == pytest.approx(scene.key_points(obj, "Basis")[-1, 0] + 1, abs=1e-5)


def test_a_bug_in_live_is_told_once(monkeypatch):
    obj = scene.bound_tube()
    monkeypatch.setattr(poses, "motion", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        follow(obj)
    assert not obj.lissom_pose.live
    assert "Live is off after an error: division by zero" in session.status[obj.session_uid][1]
    assert not follow(obj)


def duplicate(obj, linked):
    """What Shift-D or Alt-D makes of the object alone."""
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.duplicate(linked=linked)
    assert bpy.context.object != obj
    return bpy.context.object


@pytest.mark.parametrize("linked", [False, True])
def test_a_copy_leaves_the_handles_of_the_original_alone(linked):
    obj = scene.bound_tube()
    move_all(obj, TURN)
    copy = duplicate(obj, linked)
    bpy.context.view_layer.update()
    seen = scene.shown(obj)
    for operator in ("update", "apply", "reset"):
        with scene.refused("belongs to 'Tube', of which 'Tube.001' is a copy: press Unbind"):
            getattr(bpy.ops.lissom, f"pose_{operator}")(object=copy.name)
    before = scene.snapshot()
    bpy.ops.lissom.pose_unbind(object=copy.name)
    bpy.context.view_layer.update()
    after = scene.snapshot()
    assert {name: after[name] for name in before if name != copy.name} == {
        name: before[name] for name in before if name != copy.name
    }
    assert_array_equal(scene.shown(obj), seen)
    assert not copy.lissom_pose.bound
    assert not len(copy.lissom_pose.handles)
    assert (copy.data.shape_keys is None) != linked
    bpy.ops.lissom.pose_handle_add(object=copy.name, vertex_group="top")
    bpy.ops.lissom.pose_bind(object=copy.name)
    scene.empty(copy, "top").location.x += 1
    bpy.context.view_layer.update()
    assert copy.data.shape_keys.key_blocks[copy.lissom_pose.preview].data[-1].co.x > 1.9
    assert_allclose(scene.key_points(obj, PREVIEW), seen, atol=1e-6)


def test_an_original_is_unbound_whatever_its_linked_copy_says():
    obj = scene.bound_tube()
    duplicate(obj, linked=True)
    bpy.ops.lissom.pose_unbind(object="Tube")
    assert obj.data.shape_keys is None
    bpy.ops.lissom.pose_unbind(object="Tube.001")


def test_a_copy_of_mesh_and_empties_together_is_bound_by_itself():
    obj = scene.bound_tube()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.duplicate()
    copy = bpy.data.objects["Tube.001"]
    move_all(copy, TURN)
    assert_allclose(scene.shown(copy), moved(TURN, scene.key_points(copy, "Basis")), atol=2e-5)
    assert_array_equal(scene.key_points(obj, PREVIEW), scene.key_points(obj, "Basis"))


def test_a_deleted_empty_is_named():
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_handle_select(object=obj.name, handle="top")
    bpy.ops.object.delete()
    with scene.refused("Empty of handle 'top' was deleted"):
        bpy.ops.lissom.pose_apply(object=obj.name)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    with scene.refused("Empty of handle 'top' was deleted"):
        bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_handle_remove(object=obj.name, handle="top")
    bpy.ops.lissom.pose_bind(object=obj.name)


def test_a_deleted_mesh_object_does_no_harm_to_its_empties():
    obj = scene.bound_tube()
    top = scene.empty(obj, "top")
    bpy.data.objects.remove(obj)
    top.location.x += 1
    bpy.context.view_layer.update()


def test_wrong_objects_are_refused():
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.collection.objects.link(camera)
    with scene.refused("no object named 'Nobody'"):
        bpy.ops.lissom.pose_bind(object="Nobody")
    with scene.refused("'Camera' is no mesh"):
        bpy.ops.lissom.pose_bind(object="Camera")
    with scene.refused("Select a mesh object first"):
        bpy.ops.lissom.pose_bind()


def test_binding_twice_and_changing_bound_handles_is_refused():
    obj = scene.bound_tube()
    with scene.refused("is bound already"):
        bpy.ops.lissom.pose_bind(object=obj.name)
    with scene.refused("is bound: press Unbind first"):
        bpy.ops.lissom.pose_handle_remove(object=obj.name, handle="top")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    for operator in (bpy.ops.lissom.pose_unbind, bpy.ops.lissom.pose_apply, bpy.ops.lissom.pose_reset):
        with scene.refused("is not bound"):
            operator(object=obj.name)
