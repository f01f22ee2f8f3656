"""Corrected keys teach the others; jobs.learn has the logic."""

import bpy
from bpy.props import BoolProperty, StringProperty

from .. import session
from ..bridge import checks
from ..jobs import learn_shown
from ..jobs.learn import Learn, LearnAsked
from ..properties.transfer_options import learn_strength_property
from .job import JobRunner, allowed, answering, shown_object


class LISSOM_OT_learn(JobRunner, bpy.types.Operator):
    """Change the keys that were not corrected as those that were ask for.

    What was transferred counts, so that it may be pressed again after further corrections"""

    bl_idname = "lissom.learn"
    bl_label = "Learn from Corrections"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(
        name="Object",
        description="Name of the mesh object with the keys; empty: the target, or else active",
        options={"SKIP_SAVE"},
    )
    right: StringProperty(
        name="Right as They Are",
        description="Names of keys that need no correction, one a line: they teach as much",
        options={"SKIP_SAVE"},
    )
    strength: learn_strength_property()
    preview: BoolProperty(
        name="Preview",
        description="Only list what would change, with one shape key that shows it",
        options={"SKIP_SAVE"},
    )

    job_class = Learn

    @classmethod
    def poll(cls, context):
        obj = shown_object(context)
        return allowed(cls, "" if obj is None else checks.refusal(obj))

    def asked(self, context):
        target = context.scene.lissom_transfer.target
        return LearnAsked.of(self, object=self.object or (target.name if target else ""))


class LISSOM_OT_learn_stop(bpy.types.Operator):
    """Take away the shape key that shows what would be learned"""

    bl_idname = "lissom.learn_stop"
    bl_label = "End Preview"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.learned else "There is no preview")

    @answering
    def execute(self, context):
        learn_shown.stop()


classes = (LISSOM_OT_learn, LISSOM_OT_learn_stop)
