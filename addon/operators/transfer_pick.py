"""Marker pairs picked with the mouse on both surfaces: the events; core.picking has the logic."""

import bpy

from .. import session
from ..bridge import landmarks, picking
from ..bridge import markers as bridge_markers
from ..bridge.markers import SIDES
from ..bridge.screen import redraw_sidebars, redraw_views
from ..core import markers
from ..core.landmarks import upcoming
from ..core.picking import Picking
from ..core.refused import Refused
from .job import allowed, answering

HINT = (
    "Click a place on one mesh, then the same place on the other    |    Drag: correct    |    "
    "Ctrl click: a new mark beside another    |    Right click: remove    |    Ctrl Z: undo    |    "
    "Enter or Esc: done"
)


class LISSOM_OT_marker_pick(bpy.types.Operator):
    """Click a place on one mesh, then the same place on the other; drag a mark to correct it, right-click to
    remove it, Ctrl-click for a new one beside another, press Enter or Esc when done"""

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
            if obj.hide_get() or obj.hide_viewport:  # a view may show one of them alone
                raise Refused(f"'{obj.name}' is hidden: show it first")
        known, warnings = bridge_markers.current(context.scene, *ends)
        markers.check(known, *(len(obj.data.vertices) for obj in ends))
        bridge_markers.put(context.scene, known, *ends)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        context.scene.lissom_transfer.show_markers = True
        session.picking = Picking()
        self._drag = self._asked = None
        self._ask(context)
        context.window_manager.modal_handler_add(self)
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
        if session.picking is None or None in (settings.source, settings.target):
            return {"FINISHED"}
        if event.type in {"RET", "NUMPAD_ENTER", "ESC"} and event.value == "PRESS" and self._drag is None:
            return {"FINISHED"}
        if event.type == "TAB" and session.picking.wanted and self._drag is None:
            if event.value == "PRESS":
                self._skip(context)
            return {"RUNNING_MODAL"}
        if event.type == "MOUSEMOVE":
            self._ask(context)
        pressed = event.value in {"PRESS", "DOUBLE_CLICK"}
        looks = event.type in {"MOUSEMOVE", "LEFT_CTRL", "RIGHT_CTRL"}
        if self._drag is None and not (looks or (event.type in {"LEFTMOUSE", "RIGHTMOUSE"} and pressed)):
            return {"PASS_THROUGH"}
        pane = picking.pane_under(context.window, event.mouse_x, event.mouse_y)
        stage = pane and picking.Stage(
            context.scene, context.evaluated_depsgraph_get(), pane.view, pane.space
        )
        if self._drag is not None:
            return self._dragged(context, event, pane, stage)
        if looks:
            self._look(pane, stage, event.ctrl)
            return {"PASS_THROUGH"}
        if pane is None:
            return {"PASS_THROUGH"}
        took = self._press(context, event, pane, stage)
        redraw_views()
        return {"RUNNING_MODAL"} if took else {"PASS_THROUGH"}

    def _ask(self, context):
        """Asks for the next landmark, and takes the half of it that a mesh bears already."""
        settings, picked = context.scene.lissom_transfer, session.picking
        state = settings.landmarks, tuple(row.name for row in settings.markers), len(picked.skipped)
        if state == self._asked:
            return
        names, marked = landmarks.names(settings), {row.name for row in settings.markers}
        picked.drop()
        picked.wanted = upcoming(names, marked, picked.skipped) or ""
        self._asked = state
        borne = {side: landmarks.of(getattr(settings, side)).get(picked.wanted) for side in SIDES}
        borne = {side: point for side, point in borne.items() if point is not None}
        try:
            for side, point in borne.items():
                self._pick(context, side, point)
        except Refused:  # another marker is there
            return self._skip(context)
        if len(borne) < 2:  # else it is a pair, after which the next was asked for
            self._say(context)

    def _say(self, context):
        """What is asked for, in the status bar."""
        names, picked = landmarks.names(context.scene.lissom_transfer), session.picking
        place = names.index(picked.wanted) + 1 if picked.wanted in names else 0
        where = {"source": "on the target", "target": "on the source"}.get(picked.side, "on either mesh")
        asked = f"{place} of {len(names)}: {picked.wanted}, {where}    |    Tab: skip    |    "
        context.workspace.status_text_set(asked + HINT if place else HINT)
        redraw_views()

    def _skip(self, context):
        session.picking.skipped.add(session.picking.wanted)
        self._ask(context)

    def _look(self, pane, stage, ctrl):
        """Puts the ring around the mark or the rim that a click would take."""
        picked, ring = session.picking, None
        if pane is not None:
            scale = picking.ui_scale()
            mark = None if ctrl else stage.mark_at(pane.spot, scale)
            rim = None if mark else stage.rim_at(pane.spot, scale, exact=ctrl)
            found = mark or rim
            ring = found and (pane.region.as_pointer(), found[-1])
        if ring != picked.ring:
            picked.ring = ring
            redraw_views()

    def _press(self, context, event, pane, stage):
        """Whether a press of a button was about marks."""
        scale = picking.ui_scale()
        found = None if event.ctrl else stage.mark_at(pane.spot, scale)
        if event.type == "RIGHTMOUSE":
            if found:
                self._remove(context, found[0].index)
            return found is not None
        if found:
            self._drag, session.picking.ring = found[0], None
            return True
        found = stage.point_at(pane.spot, scale, exact=event.ctrl)
        if found:
            self._pick(context, *found[:2])
        return found is not None

    def _pick(self, context, side, point):
        for marker in bridge_markers.of_scene(context.scene):
            if marker.point(side) == point:
                raise Refused(f"This place of the {side} bears marker '{marker.name}' already")
        pair = session.picking.take(side, point)
        if pair:
            settings = context.scene.lissom_transfer
            new = markers.Marker.between(session.picking.wanted, *map(pair.get, SIDES))
            bridge_markers.append(context.scene, [new], settings.source, settings.target)
            self._done("Pick Marker Pair")
            self._ask(context)
        else:
            self._say(context)

    def _remove(self, context, index):
        if index < 0:
            session.picking.drop()
            return
        bridge_markers.remove(context.scene, index)
        self._done("Remove Marker Pair")

    def _dragged(self, context, event, pane, stage):
        index, _, side, before = self._drag
        rows = context.scene.lissom_transfer.markers
        if index >= len(rows) or (index < 0 and session.picking.side != side):
            self._drag = None
        elif event.type == "MOUSEMOVE":
            found = stage and stage.point_at(pane.spot, picking.ui_scale(), exact=event.ctrl, only=side)
            if found:
                self._move(context, index, side, found[1])
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            self._move(context, index, side, before)
            self._drag = None
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._drag = None
            if index >= 0:
                context.scene.lissom_transfer.active_marker = index
                if rows[index].point(side) != before:
                    self._done("Move Marker")
        redraw_views()
        return {"RUNNING_MODAL"}

    def _move(self, context, index, side, point):
        if index < 0:
            session.picking.take(side, point)
        else:
            bridge_markers.move(context.scene, index, side, point)

    def _done(self, message):
        bpy.ops.ed.undo_push(message=message)
        redraw_sidebars()


classes = (LISSOM_OT_marker_pick,)
