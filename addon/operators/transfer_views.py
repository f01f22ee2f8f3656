"""Source and target each in a view of its own, side by side, to pick in both at once."""

import bpy
import numpy as np
from mathutils import Vector

from .. import session
from ..bridge.assembly import both_sides
from ..core.framing import framed, free_span
from ..core.refused import Refused
from .job import allowed, answering


class LISSOM_OT_marker_views(bpy.types.Operator):
    """Split the view in two, the source alone in the left one and the target alone in the right one, as long
    as this is on. Markers are picked in both"""

    bl_idname = "lissom.marker_views"
    bl_label = "Two Views"
    bl_options = {"REGISTER"}  # of the window, which undo leaves alone

    @classmethod
    def poll(cls, context):
        settings = context.scene.lissom_transfer
        missing = None in (settings.source, settings.target) or settings.source == settings.target
        return allowed(cls, "Choose two different objects as source and target first" if missing else "")

    @answering
    def execute(self, context):
        if session.views is not None:
            _together(context)
            return
        if context.area is None or context.area.type != "VIEW_3D":
            raise Refused("Two Views splits a 3D view: press it in one")
        if context.space_data.local_view is not None:
            raise Refused("This view is in Local View: leave it first (View > Local View)")
        sides = both_sides(context, "", "")
        own, before = context.area, set(context.screen.areas)
        sidebar = _region(own, "UI").width
        # The new view is the left one, and until Blender has drawn both, neither knows its place.
        bpy.ops.screen.area_split(direction="VERTICAL", factor=max(0.5 - 0.5 * sidebar / own.width, 0.25))
        (new,) = set(context.screen.areas) - before
        new.spaces.active.show_region_ui = False
        for area, objects in zip((new, own), sides, strict=True):
            _alone(context, area, objects)
        session.views = own.as_pointer(), new.as_pointer()
        bpy.app.timers.register(_frame, first_interval=0.0)


def _region(area, kind="WINDOW"):
    return next(region for region in area.regions if region.type == kind)


def _alone(context, area, objects):
    """Shows these objects and nothing else in a view; the selection stays as it was."""
    selected = {obj: obj.select_get() for obj in context.view_layer.objects}
    for obj in selected:
        obj.select_set(obj in objects)
    with context.temp_override(area=area, region=_region(area)):
        bpy.ops.view3d.localview(frame_selected=True)
    for obj, was in selected.items():
        obj.select_set(was)


def _frame():
    """Has either view show its objects beside what covers it."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.as_pointer() in (session.views or ()) and area.spaces.active.local_view is not None:
                _frame_view(area, [obj for obj in window.view_layer.objects if _in(area, obj)])


def _in(area, obj):
    return obj.type == "MESH" and obj.visible_get(viewport=area.spaces.active)


def _frame_view(area, objects):
    region, data = _region(area), area.spaces.active.region_3d
    corners = [obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box]
    covering = [
        (bar.x - region.x, bar.x - region.x + bar.width)
        for bar in (_region(area, "UI"), _region(area, "TOOLS"))
        if bar.width > 1
    ]
    across = 2 / data.window_matrix[0][0] * (data.view_distance if data.is_perspective else 1)
    size = region.width, region.height
    data.view_location, factor = framed(
        np.array(corners),
        np.array(data.view_rotation.to_matrix()),
        size,
        free_span(region.width, covering),
        across / region.width,
    )
    data.view_distance *= factor


def _together(context):
    """Back to one view; what was closed meanwhile is left alone."""
    own, new = session.views
    session.views = None
    areas = {area.as_pointer(): area for area in context.screen.areas if area.type == "VIEW_3D"}
    for area in filter(None, map(areas.get, (own, new))):
        if area.spaces.active.local_view is not None:
            with context.temp_override(area=area, region=_region(area)):
                bpy.ops.view3d.localview(frame_selected=True)  # as it looked before
    if own in areas and new in areas:
        with context.temp_override(area=areas[new], region=_region(areas[new])):
            bpy.ops.screen.area_close()


classes = (LISSOM_OT_marker_views,)
