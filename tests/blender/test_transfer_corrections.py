"""Corrections are the artist's: what was edited by hand since a transfer, and what the next one does."""

import json

import bmesh
import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.bridge.written import Written
from bl_ext.user_default.lissom.jobs.corrections import is_edited
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import deltas, monkeys


def transferred(**options):
    """Suzanne's keys on the other Suzanne."""
    source, target = monkeys()
    bpy.ops.lissom.transfer_keys(**options)
    return source, target


def edit(obj, name, vertex=7, by=(0.1, 0.0, 0.05)):
    """Moves a vertex of a key, as sculpting does."""
    row = obj.data.shape_keys.key_blocks[name].data[vertex]
    row.co = np.array(row.co) + by


def states(obj, names=("squash", "ears")):
    written = Written(obj)
    return [written.state(name) for name in names]


def test_an_edited_key_is_kept_by_default_and_named(capfd):
    source, target = transferred()
    assert states(target) == ["WRITTEN", "WRITTEN"]
    edit(target, "squash")
    assert states(target) == ["EDITED", "WRITTEN"]
    before = scene.key_points(target, "squash")
    settings = target.data.shape_keys.key_blocks["squash"]
    settings.slider_max = 3.0
    source.data.shape_keys.key_blocks["ears"].data[100].co.z += 0.5
    ears = deltas(target, "ears")
    bpy.ops.lissom.transfer_keys()
    assert_array_equal(scene.key_points(target, "squash"), before)
    assert settings.slider_max == 3.0
    assert not np.array_equal(deltas(target, "ears"), ears)
    assert "Edited by hand since the last transfer, and kept: 'squash'" in capfd.readouterr().out
    assert states(target) == ["EDITED", "WRITTEN"]


def test_a_key_that_no_transfer_made_is_named_where_it_is_overwritten(capfd):
    _, target = transferred()
    target.data.shape_keys.lissom_written.clear()
    assert states(target) == ["FOREIGN", "FOREIGN"]
    bpy.ops.lissom.transfer_keys(keys="ears")
    assert "Not made by a transfer, and overwritten, as If Exists says: 'ears'" in capfd.readouterr().out
    bpy.ops.lissom.transfer_keys(keys="ears")
    assert "Not made by a transfer" not in capfd.readouterr().out


def test_an_edited_key_is_overwritten_where_that_is_asked_for():
    _, target = transferred()
    plain = deltas(target, "squash")
    edit(target, "squash")
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    assert_array_equal(deltas(target, "squash"), plain)
    assert states(target) == ["WRITTEN", "WRITTEN"]


def test_a_correction_is_carried_over_to_a_new_result_again_and_again():
    source, target = transferred()
    plain = deltas(target, "squash")
    edit(target, "squash")
    bpy.ops.lissom.transfer_keys(edited="CARRY")  # nothing new: the same again
    expected = plain.copy()
    expected[7] += [0.1, 0.0, 0.05]
    assert_allclose(deltas(target, "squash"), expected, atol=1e-6)
    assert states(target) == ["EDITED", "WRITTEN"]
    rest = scene.points(source.data.vertices)
    for factors in ([1.0, 1.0, 0.9], [1.1, 1, 0.8]):
        for row, place in zip(source.data.shape_keys.key_blocks["squash"].data, rest * factors, strict=True):
            row.co = place
        bpy.ops.lissom.transfer_keys(edited="CARRY")
        assert states(target) == ["EDITED", "WRITTEN"]
    assert_allclose(deltas(target, "squash"), expected, atol=5e-3)


def test_a_correction_turns_with_the_surface_that_it_was_made_on():
    source, target = transferred(keys="squash")
    edit(target, "squash", by=(0.1, 0, 0))
    rest = scene.points(source.data.vertices)
    for row, (x, y, z) in zip(source.data.shape_keys.key_blocks["squash"].data, rest, strict=True):
        row.co = (-y, x, z)
    bpy.ops.lissom.transfer_keys(keys="squash", edited="CARRY")
    carried = deltas(target, "squash")
    bpy.ops.lissom.transfer_keys(keys="squash", edited="OVERWRITE")
    found = carried - deltas(target, "squash")
    # What it was made on was a squash of its own, which is taken out of the turn.
    assert_allclose(found[7], [0, 0.1, 0], atol=0.01)
    assert_allclose(np.delete(found, 7, axis=0), 0, atol=1e-6)


def test_locked_keys_are_left_by_name_and_the_others_written(capfd):
    _, target = transferred()
    target.data.shape_keys.key_blocks["squash"].lock_shape = True
    before = scene.key_points(target, "squash")
    edit(target, "ears")
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    assert_array_equal(scene.key_points(target, "squash"), before)
    assert states(target) == ["WRITTEN", "WRITTEN"]
    said = capfd.readouterr().out
    assert "Locked, and left as they are: 'squash'" in said and "overwritten: 'ears'" in said


def test_where_all_is_kept_nothing_is_done_and_the_reason_is_said():
    _, target = transferred()
    for name in ("squash", "ears"):
        edit(target, name)
    with scene.refused(
        "Nothing to write. Edited by hand since the last transfer, and kept: 'squash', 'ears'"
    ):
        bpy.ops.lissom.transfer_keys()


@pytest.mark.parametrize("by", [0.0, 0.05])
def test_a_renamed_key_is_known_again(by):
    source, target = transferred()
    keys = target.data.shape_keys.key_blocks
    edit(target, "squash", by=(by, 0, 0))
    keys["squash"].name = "squeeze"
    assert states(target, ["squeeze"]) == ["EDITED" if by else "WRITTEN"]
    before = scene.key_points(target, "squeeze")
    bpy.ops.lissom.transfer_keys()  # under the source's name there is none: it is made anew, beside it
    assert keys.keys() == ["Basis", "squeeze", "ears", "squash"]
    assert_array_equal(scene.key_points(target, "squeeze"), before)
    assert states(target, ["squash", "squeeze"]) == ["WRITTEN", "EDITED" if by else "WRITTEN"]
    target.shape_key_remove(keys["squash"])
    source.data.shape_keys.key_blocks["squash"].name = "squeeze"
    plain = before.copy()
    plain[7, 0] -= by
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    assert_allclose(scene.key_points(target, "squeeze"), plain, atol=1e-6)


def test_a_remodelled_mesh_forgets_and_says_so(capfd):
    _, target = transferred()
    edit(target, "squash")
    mesh = bmesh.new()
    mesh.from_mesh(target.data)
    mesh.faces.ensure_lookup_table()
    bmesh.ops.poke(mesh, faces=mesh.faces[:1])
    mesh.to_mesh(target.data)
    mesh.free()
    assert states(target) == ["UNKNOWN", "UNKNOWN"]
    with scene.refused("The mesh was remodelled since the last transfer"):
        bpy.ops.lissom.transfer_keys()
    with scene.refused("The mesh was remodelled since the last transfer"):
        bpy.ops.lissom.transfer_keys(edited="CARRY")
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    assert states(target) == ["WRITTEN", "WRITTEN"]
    assert "edits by hand are not known; overwritten: 'squash', 'ears'" in capfd.readouterr().out


def test_what_was_written_is_saved_copied_and_moved_with_the_basis(tmp_path):
    _, target = transferred()
    edit(target, "ears")
    copy = target.copy()
    copy.data = target.data.copy()
    bpy.context.collection.objects.link(copy)
    for key in copy.data.shape_keys.key_blocks:  # as edit mode does with the Basis
        for row in key.data:
            row.co.x += 0.7
    assert states(copy) == ["WRITTEN", "EDITED"]
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert states(bpy.data.objects["Target"]) == ["WRITTEN", "EDITED"]


def test_the_lists_show_which_keys_are_edited():
    _, target = transferred()
    assert not is_edited(target, "squash")
    edit(target, "squash")
    target.data.update()
    bpy.context.view_layer.update()
    assert is_edited(target, "squash") and not is_edited(target, "ears")
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    bpy.context.view_layer.update()
    assert not is_edited(target, "squash")


def test_undo_and_redo_take_what_was_written_along():
    bpy.context.preferences.edit.use_global_undo = True
    _, target = transferred()
    bpy.ops.ed.undo_push(message="Transfer")
    edit(target, "squash")
    bpy.ops.ed.undo_push(message="Edit")
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    bpy.ops.ed.undo_push(message="Transfer again")
    bpy.ops.ed.undo()
    target = bpy.data.objects["Target"]
    assert states(target) == ["EDITED", "WRITTEN"]
    bpy.ops.ed.undo()
    assert states(bpy.data.objects["Target"]) == ["WRITTEN", "WRITTEN"]


def test_of_several_objects_each_keeps_its_own():
    source, target = monkeys()
    copies = []
    for obj in (source, target):
        other = obj.copy()
        other.data = obj.data.copy()
        other.location.x = 4.0
        bpy.context.collection.objects.link(other)
        copies.append(other)
    bpy.context.view_layer.update()
    sides = {"source": f"Source\n{copies[0].name}", "target": f"Target\n{copies[1].name}"}
    bpy.ops.lissom.transfer_keys(**sides)
    edit(copies[1], "squash")
    before = [scene.key_points(obj, "squash") for obj in (target, copies[1])]
    source.data.shape_keys.key_blocks["squash"].data[3].co.z += 0.3
    copies[0].data.shape_keys.key_blocks["squash"].data[3].co.z += 0.3
    bpy.ops.lissom.transfer_keys(**sides)
    assert not np.array_equal(scene.key_points(target, "squash"), before[0])
    assert_array_equal(scene.key_points(copies[1], "squash"), before[1])


def test_a_pose_that_was_edited_is_kept_too():
    source, target = monkeys()
    source.data.shape_keys.key_blocks["squash"].value = 1.0
    bpy.ops.lissom.transfer_pose(name="Now")
    edit(target, "Now")
    with scene.refused("and kept: 'Now'"):
        bpy.ops.lissom.transfer_pose(name="Now")
    bpy.ops.lissom.transfer_pose(name="Now", edited="OVERWRITE")
    assert states(target, ["Now"]) == ["WRITTEN"]


@pytest.mark.parametrize("choice", ["keep", "carry", "overwrite"])
def test_the_command_tells_what_it_found(choice, tmp_path):
    _, target = transferred()
    edit(target, "squash")
    target.data.shape_keys.key_blocks["ears"].lock_shape = True
    path, report = tmp_path / "both.blend", tmp_path / "report.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    words = ["transfer", "--file", path, "--source", "Source", "--target", "Target", "--out", path]
    code = commands.main([*map(str, words), "--edited", choice, "--report", str(report)])
    if choice == "keep":
        assert code == 2
        return
    found = json.loads(report.read_text())["there"]
    assert found == {
        "locked": {"Target": ["ears"]},
        "edited": {"Target": ["squash"]},
        "unknown": {},
        "edited_keys": choice,
        "foreign": {},
    }


@pytest.mark.parametrize("scale", [(2.0, 2.0, 2.0), (1.0, 3.0, -0.5)])
def test_transforms_that_are_applied_are_no_edit(scale):
    _, target = transferred()
    target.scale, target.rotation_euler = scale, (0.3, -0.5, 2.0)
    edit(target, "ears")
    bpy.context.view_layer.objects.active = target
    for obj in bpy.data.objects:
        obj.select_set(obj == target)
    bpy.context.view_layer.update()
    correction, linear = Written(target).correction("ears"), np.array(target.matrix_world)[:3, :3]
    bpy.ops.object.transform_apply()
    assert states(target) == ["WRITTEN", "EDITED"]
    assert_allclose(Written(target).correction("ears"), correction @ linear.T, atol=1e-5)
    bpy.ops.lissom.key_strength(object=target.name, keys="squash", strength=0.5)
    assert states(target) == ["WRITTEN", "EDITED"]
    bpy.ops.lissom.transfer_keys(edited="CARRY")
    assert states(target) == ["WRITTEN", "EDITED"]
