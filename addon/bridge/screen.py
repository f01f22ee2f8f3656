"""The windows of Blender."""

import bpy


def redraw_sidebars():
    """Has the sidebars of all 3D views drawn anew; the views themselves follow their data."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()
