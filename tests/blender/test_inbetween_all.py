"""Arcs to many keys in one go, and those that are out of date."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session, watch
from bl_ext.user_default.lissom.bridge import arcs
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube, native_path


def sliders(obj):
    return [arc.name for arc in obj.lissom_inbetween.arcs]


def test_all_keys_get_what_each_would_by_itself():
    obj, alone = keyed_tube(), keyed_tube()
    alone.name = "Alone"
    for end in ("half", "full"):
        bpy.ops.lissom.inbetween_bake(object="Alone", end=end, count=3)
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=3)
    assert sliders(obj) == sliders(alone) == ["half arc", "full arc"]
    names = obj.data.shape_keys.key_blocks.keys()
    assert names == alone.data.shape_keys.key_blocks.keys()
    for name in names:
        assert_allclose(scene.key_points(obj, name), scene.key_points(alone, name), atol=0)


def test_keys_of_arcs_are_not_offered_and_baking_again_takes_the_place_of_the_first():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=2)
    count = len(obj.data.shape_keys.key_blocks)
    assert arcs.offered(obj, "") == ["half", "full"]
    assert arcs.offered(obj, "half") == ["Basis", "full"]
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=2)
    assert len(obj.data.shape_keys.key_blocks) == count and len(sliders(obj)) == 2


def test_ticks_choose_and_scripts_name():
    obj = keyed_tube()
    settings = obj.lissom_inbetween
    bpy.ops.lissom.inbetween_choose(object=obj.name, action="ALL")
    assert settings.chosen.keys() == ["half", "full"]
    bpy.ops.lissom.inbetween_choose(object=obj.name, action="TOGGLE", key="half")
    assert settings.chosen.keys() == ["full"]
    bpy.ops.lissom.inbetween_choose(object=obj.name, action="NONE")
    assert not len(settings.chosen)
    with scene.refused("no shape key named 'none' to tick"):
        bpy.ops.lissom.inbetween_choose(object=obj.name, action="TOGGLE", key="none")
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, keys="full", count=1)
    assert sliders(obj) == ["full arc"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"keys": "half\nnone"}, "no shape key named 'none'"),
        ({"playback": "ABSOLUTE"}, "Absolute keys play one arc alone"),
        ({"keys": "half\nBasis"}, "are the same shape key"),
    ],
)
def test_one_that_cannot_be_baked_is_refused_before_any_is_written(options, message):
    obj = keyed_tube()
    with scene.refused(message):
        bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=1, **options)


def test_what_was_sculpted_since_is_out_of_date_and_alone_is_baked_again():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=1)
    with scene.refused("All arcs are as their ends are now"):
        bpy.ops.lissom.inbetween_update_all(object=obj.name)
    half = scene.key_points(obj, "half arc 50%")
    key = obj.data.shape_keys.key_blocks["full"]
    for row in key.data:
        row.co.x += 0.25
    assert watch.look(obj) == ["full arc"] == session.stale[obj.session_uid]
    bpy.ops.lissom.inbetween_update_all(object=obj.name)
    assert watch.look(obj) == []
    assert_allclose(scene.key_points(obj, "half arc 50%"), half, atol=0)
    wanted = native_path(obj, "Basis", "full").at([0.5])[0]
    assert_allclose(scene.key_points(obj, "full arc 50%"), wanted, atol=1e-5)
    for row in obj.data.shape_keys.key_blocks["Basis"].data:
        row.co.y += 0.5
    assert watch.look(obj) == ["half arc", "full arc"]


def test_a_slider_that_plays_changes_nothing_about_it():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=1)
    for value in (0.0, 0.4, 1.0):
        obj["full arc"] = value
        obj.update_tag()
        bpy.context.view_layer.update()
        assert watch.look(obj) == []


def test_arcs_of_older_files_are_taken_as_they_are():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=1)
    obj.lissom_inbetween.arcs["full arc"].digest = ""
    obj.data.shape_keys.key_blocks["full"].data[0].co.x += np.float32(1.0)
    assert watch.look(obj) == []


def corrected(obj, name, by=(0.3, 0.1, 0.0)):
    """Moves a few vertices of a key, as sculpting does; their places."""
    for row in obj.data.shape_keys.key_blocks[name].data[:5]:
        row.co = np.array(row.co) + by
    return scene.key_points(obj, name)


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
def test_in_betweens_that_were_corrected_by_hand_are_carried_over_again_and_again(playback, capfd):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="full", count=3, playback=playback)
    before = scene.key_points(obj, "full arc 50%")
    after = corrected(obj, "full arc 50%")
    for _ in range(2):
        bpy.ops.lissom.inbetween_rebake(object=obj.name, slider="full arc")
        assert "corrected by hand are carried over: 'full arc 50%'" in capfd.readouterr().out
        assert_allclose(scene.key_points(obj, "full arc 50%"), after, atol=1e-5)
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="full", count=7, playback=playback)
    plain = native_path(obj, "Basis", "full").at([0.375])[0]
    half = scene.key_points(obj, "full arc 37.5%") - plain
    assert_allclose(scene.key_points(obj, "full arc 50%"), after, atol=1e-5)
    assert_allclose(np.linalg.norm(half, axis=1), 0.5 * np.linalg.norm(after - before, axis=1), atol=1e-5)


def test_corrections_do_not_go_over_to_an_arc_to_another_end(capfd):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="full", slider="bend", count=1)
    corrected(obj, "bend 50%")
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="half", slider="bend", count=1)
    assert "gone with the arc to 'full': 'bend 50%'" in capfd.readouterr().out
    wanted = native_path(obj, "Basis", "half").at([0.5])[0]
    assert_allclose(scene.key_points(obj, "bend 50%"), wanted, atol=1e-5)


def test_an_in_between_is_not_edited_by_transforms_that_are_applied(capfd):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="full", count=3)
    obj.scale, obj.rotation_euler = (2.0, 2.0, 2.0), (0.4, 1.0, -2.0)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.context.view_layer.update()
    bpy.ops.object.transform_apply()
    bpy.ops.lissom.inbetween_rebake(object=obj.name, slider="full arc")
    assert "corrected by hand" not in capfd.readouterr().out


@pytest.mark.parametrize("end", ["half", "Basis"])
def test_an_end_that_was_renamed_is_known_again(end):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object=obj.name, start="Basis", end="half", count=1)
    obj.data.shape_keys.key_blocks[end].name = "other"
    assert watch.look(obj) == []
    arc = obj.lissom_inbetween.arcs[0]
    assert [arc.start, arc.end] == ["other" if name == end else name for name in ("Basis", "half")]
    bpy.ops.lissom.inbetween_rebake(object=obj.name, slider="half arc")


def test_an_arc_that_has_lost_its_end_does_not_keep_the_others_from_being_updated(capfd):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=1)
    obj.shape_key_remove(obj.data.shape_keys.key_blocks["half"])
    with scene.refused("'half arc' stays as it is: 'half' is gone"):
        bpy.ops.lissom.inbetween_update_all(object=obj.name)
    obj.data.shape_keys.key_blocks["full"].data[0].co.x += 0.25
    bpy.ops.lissom.inbetween_update_all(object=obj.name)
    assert "'half arc' stays as it is: 'half' is gone" in capfd.readouterr().out
    wanted = native_path(obj, "Basis", "full").at([0.5])[0]
    assert_allclose(scene.key_points(obj, "full arc 50%"), wanted, atol=1e-5)
