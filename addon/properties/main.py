"""The page of the tab that is shown, of the window: undo does not change it, files do not keep it."""

import bpy
from bpy.props import EnumProperty

PAGES = [
    ("POSE", "Pose", "Move a few handles, and the mesh follows with its details intact"),
    ("TRANSFER", "Transfer", "Carry shape keys over to a mesh of other topology"),
    ("INBETWEEN", "In-between", "Play the arc between two shape keys by a slider"),
]

classes = ()


def register():
    bpy.types.WindowManager.lissom_page = EnumProperty(
        name="Page", description="What the tab is for", items=PAGES, options={"SKIP_SAVE"}
    )


def unregister():
    del bpy.types.WindowManager.lissom_page
