"""In-betweens as shape keys under one slider."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..core.inbetween import ArcAsked
from ..jobs.bake import Bake
from ..properties.inbetween import ArcSettings, PathSettings
from ..properties.transfer_options import exists_property
from .arcs import arc_poll
from .job import JobRunner
from .objects import OBJECT


class LISSOM_OT_inbetween_bake(PathSettings, ArcSettings, JobRunner, bpy.types.Operator):
    """Bake the arc between two shape keys as shape keys under one slider"""

    bl_idname = "lissom.inbetween_bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    start: StringProperty(
        name="From", description="Shape key that the arc starts at; empty: the Basis", options={"SKIP_SAVE"}
    )
    end: StringProperty(name="To", description="Shape key that the arc ends at", options={"SKIP_SAVE"})
    slider: StringProperty(
        name="Slider",
        description="Name of the slider and of the baked keys; empty: named after the key it leads to",
        options={"SKIP_SAVE"},
    )
    exists: exists_property("UPDATE")
    prepare_keys: BoolProperty(
        name="Prepare Keys",
        description="Set the start key to 1 and the end key to 0, whose value the slider takes, so that the "
        "slider alone plays from one to the other. Driven, animated or locked keys are left as they are",
        default=True,
    )

    job_class, asked_class = Bake, ArcAsked

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)


classes = (LISSOM_OT_inbetween_bake,)
