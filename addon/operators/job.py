"""How operators answer: errors become reports, and long work runs beside Blender."""

import contextlib
import functools

import bpy
import lissom

from .. import session
from ..bridge import checks
from ..bridge.screen import redraw_sidebars
from ..core.refused import Refused
from ..translations import translated

POLL_SECONDS = 0.05
AT_WORK = "Lissom is at work: wait, or press ESC to cancel"


def answering(function):
    """An operator's method that returns nothing when all went well; a typed error becomes a report.

    Checks and computation come before the first write, so {'CANCELLED'} means that nothing was changed.
    """

    @functools.wraps(function)
    def answer(self, context, *arguments):
        try:
            return function(self, context, *arguments) or {"FINISHED"}
        except lissom.Cancelled:
            self.report({"WARNING"}, translated("Cancelled: nothing was changed"))
        except (Refused, lissom.Error) as error:
            self.report({"ERROR"}, translated(str(error)))
        return {"CANCELLED"}

    return answer


def allowed(operator_class, reason):
    """poll(): True where there is no reason against it, else the reason is what the disabled button says."""
    reason = AT_WORK if session.work is not None else reason
    if reason:
        operator_class.poll_message_set(translated(reason))
    return not reason


def require_rest():
    """Refused while other work goes on: there is one job at a time."""
    if session.work is not None:
        raise Refused(AT_WORK)


def shown_object(context):
    """The mesh object that a button acts on, as the panel says by a context pointer.

    None for a call from a script, which names any object by a property that poll() cannot see; there
    execute() refuses in the same words.
    """
    return getattr(context, "lissom_object", None)


def writable_mesh(operator_class, context, bound=None):
    """poll() of operators that write to a mesh; ``bound`` True or False asks for that state of its pose."""
    obj = shown_object(context)
    reason = "" if obj is None else checks.refusal(obj)
    if obj is not None and bound is not None and obj.lissom_pose.bound != bound:
        reason = "Press Bind first" if bound else "The mesh is bound: press Unbind first"
    return allowed(operator_class, reason)


class JobOperator:
    """Mixin of operators with long work.

    A subclass has ``begin(context)``, which reads the scene and returns core.work.Work, and
    ``finish(context, result)``, which writes. Between the two, Blender goes on: what ``begin`` keeps in
    ``self`` must be names and arrays, and ``finish`` must find its objects anew (bridge.meshes.Snapshot).
    """

    @answering
    def execute(self, context):
        """Waits: scripts, the redo panel and background mode."""
        work = self.begin(context)
        self.finish(context, work.wait())

    def invoke(self, context, event):
        """Runs beside Blender, polled by a timer; ESC cancels."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return self._start(context)

    @answering
    def _start(self, context):
        require_rest()
        work = self.begin(context)
        if work.finished:
            return self.finish(context, work.result)
        session.work = work
        self._history, self._scene = session.history, context.scene.session_uid
        manager = context.window_manager
        self._timer = manager.event_timer_add(POLL_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Looks at the work at every tick of the timer; all other events stay the artist's."""
        if event.type == "ESC" and event.value == "PRESS":
            session.work.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        answer = {"CANCELLED"}  # for the panel's sake also where a bug of ours goes through as it is
        try:
            answer = self._tick(context)
        finally:
            if answer != {"PASS_THROUGH"}:
                self._stop(context)
        return answer

    @answering
    def _tick(self, context):
        work = session.work
        if session.history != self._history:
            work.cancel()
            raise Refused("Undo or redo while Lissom was at work: cancelled, nothing was changed")
        if not work.poll():
            self._show(context, work)
            return {"PASS_THROUGH"}
        session.work = None  # what follows, as a review, is not to wait for it
        with self._where_it_began(context):
            return self.finish(context, work.result)

    def _where_it_began(self, context):
        """The scene that asked is the context's, also where another one is shown by now."""
        scene = next((one for one in bpy.data.scenes if one.session_uid == self._scene), None)
        if scene is None:
            raise Refused("The scene was deleted while Lissom was at work: nothing was changed")
        if scene == context.scene:
            return contextlib.nullcontext()
        return context.temp_override(scene=scene, view_layer=scene.view_layers[0])

    def cancel(self, context):
        """Blender ends the operator: a file is loaded, or Blender quits."""
        session.work.cancel()
        self._stop(context)

    def _show(self, context, work):
        fraction, stage = work.progress
        said = f"Lissom: {stage}, {100 * fraction:.0f} %    |    ESC: cancel"
        context.workspace.status_text_set(translated(said))
        redraw_sidebars()

    def _stop(self, context):
        session.work = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        redraw_sidebars()


class JobRunner(JobOperator):
    """Mixin: runs a job of ``job_class``, asked for as an ``asked_class``, and reports what it has done.

    ``keeps`` names the settings of the scene that keep its warnings for the panel, where there are such.
    """

    keeps = ""

    def asked(self, context):
        """What the operator's properties ask for."""
        return self.asked_class.of(self)

    def begin(self, context):
        self._job = self.job_class(context, self.asked(context))
        return self._job.work

    def finish(self, context, found):
        done = self._job.write(context, found)
        if self.keeps:
            getattr(context.scene, self.keeps).keep(done.kept)
        report_done(self, done, self.said(done))
        self.after(context, done)

    def said(self, done):
        """The report in one line."""
        return done.summary

    def after(self, context, done):
        """What follows the report; nothing, by default."""


def report_done(operator, done, summary=None):
    """Reports what a jobs.Done has to say; one that has stopped, as an error."""
    kind = "ERROR" if getattr(done, "stopped", False) else "INFO"
    operator.report({kind}, translated(summary or done.summary))
    for warning in reversed(done.warnings):  # what is reported last is what one sees
        operator.report({"WARNING"}, translated(warning))
