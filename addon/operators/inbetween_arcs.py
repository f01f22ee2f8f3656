"""What can be done with a baked arc: bake it again, rename it, remove it."""

import bpy
from bpy.props import StringProperty

from ..bridge import arcs, checks
from ..core.work import Work
from ..translations import translated
from .inbetween_bake import BakeOperator, arc_poll
from .job import answering
from .pose_handles import OBJECT

SLIDER = {"name": "Slider", "description": "Name of the slider", "options": {"SKIP_SAVE"}}


class ArcOperator:
    """Mixin: an operator on the arc of one slider."""

    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    slider: StringProperty(**SLIDER)

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def _object(self, context):
        obj = checks.mesh_object(self.object, context)
        arcs.require(obj)
        return obj

    def _warn(self, warnings):
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))


class LISSOM_OT_inbetween_rebake(ArcOperator, BakeOperator, bpy.types.Operator):
    """Bake an arc again with its own settings, after one of its ends has changed"""

    bl_idname = "lissom.inbetween_rebake"
    bl_label = "Bake Again"

    def begin(self, context):
        obj = self._object(context)
        arc = arcs.find(obj, self.slider)
        self._baking = arcs.Baking(obj, arcs.asked_of(arc, slider=self.slider, exists="UPDATE"))
        return Work(self._baking.steps())


class LISSOM_OT_inbetween_rename(ArcOperator, bpy.types.Operator):
    """Rename a slider with its shape keys; what animates or reads it follows"""

    bl_idname = "lissom.inbetween_rename"
    bl_label = "Rename Arc"

    name: StringProperty(name="Name", description="New name of the slider", options={"SKIP_SAVE"})

    def invoke(self, context, event):
        self.name = self.name or self.slider
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        self.layout.prop(self, "name")

    @answering
    def execute(self, context):
        self._warn(arcs.rename(self._object(context), self.slider, self.name))


class LISSOM_OT_inbetween_remove(ArcOperator, bpy.types.Operator):
    """Remove a slider and the shape keys that were baked for it"""

    bl_idname = "lissom.inbetween_remove"
    bl_label = "Remove Arc"

    @answering
    def execute(self, context):
        self._warn(arcs.remove(self._object(context), self.slider))


classes = (LISSOM_OT_inbetween_rebake, LISSOM_OT_inbetween_rename, LISSOM_OT_inbetween_remove)
