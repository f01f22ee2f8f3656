"""What the panels share."""

import blf
import bpy

from ..core import wording
from ..layouts import TAB
from ..translations import translated

# Pixels at a scale of 1: the sidebar as Blender opens it, and what in it is not text.
SIDEBAR, MARGINS, ICON, BUTTON, LABEL = 280, 66, 24, 28, 10


class Sidebar:
    """Mixin: a panel in the tab of the 3D View's sidebar, shown while its ``page`` is chosen on top of it."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB

    @classmethod
    def poll(cls, context):
        return context.window_manager.lissom_page == cls.page


def labelled(layout, label, labels=(), name="", beside=0):
    """A row for a long name, whose label takes no more room than the longest of ``labels``.

    Where ``name`` would be cut with ``beside`` of pixels at a scale of 1 next to it, the label stands above.
    """
    widest = max(map(_width, map(translated, (label, *labels))))
    if name and _width(name) > _room(beside + LABEL) - widest:
        column = layout.column(align=True)
        if label:
            column.label(text=label)
        return column.row(align=True)
    split = layout.split(factor=min((widest + LABEL * _scale()) / _room(0), 0.45))
    side = split.row()
    side.alignment = "RIGHT"
    side.label(text=label)
    return split.row(align=True)


def side_by_side(layout, *texts):
    """A row for buttons with icons, or a column where these texts of theirs would be cut in it."""
    widest = len(texts) * max((translated(text) for text in texts), key=_width)  # a row shares alike
    return layout.row(align=True) if fits(widest, len(texts) * ICON) else layout.column(align=True)


def shares(texts):
    """(place, part of what is left of a row) of buttons, each as wide as its text needs."""
    needed = [_width(translated(text)) + ICON * _scale() for text in texts]
    return [(place, own / max(sum(needed[place:]), 1.0)) for place, own in enumerate(needed)]


def name_part(name, beside, margin):
    """The part of a list's row that a whole name needs with ``beside``, where the list needs ``margin``.

    Both are pixels at a scale of 1.
    """
    return min((_width(name) + beside * _scale()) / _room(margin), 0.85)


def fits(text, beside):
    """Whether a text has room in one line of the sidebar, ``beside`` so many pixels at a scale of 1."""
    return _width(text) <= _room(beside)


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
    scale = _scale()
    region = bpy.context.region
    width = region.width if region is not None and region.type == "UI" else SIDEBAR * scale
    return max(width - (MARGINS + beside) * scale, 1.0)


def _scale():
    return bpy.context.preferences.system.ui_scale


def _width(text):
    """Pixels that Blender's own font needs for a text."""
    blf.size(0, bpy.context.preferences.ui_styles[0].widget.points * _scale())
    return blf.dimensions(0, text)[0]
