"""In-between: two shape keys, and sliders that play the arc between them."""

import bpy

from .. import session
from ..bridge import arcs, checks, sliders
from ..core.refused import first
from ..drawing import ghost
from ..layouts import split_column
from ..properties.inbetween import SETTINGS, PathSettings
from ..translations import CONTEXT, translated
from .common import Sidebar, draw_fold, draw_lines, draw_warnings, fits, labelled
from .presets import draw_presets
from .ticks import TickList, draw_ticks

ENDS = ("From", "To")
BESIDE_NAME = 35  # pixels: an icon and a button
ARC_BUTTONS = 150  # pixels of what stands beside a slider's name: its value and its buttons


def set_bake(button, obj):
    """Gives the button of Bake what the panel of this object says."""
    button.object = obj.name
    for name in ("start", "end", "slider", *SETTINGS):
        setattr(button, name, getattr(obj.lissom_inbetween, name))


def set_bake_all(button, obj):
    """Gives the button of Bake All what the panel of this object says."""
    settings = obj.lissom_inbetween
    button.object, button.start = obj.name, settings.start
    button.keys = "\n".join(row.name for row in settings.chosen)
    for name in SETTINGS:
        setattr(button, name, getattr(settings, name))


class LISSOM_UL_arc_keys(TickList, bpy.types.UIList):
    """The shape keys that arcs can lead to, with a tick each."""

    bl_idname = "LISSOM_UL_arc_keys"
    tick = "lissom.inbetween_choose"

    def chosen(self, context):
        """The ticks."""
        return checks.active_mesh(context).lissom_inbetween.chosen

    def offered(self, context):
        """Names of the keys that can be ticked."""
        obj = checks.active_mesh(context)  # lists know no pointers of the panel
        return arcs.offered(obj, obj.lissom_inbetween.start)

    def draw_more(self, context, row, item, toggle):
        toggle.object = checks.active_mesh(context).name


class LISSOM_PT_inbetween(Sidebar, bpy.types.Panel):
    """Bake the arc between two shape keys, to be played by one slider."""

    bl_idname = "LISSOM_PT_inbetween"
    page = "INBETWEEN"
    bl_label = "In-between"

    def draw(self, context):
        layout = self.layout
        obj = checks.active_mesh(context)
        if obj is None:
            draw_lines(layout, "INFO", "Select a mesh object that has shape keys, or make one of a drawing:")
            layout.operator("lissom.inbetween_image", icon="IMAGE_DATA")
            return
        layout.context_pointer_set("lissom_object", obj)
        layout.label(text=obj.name, icon="OUTLINER_OB_MESH", translate=False)
        settings = obj.lissom_inbetween
        if obj.data.shape_keys is None:
            draw_lines(
                layout, "INFO", "This mesh has no shape keys yet: sculpt one, or pose one and press Apply"
            )
            return
        row = labelled(layout, "From", ENDS, settings.start, BESIDE_NAME)
        row.prop(settings, "start", text="", icon="SHAPEKEY_DATA", placeholder=translated("Basis"))
        if settings.several:
            for button in draw_ticks(layout, "LISSOM_UL_arc_keys", obj, "lissom.inbetween_choose", 5):
                button.object = obj.name
        else:
            labelled(layout, "To", ENDS, settings.end, BESIDE_NAME).prop(
                settings, "end", text="", icon="SHAPEKEY_DATA"
            )
        column = split_column(layout)
        column.prop(settings, "several")
        column.prop(settings, "sampling")
        if settings.sampling == "TOLERANCE":
            column.prop(settings, "tolerance")
        else:
            column.prop(settings, "count", text="Number", text_ctxt=CONTEXT)
        column.prop(settings, "easing")
        if not settings.several:
            column.prop(settings, "slider", placeholder=f"{settings.end} arc" if settings.end else "")
        body = draw_fold(layout, "arc_options", "Options")
        if body:
            draw_presets(body, "inbetween")
            column = split_column(body)
            for name in (*PathSettings.__annotations__, "playback", "reroute"):
                column.prop(settings, name)
        layout.prop(settings, "ghost", icon="GHOST_ENABLED" if settings.ghost else "GHOST_DISABLED")
        shadow = ghost.of(obj)
        if settings.ghost and shadow is not None:
            lost = arcs.missing(obj, settings)
            if shadow.message or lost:
                draw_lines(
                    layout, "INFO", shadow.message or f"{first(map(repr, lost))} is gone: choose another"
                )
            else:
                layout.prop(settings, "preview", slider=True)
        row = layout.row()
        row.scale_y = 1.4
        if settings.several:
            set_bake_all(row.operator("lissom.inbetween_bake_all", icon="IPO_EASE_IN_OUT"), obj)
        else:
            set_bake(row.operator("lissom.inbetween_bake", icon="IPO_EASE_IN_OUT"), obj)
        reason = arcs.refusal(obj)
        if reason:
            draw_lines(layout, "INFO", reason)
        self._draw_sliders(layout, obj, settings)

    def _draw_sliders(self, layout, obj, settings):
        baked = [arc for arc in settings.arcs if arc.name in obj]
        if not baked:
            return
        lost = {arc.name: arcs.missing(obj, arc) for arc in baked}
        stale = [name for name in session.stale.get(obj.session_uid, []) if not lost.get(name)]
        layout.label(text="Sliders:")
        if stale:
            draw_lines(layout, "ERROR", f"Out of date, since an end was changed: {first(map(repr, stale))}")
            layout.operator("lissom.inbetween_update_all", icon="FILE_REFRESH").object = obj.name
        ready = settings.exported
        if ready:
            draw_lines(layout, "INFO", "Keyframes play the arcs, for export: sliders rest meanwhile")
        export = layout.operator(
            "lissom.inbetween_export", text="Back to Sliders" if ready else "For Export", icon="EXPORT"
        )
        export.object, export.restore = obj.name, ready
        for arc in baked:
            row = layout.row(align=True)
            if arc.name in stale or lost[arc.name]:
                row.label(text="", icon="ERROR")
            row.prop(obj, sliders.data_path(arc.name), text=arc.name, translate=False, slider=True)
            if not fits(arc.name, ARC_BUTTONS):
                row = layout.row(align=True)
                row.alignment = "RIGHT"
            second = row.operator("lissom.inbetween_second_image", text="", icon="IMAGE_DATA")
            second.object, second.slider = obj.name, arc.name
            for action, icon in (("rebake", "FILE_REFRESH"), ("rename", "GREASEPENCIL"), ("remove", "X")):
                button = row.operator(f"lissom.inbetween_{action}", text="", icon=icon)
                button.object, button.slider = obj.name, arc.name
            if lost[arc.name]:
                self._draw_lost(layout, obj, arc, lost[arc.name])
            draw_warnings(layout, arc.warnings, "INBETWEEN", obj.name, arc.name)

    def _draw_lost(self, layout, obj, arc, lost):
        draw_lines(layout, "ERROR", f"{first(map(repr, lost))} is gone: choose another, and bake again")
        for name, end in zip(ENDS, ("start", "end"), strict=True):
            if getattr(arc, end) in lost:
                labelled(layout, name, ENDS, "", BESIDE_NAME).prop_search(
                    arc, end, obj.data.shape_keys, "key_blocks", text=""
                )


classes = (LISSOM_UL_arc_keys, LISSOM_PT_inbetween)
