"""The operators in Blender's own menus, where F3 finds them, and as a pie."""

import bpy

from ..bridge import checks
from ..translations import translated
from .inbetween import set_bake
from .keys import draw_sides
from .pose import set_bind
from .transfer import set_transfer


class _Buttons:
    """Operators with what the panels say, in one layout."""

    def __init__(self, layout, context):
        self._layout, self._obj = layout, checks.active_mesh(context)
        self._settings = context.scene.lissom_transfer
        layout.operator_context = "INVOKE_DEFAULT"
        if self._obj is not None:
            layout.context_pointer_set("lissom_object", self._obj)

    @property
    def bound(self):
        """Whether the active mesh follows its handles."""
        return self._obj is not None and self._obj.lissom_pose.bound

    def page(self, page, text, icon):
        """Opens the tab."""
        self._layout.operator("lissom.page_show", text=text, icon=icon).page = page

    def pose(self, what, icon="NONE"):
        """``lissom.pose_<what>``"""
        button = self._layout.operator(f"lissom.pose_{what}", icon=icon)
        if what == "bind" and self._obj is not None:
            set_bind(button, self._obj)

    def transfer(self, what, icon="NONE"):
        """``lissom.transfer_<what>``"""
        set_transfer(self._layout.operator(f"lissom.transfer_{what}", icon=icon), self._settings, what)

    def bake(self):
        """``lissom.inbetween_bake``"""
        button = self._layout.operator("lissom.inbetween_bake", text="Bake Arc", icon="IPO_EASE_IN_OUT")
        if self._obj is not None:
            set_bake(button, self._obj)


class LISSOM_MT_object(bpy.types.Menu):
    """Pose, transfer and in-between: what the tab in the sidebar has, with its settings"""

    bl_idname = "LISSOM_MT_object"
    bl_label = "Lissom"

    def draw(self, context):
        buttons = _Buttons(self.layout, context)
        buttons.page("POSE", "Pose Panel", "CON_ARMATURE")
        for what in ("bind", "update", "reset", "apply", "bake", "unbind"):
            buttons.pose(what)
        self.layout.separator()
        buttons.page("TRANSFER", "Transfer Panel", "MOD_DATA_TRANSFER")
        self.layout.operator("lissom.transfer_sides", text="Source and Target from Selection")
        self.layout.operator("lissom.marker_pick")
        for what in ("fit", "keys", "pose", "animation", "attributes"):
            buttons.transfer(what)
        self.layout.operator("lissom.review")
        self.layout.separator()
        buttons.page("INBETWEEN", "In-between Panel", "IPO_EASE_IN_OUT")
        buttons.bake()


class LISSOM_MT_pie(bpy.types.Menu):
    """What is done most, around the mouse"""

    bl_idname = "LISSOM_MT_pie"
    bl_label = "Lissom"

    def draw(self, context):
        pie = self.layout.menu_pie()
        buttons = _Buttons(pie, context)
        buttons.page("TRANSFER", "Transfer Panel", "MOD_DATA_TRANSFER")
        buttons.page("INBETWEEN", "In-between Panel", "IPO_EASE_IN_OUT")
        buttons.page("POSE", "Pose Panel", "CON_ARMATURE")
        buttons.pose(*(("apply", "CHECKMARK") if buttons.bound else ("bind", "LINKED")))
        pie.operator("lissom.marker_pick", icon="EYEDROPPER")
        buttons.transfer("keys", "SHAPEKEY_DATA")
        buttons.pose("reset", "LOOP_BACK")
        buttons.bake()


def _draw_object(menu, context):
    menu.layout.separator()
    menu.layout.menu(LISSOM_MT_object.bl_idname)


def _draw_vertices(menu, context):
    menu.layout.separator()
    menu.layout.operator("lissom.pose_handle_add", text="Add Handle of Lissom")
    menu.layout.operator("lissom.pose_region_from_selection", text="Region of Lissom")


def _draw_edges(menu, context):
    menu.layout.separator()
    menu.layout.operator("lissom.curve_add", text="Add Curve of Lissom")


def _draw_edited(menu, context):
    _draw_vertices(menu, context)
    if context.tool_settings.mesh_select_mode[1]:
        menu.layout.operator("lissom.curve_add", text="Add Curve of Lissom")


def _draw_groups(menu, context):
    obj = context.object
    if obj is None or obj.type != "MESH" or obj.vertex_groups.active is None:
        return
    menu.layout.separator()
    handle = menu.layout.operator("lissom.pose_handle_add", text="Add Handle of Lissom", icon="EMPTY_AXIS")
    handle.object, handle.vertex_group = obj.name, obj.vertex_groups.active.name


def _draw_keys(menu, context):
    obj = context.object
    if obj is None or obj.type != "MESH" or not obj.active_shape_key_index:
        return
    menu.layout.separator()
    menu.layout.operator_context = "INVOKE_DEFAULT"
    bake = menu.layout.operator("lissom.inbetween_bake", text="Bake Arc to This Key", icon="IPO_EASE_IN_OUT")
    set_bake(bake, obj)
    bake.end, bake.slider = obj.active_shape_key.name, ""
    drive = menu.layout.operator("lissom.pose_drive", icon="DRIVER")
    drive.object, drive.key = obj.name, obj.active_shape_key.name
    draw_sides(menu.layout, obj)
    settings = context.scene.lissom_transfer
    if settings.source == obj and settings.target is not None:
        transfer = menu.layout.operator(
            "lissom.transfer_keys",
            text=translated(f"Transfer to '{settings.target.name}'"),
            icon="SHAPEKEY_DATA",
        )
        set_transfer(transfer, settings, "keys")
        transfer.keys = obj.active_shape_key.name


def _draw_add(menu, context):
    menu.layout.separator()
    menu.layout.operator("lissom.source_face_add", icon="USER")


MENUS = {
    "VIEW3D_MT_mesh_add": _draw_add,
    "VIEW3D_MT_object": _draw_object,
    "VIEW3D_MT_object_context_menu": _draw_object,
    "VIEW3D_MT_edit_mesh_context_menu": _draw_edited,
    "VIEW3D_MT_edit_mesh_vertices": _draw_vertices,
    "VIEW3D_MT_edit_mesh_edges": _draw_edges,
    "MESH_MT_vertex_group_context_menu": _draw_groups,
    "MESH_MT_shape_key_context_menu": _draw_keys,
}

classes = (LISSOM_MT_object, LISSOM_MT_pie)
_keys = []


def register():
    for name, draw in MENUS.items():
        getattr(bpy.types, name).append(draw)
    own = bpy.context.window_manager.keyconfigs.addon
    if own is None:  # in background mode
        return
    keymap = own.keymaps.new(name="3D View", space_type="VIEW_3D")
    item = keymap.keymap_items.new("wm.call_menu_pie", "L", "PRESS", ctrl=True, shift=True)
    item.properties.name = LISSOM_MT_pie.bl_idname
    _keys.append((keymap, item))


def unregister():
    for keymap, item in _keys:
        keymap.keymap_items.remove(item)
    _keys.clear()
    for name, draw in MENUS.items():
        getattr(bpy.types, name).remove(draw)
