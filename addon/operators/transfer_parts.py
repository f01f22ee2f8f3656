"""Further objects of the source and the target; the table of quality as a file, and its faces selected."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ..jobs import parts
from .job import allowed, answering, report_done


class LISSOM_OT_transfer_parts(bpy.types.Operator):
    """Add the selected mesh objects to this side: eyes, teeth, lashes that are objects of their own"""

    bl_idname = "lissom.transfer_parts"
    bl_label = "Add Selected Objects"
    bl_options = {"REGISTER", "UNDO"}

    side: EnumProperty(
        name="Side",
        description="Which side they belong to",
        items=[("SOURCE", "Source", "Where keys come from"), ("TARGET", "Target", "Where keys go to")],
    )
    remove: IntProperty(
        name="Remove",
        description="Place of the object to take away; -1: add the selected ones",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @answering
    def execute(self, context):
        if self.remove >= 0:
            parts.remove(context, self.side.lower(), self.remove)
        else:
            parts.add(context, self.side.lower())


def _judged(operator_class, context):
    there = len(context.scene.lissom_transfer.quality)
    return allowed(operator_class, "" if there else "Transfer with Check Quality first")


class LISSOM_OT_quality_save(ExportHelper, bpy.types.Operator):
    """Write what was said about each transferred shape key to a JSON file"""

    bl_idname = "lissom.quality_save"
    bl_label = "Save Quality"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return _judged(cls, context)

    @answering
    def execute(self, context):
        report_done(self, parts.save_quality(context, bpy.path.abspath(self.filepath)))


class LISSOM_OT_quality_select(bpy.types.Operator):
    """Select the faces of this key that are to be looked at, and make it the active one"""

    bl_idname = "lissom.quality_select"
    bl_label = "Select Faces"
    bl_options = {"REGISTER", "UNDO"}

    key: StringProperty(name="Key", description="Name of the shape key in the table", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return _judged(cls, context)

    @answering
    def execute(self, context):
        report_done(self, parts.select_faces(context, self.key))


classes = (LISSOM_OT_transfer_parts, LISSOM_OT_quality_save, LISSOM_OT_quality_select)
