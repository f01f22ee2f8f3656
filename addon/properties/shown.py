"""What an object showed before one of its shape keys was shown alone; see bridge.pins."""

import bpy
from bpy.props import BoolProperty, IntProperty, PointerProperty, StringProperty


class LissomShown(bpy.types.PropertyGroup):
    """On the mesh object."""

    on: BoolProperty(options={"HIDDEN"}, description="A key is shown alone")
    place: IntProperty(options={"HIDDEN"}, description="Of the active key before")
    pinned: BoolProperty(options={"HIDDEN"}, description="Whether that was shown alone")
    heard: StringProperty(options={"HIDDEN"}, description="The muted key that is heard meanwhile")
    mends: BoolProperty(options={"HIDDEN"}, description="The object is a copy, on which a key is mended")


classes = (LissomShown,)


def register():
    bpy.types.Object.lissom_shown = PointerProperty(type=LissomShown)


def unregister():
    del bpy.types.Object.lissom_shown
