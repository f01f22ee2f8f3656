"""The list of further objects under the handles."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..bridge import company
from ..core.refused import Refused
from .job import answering, writable_mesh
from .objects import OBJECT, unbound_object


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
        obj = unbound_object(self.object, context)
        rows = obj.lissom_pose.company
        if self.remove >= len(rows):
            raise Refused(f"There is no further object {self.remove}: there are {len(rows)}")
        if self.remove >= 0:
            rows.remove(self.remove)
            return
        others = [other for other in context.selected_objects if other.type == "MESH" and other != obj]
        if not others:
            raise Refused(f"Select the mesh objects that go along with '{obj.name}', then press again")
        for other in others:
            company.add(obj, other)


classes = (LISSOM_OT_pose_company,)
