"""The table of transferred keys with their verdicts, and the review of them one by one."""

import bpy

from .. import session
from ..core.quality import ORDERS, badness
from ..jobs.corrections import is_edited
from ..translations import translated
from .common import draw_lines, fits, labelled, name_part

BESIDE, LIST = 44, 30  # pixels: the verdict before a name, and what a list has beside its rows
VERDICT_ICONS = {"good": "CHECKMARK", "look": "INFO", "bad": "ERROR"}


class LISSOM_UL_quality(bpy.types.UIList):
    """The keys with what was said about each, the worst first."""

    bl_idname = "LISSOM_UL_quality"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        edited = data.target is not None and is_edited(data.target, item.name)
        said = _said(data, item)
        if not fits(item.name + said, BESIDE + LIST):  # it is below the table, for the active row
            said = ""
        # A name has the whole row where nothing is beside it.
        split = layout.split(factor=name_part(item.name, BESIDE, LIST)) if edited or said else layout.row()
        split.alert = item.verdict == "bad"
        split.label(text=item.name, translate=False, icon=VERDICT_ICONS[item.verdict])
        if edited or said:
            row = split.row(align=True)
            row.alignment = "RIGHT"
            if edited:
                row.label(text="", icon="SCULPTMODE_HLT")
            row.label(text=said, translate=False)

    def filter_items(self, context, data, property_name):
        rows = getattr(data, property_name)
        helper = bpy.types.UI_UL_list
        flags = []
        if self.filter_name:
            flags = helper.filter_items_by_name(self.filter_name, self.bitflag_filter_item, rows)
        rows = list(enumerate(rows))
        return flags, helper.sort_items_helper(
            rows, lambda pair: badness(pair[1], data.quality_order), reverse=True
        )


def _said(settings, row):
    """What the table is sorted by, of a row; "" for the verdict, which has a sign."""
    order = settings.quality_order
    return "" if order == "verdict" else translated(ORDERS[order][1](row))


def draw_quality(layout, settings):
    """The table, the review of it, and its file."""
    if not len(settings.quality):
        return
    row = layout.row()
    row.scale_y = 1.4
    row.operator("lissom.review", icon="VIS_SEL_11")
    row = labelled(layout, "Worst by")
    row.prop(settings, "quality_order", text="")
    row.operator("lissom.quality_save", text="", icon="EXPORT")
    _draw_table(layout, settings, 5)


def draw_review(layout, settings):
    """What the tab has while keys are looked at one by one."""
    row = layout.row(align=True)
    row.scale_y = 1.4
    row.operator("lissom.review", text="Done", icon="CHECKMARK", depress=True)
    row = labelled(layout, "Fix")
    row.operator("lissom.review_mend", text="Sculpt", icon="SCULPTMODE_HLT").by = "SCULPT"
    row.operator("lissom.review_mend", text="Handles", icon="EMPTY_AXIS").by = "HANDLES"
    mending = session.review.mending is not None
    keys = "Up and Down: another key. Space: the key on and off. Esc: done"
    draw_lines(layout, "INFO", "Esc: back to the review" if mending else keys)
    _draw_table(layout, settings, 15)


def _draw_table(layout, settings, rows):
    layout.template_list(
        "LISSOM_UL_quality", "", settings, "quality", settings, "active_quality", rows=rows, sort_lock=True
    )
    if settings.active_quality >= len(settings.quality):
        return
    active = settings.quality[settings.active_quality]
    said = _said(settings, active)
    if said and not fits(active.name + said, BESIDE + LIST):
        draw_lines(layout, "NONE", said)
    for reason in active.reasons.splitlines():
        said = translated(reason)
        draw_lines(layout, VERDICT_ICONS[active.verdict], said[:1].upper() + said[1:])
    if active.faces not in ("", "{}"):
        select = layout.operator("lissom.quality_select", icon="RESTRICT_SELECT_OFF")
        select.key = active.name


classes = (LISSOM_UL_quality,)
