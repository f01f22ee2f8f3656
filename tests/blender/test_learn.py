"""Learn from Corrections: keys that were edited since a transfer teach the others."""

import json

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands, session
from bl_ext.user_default.lissom.bridge.written import Written
from bl_ext.user_default.lissom.jobs.learn import Learn, LearnAsked
from numpy.testing import assert_allclose, assert_array_equal
from test_panels import draw
from test_transfer import deltas

WAYS = {"up": (0, 0, 0.1), "out": (0, -0.05, 0.08), "aside": (0.04, 0, 0.1), "all": (0.02, -0.03, 0.1)}
TAUGHT = ("up", "out", "aside")


def mouth():
    """A monkey whose mouth is moved by four keys, as a transfer has written them, and a key of another's."""
    obj = scene.monkey(levels=2)
    rest = scene.points(obj.data.vertices)
    near = np.clip(1 - ((rest - [0, -0.6, -0.6]) ** 2).sum(axis=1) / 0.5, 0, None)[:, None] ** 2
    for name, way in WAYS.items():
        scene.add_key(obj, name, rest + near * way)
    scene.add_key(obj, "own", rest + near * (0.1, 0.1, 0))
    written = Written(obj)
    for name in WAYS:
        written.remember(name)
    bpy.context.scene.lissom_transfer.target = obj
    return obj


def correct(obj, names=TAUGHT, by=1.3):
    """Makes keys so many times as strong, by hand."""
    rest = scene.points(obj.data.vertices)
    for name in names:
        for row, place, offset in zip(
            obj.data.shape_keys.key_blocks[name].data, rest, deltas(obj, name), strict=True
        ):
            row.co = place + by * offset


def test_corrected_keys_teach_the_others_and_stay_to_the_bit(capfd):
    obj = mouth()
    plain = deltas(obj, "all")
    correct(obj)
    before = {name: scene.key_points(obj, name) for name in (*TAUGHT, "own")}
    bpy.ops.lissom.learn()
    for name, shape in before.items():
        assert_array_equal(scene.key_points(obj, name), shape)
    found = deltas(obj, "all")
    grown = (found * plain).sum() / (plain**2).sum()
    assert 1.2 < grown < 1.31
    assert_array_equal(found[~plain.any(axis=1)], 0)
    said = capfd.readouterr().out
    assert "Learned from 'up', 'out', 'aside': 1 key changed on 'Monkey'" in said


def test_what_was_learned_is_no_correction_and_is_learned_anew():
    obj = mouth()
    plain = deltas(obj, "all")
    correct(obj)
    bpy.ops.lissom.learn()
    once = deltas(obj, "all")
    assert Written(obj).state("all") == "WRITTEN"
    bpy.ops.lissom.learn()
    assert_allclose(deltas(obj, "all"), once, atol=1e-6)
    bpy.ops.lissom.learn(strength=0.5)
    assert_allclose(deltas(obj, "all"), (plain + once) / 2, atol=1e-6)
    bpy.ops.lissom.learn(strength=0.0)
    assert_allclose(deltas(obj, "all"), plain, atol=1e-6)
    correct(obj, ["all"], 2.0)
    assert Written(obj).state("all") == "EDITED"
    assert_allclose(Written(obj).transferred("all"), plain, atol=1e-6)


def test_a_preview_shows_key_after_key_and_leaves_nothing_behind():
    obj = mouth()
    correct(obj)
    obj.active_shape_key_index = 2
    before = scene.snapshot()
    settings = bpy.context.scene.lissom_transfer
    bpy.ops.lissom.learn(preview=True)
    assert [row.name for row in settings.learned] == ["all", *TAUGHT]
    assert settings.learned["all"].change == pytest.approx(0.3, abs=0.08)
    assert [row.corrected for row in settings.learned] == [False, True, True, True]
    assert min(settings.learned[name].foretold for name in TAUGHT) > 0
    shown = scene.shown(obj) - scene.points(obj.data.vertices)
    assert np.linalg.norm(shown) > 1.15 * np.linalg.norm(deltas(obj, "all"))
    settings.active_learned = 1
    assert_allclose(scene.shown(obj), scene.key_points(obj, "up"), atol=1e-6)
    bpy.ops.lissom.learn_stop()
    assert scene.snapshot() == before and obj.active_shape_key_index == 2
    assert not obj.show_only_shape_key and session.learned is None
    with scene.refused("There is no preview"):
        bpy.ops.lissom.learn_stop()
    bpy.ops.lissom.learn(preview=True)
    bpy.ops.lissom.learn()
    assert "Learned Preview" not in obj.data.shape_keys.key_blocks


def test_keys_that_are_right_teach_too_and_locked_ones_are_left(capfd):
    obj = mouth()
    correct(obj, ["up"])
    done = learned(obj, right="out\naside\nall")
    assert not done.written and set(done.foretold) == set(WAYS)
    correct(obj, ["out", "aside"])
    obj.data.shape_keys.key_blocks["all"].lock_shape = True
    before = scene.key_points(obj, "all")
    bpy.ops.lissom.learn()
    assert_array_equal(scene.key_points(obj, "all"), before)
    assert "Locked, and left as they are: 'all'" in capfd.readouterr().out


def learned(obj, **asked):
    job = Learn(bpy.context, LearnAsked(object=obj.name, **asked))
    return job.write(bpy.context, job.work.wait())


def test_what_cannot_be_learned_from_is_refused():
    obj = mouth()
    with scene.refused("No key of 'Monkey' was edited since it was transferred: correct some first"):
        bpy.ops.lissom.learn()
    with scene.refused("No transfer has written the key 'own'"):
        bpy.ops.lissom.learn(right="own")
    obj.data.shape_keys.lissom_written.clear()
    with scene.refused("No transfer has written keys of 'Monkey'"):
        bpy.ops.lissom.learn()


def test_the_panel_offers_it_once_a_key_was_corrected(monkeypatch):
    obj = mouth()
    settings = bpy.context.scene.lissom_transfer
    settings.source = scene.tube(name="Source")
    settings.learn_strength = 0.75
    assert "lissom.learn" not in draw(bpy.types.LISSOM_PT_transfer)["operators"]
    correct(obj)
    bpy.context.view_layer.update()
    session.edited.clear()
    made = draw(bpy.types.LISSOM_PT_transfer)["operators"]
    assert [row["preview"] for row in made["lissom.learn"]] == [True, False]
    assert {row["strength"] for row in made["lissom.learn"]} == {0.75}


def test_the_command_learns(tmp_path, capsys):
    obj = mouth()
    plain = deltas(obj, "all")
    correct(obj)
    paths = {
        name: tmp_path / f"{name}.{end}" for name, end in (("in", "blend"), ("out", "blend"), ("say", "json"))
    }
    bpy.ops.wm.save_as_mainfile(filepath=str(paths["in"]))
    words = [
        "learn",
        "--file",
        paths["in"],
        "--target",
        "Monkey",
        "--out",
        paths["out"],
        "--report",
        paths["say"],
    ]
    assert commands.main(list(map(str, words))) == 0
    report = json.loads(paths["say"].read_text())
    assert report["written"] == ["all"] and set(report["foretold"]) == set(TAUGHT)
    assert report["errors"] == [] and report["seconds"] > 0 and "warnings" in report
    bpy.ops.wm.open_mainfile(filepath=str(paths["out"]))
    assert np.linalg.norm(deltas(bpy.data.objects["Monkey"], "all")) > 1.2 * np.linalg.norm(plain)
    assert commands.main([*map(str, words[:5]), "--strength", "3"]) == 2
    assert "--strength" in capsys.readouterr().out
