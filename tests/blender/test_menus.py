"""Blender's own menus, the pie, and the preferences."""

import bpy
import pytest
import scene
from bl_ext.user_default.lissom import preferences
from bl_ext.user_default.lissom.panels import menus
from test_panels import draw


def drawn_into(name):
    """What is added to one of Blender's menus."""
    stub = type("Menu", (), {"draw": lambda self, context: menus.MENUS[name](self, context)})
    return draw(stub)


def test_f3_finds_every_operator_of_the_three_jobs():
    scene.bound_tube()
    found = set()
    for name in menus.MENUS:
        found |= set(drawn_into(name)["operators"])
    found |= set(draw(bpy.types.LISSOM_MT_object)["operators"])
    for name in (
        "pose_bind",
        "pose_apply",
        "transfer_fit",
        "transfer_keys",
        "marker_pick",
        "review",
        "inbetween_bake",
    ):
        assert f"lissom.{name}" in found
    assert {"lissom.pose_handle_add", "lissom.curve_add"} <= found


@pytest.mark.parametrize("menu", ["object", "pie"])
def test_buttons_in_menus_take_what_the_panels_say(menu, monkeypatch):
    monkeypatch.setattr("test_panels.LAYOUTS", {"row", "column", "box", "split", "menu_pie"})
    obj = scene.bound_tube()
    bpy.ops.lissom.pose_unbind(object=obj.name)
    obj.lissom_pose.method = "poisson"
    obj.lissom_inbetween.count = 7
    scene_settings = bpy.context.scene.lissom_transfer
    scene_settings.match_distance = 0.03
    made = draw(getattr(bpy.types, f"LISSOM_MT_{menu}"))["operators"]
    assert made["lissom.pose_bind"][0]["method"] == "poisson"
    assert made["lissom.inbetween_bake"][0]["count"] == 7
    assert made["lissom.transfer_keys"][0]["match_distance"] == scene_settings.match_distance


def test_a_shape_key_offers_its_arc_and_its_transfer():
    obj, other = scene.tube(name="A"), scene.tube(name="B")
    assert not drawn_into("MESH_MT_shape_key_context_menu")["operators"]
    bpy.context.view_layer.objects.active = obj
    scene.add_key(obj, "Smile", scene.points(obj.data.vertices) + 0.1)
    obj.active_shape_key_index = 1
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = obj, other
    settings.scale, obj.lissom_inbetween.count, obj.lissom_inbetween.slider = "source", 7, "other"
    made = drawn_into("MESH_MT_shape_key_context_menu")["operators"]
    assert made["lissom.inbetween_bake"][0]["end"] == made["lissom.transfer_keys"][0]["keys"] == "Smile"
    assert made["lissom.transfer_keys"][0]["scale"] == "source"
    assert (made["lissom.inbetween_bake"][0]["count"], made["lissom.inbetween_bake"][0]["slider"]) == (7, "")


def test_preferences_have_defaults_where_the_package_is_no_enabled_add_on():
    assert preferences.look() == preferences.Look()
    kind = bpy.types.AddonPreferences.bl_rna_get_subclass_py("LissomPreferences")
    assert kind.bl_idname == preferences.ADDON
    assert set(kind.__annotations__) == {*preferences.Look._fields, "jump"}
