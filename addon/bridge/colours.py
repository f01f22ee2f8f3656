"""Colours on meshes, and views that show them."""

import bpy
import numpy as np

from ..core.refused import Refused

NAME = "Lissom Fit"


def show(obj, colours):
    """Puts (n, 4) linear colours on the vertices of a mesh object as its active colour attribute.

    Returns the name of the one that was active before, or None.
    """
    attributes = obj.data.color_attributes
    if NAME in obj.data.attributes:
        raise Refused(f"'{obj.name}' has an attribute '{NAME}' that is no colour of ours: rename it first")
    before = attributes.active_color.name if attributes.active_color is not None else None
    made = attributes.new(NAME, "FLOAT_COLOR", "POINT")
    made.data.foreach_set("color", np.ascontiguousarray(colours, dtype=np.float32).ravel())
    attributes.active_color = attributes[NAME]
    obj.data.update()
    return before


def hide(obj, before=None):
    """Takes them away; the attribute named ``before`` is the active one again."""
    found = obj.data.color_attributes.get(NAME)
    if found is None:
        return
    attributes = obj.data.color_attributes
    attributes.remove(found)
    if before is not None and before in attributes:
        attributes.active_color = attributes[before]


def shown(obj):
    """Whether they are there."""
    return NAME in obj.data.color_attributes


def shadings():
    """((screen, place of the area), shading) of all 3D views."""
    for screen in bpy.data.screens:
        for place, area in enumerate(screen.areas):
            if area.type == "VIEW_3D":
                yield (screen.name, place), area.spaces.active.shading
