"""Fit: which face of the source belongs to which face of the target."""

import bpy

from ..jobs.fit import Fit, FitAsked
from .job import JobRunner
from .transfer import FitProperties, ready


class LISSOM_OT_transfer_fit(FitProperties, JobRunner, bpy.types.Operator):
    """Pull the source onto the target, by markers or else by shape, and find which faces belong together"""

    bl_idname = "lissom.transfer_fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    job_class, asked_class = Fit, FitAsked

    @classmethod
    def poll(cls, context):
        return ready(cls, context)


classes = (LISSOM_OT_transfer_fit,)
