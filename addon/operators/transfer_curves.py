"""The list of curves: add and remove."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..core.refused import Refused
from ..jobs import marks
from .job import answering, report_done
from .objects import SOURCE, TARGET


class LISSOM_OT_curve_add(bpy.types.Operator):
    """Pair the edges selected on the source with those selected on the target, such as rims of lids or lips.

    In Edit Mode, Alt-click an edge of a rim to select all of it, and Shift-Alt-click its counterpart"""

    bl_idname = "lissom.curve_add"
    bl_label = "Add Curve"
    bl_options = {"REGISTER", "UNDO"}

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    name: StringProperty(name="Name", description="What this rim is; empty: numbered", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        report_done(self, marks.add_curve(context, (self.source, self.target), self.name))


class LISSOM_OT_curve_remove(bpy.types.Operator):
    """Remove a curve from the list"""

    bl_idname = "lissom.curve_remove"
    bl_label = "Remove Curve"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Index", description="Place in the list", min=0, options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        curves = context.scene.lissom_transfer.curves
        if self.index >= len(curves):
            raise Refused(f"There is no curve {self.index}: the list holds {len(curves)}")
        curves.remove(self.index)


classes = (LISSOM_OT_curve_add, LISSOM_OT_curve_remove)
