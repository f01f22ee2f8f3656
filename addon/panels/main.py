"""The three jobs, as buttons on top of the tab: one is shown at a time; and the progress of work."""

import bpy

from .. import session
from ..core import build
from ..layouts import TAB
from ..properties.main import PAGES
from ..translations import translated
from .common import ICON, draw_lines, fits, shares


class LISSOM_PT_main(bpy.types.Panel):
    """Choose what to do; the panel below is for that."""

    bl_idname = "LISSOM_PT_main"
    bl_label = "Lissom"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_options = {"HIDE_HEADER"}

    def draw(self, context):
        if session.other_build:
            warning = self.layout.column(align=True)
            warning.alert = True
            draw_lines(warning, "ERROR", build.MESSAGE)
        row = self.layout.row(align=True)
        row.scale_y = 1.3
        if session.work is not None:  # in place of the buttons, so that nothing moves
            fraction, stage = session.work.progress
            row.progress(factor=fraction, text=translated(f"{stage} (ESC cancels)"))
            return
        labels = [label for _, label, _ in PAGES]
        if not fits(" ".join(map(translated, labels)), ICON * len(labels)):
            column = self.layout.column(align=True)
            for name, *_ in PAGES:
                column.prop_enum(context.window_manager, "lissom_page", name)
            return
        for page, part in shares(labels):  # prop(expand=True) would cut the longest
            split = row.split(factor=part, align=True)
            split.prop_enum(context.window_manager, "lissom_page", PAGES[page][0])
            row = split.row(align=True)


classes = (LISSOM_PT_main,)
