"""Transfer: source, target, markers, fit, keys."""

import bpy

from .. import session
from ..bridge import shape_keys, source_face
from ..core.transfer_options import MASKS
from ..core.transfer_options import OPTIONS as TRANSFER_OPTIONS
from ..jobs.blinks import BLINKS
from ..jobs.corrections import is_edited
from ..layouts import split_column
from ..translations import translated
from .common import ICON, Sidebar, draw_fold, draw_lines, draw_warnings, fits, labelled
from .fit import FIT_OPTIONS, draw_fit
from .keys import draw_made_keys
from .markers import draw_curves, draw_markers
from .presets import draw_presets
from .quality import draw_quality, draw_review
from .ticks import TickList, draw_ticks


class LISSOM_UL_keys(TickList, bpy.types.UIList):
    """The source's shape keys with a tick each."""

    bl_idname = "LISSOM_UL_keys"
    tick = "lissom.transfer_choose"

    def chosen(self, context):
        """The ticks."""
        return context.scene.lissom_transfer.chosen

    def offered(self, context):
        """Names of the keys that can be ticked."""
        return shape_keys.key_names(context.scene.lissom_transfer.source)

    def draw_more(self, context, row, item, toggle):
        target = context.scene.lissom_transfer.target
        if target is not None and is_edited(target, item.name):
            row.label(text="", icon="SCULPTMODE_HLT")


ANIMATION_OPTIONS = tuple(TRANSFER_OPTIONS["transfer"])
POSE_OPTIONS = (*ANIMATION_OPTIONS, "exists", "edited")
KEY_OPTIONS = (*POSE_OPTIONS, "drivers", "drop_empty", "check")
ATTRIBUTE_OPTIONS = ("vertex_groups", "uv_maps", "colours", "exists")


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


SIDES = ("Source", "Target")
BESIDE_NAME = 50  # pixels: an icon and two buttons


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
            chosen = getattr(settings, side)
            row = labelled(layout, side.capitalize(), SIDES, chosen.name if chosen else "", BESIDE_NAME)
            row.prop(settings, side, text="", icon="OUTLINER_OB_MESH")
            row.operator("lissom.transfer_parts", text="", icon="ADD").side = side.upper()
            for place, part in enumerate(getattr(settings, f"{side}_parts")):
                name = part.object.name if part.object else ""
                row = labelled(layout, "", SIDES, name, BESIDE_NAME)
                row.prop(part, "object", text="", icon="OUTLINER_OB_MESH")
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
            draw_markers(layout, context)
            draw_curves(layout, settings)
        body = draw_fold(layout, "fit_options", "Fit Options")
        if body:
            draw_presets(body, "transfer")
            self._draw_fit_options(split_column(body), settings)
        row = layout.row()
        row.scale_y = 1.4
        set_transfer(row.operator("lissom.transfer_fit", icon="MOD_SHRINKWRAP"), settings, "fit")
        draw_fit(layout, context)
        self._draw_what(layout, settings)
        draw = {
            "KEYS": self._draw_keys,
            "POSE": self._draw_pose,
            "ANIMATION": self._draw_animation,
            "ATTRIBUTES": self._draw_attributes,
        }
        draw[settings.what](layout, settings)
        draw_warnings(layout, settings.told, "TRANSFER")
        if settings.what == "KEYS":
            draw_quality(layout, settings)
            draw_made_keys(layout, settings)

    def _draw_what(self, layout, settings):
        """Four buttons in a row, or two rows of two where the sidebar is narrow."""
        items = settings.bl_rna.properties["what"].enum_items
        words = "".join(translated(item.name) for item in items)
        grid = layout.grid_flow(
            row_major=True, columns=4 if fits(words, 4 * ICON) else 2, even_columns=True, align=True
        )
        for item in items:
            grid.prop_enum(settings, "what", item.identifier)

    def _draw_face(self, layout, settings):
        """The first offer: no source, no marker."""
        if settings.source is not None and not source_face.is_it(settings.source):
            return
        box = layout.box()
        draw_lines(box, "USER", "A head without face keys gets them by one press: no source, no marker")
        split_column(box).prop(settings, "face_names")
        for part in settings.target_parts:
            if part.object is None:
                continue
            split_column(box).prop(part, "kind", text=part.object.name, translate=False)
            if part.found:
                labels = part.bl_rna.properties["kind"].enum_items
                found = (translated(labels[kind].name) for kind in part.found.split(", "))
                draw_lines(box, "NONE", f"Found: {', '.join(found)}")
        row = box.row()
        row.scale_y = 1.4
        row.operator("lissom.face_keys", icon="SHAPEKEY_DATA").names = settings.face_names
        keys = shape_keys.key_names(settings.target) if settings.target and settings.target_parts else []
        if any(map(BLINKS.fullmatch, keys)):
            box.operator("lissom.face_blinks", icon="IPO_SINE")
        if settings.source is not None:
            return
        layout.label(text="Or from a face of your own:")

    def _draw_fit_options(self, column, settings):
        hidden = {"overlap"}  # it stands above
        if settings.overlap:
            hidden |= {"marker_tolerance", "closest"}
        if not len(settings.markers):
            hidden.add("marker_tolerance")
        for name in TRANSFER_OPTIONS["fit"]:
            if name not in hidden:
                column.prop(settings, name)
        for name, side in zip(MASKS, ("source", "target"), strict=True):
            objects = [getattr(settings, side), *(part.object for part in getattr(settings, f"{side}_parts"))]
            objects = list(filter(None, objects))
            mask = getattr(settings, name)
            for obj in [obj for obj in objects if mask in obj.vertex_groups][:1] or objects[:1]:
                column.prop_search(settings, name, obj, "vertex_groups")

    def _draw_keys(self, layout, settings):
        source = settings.source
        layout.row().prop(settings, "which", expand=True)
        if settings.which == "SELECTED" and source and shape_keys.key_names(source):
            draw_ticks(layout, "LISSOM_UL_keys", source, "lissom.transfer_choose", 4)
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


classes = (LISSOM_UL_keys, LISSOM_PT_transfer)
