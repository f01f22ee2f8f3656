"""The handles and the region of a pose."""

import bpy
from bpy.props import StringProperty

from ..bridge import groups
from ..jobs import handles
from .job import allowed, answering, shown_object, writable_mesh
from .objects import OBJECT


class _UnboundObject:
    """Mixin: an operator on a mesh object that is not bound."""

    object: StringProperty(**OBJECT)

    @classmethod
    def poll(cls, context):
        """Like job.writable_mesh, but edit mode is welcome: that is where vertices are selected."""
        obj = shown_object(context)
        if obj is not None and obj.mode == "EDIT" and not obj.lissom_pose.bound:
            return allowed(cls, "")
        return writable_mesh(cls, context, bound=False)


class LISSOM_OT_pose_handle_add(_UnboundObject, bpy.types.Operator):
    """Make a handle of a vertex group: an Empty at its centre that will move its vertices"""

    bl_idname = "lissom.pose_handle_add"
    bl_label = "Add Handle"
    bl_options = {"REGISTER", "UNDO"}

    vertex_group: StringProperty(
        name="Vertex Group",
        description="The vertices to move. Empty: a new group of the vertices selected in Edit Mode",
        options={"SKIP_SAVE"},
    )

    @answering
    def execute(self, context):
        handles.add(context, self.object, self.vertex_group)


class LISSOM_OT_pose_handle_remove(_UnboundObject, bpy.types.Operator):
    """Remove a handle and its Empty; the vertex group stays"""

    bl_idname = "lissom.pose_handle_remove"
    bl_label = "Remove Handle"
    bl_options = {"REGISTER", "UNDO"}

    handle: StringProperty(
        name="Handle", description="Name of its vertex group; empty: the active one", options={"SKIP_SAVE"}
    )

    @answering
    def execute(self, context):
        handles.remove(context, self.object, self.handle)


class LISSOM_OT_pose_handle_select(bpy.types.Operator):
    """Select the Empty of this handle, to move it"""

    bl_idname = "lissom.pose_handle_select"
    bl_label = "Select Handle"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    handle: StringProperty(name="Handle", description="Name of its vertex group", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        handles.select(context, self.object, self.handle)


class LISSOM_OT_pose_region_from_selection(_UnboundObject, bpy.types.Operator):
    """Make a vertex group of the vertices selected in Edit Mode, and let only those move"""

    bl_idname = "lissom.pose_region_from_selection"
    bl_label = "Region from Selection"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Vertex Group", description="Name of the new vertex group", default="Region")

    @answering
    def execute(self, context):
        obj = handles.unbound(context, self.object)
        obj.lissom_pose.roi = groups.from_selection(obj, self.name)


classes = (
    LISSOM_OT_pose_handle_add,
    LISSOM_OT_pose_handle_remove,
    LISSOM_OT_pose_handle_select,
    LISSOM_OT_pose_region_from_selection,
)
