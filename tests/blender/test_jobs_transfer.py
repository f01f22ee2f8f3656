"""The use cases of a transfer as plain objects: what they return is what they have written."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.jobs.attributes import AttributesAsked, TransferAttributes
from bl_ext.user_default.lissom.jobs.fit import Fit, FitAsked
from bl_ext.user_default.lissom.jobs.transfer_keys import KeysAsked, TransferKeys
from bl_ext.user_default.lissom.jobs.transfer_pose import (
    AnimationAsked,
    PoseAsked,
    TransferAnimation,
    TransferPose,
)
from numpy.testing import assert_array_equal
from test_panels import draw, text
from test_transfer import deltas, monkeys


def run(job):
    return job.write(bpy.context, job.work.wait())


def test_a_fit_is_returned_and_remembered():
    monkeys()
    done = run(Fit(bpy.context, FitAsked()))
    assert done.fit is session.fit and done.summary == session.fit.summary
    assert done.doubtful_markers == [] and done.warnings == []


def test_keys_are_returned_by_object_with_their_quality():
    _, target = monkeys()
    done = run(TransferKeys(bpy.context, KeysAsked(keys=("ears", "squash"))))
    assert done.written == {"Target": ["ears", "squash"]}
    assert {row["name"] for row in done.quality} == {"ears", "squash"}
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "ears", "squash"]
    assert done.summary == "2 shape keys on 'Target'"


def test_arcs_to_keys_that_became_others_are_said_to_be_out_of_date():
    source, _ = monkeys()
    once = run(TransferKeys(bpy.context, KeysAsked()))
    bpy.ops.lissom.inbetween_bake(object="Target", end="squash", count=2, slider="low")
    again = run(TransferKeys(bpy.context, KeysAsked()))
    squash = source.data.shape_keys.key_blocks["squash"]
    squash.data.foreach_set("co", (scene.key_points(source, "Basis") * np.float32([1.2, 1, 0.7])).ravel())
    changed = run(TransferKeys(bpy.context, KeysAsked()))
    said = "Arcs on 'Target' are out of date, bake them again: 'low'"
    assert [said in done.warnings for done in (once, again, changed)] == [False, False, True]


def test_a_job_does_what_its_operator_does():
    _, target = monkeys()
    bpy.ops.lissom.transfer_keys(scale="source", match_distance=0.03)
    expected = {name: deltas(target, name) for name in ("squash", "ears")}
    target.shape_key_clear()
    run(TransferKeys(bpy.context, KeysAsked(scale="source", match_distance=0.03)))
    for name, delta in expected.items():
        assert_array_equal(deltas(target, name), delta)


def test_a_pose_and_an_animation_say_what_they_made(tmp_path):
    source, target = monkeys()
    source.data.shape_keys.key_blocks["squash"].value = 1.0
    done = run(TransferPose(bpy.context, PoseAsked(name="Now")))
    assert done.written == {"Target": "Now"} and deltas(target, "Now").any()
    path = str(tmp_path / "cache.pc2")
    done = run(TransferAnimation(bpy.context, AnimationAsked(frames=[1, 2], cache_path=path)))
    assert done.frames == [1, 2] and done.caches == [target.modifiers[0].filepath]
    done = run(TransferAnimation(bpy.context, AnimationAsked(frames=[1, 2], keys=("a", "b"))))
    assert done.caches == [] and {"a", "b"} <= set(target.data.shape_keys.key_blocks.keys())


def test_attributes_are_named():
    source, target = monkeys()
    scene.group(source, "left", lambda co: co.x > 0)
    done = run(TransferAttributes(bpy.context, AttributesAsked(uv_maps=False, colours=False)))
    assert done.written == ["left"] == target.vertex_groups.keys()


@pytest.mark.parametrize("asked", [KeysAsked(target="Nobody"), KeysAsked(keys=("gone",))])
def test_what_cannot_be_done_is_refused_before_any_work(asked):
    monkeys()
    before = scene.snapshot()
    with pytest.raises(Refused):
        TransferKeys(bpy.context, asked)
    assert scene.snapshot() == before


def test_warnings_stay_with_the_source_and_the_target_that_they_are_about():
    source, target = monkeys()
    other = scene.monkey(1, "Other")
    settings, panel = bpy.context.scene.lissom_transfer, bpy.types.LISSOM_PT_transfer
    target.data.shape_keys or target.shape_key_add(name="Basis")
    scene.add_key(target, "ears", scene.points(target.data.vertices)).lock_shape = True
    bpy.ops.lissom.transfer_keys()
    (said,) = [line for line in settings.warnings.splitlines() if "locked" in line.lower()]
    assert said in text(draw(panel))
    settings.target = other
    assert settings.told == "" and said not in text(draw(panel))
    settings.target = target
    assert said in settings.told
    bpy.ops.lissom.transfer_sides(swap=True)
    assert settings.source == target and settings.told == ""
    bpy.ops.lissom.transfer_sides(swap=True)
    bpy.ops.lissom.warning_dismiss(page="TRANSFER")
    assert settings.told == "" and (settings.source, settings.target) == (source, target)


def test_what_is_asked_has_the_precision_of_properties():
    assert FitAsked(match_distance=0.1).match_distance == float(np.float32(0.1))
