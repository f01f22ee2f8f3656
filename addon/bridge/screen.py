"""The windows of Blender."""

import bpy


def redraw_sidebars():
    """Has the sidebars of all 3D views drawn anew; the views themselves follow their data."""
    _redraw("UI")


def redraw_views():
    """Has all 3D views drawn anew, for what is drawn over them."""
    _redraw("WINDOW")


def _redraw(kind):
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == kind:
                        region.tag_redraw()
