"""The pose as a shape key."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..jobs.pose import Apply, ApplyAsked
from ..properties.options import iterations_property
from ..properties.transfer_options import exists_property
from .job import JobRunner
from .objects import BoundObject


class LISSOM_OT_pose_apply(BoundObject, JobRunner, bpy.types.Operator):
    """Keep the pose as a shape key, and put the handles back for the next one"""

    bl_idname = "lissom.pose_apply"
    bl_label = "Apply as Shape Key"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the shape key", default="Pose")
    exists: exists_property("RENAME")
    value: FloatProperty(
        name="Value",
        description="Value of the new shape key; at 1 the mesh stays as posed",
        default=1.0,
        min=0,
        max=1,
    )
    max_iterations: iterations_property()
    reset: BoolProperty(
        name="Reset Handles", description="Put the handles back where they were at Bind", default=True
    )

    job_class, asked_class = Apply, ApplyAsked


classes = (LISSOM_OT_pose_apply,)
