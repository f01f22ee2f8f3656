"""Review of transferred keys: both meshes side by side, key after key; jobs.review has the logic."""

import bpy
from bpy.props import EnumProperty

from .. import session
from ..bridge import views
from ..bridge.assembly import both_sides
from ..bridge.screen import redraw_sidebars
from ..core.refused import Refused
from ..jobs.review import Review
from ..translations import translated
from .job import allowed, answering

TICK = 0.1  # seconds: so soon Done is noticed
LINK = 1 / 60  # seconds: so soon one view follows the other
HINT = "Up, Down: another key    |    Space: the key on, off    |    Esc: done"
MENDING = "Mend the key on the target    |    Esc: back to the review"
POSING = "Drag the mesh: a click makes a handle, Shift pins    |    Esc: back to the review"
STEPS = {"UP_ARROW": -1, "DOWN_ARROW": 1}


class LISSOM_OT_review(bpy.types.Operator):
    """Look at the transferred keys one by one, the worst first, source and target side by side. Press again,
    or Esc, when done: nothing is left changed"""

    bl_idname = "lissom.review"
    bl_label = "Review"
    bl_options = {"REGISTER"}  # of the window; what is mended has undo steps of its own

    @classmethod
    def poll(cls, context):
        settings = context.scene.lissom_transfer
        reason = "" if len(settings.quality) else "Transfer with Check Quality first"
        if None in (settings.source, settings.target) or settings.source == settings.target:
            reason = "Choose two different objects as source and target first"
        return allowed(cls, "" if session.review else reason)

    def invoke(self, context, event):
        """Starts the review, or ends it where it is under way."""
        return self._start(context)

    def execute(self, context):
        self.report({"ERROR"}, translated("A review is for the eye: scripts have lissom.quality_save"))
        return {"CANCELLED"}

    @answering
    def _start(self, context):
        if session.review is not None:
            session.review = None  # modal() sees it at the next tick
            return None
        sides = both_sides(context, "", "")
        self._review = Review(context, sides)
        self._splits = session.views is None
        try:
            if self._splits:
                session.views = views.split(context, sides)
        except BaseException:
            self._review.leave(context)
            raise
        self._looks = {} if self._splits else views.looks(session.views)
        session.review = self._review
        _link(self._review)
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(translated(HINT))
        redraw_sidebars()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """One event; all that is not about the review stays the artist's."""
        answer = {"FINISHED"}  # for the views' sake also where a bug of ours goes through as it is
        try:
            answer = self._event(context, event)
        finally:
            if answer == {"FINISHED"}:
                self._stop(context)
        return answer

    def cancel(self, context):
        """Blender ends the operator: a file is loaded, or Blender quits."""
        session.review = session.views = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _event(self, context, event):
        review, settings = self._review, context.scene.lissom_transfer
        if session.review is not review:
            return {"FINISHED"}
        context.workspace.status_text_set(translated(self._hint(review)))
        if event.value != "PRESS":
            return {"PASS_THROUGH"}
        if event.type == "ESC":
            if review.mending is None:
                return {"FINISHED"}
            try:
                review.rest(context)
            except Refused as error:
                self.report({"WARNING"}, translated(str(error)))
            bpy.ops.ed.undo_push(message="Fix Key")
            return {"RUNNING_MODAL"}
        if review.mending is not None or not views.under(context.window, event.mouse_x, event.mouse_y):
            return {"PASS_THROUGH"}
        if event.type in STEPS:
            review.step(settings, STEPS[event.type])
        elif event.type == "SPACE":
            review.toggle(settings)
        else:
            return {"PASS_THROUGH"}
        redraw_sidebars()
        return {"RUNNING_MODAL"}

    def _hint(self, review):
        mending = review.mending
        return HINT if mending is None else POSING if mending.mode == "OBJECT" else MENDING

    def _stop(self, context):
        session.review = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        self._review.leave(context)
        if self._splits and session.views is not None:
            before, session.views = session.views, None
            views.together(context, before)
        views.look_again(self._looks)
        redraw_sidebars()


def _link(review):
    """Has both views look alike as long as the review goes on, also while one is being turned."""
    linked = []

    def follow():
        if session.review is not review or session.views is None:
            return None
        if not views.settled(session.views):
            return LINK
        if not linked:
            views.frame(session.views)
            linked.append(views.Linked(session.views))
        linked[0].follow()
        return LINK

    bpy.app.timers.register(follow, first_interval=0.0)


class LISSOM_OT_review_mend(bpy.types.Operator):
    """Open the key on the target to be mended; press Esc to go back to the review"""

    bl_idname = "lissom.review_mend"
    bl_label = "Fix"
    bl_options = {"REGISTER"}  # sculpting and posing have undo steps of their own

    by: EnumProperty(
        name="By",
        description="What the key is mended with",
        items=[
            ("SCULPT", "Sculpt", "Sculpt the key"),
            ("HANDLES", "Handles", "Drag the mesh by handles: what is posed goes into the key"),
        ],
    )

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.review is not None else "Press Review first")

    @answering
    def execute(self, context):
        session.review.mend(context, self.by, session.views and session.views[0])
        bpy.ops.ed.undo_push(message="Fix Key")  # strokes are undone back to here
        redraw_sidebars()


classes = (LISSOM_OT_review, LISSOM_OT_review_mend)
