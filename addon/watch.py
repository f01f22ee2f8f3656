"""Which arcs are out of date: looked at when an object with arcs was changed and then rests."""

import bpy
from bpy.app.handlers import persistent

from . import session
from .bridge import arcs
from .bridge.checks import by_uid
from .bridge.screen import redraw_sidebars

REST_SECONDS = 0.7

_due = set()  # session_uids of mesh objects to look at


def look(obj):
    """Finds the arcs of an object that are out of date, for the panel; returns their names."""
    for arc in obj.lissom_inbetween.arcs:
        arcs.find_ends(obj, arc)
    found = [arc.name for arc in obj.lissom_inbetween.arcs if arcs.is_stale(obj, arc)]
    session.stale[obj.session_uid] = found
    return found


@persistent
def _on_update(scene, depsgraph):
    for change in depsgraph.updates:
        if not (change.is_updated_geometry and isinstance(change.id, bpy.types.Object)):
            continue
        obj = change.id.original
        if obj.type == "MESH" and len(obj.lissom_inbetween.arcs):
            _due.add(obj.session_uid)
    if _due and not bpy.app.background:  # anew with every change: not while an artist sculpts or an arc plays
        if bpy.app.timers.is_registered(_flush):
            bpy.app.timers.unregister(_flush)
        bpy.app.timers.register(_flush, first_interval=REST_SECONDS)


def _flush():
    for uid in list(_due):
        obj = by_uid(uid)
        if obj is not None and obj.type == "MESH" and obj.mode == "OBJECT":
            look(obj)
    _due.clear()
    redraw_sidebars()


def register():
    bpy.app.handlers.depsgraph_update_post.append(_on_update)


def unregister():
    bpy.app.handlers.depsgraph_update_post.remove(_on_update)
    if bpy.app.timers.is_registered(_flush):
        bpy.app.timers.unregister(_flush)
    _due.clear()
