"""The extension as Blender registers it: twice, with undo, and a text for every property."""

import sys

import bpy
import pytest


def own_classes(addon):
    return addon._CLASSES


def test_the_package_registers_twice(addon):
    addon.unregister()
    assert not hasattr(bpy.types.Object, "lissom_pose")
    assert not any("lissom" in handler.__module__ for handler in bpy.app.handlers.depsgraph_update_post)
    addon.register()
    assert hasattr(bpy.types.Object, "lissom_pose")


APART = (
    "marker_pick",
    "marker_views",
    "page_show",
    "preset_pose",
    "preset_transfer",
    "preset_inbetween",
    "pose_touch",
    "review",
    "review_mend",
)


def test_every_operator_can_be_undone_and_repeated(addon):
    operators = [cls for cls in own_classes(addon) if issubclass(cls, bpy.types.Operator)]
    assert len(operators) >= 15
    for cls in operators:
        # Every pair is a step of its own; views and windows are no part of the file.
        apart = cls.bl_idname.split(".")[1] in APART
        assert cls.bl_options == ({"REGISTER"} if apart else {"REGISTER", "UNDO"}), cls


def test_every_property_says_what_it_is(addon):
    inherited = {"filepath", "check_existing", "filter_glob"}  # of bpy_extras.io_utils
    inherited |= {"remove_name", "remove_active"}  # of bl_operators.presets
    for cls in own_classes(addon):
        if not issubclass(cls, bpy.types.Operator):
            continue
        kind = getattr(bpy.ops.lissom, cls.bl_idname.split(".")[1]).get_rna_type()
        assert kind.description, cls
        for prop in kind.properties:
            if prop.identifier != "rna_type" and prop.identifier not in inherited:
                assert prop.name and prop.description, f"{cls.__name__}.{prop.identifier}"


def test_one_page_is_shown_at_a_time(addon):
    pages = [cls for cls in own_classes(addon) if hasattr(cls, "page") and issubclass(cls, bpy.types.Panel)]
    for page in ("POSE", "TRANSFER", "INBETWEEN"):
        assert bpy.ops.lissom.page_show.poll()
        bpy.context.window_manager.lissom_page = page
        assert [panel.page for panel in pages if panel.poll(bpy.context)] == [page]
    bpy.context.window_manager.property_unset("lissom_page")


def test_there_is_one_tab_with_its_panels_in_order(addon):
    panels = [cls for cls in own_classes(addon) if issubclass(cls, bpy.types.Panel)]
    assert [panel.bl_label for panel in panels] == ["Lissom", "Pose", "Transfer", "In-between"]
    assert {(panel.bl_space_type, panel.bl_region_type, panel.bl_category) for panel in panels} == {
        ("VIEW_3D", "UI", "Lissom")
    }


def test_core_never_imports_bpy(addon):
    modules = [m for name, m in sys.modules.items() if name.startswith(f"{addon.__name__}.core")]
    assert len(modules) > 5
    for module in modules:
        assert not any(name in vars(module) for name in ("bpy", "bmesh", "mathutils")), module


def test_the_manifest_replaces_bl_info(addon):
    assert not hasattr(addon, "bl_info")


@pytest.mark.parametrize("kind", ["pose", "inbetween"])
def test_settings_of_an_object_are_its_own(addon, kind):
    one, other = (bpy.data.objects.new(name, None) for name in "ab")
    setattr(getattr(one, f"lissom_{kind}"), {"pose": "roi", "inbetween": "end"}[kind], "x")
    assert getattr(getattr(other, f"lissom_{kind}"), {"pose": "roi", "inbetween": "end"}[kind]) == ""
