"""The mesh follows its handles while an Empty moves.

Blender tells of moved objects after each update of the dependency graph. With a window, the solve then
runs beside it and a timer looks whether it is done: many mouse moves make one solve, and the view is drawn
in between; an iterative method that stops early goes on from there while nothing moves. In background mode,
where timers do not run, the solve is done at once. Only moved Empties count, and the solve moves none: it
cannot call itself.
"""

import time

import bpy
from bpy.app.handlers import persistent

from . import changes, session
from .bridge.checks import by_uid
from .bridge.screen import redraw_sidebars
from .jobs import applied, bound

_due = set()  # session_uids of mesh objects to solve
_running = {}  # session_uid -> Work that solves it
BUDGET = 1 / 60  # seconds that an iterative method may take in one go while the artist watches
PATIENCE = 1 / 125  # seconds in which a solve is waited for: what takes longer is shown when it is done
POLL = 1 / 250


def mark(obj):
    """Has the pose of a bound mesh object solved at the next occasion."""
    _due.add(obj.session_uid)
    if not bpy.app.background and not bpy.app.timers.is_registered(_flush):
        bpy.app.timers.register(_flush, first_interval=0.0)


def _flush():
    for uid in _due | _running.keys():
        _go_on(uid)
    return POLL if _due or _running else None


def _go_on(uid):
    """Starts to solve an object, or looks whether that is done."""
    work = _running.pop(uid, None)
    if work is None:
        _due.discard(uid)  # what moves from here on is due again
        obj = by_uid(uid)
        if obj is None:
            return
        work = bound.following(obj, BUDGET)
    until = time.perf_counter() + PATIENCE
    while not work.poll():
        if time.perf_counter() > until:
            _running[uid] = work
            return
        time.sleep(PATIENCE / 16)
    if work.result:
        _due.add(uid)
    redraw_sidebars()


def _stop():
    for work in _running.values():
        work.cancel()
    _running.clear()
    _due.clear()


@persistent
def _on_update(scene, depsgraph):
    if not session.following:
        session.edited.clear()
        return
    for change in depsgraph.updates:
        if change.is_updated_geometry:
            session.edited.clear()
        if not isinstance(change.id, bpy.types.Object):
            continue
        obj = change.id.original
        if applied.bound_mesh(obj):
            applied.follow(obj)
        if not change.is_updated_transform:
            continue
        obj = obj.lissom_handle_of
        if obj is not None and obj.lissom_pose.bound:
            mark(obj)
    if bpy.app.background:
        while _due:
            obj = by_uid(_due.pop())
            if obj is not None:
                bound.follow(obj)


@persistent
def _on_history(*_):
    """After undo or redo positions are those of the past: solve again, from the handles of the past."""
    session.history += 1
    session.status.clear()
    session.edited.clear()
    for obj in bpy.data.objects:
        if applied.bound_mesh(obj):
            applied.follow(obj)
            if obj.session_uid in session.poses:
                session.poses[obj.session_uid].forget()
            mark(obj)


@persistent
def _on_load(*_):
    session.history += 1
    _stop()
    session.clear()
    bound = list(filter(applied.bound_mesh, bpy.data.objects))
    if bound:
        bpy.context.view_layer.update()  # a file holds no matrices of objects
    for obj in bound:
        applied.note(obj)


_HANDLERS = (
    ("depsgraph_update_post", _on_update),
    ("frame_change_post", _on_update),
    ("undo_post", _on_history),
    ("redo_post", _on_history),
    ("load_post", _on_load),
)


def register():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)
    changes.handle_turn.append(mark)


def unregister():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
    changes.handle_turn.remove(mark)
    if bpy.app.timers.is_registered(_flush):
        bpy.app.timers.unregister(_flush)
    _stop()
    session.clear()
