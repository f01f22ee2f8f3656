"""Presets of the options of the three jobs: Blender's own mechanism, files in the user's scripts folder."""

import bpy

from ..properties.presets import folder


class _Presets:
    """Mixin: a menu of the presets of one job."""

    bl_label = "Presets"
    preset_operator = "script.execute_preset"

    def draw(self, context):
        self.draw_preset(context)


class LISSOM_MT_pose_presets(_Presets, bpy.types.Menu):
    """Options of the method that were kept under a name"""

    bl_idname = "LISSOM_MT_pose_presets"
    preset_subdir = folder("pose")


class LISSOM_MT_transfer_presets(_Presets, bpy.types.Menu):
    """Options of fit and transfer that were kept under a name"""

    bl_idname = "LISSOM_MT_transfer_presets"
    preset_subdir = folder("transfer")


class LISSOM_MT_inbetween_presets(_Presets, bpy.types.Menu):
    """Options of arcs that were kept under a name"""

    bl_idname = "LISSOM_MT_inbetween_presets"
    preset_subdir = folder("inbetween")


def draw_presets(layout, job):
    """The menu of a job's presets, and the buttons that keep and remove one."""
    row = layout.row(align=True)
    menu = getattr(bpy.types, f"LISSOM_MT_{job}_presets")
    row.menu(menu.bl_idname, text=menu.bl_label)
    row.operator(f"lissom.preset_{job}", text="", icon="ADD")
    row.operator(f"lissom.preset_{job}", text="", icon="REMOVE").remove_active = True


classes = (LISSOM_MT_pose_presets, LISSOM_MT_transfer_presets, LISSOM_MT_inbetween_presets)
