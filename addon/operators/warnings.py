"""What jobs had to say, kept in the panels until it is dealt with."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ..bridge import arcs, checks
from ..core.refused import Refused
from ..properties.main import PAGES
from .job import answering
from .objects import OBJECT


class LISSOM_OT_warning_dismiss(bpy.types.Operator):
    """Take this line off the panel: it is dealt with"""

    bl_idname = "lissom.warning_dismiss"
    bl_label = "Dismiss"
    bl_options = {"REGISTER", "UNDO"}

    page: EnumProperty(name="Page", description="Where the line stands", items=PAGES)
    object: StringProperty(**OBJECT)
    slider: StringProperty(
        name="Slider", description="Slider of the arc that it is said of", options={"SKIP_SAVE"}
    )
    line: IntProperty(
        name="Line",
        description="Place of the line; -1: all of them",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @answering
    def execute(self, context):
        owner = self._owner(context)
        lines = owner.warnings.splitlines()
        if self.line >= len(lines):
            raise Refused(f"There is no line {self.line}: there are {len(lines)}")
        if self.line < 0:
            lines.clear()
        else:
            del lines[self.line]
        owner.warnings = "\n".join(lines)

    def _owner(self, context):
        if self.page == "TRANSFER":
            return context.scene.lissom_transfer
        obj = checks.mesh_object(self.object, context)
        return obj.lissom_pose if self.page == "POSE" else arcs.find(obj, self.slider)


classes = (LISSOM_OT_warning_dismiss,)
