"""*Online Manual* in context menus, F1: which page of the manual is about an operator or a setting.

The manual's pages are read in the repository that the manifest's ``website`` names, as releases are built; an
extension that was built without one has none.
"""

import pathlib
import tomllib

import bpy

MANIFEST = pathlib.Path(__file__).with_name("blender_manifest.toml")
POSE, TRANSFER, INBETWEEN = "pose.md#in-blender", "transfer.md#in-blender", "inbetween.md#in-blender"

# Patterns of identifiers in lower case, as Blender compares them; the first that fits is taken.
PAGES = (
    ("bpy.types.lissomposeoptions_common.*", "options.md#pose-every-method"),
    ("bpy.types.lissomposeoptions_*.*", "pose.md#methods"),
    ("bpy.types.lissompose*", POSE),
    ("bpy.types.lissomhandle*", POSE),
    ("bpy.types.lissomcompanion*", POSE),
    ("bpy.types.lissombaked*", POSE),
    ("bpy.types.lissominbetween*", INBETWEEN),
    ("bpy.types.lissomarc*", INBETWEEN),
    ("bpy.types.lissom*", TRANSFER),
    ("bpy.types.windowmanager.lissom_page*", "index.md"),
    ("bpy.ops.lissom.page_show*", "index.md"),
    ("bpy.ops.lissom.pose_*", POSE),
    ("bpy.ops.lissom.preset_pose*", POSE),
    ("bpy.ops.lissom.preset_inbetween*", INBETWEEN),
    ("bpy.ops.lissom.inbetween_image*", "drawings.md"),
    ("bpy.ops.lissom.inbetween_second_image*", "drawings.md"),
    ("bpy.ops.lissom.inbetween_*", INBETWEEN),
    ("bpy.ops.lissom.marker_load*", "transfer.md#marker-files"),
    ("bpy.ops.lissom.marker_save*", "transfer.md#marker-files"),
    ("bpy.ops.lissom.face_keys*", "tutorials/face.md"),
    ("bpy.ops.lissom.*", TRANSFER),
)


def folder(manifest=MANIFEST):
    """Where the manual's pages are, or "" where the manifest names no repository."""
    with open(manifest, "rb") as file:
        repository = tomllib.load(file).get("website", "").rstrip("/")
    return repository and f"{repository}/blob/HEAD/docs/"


def pages():
    """(prefix, patterns) as bpy.utils.register_manual_map wants it."""
    place = folder()
    return place, PAGES if place else ()


def register():
    bpy.utils.register_manual_map(pages)


def unregister():
    bpy.utils.unregister_manual_map(pages)
