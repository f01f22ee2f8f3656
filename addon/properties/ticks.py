"""Shape keys that are ticked, by name."""

import bpy
from bpy.props import StringProperty


class LissomTick(bpy.types.PropertyGroup):
    """The name of a shape key that is ticked."""

    name: StringProperty(name="Shape Key")


def put(rows, names):
    """Has a collection of LissomTick hold these names."""
    rows.clear()
    for name in names:
        rows.add().name = name


classes = (LissomTick,)
