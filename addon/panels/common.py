"""What the panels share."""

import blf
import bpy

from ..core import wording
from ..layouts import TAB
from ..translations import translated

# Pixels at a scale of 1: the sidebar as Blender opens it, and what in it is not text.
SIDEBAR, MARGINS, ICON, BUTTON = 280, 66, 24, 28


class Sidebar:
    """Mixin: a panel in the tab of the 3D View's sidebar, shown while its ``page`` is chosen on top of it."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB

    @classmethod
    def poll(cls, context):
        return context.window_manager.lissom_page == cls.page


def draw_fold(layout, name, label):
    """The body of a part that is folded away at first, or None while it is."""
    header, body = layout.panel(f"LISSOM_{name}", default_closed=True)
    header.label(text=label)
    return body


def draw_lines(layout, icon, text, margin=0):
    """A longer text over as many lines as the sidebar needs; the first has the icon, "NONE" for none.

    ``margin`` is what else stands beside it, in pixels at a scale of 1.
    """
    column = layout.column(align=True)
    column.scale_y = 0.8
    room = _room((ICON if icon != "NONE" else 0) + margin)
    for line in wording.lines(translated(text), lambda line: _width(line) <= room):
        column.label(text=line, icon=icon, translate=False)
        icon = "NONE" if icon == "NONE" else "BLANK1"


def draw_warnings(layout, warnings, page, name="", slider=""):
    """What jobs had to say, one a line, each with a button that takes it away once it is dealt with.

    ``page`` is that of the tab, ``name`` of the object and ``slider`` of the arc that they are kept with.
    """
    for place, line in enumerate(warnings.splitlines()):
        row = layout.row()
        draw_lines(row.column(), "ERROR", line, margin=BUTTON)
        dismiss = row.operator("lissom.warning_dismiss", text="", icon="X", emboss=False)
        dismiss.page, dismiss.object, dismiss.slider, dismiss.line = page, name, slider, place


def _room(beside):
    """Pixels that a line of text has in the sidebar beside its tabs and margins, and something else."""
    scale = bpy.context.preferences.system.ui_scale
    region = bpy.context.region
    width = region.width if region is not None and region.type == "UI" else SIDEBAR * scale
    return width - (MARGINS + beside) * scale


def _width(text):
    """Pixels that Blender's own font needs for a text."""
    preferences = bpy.context.preferences
    blf.size(0, preferences.ui_styles[0].widget.points * preferences.system.ui_scale)
    return blf.dimensions(0, text)[0]
