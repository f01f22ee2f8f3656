"""The last fit as colours on both meshes."""

import bpy
import numpy as np

from .. import session
from ..bridge import checks, colours
from ..core.colours import LIMIT, of_fit
from .fit import remembered


def coloured():
    """The mesh objects that bear the colours of a fit."""
    return [obj for obj in bpy.data.objects if obj.type == "MESH" and colours.shown(obj)]


def show(context):
    """Colours both sides of the last fit, and has all 3D views show them."""
    memory, source, target = remembered()
    objects = source.objects() + target.objects()
    for obj in objects:
        checks.require_writable(obj, keys=False)
    diagonal = float(np.linalg.norm(np.ptp(target.rest(), axis=0)))
    found = of_fit(memory.fit, source.geometry()[1], diagonal, LIMIT)
    for side, values in zip((source, target), found, strict=True):
        for obj, own in zip(side.objects(), side.split(values), strict=True):
            _hide(obj)
            before = colours.show(obj, own)
            if before is not None:
                session.colours[obj.session_uid] = before
    _shade()


def _shade():
    for place, shading in colours.shadings():
        session.shadings.setdefault(place, (shading.type, shading.color_type))
        shading.type, shading.color_type = "SOLID", "VERTEX"


def hide(context):
    """Takes the colours away, and gives the views the shading that they had."""
    for obj in coloured():
        _hide(obj)
    for place, shading in colours.shadings():
        if place in session.shadings:
            kind, shading.color_type = session.shadings.pop(place)
            shading.type = kind


def put_right():
    """After undo and redo: views show the colours where these are there, else what they showed before."""
    there = bool(coloured())
    if there and not session.shadings:  # else the artist may have chosen another shading since
        _shade()
    elif session.shadings and not there:
        hide(bpy.context)


def _hide(obj):
    colours.hide(obj, session.colours.pop(obj.session_uid, None) if colours.shown(obj) else None)
