"""Opens the tab in the sidebar at one of its pages."""

import bpy
from bpy.props import EnumProperty

from ..core.refused import Refused
from ..layouts import TAB
from ..properties.main import PAGES
from .job import answering


class LISSOM_OT_page_show(bpy.types.Operator):
    """Show this page of Lissom in the sidebar"""

    bl_idname = "lissom.page_show"
    bl_label = "Show Panel"
    bl_options = {"REGISTER"}  # of the window, which undo leaves alone

    page: EnumProperty(name="Page", description="What the tab is to be for", items=PAGES)

    @answering
    def execute(self, context):
        context.window_manager.lissom_page = self.page
        area = context.area
        if area is None or area.type != "VIEW_3D":
            raise Refused("The panels are in the sidebar of a 3D View: press it in one")
        area.spaces.active.show_region_ui = True
        sidebar = next(region for region in area.regions if region.type == "UI")
        bpy.app.timers.register(lambda: _choose(sidebar), first_interval=0.05)


def _choose(sidebar):
    """A tab is known only once the sidebar was drawn."""
    try:
        sidebar.active_panel_category = TAB
        sidebar.tag_redraw()
    except (ReferenceError, TypeError, AttributeError):
        pass  # the sidebar is gone, or does not have the tab


classes = (LISSOM_OT_page_show,)
