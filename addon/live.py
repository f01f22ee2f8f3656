"""The mesh follows its handles while an Empty moves.

Blender tells of moved objects after each update of the dependency graph. With a window, the solve then
waits for a timer, so that many mouse moves make one solve and the view is drawn in between; an iterative
method that stops early goes on from there while nothing moves. In background mode, where timers do not run,
the solve is done at once. Only moved Empties count, and the solve moves none: it cannot call itself.
"""

import time

import bpy
from bpy.app.handlers import persistent

from . import changes, session
from .bridge.checks import by_uid
from .bridge.screen import redraw_sidebars
from .jobs import applied, bound

_due = set()  # session_uids of mesh objects to solve
_delay = 0.0  # seconds until the next solve: half of what the last one took, to leave time for drawing
MAX_DELAY = 0.25
BUDGET = 1 / 60  # seconds that an iterative method may take in one go while the artist watches


def mark(obj):
    """Has the pose of a bound mesh object solved at the next occasion."""
    _due.add(obj.session_uid)
    if not bpy.app.background and not bpy.app.timers.is_registered(_flush):
        bpy.app.timers.register(_flush, first_interval=_delay)


def _flush():
    global _delay
    started = time.perf_counter()
    for uid in list(_due):
        obj = by_uid(uid)
        if obj is None or not bound.follow(obj, BUDGET):
            _due.discard(uid)
    _delay = min(0.5 * (time.perf_counter() - started), MAX_DELAY)
    redraw_sidebars()
    return _delay if _due else None


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
    _due.clear()
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
    _due.clear()
    session.clear()
