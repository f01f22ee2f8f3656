"""What can be done with a baked arc: bake it again, rename it, remove it."""

import bpy
from bpy.props import StringProperty

from ..jobs import arcs
from ..jobs.bake import Bake, again
from .arcs import ArcOperator
from .job import JobRunner, answering


class LISSOM_OT_inbetween_rebake(ArcOperator, JobRunner, bpy.types.Operator):
    """Bake an arc again with its own settings, after one of its ends has changed"""

    bl_idname = "lissom.inbetween_rebake"
    bl_label = "Bake Again"

    job_class = Bake

    def asked(self, context):
        return again(context, self.object, self.slider)


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
