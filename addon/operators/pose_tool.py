"""The tool to pose on the mesh itself: a click makes a handle, a drag moves it, Shift pins."""

import bpy
from bpy.props import BoolProperty, IntProperty

from ..bridge import brush, checks
from ..bridge.screen import redraw_sidebars
from ..core.refused import Refused
from ..drawing.shapes import ring
from ..jobs import touch as touched
from ..translations import translated
from .job import answering, require_rest

RADIUS = 40  # pixels


class LISSOM_OT_pose_touch(bpy.types.Operator):
    """Drag the mesh: a handle is made where it is clicked, and the rest follows. With Shift it is a pin"""

    bl_idname = "lissom.pose_touch"
    bl_label = "Pose on the Mesh"
    bl_options = {"REGISTER"}  # each drag is an undo step of its own

    pin: BoolProperty(name="Pin", description="The place stays where it is", options={"SKIP_SAVE"})

    def execute(self, context):
        self.report({"ERROR"}, translated("The tool needs the mouse: scripts use lissom.pose_handle_add"))
        return {"CANCELLED"}

    def invoke(self, context, event):
        """A press of the mouse button."""
        return self._start(context, (event.mouse_region_x, event.mouse_region_y))

    @answering
    def _start(self, context, spot):
        require_rest()
        obj = checks.active_mesh(context)
        if obj is None:
            raise Refused("Select a mesh object first")
        touch = touched.at(context, obj, spot, context.window_manager.lissom_brush, self.pin)
        if touch is None:  # passed on, a drag that misses by a few pixels would move the object
            bpy.ops.view3d.select(location=tuple(map(int, spot)))
            return {"FINISHED"}
        self._made = touch.made
        if self.pin:
            return self._done(context, "Pin")
        self._empty, self._place = touch.empty, touch.place
        self._before = bpy.data.objects[touch.empty].matrix_world.copy()
        self._moved = False
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(
            translated("Drag: pose    |    Esc or right click: back where it was")
        )
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Until the mouse button is up."""
        empty = bpy.data.objects.get(self._empty)
        if empty is None:
            return self._done(context, "")
        if event.type == "MOUSEMOVE":
            spot = event.mouse_region_x, event.mouse_region_y
            brush.drag(context, empty, self._place, self._before, spot)
            self._moved = True
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            empty.matrix_world = self._before
            return self._done(context, "Touch" if self._made else "")
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            return self._done(context, "Pose" if self._moved else "Touch" if self._made else "")
        return {"RUNNING_MODAL"}

    def _done(self, context, message):
        context.workspace.status_text_set(None)
        if message:
            bpy.ops.ed.undo_push(message=message)
        redraw_sidebars()
        return {"FINISHED"}


class PoseTool(bpy.types.WorkSpaceTool):
    """In the toolbar of the 3D View, in Object Mode."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "lissom.pose_tool"
    bl_label = "Pose on the Mesh"
    bl_description = (
        "Drag the active mesh: a click makes a handle, and the mesh follows it.\n"
        "Shift click: pin a place. Click beside it: select. F: size of the brush"
    )
    bl_icon = "ops.pose.push"
    bl_widget = None
    bl_keymap = (
        ("lissom.pose_touch", {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        ("lissom.pose_touch", {"type": "LEFTMOUSE", "value": "PRESS", "shift": True},
         {"properties": [("pin", True)]}),
        ("wm.radial_control", {"type": "F", "value": "PRESS"},
         {"properties": [("data_path_primary", "window_manager.lissom_brush")]}),
    )  # fmt: skip

    def draw_settings(context, layout, tool):
        """In the header."""
        layout.prop(context.window_manager, "lissom_brush")

    def draw_cursor(context, tool, spot):
        """The brush around the mouse."""
        radius = context.window_manager.lissom_brush
        ring((spot[0], spot[1]), radius - 1.0, radius + 0.5, (1.0, 0.62, 0.12, 0.9))


classes = (LISSOM_OT_pose_touch,)


def register():
    bpy.types.WindowManager.lissom_brush = IntProperty(
        name="Brush",
        description="Radius of what becomes a handle by a click, in pixels; it is soft toward its rim",
        default=RADIUS,
        min=1,
        max=1000,
        soft_max=200,
        subtype="PIXEL",
    )
    bpy.utils.register_tool(PoseTool, after={"builtin.transform"}, separator=True)


def unregister():
    bpy.utils.unregister_tool(PoseTool)
    del bpy.types.WindowManager.lissom_brush
