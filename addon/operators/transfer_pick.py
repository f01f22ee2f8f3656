"""Marker pairs picked with the mouse on both surfaces."""

import bpy

from .. import session
from ..bridge import markers as bridge_markers
from ..bridge import picking
from ..bridge.markers import SIDES
from ..bridge.screen import redraw_sidebars, redraw_views
from ..core import markers
from ..core.refused import Refused
from .job import allowed, answering

HINT = (
    "Click a place on one mesh, then the same place on the other    |    Drag: correct    |    "
    "Right click: remove    |    Ctrl Z: undo    |    Enter or Esc: done"
)


class LISSOM_OT_marker_pick(bpy.types.Operator):
    """Click a place on one mesh, then the same place on the other; drag a mark to correct it,
    right-click to remove it, press Enter or Esc when done"""

    bl_idname = "lissom.marker_pick"
    bl_label = "Pick Markers"
    bl_options = {"REGISTER"}  # each pair is an undo step of its own

    @classmethod
    def poll(cls, context):
        settings = context.scene.lissom_transfer
        missing = None in (settings.source, settings.target) or settings.source == settings.target
        return allowed(cls, "Choose two different objects as source and target first" if missing else "")

    def invoke(self, context, event):
        """Starts picking, or ends it where it is under way."""
        return self._start(context)

    @answering
    def _start(self, context):
        if session.picking is not None:  # the button again
            session.picking = None
            redraw_views()
            return None
        ends = bridge_markers.pair_of_objects(context, "", "")
        for obj in ends:
            if obj.mode != "OBJECT":
                raise Refused(f"'{obj.name}' is in {obj.mode.lower()} mode: go to Object Mode first")
            if not obj.visible_get():
                raise Refused(f"'{obj.name}' is hidden: show it first")
        known, warnings = bridge_markers.current(context.scene, *ends)
        markers.check(known, *(len(obj.data.vertices) for obj in ends))
        bridge_markers.put(context.scene, known, *ends)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        session.picking = picking.Picking()
        self._drag = None
        context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        redraw_views()
        redraw_sidebars()
        return {"RUNNING_MODAL"}

    def execute(self, context):
        self.report({"ERROR"}, "Markers are picked with the mouse: scripts use lissom.marker_add")
        return {"CANCELLED"}

    def modal(self, context, event):
        """One event; all that is not about marks stays the artist's."""
        answer = {"FINISHED"}  # for the panel's sake also where a bug of ours goes through as it is
        try:
            answer = self._event(context, event)
        except Refused as error:
            self.report({"WARNING"}, str(error))
            answer = {"RUNNING_MODAL"}
        finally:
            if answer == {"FINISHED"}:
                self._stop(context)
        redraw_views()
        return answer

    def cancel(self, context):
        """Blender ends the operator: a file is loaded, or Blender quits."""
        self._stop(context)

    def _stop(self, context):
        session.picking = None
        context.workspace.status_text_set(None)
        redraw_views()
        redraw_sidebars()

    def _event(self, context, event):
        settings = context.scene.lissom_transfer
        self._ends = settings.source, settings.target
        if session.picking is None or None in self._ends:
            return {"FINISHED"}
        if self._drag is not None:
            return self._dragged(context, event)
        if event.type in {"RET", "NUMPAD_ENTER", "ESC"} and event.value == "PRESS":
            return {"FINISHED"}
        if event.type not in {"LEFTMOUSE", "RIGHTMOUSE"} or event.value not in {"PRESS", "DOUBLE_CLICK"}:
            return {"PASS_THROUGH"}
        found = picking.view_under(context.window, event.mouse_x, event.mouse_y)
        if found is None:
            return {"PASS_THROUGH"}
        depsgraph = context.evaluated_depsgraph_get()
        mark = self._mark_under(context, depsgraph, *found)
        if event.type == "RIGHTMOUSE":
            if mark is None:
                return {"PASS_THROUGH"}
            self._remove(context, mark[0])
            return {"RUNNING_MODAL"}
        self._surfaces = [picking.Surface(obj, depsgraph) for obj in self._ends]
        if mark is not None:
            self._drag = *mark, self._vertex_of(context, *mark)
            return {"RUNNING_MODAL"}
        hits = self._hits(*found)
        if not hits:
            return {"PASS_THROUGH"}
        _, vertex, side = min(hits)
        self._pick(context, side, vertex)
        return {"RUNNING_MODAL"}

    def _hits(self, region, view, spot):
        """(distance, vertex, place of the side) of what is under the mouse."""
        ray = picking.ray(region, view, spot)
        found = [surface.hit(*ray) for surface in self._surfaces]
        return [(*hit, place) for place, hit in enumerate(found) if hit and self._ends[place].visible_get()]

    def _mark_under(self, context, depsgraph, region, view, spot):
        """(number, side) of the mark under the mouse; -1 is that of the pair that is begun; or None."""
        near = []
        for number, side, vertex in bridge_markers.marks_of(context):
            obj = self._ends[SIDES.index(side)]
            shown = picking.shown_mesh(obj, depsgraph)
            place = picking.on_screen(obj, vertex, shown, region, view)
            if place is not None and obj.visible_get():
                away = max(abs(place.x - spot[0]), abs(place.y - spot[1]))
                near.append((away, number, side))
        near = [entry for entry in near if entry[0] <= picking.REACH * picking.ui_scale()]
        return min(near)[1:] if near else None

    def _vertex_of(self, context, number, side):
        if number < 0:
            return session.picking.vertex
        return getattr(context.scene.lissom_transfer.markers[number], side)

    def _pick(self, context, place, vertex):
        side, begun = SIDES[place], session.picking
        pair = {side: vertex, begun.side: begun.vertex} if begun.side else {side: vertex}
        marker = markers.Marker(_name(context.scene), pair.get("source", -1), pair.get("target", -1))
        self._check(context, [marker], pair)
        if len(pair) < 2:
            session.picking = picking.Picking(side, vertex)
            return
        session.picking = picking.Picking()
        bridge_markers.append(context.scene, [marker], *self._ends)
        self._done("Pick Marker Pair")

    def _check(self, context, added, sides):
        """Refused where a vertex is marked already."""
        known = bridge_markers.of_scene(context.scene)
        for side in sides:
            for marker in known:
                if getattr(marker, side) in [getattr(new, side) for new in added]:
                    raise Refused(f"This vertex of the {side} bears marker '{marker.name}' already")

    def _remove(self, context, number):
        if number < 0:
            session.picking = picking.Picking()
            return
        settings = context.scene.lissom_transfer
        settings.markers.remove(number)
        settings.active_marker = max(0, min(number, len(settings.markers) - 1))
        self._done("Remove Marker Pair")

    def _dragged(self, context, event):
        number, side, before = self._drag
        if number >= len(context.scene.lissom_transfer.markers):
            self._drag = None
        elif event.type == "MOUSEMOVE":
            found = picking.view_under(context.window, event.mouse_x, event.mouse_y)
            hits = [hit for hit in self._hits(*found) if SIDES[hit[2]] == side] if found else []
            if hits:
                self._move(context, number, side, hits[0][1])
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            self._move(context, number, side, before)
            self._drag = None
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._drag = None
            if number >= 0:
                context.scene.lissom_transfer.active_marker = number
                if self._vertex_of(context, number, side) != before:
                    self._done("Move Marker")
        return {"RUNNING_MODAL"}

    def _move(self, context, number, side, vertex):
        rows = context.scene.lissom_transfer.markers
        if vertex in [getattr(row, side) for place, row in enumerate(rows) if place != number]:
            return
        if number < 0:
            session.picking = picking.Picking(side, vertex)
        else:
            setattr(rows[number], side, vertex)

    def _done(self, message):
        bpy.ops.ed.undo_push(message=message)
        redraw_sidebars()


def _name(scene):
    taken = {row.name for row in scene.lissom_transfer.markers}
    number = len(taken) + 1
    while f"Marker {number}" in taken:
        number += 1
    return f"Marker {number}"


classes = (LISSOM_OT_marker_pick,)
