"""An animated pose as shape keys, one a frame, or as a point cache."""

import bpy
from bpy.props import StringProperty

from ..jobs.pose_bake import BakeAsked, BakePose
from ..properties.options import iterations_property
from .baking import CACHE_FILE, BakeProperties
from .job import JobRunner
from .objects import BoundObject


class LISSOM_OT_pose_bake(BoundObject, BakeProperties, JobRunner, bpy.types.Operator):
    """Bake the motion of the handles over a range of frames, and unbind the mesh, which then plays it"""

    bl_idname = "lissom.pose_bake"
    bl_label = "Bake Animation"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(**CACHE_FILE)
    max_iterations: iterations_property()

    job_class = BakePose

    def asked(self, context):
        return BakeAsked.of(self, frames=self.frames(context.scene))


classes = (LISSOM_OT_pose_bake,)
