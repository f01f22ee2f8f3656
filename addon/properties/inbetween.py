"""Settings of in-betweens, on the mesh object."""

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty

from ..bridge import shape_keys

ROTATION_ITEMS = [
    (
        "consistent",
        "Consistent",
        "Neighbouring faces turn alike: twists beyond half a turn come out whole",
        0,
    ),
    ("shortest", "Shortest", "Every face turns the short way by itself; for turns below half a turn", 1),
]


class LissomArcKey(bpy.types.PropertyGroup):
    """A baked shape key, by name."""

    name: StringProperty(name="Shape Key")


class LissomArc(bpy.types.PropertyGroup):
    """A baked arc; its name is that of the slider."""

    name: StringProperty(name="Slider")
    start: StringProperty(name="From")
    end: StringProperty(name="To")
    keys: CollectionProperty(type=LissomArcKey)


def ends(settings, context, text):
    """The shape keys that an arc can start or end at: all but those that show a live pose."""
    mesh = settings.id_data.data
    keys = mesh.shape_keys
    left_out = shape_keys.previews(mesh)
    return [name for name in (keys.key_blocks.keys() if keys else []) if name not in left_out]


class LissomInbetween(bpy.types.PropertyGroup):
    """Settings of one mesh object."""

    start: StringProperty(
        name="From",
        description="Shape key that the arc starts at. Empty: the Basis",
        search=ends,
        search_options=set(),
    )
    end: StringProperty(
        name="To", description="Shape key that the arc ends at", search=ends, search_options=set()
    )
    count: IntProperty(
        name="In-betweens",
        description="Shape keys between the two; more follow the arc more closely",
        default=5,
        min=1,
        soft_max=20,
        max=100,
    )
    rotation: EnumProperty(
        name="Rotation",
        description="How the turn of every face is chosen",
        items=ROTATION_ITEMS,
        default="consistent",
    )
    slider: StringProperty(
        name="Slider",
        description="Name of the slider, and of the baked keys. Empty: named after the key it leads to",
    )
    arcs: CollectionProperty(type=LissomArc)


classes = (LissomArcKey, LissomArc, LissomInbetween)


def register():
    bpy.types.Object.lissom_inbetween = PointerProperty(type=LissomInbetween)


def unregister():
    del bpy.types.Object.lissom_inbetween
