"""A bound mesh whose method or options were changed is bound anew beside Blender.

Values that are dragged change many times a second: the work starts when they rest, and starts again where
they change meanwhile. Until it is done the mesh stays as it was last posed.
"""

import bpy
import lissom

from . import changes, live, session
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
    session.rebinding[obj.name] = None
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
    bpy.app.timers.register(_poll, first_interval=REST_SECONDS)


def _poll():
    for name in list(session.rebinding):
        try:
            if _goes_on(name):
                continue
        except (Refused, lissom.Error) as error:
            session.status[name] = ("ERROR", str(error))
        session.rebinding.pop(name, None)
    redraw_sidebars()
    return POLL_SECONDS if session.rebinding else None


def _goes_on(name):
    """One look at the work of an object; False where it is done or in vain."""
    obj, work = bpy.data.objects.get(name), session.rebinding[name]
    if obj is None or not obj.lissom_pose.bound:
        return False
    if work is None:
        work = session.rebinding[name] = bound.bind_again(obj)
        session.status[name] = ("SORTTIME", "Binding anew, as the options say")
    if not work.poll():
        return True
    work.result.forget()
    session.poses[obj.session_uid] = work.result
    session.status.pop(name, None)
    live.mark(obj)
    return False


def register():
    changes.pose_options.append(ask)


def unregister():
    """Stops all of it."""
    changes.pose_options.remove(ask)
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
