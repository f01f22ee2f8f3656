"""Pose: a region, handles, and Empties that move them."""

import bpy

from .. import session
from ..bridge import checks, company, empties, mirrors, poses
from ..core.pose_options import METHODS
from ..jobs.pose import bind_asked
from ..layouts import draw_options, split_column
from ..translations import translated
from .common import Sidebar, draw_fold, draw_lines, draw_warnings, labelled, side_by_side
from .presets import draw_presets

METHOD_LINES = {name: line for name, _, line in METHODS}


class LISSOM_UL_handles(bpy.types.UIList):
    """The handles of a mesh."""

    bl_idname = "LISSOM_UL_handles"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        obj = item.id_data
        known = item.name in obj.vertex_groups
        row = layout.row(align=True)
        row.alert = not known or not empties.is_alive(item.empty)
        if row.alert:
            lost = "no such group" if not known else "Empty deleted"
            row.label(text=f"{item.name} ({translated(lost)})", icon="ERROR", translate=False)
            return
        row.prop(item, "label", text="", icon="GROUP_VERTEX", emboss=False)
        chosen = item.empty.select_get()
        select = row.operator(
            "lissom.pose_handle_select",
            text="",
            icon="RESTRICT_SELECT_OFF" if chosen else "EMPTY_AXIS",
            emboss=False,
        )
        select.object, select.handle = obj.name, item.name


class LISSOM_MT_handle_add(bpy.types.Menu):
    """Choose the vertices of a new handle"""

    bl_idname = "LISSOM_MT_handle_add"
    bl_label = "Add Handle"

    def draw(self, context):
        layout = self.layout
        obj = checks.active_mesh(context)
        layout.context_pointer_set("lissom_object", obj)
        new = layout.operator(
            "lissom.pose_handle_add", text="From Selected Vertices", icon="RESTRICT_SELECT_OFF"
        )
        new.object = obj.name
        layout.separator()
        free = [group.name for group in obj.vertex_groups if group.name not in obj.lissom_pose.handles]
        for name in free:
            add = layout.operator("lissom.pose_handle_add", text=name, icon="GROUP_VERTEX", translate=False)
            add.object, add.vertex_group = obj.name, name
        if not free:
            layout.label(text="No other vertex group")


def set_bind(button, obj):
    """Gives the button of Bind what the panel of this object says."""
    asked = bind_asked(obj)
    given = {**asked.pose._asdict(), **asked.pose.options, "object": asked.object, "stands": asked.stands}
    del given["options"]
    for name, value in given.items():
        setattr(button, name, value)


class LISSOM_PT_pose(Sidebar, bpy.types.Panel):
    """Move a few handles, and the mesh follows with its details intact."""

    bl_idname = "LISSOM_PT_pose"
    page = "POSE"
    bl_label = "Pose"

    def draw(self, context):
        layout = self.layout
        obj = checks.active_mesh(context)
        if obj is None:
            draw_lines(
                layout, "INFO", "Select a mesh object, and add a handle for each part that moves or stays"
            )
            return
        settings = obj.lissom_pose
        layout.context_pointer_set("lissom_object", obj)
        layout.label(text=obj.name, icon="OUTLINER_OB_MESH", translate=False)
        self._draw_setup(layout.column(), obj, settings)
        if not settings.bound:
            self._draw_method(layout, settings)
            row = layout.row()
            row.scale_y = 1.4
            set_bind(row.operator("lissom.pose_bind", icon="LINKED"), obj)
            reason = checks.refusal(obj)
            if reason and obj.mode != "EDIT":
                draw_lines(layout, "INFO", reason)
            return
        self._draw_method(layout, settings)
        self._draw_bound(layout, obj, settings)

    def _draw_setup(self, column, obj, settings):
        row = column.row(align=True)
        row.enabled = not settings.bound
        row.prop_search(
            settings,
            "roi",
            obj,
            "vertex_groups",
            text="Region",
            icon="GROUP_VERTEX",
        )
        region = row.operator("lissom.pose_region_from_selection", text="", icon="ADD")
        region.object = obj.name
        column.separator()
        row = labelled(column, "Handles:")
        row.operator("wm.tool_set_by_id", text="On the Mesh", icon="BRUSH_DATA").name = "lissom.pose_tool"
        row = column.row()
        row.template_list("LISSOM_UL_handles", "", settings, "handles", settings, "chosen_handle", rows=3)
        side = row.column(align=True)
        side.enabled = not settings.bound
        side.menu("LISSOM_MT_handle_add", text="", icon="ADD")
        active = settings.active_handle
        remove = side.operator("lissom.pose_handle_remove", text="", icon="REMOVE")
        remove.object = obj.name
        if 0 <= active < len(settings.handles):
            remove.handle = settings.handles[active].name
        if 0 <= active < len(settings.handles):
            column.prop(settings.handles[active], "turns_by_itself")
        self._draw_company(column, obj, settings)
        if len(settings.handles) and poses.is_adrift(settings):
            column = split_column(column)
            column.prop(settings, "stays", text="What stays?")
            if settings.stays == "FAR":
                column.prop(settings, "reach")

    def _draw_company(self, column, obj, settings):
        row = column.row(align=True)
        row.enabled = not settings.bound
        row.label(text="Further Objects:" if len(settings.company) else "Further Objects: none")
        row.operator("lissom.pose_company", text="", icon="ADD").object = obj.name
        for place, other in enumerate(settings.company):
            row = column.row(align=True)
            row.enabled = not settings.bound
            there = company.is_there(other)
            row.alert = not there
            row.prop(other, "object", text="" if there else "Deleted")
            row.prop(other, "way", text="")
            remove = row.operator("lissom.pose_company", text="", icon="REMOVE")
            remove.object, remove.remove = obj.name, place

    def _draw_method(self, layout, settings):
        column = split_column(layout)
        column.prop(settings, "method")
        draw_lines(column, "NONE", METHOD_LINES[settings.method])
        column.prop(settings, "symmetry")
        for modifier in mirrors.taken(settings.id_data):
            draw_lines(column, "MOD_MIRROR", f"'{modifier.name}' mirrors the pose, and its seam stays closed")
        if not settings.bound:
            column.prop(settings, "stands")
        elif settings.stood:
            draw_lines(column, "ARMATURE_DATA", "Posed as it stands: Apply goes back through the modifiers")
        body = draw_fold(layout, "pose_options", "Options")
        if body:
            draw_presets(body, "pose")
            options = settings.options
            column = split_column(body)
            base = options.multiresolution.base
            draw_options(column, settings.method, base, lambda owner: getattr(options, owner))
            for name in ("use_weights", "weld"):
                row = column.row()
                row.enabled = name == "weld" or not settings.bound
                row.prop(settings, name)

    def _draw_bound(self, layout, obj, settings):
        layout.separator(factor=0.5)
        row = side_by_side(layout, "Live", "Update", "Reset")
        row.prop(settings, "live", toggle=True, icon="PLAY")
        row.operator("lissom.pose_update", icon="FILE_REFRESH").object = obj.name
        row.operator("lissom.pose_reset", text="Reset", icon="LOOP_BACK").object = obj.name
        icon, text = session.status.get(obj.session_uid, ("INFO", "Move an Empty: the mesh follows"))
        reason = poses.foreign_handles(obj) or poses.rescaled(obj) or poses.hidden(obj)
        if reason:
            icon, text = "ERROR", reason
        draw_lines(layout, icon, text)
        draw_warnings(layout, settings.warnings, "POSE", obj.name)
        layout.separator()
        box = layout.column(align=True)
        box.prop(settings, "key_name", icon="SHAPEKEY_DATA", text="")
        row = side_by_side(box, "Apply", "And Next")
        row.scale_y = 1.4
        apply = row.operator("lissom.pose_apply", text="Apply", icon="CHECKMARK")
        apply.object, apply.name = obj.name, settings.key_name
        following = row.operator("lissom.pose_apply", text="And Next", icon="NEXT_KEYFRAME")
        following.object, following.name, following.value = obj.name, settings.key_name, 0.0
        key = poses.to_drive(obj) if settings.stood else ""
        if key:
            said = translated(f"Drive '{key}' by Bone")
            drive = box.operator("lissom.pose_drive", text=said, icon="DRIVER", translate=False)
            drive.object, drive.key = obj.name, key
        self._draw_bake(layout, obj, settings)
        layout.operator("lissom.pose_unbind", icon="UNLINKED").object = obj.name

    def _draw_bake(self, layout, obj, settings):
        body = draw_fold(layout, "pose_bake", "Bake Animation")
        if not body:
            return
        scene = bpy.context.scene
        column = split_column(body)
        column.prop(settings, "bake_output")
        row = column.row(align=True)
        row.prop(scene, "frame_start", text="Frames")
        row.prop(scene, "frame_end", text="")
        column.prop(settings, "bake_step")
        if settings.bake_output == "CACHE":
            column.prop(settings, "bake_path", text="File")
        bake = body.operator("lissom.pose_bake", icon="RENDER_ANIMATION")
        bake.object, bake.name = obj.name, settings.key_name
        bake.output, bake.step = settings.bake_output, settings.bake_step
        bake.filepath = settings.bake_path


classes = (LISSOM_UL_handles, LISSOM_MT_handle_add, LISSOM_PT_pose)
