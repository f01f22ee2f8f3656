"""The row of a handle is the active one of the list while its Empty is the active object."""

import bpy
from bpy.app.handlers import persistent

from .bridge import handles
from .bridge.screen import redraw_sidebars


@persistent
def _on_update(scene, depsgraph):
    found = handles.row_of(bpy.context.view_layer.objects.active)
    if found is None:
        return
    obj, row = found
    if obj.lissom_pose.active_handle != row and obj.library is None:
        obj.lissom_pose.active_handle = row
        redraw_sidebars()


def register():
    bpy.app.handlers.depsgraph_update_post.append(_on_update)


def unregister():
    bpy.app.handlers.depsgraph_update_post.remove(_on_update)
