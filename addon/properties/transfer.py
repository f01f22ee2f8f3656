"""Settings of a transfer, on the scene."""

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty

EXISTS_ITEMS = [
    ("UPDATE", "Update", "Write over a shape key of the same name"),
    ("SKIP", "Skip", "Leave a shape key of the same name as it is"),
    ("RENAME", "Rename", "Keep a shape key of the same name and number the new one"),
]


def exists_property(default):
    """What a key gets whose name is taken (row 32)."""
    return EnumProperty(
        name="If Exists",
        description="What to do where a shape key of that name is there already",
        items=EXISTS_ITEMS,
        default=default,
    )


def _is_mesh(_, obj):
    return obj.type == "MESH"


class LissomMarker(bpy.types.PropertyGroup):
    """One marker pair."""

    name: StringProperty(name="Name", description="What this place is, such as: left corner of the mouth")
    source: IntProperty(name="Source Vertex", description="Index of the vertex on the source mesh", min=0)
    target: IntProperty(name="Target Vertex", description="Index of the vertex on the target mesh", min=0)


class LissomKeyChoice(bpy.types.PropertyGroup):
    """The name of a shape key that is ticked."""

    name: StringProperty(name="Shape Key")


class LissomTransfer(bpy.types.PropertyGroup):
    """Settings of the scene's transfer."""

    source: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Source",
        description="The mesh whose shape keys are carried over",
    )
    target: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Target",
        description="The mesh that receives the shape keys",
    )
    markers: CollectionProperty(type=LissomMarker)
    active_marker: IntProperty(name="Active Marker", options=set())
    which: EnumProperty(
        name="Keys",
        description="Which shape keys of the source to carry over",
        items=[
            ("ALL", "All", "All shape keys of the source"),
            ("SELECTED", "Selected", "Only the shape keys that are ticked in the list"),
        ],
    )
    chosen: CollectionProperty(type=LissomKeyChoice)
    exists: exists_property("UPDATE")


classes = (LissomMarker, LissomKeyChoice, LissomTransfer)


def register():
    bpy.types.Scene.lissom_transfer = PointerProperty(type=LissomTransfer)


def unregister():
    del bpy.types.Scene.lissom_transfer
