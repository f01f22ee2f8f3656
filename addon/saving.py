"""What is shown for a while is not for files, undo and redo: pins and views of a review, colours of a fit."""

import contextlib

import bpy
from bpy.app.handlers import persistent

from . import session
from .bridge import views
from .core.refused import Refused
from .jobs import fit_shown
from .jobs.review import put_right

_coloured = False  # whether the colours of a fit are shown again when the file is saved
LOADED = 0.1  # seconds: a file is on the screen by then


@persistent
def _before(*_):
    bpy.context.scene.lissom_transfer.split_views = views.written(session.views)
    if session.review is not None:
        session.review.lift()
    global _coloured
    _coloured = bool(fit_shown.coloured())
    fit_shown.hide(bpy.context)


@persistent
def _after(*_):
    bpy.context.scene.lissom_transfer.split_views = ""
    if session.review is not None:
        session.review.show(bpy.context.scene.lissom_transfer)
    if _coloured:
        with contextlib.suppress(Refused):  # the meshes were changed since the fit
            fit_shown.show(bpy.context)


@persistent
def _on_history(*_):
    if bpy.app.background:
        _put_right()
    else:  # Blender is not done yet
        bpy.app.timers.register(_put_right, first_interval=0.0)


def _put_right():
    put_right(bpy.context)
    fit_shown.put_right()


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
