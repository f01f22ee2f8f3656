"""In-between: two shape keys, and sliders that play the arc between them."""

import bpy

from ..bridge import arcs, checks, sliders
from ..drawing import ghost
from ..properties.inbetween import SETTINGS, PathSettings
from .common import Sidebar, draw_fold, draw_lines, split_column


def set_bake(button, obj):
    """Gives the button of Bake what the panel of this object says."""
    button.object = obj.name
    for name in ("start", "end", "slider", *SETTINGS):
        setattr(button, name, getattr(obj.lissom_inbetween, name))


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
        column = split_column(layout)
        column.prop(
            settings, "start", text="From" if settings.start else "From (Basis)", icon="SHAPEKEY_DATA"
        )
        column.prop(settings, "end", icon="SHAPEKEY_DATA")
        column.prop(settings, "sampling")
        column.prop(settings, "tolerance" if settings.sampling == "TOLERANCE" else "count")
        column.prop(settings, "easing")
        column.prop(settings, "slider", placeholder=f"{settings.end} arc" if settings.end else "")
        body = draw_fold(layout, "arc_options", "Options")
        if body:
            column = split_column(body)
            for name in (*PathSettings.__annotations__, "playback", "reroute"):
                column.prop(settings, name)
        layout.prop(settings, "ghost", icon="GHOST_ENABLED" if settings.ghost else "GHOST_DISABLED")
        shadow = ghost.of(obj)
        if settings.ghost and shadow is not None and shadow.message:
            draw_lines(layout, "INFO", shadow.message)
        row = layout.row()
        row.scale_y = 1.4
        set_bake(row.operator("lissom.inbetween_bake", icon="IPO_EASE_IN_OUT"), obj)
        reason = arcs.refusal(obj)
        if reason:
            draw_lines(layout, "INFO", reason)
        self._draw_sliders(layout, obj, settings)

    def _draw_sliders(self, layout, obj, settings):
        baked = [arc for arc in settings.arcs if arc.name in obj]
        if not baked:
            return
        layout.label(text="Sliders:")
        for arc in baked:
            row = layout.row(align=True)
            row.prop(obj, sliders.data_path(arc.name), text=arc.name, slider=True)
            second = row.operator("lissom.inbetween_second_image", text="", icon="IMAGE_DATA")
            second.object, second.slider = obj.name, arc.name
            for action, icon in (("rebake", "FILE_REFRESH"), ("rename", "GREASEPENCIL"), ("remove", "X")):
                button = row.operator(f"lissom.inbetween_{action}", text="", icon=icon)
                button.object, button.slider = obj.name, arc.name


classes = (LISSOM_PT_inbetween,)
