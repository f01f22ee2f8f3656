"""The handles and the region of a pose."""

import bpy
import numpy as np
from bpy.props import StringProperty
from mathutils import Vector

from ..bridge import checks, empties, groups, standing
from ..core import space
from ..core.refused import Refused
from .job import allowed, answering, shown_object, writable_mesh
from .objects import OBJECT, unbound_object


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
        obj = unbound_object(self.object, context)
        space.linear_part(obj.matrix_world, obj.name)
        name = self.vertex_group or groups.from_selection(obj, "Handle")
        handles = obj.lissom_pose.handles
        if name in handles:
            raise Refused(f"'{name}' is a handle already")
        members = groups.members(obj, [name])
        if name not in members:
            raise Refused(f"'{obj.name}' has no vertex group named '{name}'")
        if not len(members[name]):
            raise Refused(f"Vertex group '{name}' holds no vertices: assign some, then add it")
        rest = standing.shown(obj)
        extent = np.ptp(space.into(np.array(obj.matrix_world)[:3, :3], rest), axis=0)
        empty = empties.add(
            obj,
            f"{obj.name} {name}",
            Vector(rest[members[name]].mean(axis=0)),
            0.04 * float(np.linalg.norm(extent)) or 1.0,
        )
        handle = handles.add()
        handle.name = name
        handle.empty = empty
        obj.lissom_pose.active_handle = len(handles) - 1
        obj.lissom_pose.property_unset("reach")


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
        obj = unbound_object(self.object, context)
        settings = obj.lissom_pose
        index = settings.handles.find(self.handle) if self.handle else settings.active_handle
        if not 0 <= index < len(settings.handles):
            raise Refused(
                f"'{obj.name}' has no handle '{self.handle}'" if self.handle else "Choose a handle first"
            )
        empty = settings.handles[index].empty
        if empty is not None and empty.lissom_handle_of == obj:
            bpy.data.objects.remove(empty)
        settings.handles.remove(index)
        settings.active_handle = max(0, min(settings.active_handle, len(settings.handles) - 1))
        settings.property_unset("reach")


class LISSOM_OT_pose_handle_select(bpy.types.Operator):
    """Select the Empty of this handle, to move it"""

    bl_idname = "lissom.pose_handle_select"
    bl_label = "Select Handle"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    handle: StringProperty(name="Handle", description="Name of its vertex group", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        handle = obj.lissom_pose.handles.get(self.handle)
        if handle is None or not empties.is_alive(handle.empty):
            raise Refused(f"Handle '{self.handle}' has no Empty: remove the handle and add it again")
        if context.mode != "OBJECT":
            raise Refused("Go to Object Mode first")
        for other in context.view_layer.objects:
            other.select_set(other == handle.empty)
        context.view_layer.objects.active = handle.empty


class LISSOM_OT_pose_region_from_selection(_UnboundObject, bpy.types.Operator):
    """Make a vertex group of the vertices selected in Edit Mode, and let only those move"""

    bl_idname = "lissom.pose_region_from_selection"
    bl_label = "Region from Selection"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Vertex Group", description="Name of the new vertex group", default="Region")

    @answering
    def execute(self, context):
        obj = unbound_object(self.object, context)
        obj.lissom_pose.roi = groups.from_selection(obj, self.name)


classes = (
    LISSOM_OT_pose_handle_add,
    LISSOM_OT_pose_handle_remove,
    LISSOM_OT_pose_handle_select,
    LISSOM_OT_pose_region_from_selection,
)
