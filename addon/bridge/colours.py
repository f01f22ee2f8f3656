"""Colours on meshes, and views that show them."""

import bpy
import numpy as np

from .. import session
from ..core.refused import Refused

NAME = "Lissom Fit"


def show(obj, colours):
    """Puts (n, 4) linear colours on the vertices of a mesh object as its active colour attribute."""
    hide(obj)
    attributes = obj.data.color_attributes
    if NAME in obj.data.attributes:
        raise Refused(f"'{obj.name}' has an attribute '{NAME}' that is no colour of ours: rename it first")
    if attributes.active_color is not None:
        session.colours[obj.session_uid] = attributes.active_color.name
    made = attributes.new(NAME, "FLOAT_COLOR", "POINT")
    made.data.foreach_set("color", np.ascontiguousarray(colours, dtype=np.float32).ravel())
    attributes.active_color = attributes[NAME]
    obj.data.update()


def hide(obj):
    """Takes them away."""
    found = obj.data.color_attributes.get(NAME)
    if found is None:
        return
    attributes = obj.data.color_attributes
    attributes.remove(found)
    before = session.colours.pop(obj.session_uid, None)
    if before is not None and before in attributes:
        attributes.active_color = attributes[before]


def shown(obj):
    """Whether they are there."""
    return NAME in obj.data.color_attributes


def views_show():
    """Has all 3D views show colour attributes; ``views_back`` undoes it."""
    for place, shading in _shadings():
        session.shadings.setdefault(place, (shading.type, shading.color_type))
        shading.type, shading.color_type = "SOLID", "VERTEX"


def views_back():
    """Gives the views the shading that they had."""
    for place, shading in _shadings():
        if place in session.shadings:
            kind, shading.color_type = session.shadings.pop(place)
            shading.type = kind


def _shadings():
    for screen in bpy.data.screens:
        for place, area in enumerate(screen.areas):
            if area.type == "VIEW_3D":
                yield (screen.name, place), area.spaces.active.shading
