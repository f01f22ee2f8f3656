"""The words of demo.blend: a label below each group, and a page that opens with the file."""

import pathlib
import re
import sys

import bpy
import pytest

DEMO = pathlib.Path(__file__).parents[2] / "demo"


@pytest.fixture
def guide(monkeypatch):
    monkeypatch.syspath_prepend(str(DEMO))
    for name in ("scene", "guide"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    import guide

    yield guide
    for name in ("scene", "guide"):
        sys.modules.pop(name, None)


def test_it_knows_every_group_of_the_demo(guide):
    sources = "".join(file.read_text(encoding="utf-8") for file in DEMO.glob("*.py"))
    groups = set(re.findall(r'scene\.collection\("(\d .*?)"\)', sources)) - {"0 Labels"}
    assert groups == set(guide.WORDS)


def test_labels_stand_below_what_they_are_about_and_the_page_opens(guide, tmp_path):
    for place, name in enumerate(guide.WORDS):
        into = bpy.data.collections.new(name)
        bpy.context.scene.collection.children.link(into)
        bpy.ops.mesh.primitive_cube_add(location=(4 * place, 0, 0))
        into.objects.link(bpy.context.object)
    guide.write()
    labels = {obj.data.body: obj for obj in bpy.data.objects if obj.type == "FONT"}
    for place, (title, _) in enumerate(guide.WORDS.values()):
        label = labels[title]
        assert tuple(label.location) == pytest.approx((4 * place, -1, -1 - guide.BELOW))
        assert label.hide_render  # pictures stay as they are
    path = tmp_path / "demo.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    areas = bpy.data.screens["Layout"].areas
    shown = [area.spaces.active.text for area in areas if area.type == "TEXT_EDITOR"]
    assert [text.name for text in shown] == [guide.TITLE]
    said = shown[0].as_string()
    assert all(line in said for _, line in guide.WORDS.values())
    views = [area.spaces.active for area in areas if area.type == "VIEW_3D"]
    assert views and all(view.show_region_ui for view in views)
