"""Shape keys mirrored, summed and split into left and right."""

import bpy
import numpy as np
import pytest
import scene
from numpy.testing import assert_allclose
from test_menus import drawn_into
from test_transfer import deltas, monkeys


def suzanne():
    """A monkey with a key that moves its left ear and one that moves all of its front."""
    obj = scene.monkey(levels=1)
    rest = scene.points(obj.data.vertices)
    ear = np.exp(-3 * ((rest - [1.2, 0, 0.3]) ** 2).sum(axis=1))[:, None] * [0.1, 0.05, 0.2]
    front = np.clip(-rest[:, 1], 0, None)[:, None] * [0.02, -0.1, 0.1]
    scene.add_key(obj, "earLeft", rest + ear, value=0.5, slider_max=2.0)
    scene.add_key(obj, "front", rest + front, value=0.25)
    obj.active_shape_key_index = 1
    return obj


def test_the_active_key_is_mirrored_to_the_other_side_and_back():
    obj = suzanne()
    before = deltas(obj, "earLeft")
    bpy.ops.lissom.key_mirror()
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "earLeft", "front", "earRight"]
    right = deltas(obj, "earRight")
    rest = scene.points(obj.data.vertices)
    far = np.argmax(np.linalg.norm(right, axis=1))
    assert rest[far, 0] < -0.9 and right[far, 0] < 0 < before[np.abs(before).max(axis=1).argmax(), 0]
    key = obj.data.shape_keys.key_blocks["earRight"]
    assert (key.value, key.slider_max) == (0.0, 2.0)
    bpy.ops.lissom.key_mirror(keys="earRight")
    assert_allclose(deltas(obj, "earLeft"), before, atol=1e-6)
    assert obj.data.shape_keys.key_blocks["earLeft"].value == 0.5, "settings of a key that is there stay"


def test_how_far_the_mesh_is_from_symmetric_is_said(capfd):
    obj = suzanne()
    bpy.ops.lissom.key_mirror()
    assert "not symmetric" not in capfd.readouterr().out
    for rows in (obj.data.vertices, *(key.data for key in obj.data.shape_keys.key_blocks)):
        for row in rows:
            if row.co.x > 0:
                row.co.x *= 1.05
    bpy.ops.lissom.key_mirror(keys="earLeft", exists="UPDATE")
    assert "not symmetric" in capfd.readouterr().out


def test_left_and_right_add_up_to_the_key():
    obj = suzanne()
    bpy.ops.lissom.key_split(keys="front", falloff=0.2)
    left, right, whole = (deltas(obj, name) for name in ("front.L", "front.R", "front"))
    # Positions are in single precision: each of the three is rounded once.
    assert np.abs(left + right - whole).max() < 4 * np.finfo(np.float32).eps
    x = scene.points(obj.data.vertices)[:, 0]
    assert not left[x < -0.3].any() and not right[x > 0.3].any()
    assert left[np.abs(x) < 0.05].any() and right[np.abs(x) < 0.05].any()


def test_the_sum_of_what_is_raised_is_what_is_seen():
    obj = suzanne()
    seen = scene.shown(obj)
    bpy.ops.lissom.key_sum(name="Mix")
    assert_allclose(scene.key_points(obj, "Mix"), seen, atol=1e-6)
    bpy.ops.lissom.key_sum(name="Mix", keys="earLeft\nfront", by_value=False)
    assert_allclose(deltas(obj, "Mix.001"), deltas(obj, "earLeft") + deltas(obj, "front"), atol=1e-6)


def test_halves_of_a_key_sum_up_to_it_again():
    obj = suzanne()
    bpy.ops.lissom.key_split(keys="earLeft")
    bpy.ops.lissom.key_sum(name="again", keys="earLeftLeft\nearLeftRight", by_value=False)
    assert_allclose(deltas(obj, "again"), deltas(obj, "earLeft"), atol=1e-6)


@pytest.mark.parametrize("what", ["mirror", "split", "sum"])
def test_what_cannot_be_done_changes_nothing(what):
    obj = suzanne()
    operator = getattr(bpy.ops.lissom, f"key_{what}")
    with scene.refused("has no shape key named 'nose'"):
        operator(keys="nose")
    operator(keys="earLeft", exists="RENAME")
    made = obj.data.shape_keys.key_blocks[-1]
    made.lock_shape = True
    options = {"name": made.name} if what == "sum" else {}
    with scene.refused("locked"):
        operator(keys="earLeft", exists="UPDATE", **options)
    obj.active_shape_key_index = 0
    for key in obj.data.shape_keys.key_blocks[1:]:
        key.value = 0
    with scene.refused("are to be summed first" if what == "sum" else "other than the Basis first"):
        operator()


def test_they_stand_in_the_menu_of_shape_keys():
    obj = suzanne()
    made = drawn_into("MESH_MT_shape_key_context_menu")["operators"]
    for what in ("mirror", "split", "sum"):
        assert made[f"lissom.key_{what}"][0]["object"] == obj.name


def nudge(obj, name):
    """Moves a vertex of a key, as sculpting does."""
    row = obj.data.shape_keys.key_blocks[name].data[5]
    row.co.x += 0.5
    return scene.key_points(obj, name)


@pytest.mark.parametrize(
    ("run", "other"),
    [
        (lambda **how: bpy.ops.lissom.key_mirror(keys="earLeft", **how), "earRight"),
        (lambda **how: bpy.ops.lissom.key_split(keys="front", **how), "front.L"),
        (lambda **how: bpy.ops.lissom.key_sum(keys="earLeft\nfront", exists="UPDATE", **how), "Sum"),
    ],
)
def test_what_was_corrected_by_hand_of_a_key_that_was_made_is_kept(run, other, capfd):
    obj = suzanne()
    run()
    before = scene.key_points(obj, other)
    run()
    assert "kept" not in capfd.readouterr().out, "made again it takes the place of the first"
    edited = nudge(obj, other)
    run()
    assert f"Edited by hand, and kept: '{other}'" in capfd.readouterr().out
    assert_allclose(scene.key_points(obj, other), edited, atol=0)
    run(edited="OVERWRITE")
    assert_allclose(scene.key_points(obj, other), before, atol=1e-6)


def test_mirroring_keeps_what_was_corrected_of_a_transferred_key_and_transfers_keep_what_was_mirrored():
    source, target = monkeys()
    rest = scene.points(source.data.vertices)
    scene.add_key(source, "lift.L", rest + [0, 0, 0.1] * (rest[:, :1] > 0))
    scene.add_key(source, "lift.R", rest + [0, 0, 0.1] * (rest[:, :1] < 0))
    bpy.ops.lissom.transfer_keys()
    nudge(target, "lift.L")
    bpy.ops.lissom.key_mirror(object=target.name, keys="lift.L")
    mirrored = scene.key_points(target, "lift.R")
    bpy.ops.lissom.transfer_keys()
    assert_allclose(scene.key_points(target, "lift.R"), mirrored, atol=0)
    nudge(target, "lift.L")
    bpy.ops.lissom.key_mirror(object=target.name, keys="lift.L")
    assert np.abs(scene.key_points(target, "lift.R") - mirrored).max() > 0.4
    edited = nudge(target, "lift.R")
    bpy.ops.lissom.key_mirror(object=target.name, keys="lift.L")
    assert_allclose(scene.key_points(target, "lift.R"), edited, atol=0)
