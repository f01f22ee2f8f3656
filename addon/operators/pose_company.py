"""The list of further objects under the handles."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..jobs import handles
from .job import answering, writable_mesh
from .objects import OBJECT


class LISSOM_OT_pose_company(bpy.types.Operator):
    """Have the selected mesh objects go along with this one, such as eyes, teeth or clothes"""

    bl_idname = "lissom.pose_company"
    bl_label = "Add Selected Objects"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    remove: IntProperty(
        name="Remove",
        description="Place of the object to take off the list; -1: add the selected ones",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=False)

    @answering
    def execute(self, context):
        if self.remove >= 0:
            handles.leave_behind(context, self.object, self.remove)
        else:
            handles.take_along(context, self.object)


classes = (LISSOM_OT_pose_company,)
