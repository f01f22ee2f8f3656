"""Transfer: source, target, markers, fit, keys."""

import bpy

from .. import session
from ..bridge import colours, shape_keys
from ..bridge import markers as bridge_markers
from ..bridge.assembly import both_sides
from ..bridge.written import is_edited
from ..core.colours import LEGEND, LIMIT
from ..core.refused import Refused
from .common import BUTTON, Sidebar, draw_fold, draw_lines, split_column
from .keys import draw_made_keys
from .quality import draw_quality, draw_review


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
        row.prop(item, "mirror", text="", icon="MOD_MIRROR", emboss=False)
        row.operator("lissom.marker_show", text="", icon="RESTRICT_SELECT_OFF", emboss=False).index = index


class LISSOM_UL_keys(bpy.types.UIList):
    """The source's shape keys with a tick each."""

    bl_idname = "LISSOM_UL_keys"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        ticked = item.name in context.scene.lissom_transfer.chosen
        row = layout.row(align=True)
        toggle = row.operator(
            "lissom.transfer_choose",
            text="",
            icon="CHECKBOX_HLT" if ticked else "CHECKBOX_DEHLT",
            emboss=False,
        )
        toggle.action, toggle.key = "TOGGLE", item.name
        row.label(text=item.name, translate=False)
        target = context.scene.lissom_transfer.target
        if target is not None and is_edited(target, item.name):
            row.label(text="", icon="SCULPTMODE_HLT")

    def filter_items(self, context, data, property_name):
        keys = getattr(data, property_name)
        helper = bpy.types.UI_UL_list
        flags = [self.bitflag_filter_item] * len(keys)
        if self.filter_name:
            flags = helper.filter_items_by_name(self.filter_name, self.bitflag_filter_item, keys)
        offered = set(shape_keys.key_names(context.scene.lissom_transfer.source))
        return [flag if key.name in offered else 0 for flag, key in zip(flags, keys, strict=True)], []


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


KEY_OPTIONS = ("unmatched", "scale", "exists", "edited", "drivers", "contact", "drop_empty", "check")
POSE_OPTIONS = ("unmatched", "scale", "exists", "edited", "contact")
ANIMATION_OPTIONS = ("unmatched", "scale", "contact")
ATTRIBUTE_OPTIONS = ("vertex_groups", "uv_maps", "colours", "exists")
FIT_OPTIONS = ("overlap", "marker_tolerance", "match_distance", "closest", "source_mask", "target_mask")


OPTIONS = {
    "fit": (),
    "keys": KEY_OPTIONS,
    "pose": POSE_OPTIONS,
    "animation": ANIMATION_OPTIONS,
    "attributes": ATTRIBUTE_OPTIONS,
}


def set_transfer(button, settings, what):
    """Gives the button of ``lissom.transfer_<what>`` what the panel says."""
    for name in (*OPTIONS[what], *FIT_OPTIONS):
        setattr(button, name, getattr(settings, name))
    if what in ("pose", "animation"):
        button.name = settings.pose_name
    if what == "keys" and settings.which == "SELECTED":
        button.keys = "\n".join(row.name for row in settings.chosen)
    if what == "animation":
        button.step = settings.bake_step
        button.output, button.cache_path = settings.bake_output, settings.bake_path


def fit_of(settings):
    """The last fit, where it is one of the objects that are chosen; else None."""
    memory = session.fit
    if memory is None or not settings.source or not settings.target:
        return None
    same = (memory.source.name, memory.target.name) == (settings.source.name, settings.target.name)
    return memory if same else None


def doubts(settings):
    """{ends: (marker, why)} of the markers that the last fit doubts."""
    memory = fit_of(settings)
    return memory.doubts if memory else {}


class LISSOM_PT_transfer(Sidebar, bpy.types.Panel):
    """Carry the shape keys of one mesh over to another of different topology."""

    bl_idname = "LISSOM_PT_transfer"
    page = "TRANSFER"
    bl_label = "Transfer"

    def draw(self, context):
        layout = self.layout
        settings = context.scene.lissom_transfer
        layout.context_pointer_set("lissom_transfer", settings)
        if session.review is not None:
            draw_review(layout, settings)
            return
        for side in ("source", "target"):
            row = layout.row(align=True)
            split_column(row).prop(settings, side, icon="OUTLINER_OB_MESH")
            row.operator("lissom.transfer_parts", text="", icon="ADD").side = side.upper()
            for place, part in enumerate(getattr(settings, f"{side}_parts")):
                row = layout.row(align=True)
                split_column(row).prop(part, "object", text=" ", icon="OUTLINER_OB_MESH")
                remove = row.operator("lissom.transfer_parts", text="", icon="REMOVE")
                remove.side, remove.remove = side.upper(), place
        self._draw_face(layout, settings)
        row = layout.row(align=True)
        row.operator("lissom.transfer_sides", icon="RESTRICT_SELECT_OFF")
        row.operator("lissom.transfer_sides", text="", icon="UV_SYNC_SELECT").swap = True
        if None in (settings.source, settings.target) or settings.source == settings.target:
            draw_lines(
                layout,
                "INFO",
                "Choose the mesh that has shape keys as source and the one that is to get them as target, or "
                "select both, the target last, and press From Selection",
            )
            return
        split_column(layout).prop(settings, "overlap")
        if not settings.overlap:
            self._draw_markers(layout, context)
            self._draw_curves(layout, settings)
        body = draw_fold(layout, "fit_options", "Fit Options")
        if body:
            self._draw_fit_options(split_column(body), settings)
        row = layout.row()
        row.scale_y = 1.4
        set_transfer(row.operator("lissom.transfer_fit", icon="MOD_SHRINKWRAP"), settings, "fit")
        self._draw_fit(layout, context)
        layout.row().prop(settings, "what", expand=True)
        draw = {
            "KEYS": self._draw_keys,
            "POSE": self._draw_pose,
            "ANIMATION": self._draw_animation,
            "ATTRIBUTES": self._draw_attributes,
        }
        draw[settings.what](layout, settings)
        if settings.what == "KEYS":
            draw_quality(layout, settings)
            draw_made_keys(layout, settings)

    def _draw_face(self, layout, settings):
        """The first offer: no source, no marker."""
        if settings.source is not None:
            return
        box = layout.box()
        draw_lines(box, "USER", "A head without face keys gets them by one press: no source, no marker")
        split_column(box).prop(settings, "face_names")
        row = box.row()
        row.scale_y = 1.4
        row.operator("lissom.face_keys", icon="SHAPEKEY_DATA").names = settings.face_names
        layout.label(text="Or from a face of your own:")

    def _draw_fit_options(self, column, settings):
        if len(settings.markers) and not settings.overlap:
            column.prop(settings, "marker_tolerance")
        column.prop(settings, "match_distance")
        if not settings.overlap:
            column.prop(settings, "closest")
        for side in ("source", "target"):
            objects = [getattr(settings, side), *(part.object for part in getattr(settings, f"{side}_parts"))]
            objects = list(filter(None, objects))
            mask = getattr(settings, f"{side}_mask")
            for obj in [obj for obj in objects if mask in obj.vertex_groups][:1] or objects[:1]:
                column.prop_search(settings, f"{side}_mask", obj, "vertex_groups")

    def _draw_without(self, layout, context):
        try:
            needless = bridge_markers.needless(*both_sides(context, "", ""))
        except Refused:
            return False
        if needless:
            draw_lines(layout, "CHECKMARK", "Both have the same faces: no markers are needed")
        else:
            draw_lines(layout, "INFO", "No markers: found by shape")
        return needless

    def _draw_markers(self, layout, context):
        settings = context.scene.lissom_transfer
        row = layout.row(align=True)
        row.label(text=f"Markers: {len(settings.markers)}" if len(settings.markers) else "Markers:")
        row.operator(
            "lissom.marker_pick", text="Pick", icon="EYEDROPPER", depress=session.picking is not None
        )
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
            _, doubt = doubts(settings).get(active.ends, (None, ""))
            if doubt:
                draw_lines(layout, "ERROR", f"This pair is {doubt}")
        needless = not len(settings.markers) and self._draw_without(layout, context)
        if len(settings.markers) < 3 and not needless:
            draw_lines(
                layout,
                "INFO",
                "Press Pick where the fit is off, then click a place on one mesh and the same place on the "
                "other: corners of eyes and mouth tell most",
            )

    def _draw_curves(self, layout, settings):
        column = layout.column(align=True)
        row = column.row(align=True)
        row.label(text=f"Curves: {len(settings.curves)}" if len(settings.curves) else "Curves:")
        row.operator("lissom.curve_add", text="From Edges", icon="EDGESEL")
        for place, curve in enumerate(settings.curves):
            row = column.row(align=True)
            row.prop(curve, "name", text="")
            counts = [len(set(vertices.split())) for vertices in curve.vertices]
            row.label(text="{} to {}".format(*counts))
            row.operator("lissom.curve_remove", text="", icon="X").index = place

    def _draw_fit(self, layout, context):
        settings = context.scene.lissom_transfer
        memory = fit_of(settings)
        if memory is None:
            return
        markers = [row.ends for row in settings.markers if not row.guessed]
        listed = ([], []) if settings.overlap else (markers, [row.vertices for row in settings.curves])
        current = (memory.pairs, memory.curves) == listed
        grave = any(fault.grave for fault in memory.faults)
        for place, fault in enumerate(memory.faults):
            self._draw_fault(layout, place, fault, current)
        if not current:
            draw_lines(layout, "INFO", "The markers were changed since the last fit: Transfer fits again")
        draw_lines(layout, "CHECKMARK" if current and not grave else "NONE", memory.summary)
        row = layout.row(align=True)
        shown = any(map(colours.shown, filter(None, (settings.source, settings.target))))
        row.operator(
            "lissom.fit_show", text="Hide Fit" if shown else "Show Fit", icon="COLOR", depress=shown
        ).show = not shown
        if not settings.overlap:
            row.operator("lissom.marker_suggest", icon="OUTLINER_OB_LIGHT")
        if shown:
            draw_lines(layout, "NONE", LEGEND.format(limit=100 * LIMIT))

    def _draw_fault(self, layout, place, fault, current):
        """One line of what is wrong, red until it is mended, and a button that shows where."""
        row = layout.row()
        told = row.column()
        told.alert = fault.grave
        draw_lines(told, "ERROR" if fault.grave else "INFO", fault.line, margin=BUTTON)
        if current:
            row.operator("lissom.fit_place", text="", icon="ZOOM_SELECTED").place = place

    def _draw_keys(self, layout, settings):
        source = settings.source
        layout.row().prop(settings, "which", expand=True)
        if settings.which == "SELECTED" and source and shape_keys.key_names(source):
            column = layout.column(align=True)
            column.template_list(
                "LISSOM_UL_keys",
                "",
                source.data.shape_keys,
                "key_blocks",
                source,
                "active_shape_key_index",
                rows=4,
            )
            row = column.row(align=True)
            row.operator("lissom.transfer_choose", text="All").action = "ALL"
            row.operator("lissom.transfer_choose", text="None").action = "NONE"
        split_column(layout).prop(settings, "scale")
        body = draw_fold(layout, "key_options", "Options")
        if body:
            column = split_column(body)
            for name in KEY_OPTIONS:
                if name != "scale":
                    column.prop(settings, name)
        self._draw_transfer(layout, settings, "keys", "SHAPEKEY_DATA")

    def _draw_pose(self, layout, settings):
        column = split_column(layout)
        for name in ("pose_name", *POSE_OPTIONS):
            column.prop(settings, name)
        self._draw_transfer(layout, settings, "pose", "ARMATURE_DATA")

    def _draw_animation(self, layout, settings):
        scene = settings.id_data
        column = split_column(layout)
        column.prop(settings, "pose_name")
        row = column.row(align=True)
        row.prop(scene, "frame_start", text="Frames")
        row.prop(scene, "frame_end", text="")
        column.prop(settings, "bake_step")
        column.prop(settings, "bake_output")
        if settings.bake_output == "CACHE":
            column.prop(settings, "bake_path", text="File")
        for name in ANIMATION_OPTIONS:
            column.prop(settings, name)
        self._draw_transfer(layout, settings, "animation", "RENDER_ANIMATION")

    def _draw_attributes(self, layout, settings):
        column = split_column(layout)
        for name in ATTRIBUTE_OPTIONS:
            column.prop(settings, name)
        self._draw_transfer(layout, settings, "attributes", "GROUP_VERTEX")

    def _draw_transfer(self, layout, settings, what, icon):
        row = layout.row()
        row.scale_y = 1.4
        set_transfer(row.operator(f"lissom.transfer_{what}", icon=icon), settings, what)


classes = (LISSOM_UL_markers, LISSOM_UL_keys, LISSOM_MT_markers, LISSOM_PT_transfer)
