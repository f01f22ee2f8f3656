"""A bound mesh whose method or options were changed is bound anew beside Blender.

Values that are dragged change many times a second: the work starts when they rest, and starts again where
they change meanwhile. Until it is done the mesh stays as it was last posed.
"""

import bpy
import lissom

from . import changes, live, session
from .bridge.checks import by_uid
from .bridge.screen import redraw_sidebars
from .core.refused import Refused
from .jobs import bound

REST_SECONDS = 0.15
POLL_SECONDS = 0.05


def ask(obj):
    """Has a bound mesh object bound anew, by its settings of the moment when the work starts."""
    if bpy.app.background:  # timers do not run: the next solve binds
        live.mark(obj)
        return
    bound.stop_binding(obj)
    session.rebinding[obj.session_uid] = None
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
    bpy.app.timers.register(_poll, first_interval=REST_SECONDS)


def _poll():
    for uid in list(session.rebinding):
        try:
            if _goes_on(uid):
                continue
        except (Refused, lissom.Error) as error:
            session.status[uid] = ("ERROR", str(error))
        session.rebinding.pop(uid, None)
    redraw_sidebars()
    return POLL_SECONDS if session.rebinding else None


def _goes_on(uid):
    """One look at the work of an object; False where it is done or in vain."""
    obj, work = by_uid(uid), session.rebinding[uid]
    if obj is None or not obj.lissom_pose.bound:
        return False
    if work is None:
        work = session.rebinding[uid] = bound.bind_again(obj)
        session.status[uid] = ("SORTTIME", "Binding anew, as the options say")
    if not work.poll():
        return True
    work.result.forget()
    session.poses[obj.session_uid] = work.result
    session.status.pop(uid, None)
    live.mark(obj)
    return False


def register():
    changes.pose_options.append(ask)


def unregister():
    """Stops all of it."""
    changes.pose_options.remove(ask)
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
