"""Options are kept under a name, as presets of Blender."""

import bpy
from bl_operators.presets import AddPresetBase

from ..properties.presets import FILES, folder


class _Preset(AddPresetBase):
    """Mixin: keeps the options of ``job`` as a preset, or removes the one that was chosen last."""

    bl_options = {"REGISTER"}  # of files, which undo leaves alone

    @property
    def preset_defines(self):
        """Lines of the file that come first."""
        return FILES[self.job][0]

    @property
    def preset_values(self):
        """What the file sets."""
        return FILES[self.job][1]

    @property
    def preset_subdir(self):
        """Where the file goes."""
        return folder(self.job)

    @property
    def preset_menu(self):
        """The menu that lists it."""
        return f"LISSOM_MT_{self.job}_presets"


class LISSOM_OT_preset_pose(_Preset, bpy.types.Operator):
    """Keep the method and its options under a name, for other meshes and files"""

    bl_idname = "lissom.preset_pose"
    bl_label = "Add Pose Preset"
    job = "pose"


class LISSOM_OT_preset_transfer(_Preset, bpy.types.Operator):
    """Keep the options of fit and transfer under a name, for other meshes and files"""

    bl_idname = "lissom.preset_transfer"
    bl_label = "Add Transfer Preset"
    job = "transfer"


class LISSOM_OT_preset_inbetween(_Preset, bpy.types.Operator):
    """Keep the options of arcs under a name, for other meshes and files"""

    bl_idname = "lissom.preset_inbetween"
    bl_label = "Add In-between Preset"
    job = "inbetween"


classes = (LISSOM_OT_preset_pose, LISSOM_OT_preset_transfer, LISSOM_OT_preset_inbetween)
