"""A file that is saved during a review is saved as it was before: pins and mutes are of the review alone."""

import bpy
from bpy.app.handlers import persistent

from . import session


@persistent
def _before(*_):
    if session.review is not None:
        session.review.lift()


@persistent
def _after(*_):
    if session.review is not None:
        session.review.show(bpy.context.scene.lissom_transfer)


_HANDLERS = (("save_pre", _before), ("save_post", _after), ("save_post_fail", _after))


def register():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister():
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
