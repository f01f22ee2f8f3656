"""Arcs of a whole face: to many shape keys in one go, and those that are out of date baked again."""

import bpy
from bpy.props import StringProperty

from ..bridge import arcs, checks
from ..core.inbetween import ArcAsked
from ..jobs.bake import BakeAll, UpdateAll, to_many
from ..properties.inbetween import ArcSettings, PathSettings
from ..properties.transfer_options import exists_property
from .arcs import arc_poll
from .job import JobRunner, answering
from .objects import OBJECT
from .ticks import TickProperties


class LISSOM_OT_inbetween_bake_all(PathSettings, ArcSettings, JobRunner, bpy.types.Operator):
    """Bake the arcs from one shape key to many others, each under a slider of its own"""

    bl_idname = "lissom.inbetween_bake_all"
    bl_label = "Bake All"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    start: StringProperty(
        name="From", description="Shape key that all arcs start at; empty: the Basis", options={"SKIP_SAVE"}
    )
    keys: StringProperty(
        name="Keys",
        description="Names of the shape keys that the arcs lead to, one a line; empty: all but those of arcs",
        options={"SKIP_SAVE"},
    )
    exists: exists_property("UPDATE")

    job_class = BakeAll

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def asked(self, context):
        return to_many(context, ArcAsked.of(self), [line for line in self.keys.splitlines() if line])


class LISSOM_OT_inbetween_update_all(JobRunner, bpy.types.Operator):
    """Bake all arcs again whose ends were changed since"""

    bl_idname = "lissom.inbetween_update_all"
    bl_label = "Update All"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)

    job_class = UpdateAll

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def asked(self, context):
        return self.object


class LISSOM_OT_inbetween_choose(TickProperties, bpy.types.Operator):
    """Tick this shape key, to bake the arc that leads to it"""

    bl_idname = "lissom.inbetween_choose"
    bl_label = "Choose Keys"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        settings = obj.lissom_inbetween
        self.tick(settings.chosen, arcs.offered(obj, settings.start))


classes = (LISSOM_OT_inbetween_bake_all, LISSOM_OT_inbetween_update_all, LISSOM_OT_inbetween_choose)
