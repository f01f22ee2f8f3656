"""Arcs made ready for exporters, and given back their drivers."""

import bpy
from bpy.props import BoolProperty

from ..bridge import exported
from ..translations import translated
from .arcs import ArcOperator
from .job import answering


class LISSOM_OT_inbetween_export(ArcOperator, bpy.types.Operator):
    """Put keyframes on the keys of all arcs in place of their drivers, over the frames of the scene,
    for glTF, FBX and USD to play by their exporters' defaults"""

    bl_idname = "lissom.inbetween_export"
    bl_label = "For Export"

    restore: BoolProperty(
        name="Restore", description="Take the keyframes away and let the drivers play", options={"SKIP_SAVE"}
    )

    @answering
    def execute(self, context):
        obj = self._object(context)
        if self.restore:
            exported.restore(obj)
            return
        count = exported.prepare(obj, context.scene)
        self.report(
            {"INFO"}, translated(f"{count} shape keys have keyframes: export, then press Back to Sliders")
        )


classes = (LISSOM_OT_inbetween_export,)
