"""The manual's page of every operator and setting, and that these pages and headings are there."""

import pathlib
import re
from fnmatch import fnmatchcase

import bpy
import pytest
from bl_ext.user_default.lissom import manual

ROOT = pathlib.Path(__file__).parents[2]


def page_of(identifier):
    """The page that Blender would open (bl_operators/wm.py)."""
    return next((page for pattern, page in manual.PAGES if fnmatchcase(identifier.lower(), pattern)), None)


def headings(file):
    """The anchors of a page's headings, as GitHub and Python-Markdown make them."""
    found = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
    plain = [re.sub(r"[^\w\s-]", "", line).strip().lower() for line in found]
    return {re.sub(r"[-\s]+", "-", line) for line in plain}


def test_every_page_and_heading_is_in_the_manual():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for _, target in manual.PAGES:
        page, _, anchor = target.partition("#")
        assert re.search(rf"- (.+: )?{re.escape(page)}\n", navigation), page
        assert not anchor or anchor in headings(ROOT / "docs" / page), target


def test_every_operator_and_setting_has_a_page(addon):
    for cls in addon._CLASSES:
        if issubclass(cls, bpy.types.Operator):
            assert page_of(f"bpy.ops.{cls.bl_idname}") is not None, cls
        if issubclass(cls, bpy.types.PropertyGroup):
            for prop in cls.bl_rna.properties:
                assert page_of(f"bpy.types.{cls.__name__}.{prop.identifier}") is not None, (cls, prop)


@pytest.mark.parametrize(
    ("identifier", "page"),
    [
        ("bpy.types.LissomPoseOptions_arap.solid", "pose.md#methods"),
        ("bpy.types.LissomPose.method", "pose.md#in-blender"),
        ("bpy.ops.lissom.transfer_keys", "transfer.md#in-blender"),
        ("bpy.types.LissomArc.count", "inbetween.md#in-blender"),
        ("bpy.ops.lissom.marker_load", "transfer.md#marker-files"),
    ],
)
def test_the_page_is_that_of_the_job(identifier, page):
    assert page_of(identifier) == page


def test_no_pattern_is_hidden_by_one_before_it():
    for place, (pattern, _) in enumerate(manual.PAGES):
        hidden = [before for before, _ in manual.PAGES[:place] if fnmatchcase(pattern, before)]
        assert not hidden, (pattern, hidden)


def test_blender_asks_it_where_the_manifest_names_a_website(tmp_path, monkeypatch):
    manifest = tmp_path / "blender_manifest.toml"
    manifest.write_text('website = "https://example.org/lissom"\n', encoding="utf-8")
    there = "https://example.org/lissom/blob/HEAD/docs/"
    assert manual.folder(manifest) == there
    assert ("", ()) in bpy.utils.manual_map()  # none is told: Blender goes on to its own manual
    monkeypatch.setattr(manual, "folder", lambda: there)
    assert (there, manual.PAGES) in bpy.utils.manual_map()
