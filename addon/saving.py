"""What files, undo and redo hold of a review: pins, views and a mesh to mend on are of the review alone."""

import bpy
from bpy.app.handlers import persistent

from . import session
from .bridge import views
from .jobs.review import put_right

LOADED = 0.1  # seconds: a file is on the screen by then


@persistent
def _before(*_):
    bpy.context.scene.lissom_transfer.split_views = views.written(session.views)
    if session.review is not None:
        session.review.lift()


@persistent
def _after(*_):
    bpy.context.scene.lissom_transfer.split_views = ""
    if session.review is not None:
        session.review.show(bpy.context.scene.lissom_transfer)


@persistent
def _on_history(*_):
    if bpy.app.background:
        put_right(bpy.context)
    else:  # Blender is not done yet
        bpy.app.timers.register(lambda: put_right(bpy.context), first_interval=0.0)


@persistent
def _on_load(*_):
    _on_history()
    if not bpy.app.background:
        bpy.app.timers.register(_together, first_interval=LOADED)


def _together():
    settings = bpy.context.scene.lissom_transfer
    found = views.read(settings.split_views) if settings.split_views else None
    settings.split_views = ""
    if found:
        window, addresses = found
        with bpy.context.temp_override(window=window, screen=window.screen):
            views.together(bpy.context, addresses)


_HANDLERS = (
    *(("save_pre", _before), ("save_post", _after), ("save_post_fail", _after)),
    *(("undo_post", _on_history), ("redo_post", _on_history), ("load_post", _on_load)),
)


def register():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
