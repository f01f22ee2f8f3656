"""Source and target from the selection, and swapped."""

import bpy
from bpy.props import BoolProperty

from ..core.refused import Refused
from .job import allowed, answering


class LISSOM_OT_transfer_sides(bpy.types.Operator):
    """The active mesh becomes the target, the other selected mesh the source"""

    bl_idname = "lissom.transfer_sides"
    bl_label = "From Selection"
    bl_options = {"REGISTER", "UNDO"}

    swap: BoolProperty(
        name="Swap",
        description="Source and target change places instead, with all their marks",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return allowed(cls, "")

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        if self.swap:
            settings.swap()
            return
        chosen = [obj for obj in context.selected_objects if obj.type == "MESH"]
        if len(chosen) != 2 or context.object not in chosen:
            raise Refused(
                "Select the mesh that has the shape keys, then with Shift the one that is to get "
                "them. Further objects of either, such as eyes, are added by its plus"
            )
        settings.target = context.object
        settings.source = next(obj for obj in chosen if obj != context.object)


classes = (LISSOM_OT_transfer_sides,)
