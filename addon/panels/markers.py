"""Marker pairs and curves."""

import bpy

from .. import session
from ..bridge import markers as bridge_markers
from ..bridge.assembly import both_sides
from ..core.refused import Refused
from ..layouts import split_column
from ..translations import translated
from .common import draw_lines, fits
from .fit import FIT_OPTIONS, doubts

MARKER_ROW = 130  # pixels of what stands beside a name: number, signs, the list's edge and its buttons


class LISSOM_UL_markers(bpy.types.UIList):
    """Marker pairs."""

    bl_idname = "LISSOM_UL_markers"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index):
        row = layout.row(align=True)
        number = row.row()
        number.ui_units_x = 1.2
        number.label(text=str(item.number or index + 1))
        if item.ends in doubts(data):
            row.label(text="", icon="ERROR")
        if item.guessed:
            row.prop(item, "guessed", text="", icon="QUESTION", emboss=False)
        row.prop(item, "name", text="", emboss=False)


class LISSOM_MT_markers(bpy.types.Menu):
    """Files, landmarks, and the whole list"""

    bl_idname = "LISSOM_MT_markers"
    bl_label = "Markers"

    def draw(self, context):
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"  # the file browser
        layout.operator("lissom.marker_load", icon="IMPORT", text="Load...")
        layout.operator("lissom.marker_save", icon="EXPORT", text="Save...")
        layout.separator()
        layout.operator("lissom.marker_clear", icon="X", text="Remove All")
        layout.separator()
        layout.operator("lissom.landmarks_pair", icon="LINKED")
        guess = layout.operator("lissom.landmarks_guess", icon="QUESTION")
        for name in FIT_OPTIONS:
            setattr(guess, name, getattr(context.scene.lissom_transfer, name))


def draw_markers(layout, context):
    """The list of marker pairs, and what is said of the chosen one."""
    settings = context.scene.lissom_transfer
    row = layout.row(align=True)
    row.label(text=translated(f"Markers: {len(settings.markers)}" if len(settings.markers) else "Markers:"))
    row.operator("lissom.marker_pick", text="Pick", icon="EYEDROPPER", depress=session.picking is not None)
    row.operator("lissom.marker_views", text="", icon="SPLIT_VERTICAL", depress=session.views is not None)
    row.prop(settings, "show_markers", text="", icon="HIDE_OFF" if settings.show_markers else "HIDE_ON")
    split_column(layout).prop(settings, "landmarks")
    row = layout.row()
    row.template_list("LISSOM_UL_markers", "", settings, "markers", settings, "active_marker", rows=4)
    side = row.column(align=True)
    side.operator("lissom.marker_add", text="", icon="ADD")
    side.operator("lissom.marker_remove", text="", icon="REMOVE")
    side.separator()
    side.operator("lissom.marker_mirror", text="", icon="MOD_MIRROR")
    side.menu("LISSOM_MT_markers", text="", icon="DOWNARROW_HLT")
    if any(row.guessed for row in settings.markers):
        layout.operator("lissom.landmarks_confirm", icon="CHECKMARK")
    if settings.active_marker < len(settings.markers):
        active = settings.markers[settings.active_marker]
        row = layout.row(align=True)
        row.prop(active, "source", text="Source")
        row.prop(active, "target", text="Target")
        row.prop(active, "mirror", text="", icon="MOD_MIRROR")
        show = row.operator("lissom.marker_show", text="", icon="RESTRICT_SELECT_OFF")
        show.index = settings.active_marker
        if not fits(active.name, MARKER_ROW):
            draw_lines(layout, "NONE", active.name)
        _, doubt = doubts(settings).get(active.ends, (None, ""))
        if doubt:
            draw_lines(layout, "ERROR", f"This pair is {doubt}")
    needless = not len(settings.markers) and _draw_without(layout, context)
    if len(settings.markers) < 3 and not needless:
        draw_lines(
            layout,
            "INFO",
            "Press Pick where the fit is off, then click a place on one mesh and the same place on the "
            "other: corners of eyes and mouth tell most",
        )


def _draw_without(layout, context):
    try:
        needless = bridge_markers.needless(*both_sides(context, "", ""))
    except Refused:
        return False
    if needless:
        draw_lines(layout, "CHECKMARK", "Both have the same faces: no markers are needed")
    else:
        draw_lines(layout, "INFO", "No markers: found by shape")
    return needless


def draw_curves(layout, settings):
    """The list of curves."""
    column = layout.column(align=True)
    row = column.row(align=True)
    row.label(text=translated(f"Curves: {len(settings.curves)}" if len(settings.curves) else "Curves:"))
    row.operator("lissom.curve_add", text="From Edges", icon="EDGESEL")
    for place, curve in enumerate(settings.curves):
        row = column.row(align=True)
        row.prop(curve, "name", text="")
        counts = [len(set(vertices.split())) for vertices in curve.vertices]
        row.label(text=translated("{} to {}".format(*counts)))
        row.operator("lissom.curve_remove", text="", icon="X").index = place


classes = (LISSOM_UL_markers, LISSOM_MT_markers)
