"""The use cases of a pose and of arcs as plain objects, without an operator or a window."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.core.inbetween import ArcAsked
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.jobs import arcs, handles, pose
from bl_ext.user_default.lissom.jobs.bake import Bake, BakeAll, again, to_many
from bl_ext.user_default.lissom.jobs.drive import DriveAsked, drive
from bl_ext.user_default.lissom.jobs.pose_bake import BakeAsked, BakePose
from numpy.testing import assert_array_equal
from test_inbetween import keyed_tube
from test_pose_stands import arm


def run(job):
    return job.write(bpy.context, job.work.wait())


def handled():
    """A tube with handles at both ends, unbound."""
    obj = scene.bound_tube(rings=12, around=8)
    pose.unbind(bpy.context, obj.name)
    return obj


def test_bind_solve_apply_and_unbind_return_what_they_did():
    obj = handled()
    done = run(pose.Bind(bpy.context, pose.bind_asked(obj)))
    assert done.object == "Tube" and obj.lissom_pose.bound
    assert obj.lissom_pose.warnings.splitlines() == done.warnings
    obj.lissom_pose.live = False
    scene.empty(obj, "top").location.x += 0.5
    done = run(pose.Solve(bpy.context, pose.SolveAsked(object="Tube")))
    assert done.summary == "'Tube' is solved" and session.status[obj.session_uid][0] == "CHECKMARK"
    shown = scene.shown(obj)
    done = run(pose.Apply(bpy.context, pose.ApplyAsked(object="Tube", name="Bent")))
    assert done.written == {"Tube": "Bent"}
    assert np.abs(scene.key_points(obj, "Bent") - shown).max() < 1e-4
    pose.unbind(bpy.context, "Tube")
    assert not obj.lissom_pose.bound and obj.lissom_pose.warnings == ""
    with pytest.raises(Refused, match="is not bound"):
        pose.unbind(bpy.context, "Tube")


def test_a_solve_that_does_not_converge_says_so_until_one_does():
    obj = handled()
    run(pose.Bind(bpy.context, pose.bind_asked(obj)))
    obj.lissom_pose.live = False
    scene.empty(obj, "top").rotation_euler.x = 1.5
    done = run(pose.Solve(bpy.context, pose.SolveAsked(object="Tube", max_iterations=1)))
    assert done.warnings[-1] == "Not converged after 1 iterations: raise Iterations"
    assert session.status[obj.session_uid] == ("ERROR", done.warnings[-1])
    run(pose.Solve(bpy.context, pose.SolveAsked(object="Tube")))
    assert session.status[obj.session_uid][0] == "CHECKMARK"


def test_what_bind_has_to_say_stays_in_the_panel_until_it_is_dismissed():
    obj = handled()
    scene.add_key(obj, "smile", scene.points(obj.data.vertices) + [1, 0, 0], value=0.5)
    bpy.ops.lissom.pose_bind(object="Tube", stands=False)
    assert "The pose starts from the Basis" in obj.lissom_pose.warnings
    scene.empty(obj, "top").location.x += 0.5
    bpy.context.view_layer.update()
    assert session.status[obj.session_uid][1].startswith("Solved")
    assert "The pose starts from the Basis" in obj.lissom_pose.warnings
    with scene.refused("There is no line 9"):
        bpy.ops.lissom.warning_dismiss(page="POSE", object="Tube", line=9)
    bpy.ops.lissom.warning_dismiss(page="POSE", object="Tube", line=0)
    assert "The pose starts from the Basis" not in obj.lissom_pose.warnings


def test_a_baked_pose_tells_its_keys():
    obj = handled()
    run(pose.Bind(bpy.context, pose.bind_asked(obj)))
    done = run(BakePose(bpy.context, BakeAsked(object="Tube", frames=[1, 3])))
    assert done.keys == ["Pose 0001", "Pose 0003"] and done.restless == []
    assert set(done.keys) < set(obj.data.shape_keys.key_blocks.keys()) and not obj.lissom_pose.bound


def test_an_arc_is_what_its_operator_bakes():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=2)
    names = [key.name for key in obj.lissom_inbetween.arcs["full arc"].keys]
    expected = [scene.key_points(obj, name) for name in names]
    done = run(Bake(bpy.context, again(bpy.context, "Tube", "full arc")))
    assert (done.slider, [name for name, _ in done.keys]) == ("full arc", names)
    for name, shape in zip(names, expected, strict=True):
        assert_array_equal(scene.key_points(obj, name), shape)
    arcs.rename(obj, "full arc", "opens")
    assert obj.lissom_inbetween.arcs.keys() == ["opens"]
    arcs.remove(obj, "opens")
    assert not obj.lissom_inbetween.arcs


def test_many_arcs_are_told_one_by_one():
    obj = keyed_tube()
    done = run(BakeAll(bpy.context, to_many(bpy.context, ArcAsked(object="Tube", count=1), [])))
    assert [one.slider for one in done.arcs] == ["half arc", "full arc"] == obj.lissom_inbetween.arcs.keys()
    assert done.summary == f"{sum(len(one.keys) for one in done.arcs)} shape keys under 2 sliders"


def test_handles_are_added_removed_and_refused_without_an_operator():
    obj = scene.tube()
    for name in ("bottom", "top"):
        scene.group(obj, name, lambda co, up=name == "top": (co.z > 2.5) == up and abs(co.z) > 2.5)
        assert handles.add(bpy.context, "Tube", name).name == name
    with pytest.raises(Refused, match="'top' is a handle already"):
        handles.add(bpy.context, "Tube", "top")
    handles.remove(bpy.context, "Tube", "bottom")
    assert obj.lissom_pose.handles.keys() == ["top"] and obj.vertex_groups.keys() == ["bottom", "top"]
    assert [other for other in bpy.data.objects if other.type == "EMPTY"] == [scene.empty(obj, "top")]
    with pytest.raises(Refused, match="has no handle 'bottom'"):
        handles.remove(bpy.context, "Tube", "bottom")


def test_driving_says_what_drives_what():
    obj, rig = arm(degrees=60.0)
    scene.add_key(obj, "a", scene.points(obj.data.vertices))
    done = drive(bpy.context, DriveAsked(object=obj.name, key="a"))
    assert (done.key, done.armature, done.bone) == ("a", rig.name, "upper")
    assert done.summary == "'a' follows the swing of bone 'upper'"
