"""Marker pairs picked with the mouse on both surfaces: the events; jobs.pick has what they do."""

import bpy

from .. import preferences, session
from ..bridge import picking
from ..bridge.screen import redraw_sidebars, redraw_views
from ..core.refused import Refused
from ..jobs import pick
from ..jobs.jump import Jumps
from ..translations import translated
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
        for warning in pick.begin(context):
            self.report({"WARNING"}, translated(warning))
        self._drag, self._said, self._picks = None, None, pick.Picks(_push)
        self._jumps, self._area = Jumps(), context.area and context.area.as_pointer()
        self._picks.ask(context.scene)
        self._say(context)
        context.window_manager.modal_handler_add(self)
        redraw_sidebars()
        return {"RUNNING_MODAL"}

    def execute(self, context):
        self.report({"ERROR"}, translated("Markers are picked with the mouse: scripts use lissom.marker_add"))
        return {"CANCELLED"}

    def modal(self, context, event):
        """One event; all that is not about marks stays the artist's."""
        answer = {"FINISHED"}  # for the panel's sake also where a bug of ours goes through as it is
        try:
            answer = self._event(context, event)
        except Refused as error:
            self.report({"WARNING"}, translated(str(error)))
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
        context.scene.lissom_transfer.show_markers = True  # also where an undo went behind the start
        self._jumps.back()
        context.workspace.status_text_set(None)
        redraw_views()
        redraw_sidebars()

    def _event(self, context, event):
        settings = context.scene.lissom_transfer
        if session.picking is None or None in (settings.source, settings.target):
            return {"FINISHED"}
        answer = _key(event, self._picks, context.scene) if self._drag is None else None
        if answer:
            self._say(context)
            redraw_views()
            return answer
        if event.type == "MOUSEMOVE":
            self._picks.ask(context.scene)
            self._say(context)
        looks = event.type in {"MOUSEMOVE", "LEFT_CTRL", "RIGHT_CTRL"}
        takes = event.type in {"LEFTMOUSE", "RIGHTMOUSE"} and event.value in {"PRESS", "DOUBLE_CLICK"}
        if self._drag is None and not (looks or takes):
            return {"PASS_THROUGH"}
        pane = picking.pane_under(context.window, event.mouse_x, event.mouse_y)
        if pane is not None:
            self._area = pane.area.as_pointer()
        stage = pane and picking.Stage(
            context.scene, context.evaluated_depsgraph_get(), pane.view, pane.space, session.picking
        )
        if self._drag is not None:
            return self._dragged(context, event, pane, stage)
        if looks:
            self._look(pane, stage, event.ctrl)
        if looks or pane is None:
            return {"PASS_THROUGH"}
        took = self._press(context, event, pane, stage)
        redraw_views()
        return {"RUNNING_MODAL"} if took else {"PASS_THROUGH"}

    def _say(self, context):
        """What is asked for, in the status bar; no more than is new, since the mouse asks at every move."""
        asked = self._picks.asked(context.scene)
        said = f"{asked}    |    Tab: skip    |    {HINT}" if asked else HINT
        if said != self._said:
            self._said = said
            context.workspace.status_text_set(translated(said))
            redraw_views()
        if preferences.jumps():
            self._jumps.follow(context, session.picking, session.views, self._area)

    def _look(self, pane, stage, ctrl):
        """Puts the ring around the mark or the rim that a click would take."""
        spot = stage and stage.ring_at(pane.spot, picking.ui_scale(), ctrl)
        ring = spot and (pane.region.as_pointer(), spot)
        if ring != session.picking.ring:
            session.picking.ring = ring
            redraw_views()

    def _press(self, context, event, pane, stage):
        """Whether a press of a button was about marks."""
        scale = picking.ui_scale()
        found = None if event.ctrl else stage.mark_at(pane.spot, scale)
        if event.type == "RIGHTMOUSE":
            if found:
                self._picks.remove(context.scene, found[0].index)
                self._say(context)
            return found is not None
        if found:
            self._drag, session.picking.ring = found[0], None
            return True
        found = stage.point_at(pane.spot, scale, exact=event.ctrl)
        if found:
            self._picks.take(context.scene, *found[:2])
            self._say(context)
        return found is not None

    def _dragged(self, context, event, pane, stage):
        index, _, side, before = self._drag
        rows = context.scene.lissom_transfer.markers
        if index >= len(rows) or (index < 0 and session.picking.side != side):
            self._drag = None
        elif event.type == "MOUSEMOVE":
            found = stage and stage.point_at(pane.spot, picking.ui_scale(), exact=event.ctrl, only=side)
            if found:
                self._picks.move(context.scene, index, side, found[1])
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            self._picks.move(context.scene, index, side, before)
            self._drag = None
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._drag = None
            self._picks.moved(context.scene, index, side, before)
        redraw_views()
        return {"RUNNING_MODAL"}


def _key(event, picks, scene):
    """What a key does while nothing is dragged: an answer of modal(), or None."""
    pressed = event.value == "PRESS"
    if event.type in {"RET", "NUMPAD_ENTER", "ESC"} and pressed:
        return {"FINISHED"}
    if (
        event.type == "Z"
        and (event.ctrl or event.oskey)
        and not event.shift
        and session.picking.side
        and pressed
    ):
        picks.remove(scene, -1)  # a half is no undo step of Blender's
        return {"RUNNING_MODAL"}
    if event.type == "TAB" and session.picking.wanted:
        if pressed:
            picks.skip(scene)
        return {"RUNNING_MODAL"}
    return None


def _push(message):
    bpy.ops.ed.undo_push(message=message)
    redraw_sidebars()


classes = (LISSOM_OT_marker_pick,)
