"""Transfer of what the source looks like: of a pose as a shape key, of a range of frames as animation."""

import bpy
from bpy.props import StringProperty

from ..jobs.transfer_pose import AnimationAsked, PoseAsked, TransferAnimation, TransferPose
from ..properties.transfer_options import edited_property, exists_property
from .baking import CACHE_FILE, BakeProperties
from .job import JobRunner
from .transfer import TransferProperties, ready


class LISSOM_OT_transfer_pose(TransferProperties, JobRunner, bpy.types.Operator):
    """Carry over what the source looks like now, by armature, modifiers and shape keys, as one shape key"""

    bl_idname = "lissom.transfer_pose"
    bl_label = "Transfer Pose"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the shape key", default="Pose")
    exists: exists_property("UPDATE")
    edited: edited_property()

    job_class, asked_class = TransferPose, PoseAsked

    @classmethod
    def poll(cls, context):
        return ready(cls, context, writes=True)


class LISSOM_OT_transfer_animation(BakeProperties, TransferProperties, JobRunner, bpy.types.Operator):
    """Carry over what the source looks like at each frame of a range"""

    bl_idname = "lissom.transfer_animation"
    bl_label = "Transfer Animation"
    bl_options = {"REGISTER", "UNDO"}

    cache_path: StringProperty(**CACHE_FILE)

    job_class = TransferAnimation

    @classmethod
    def poll(cls, context):
        return ready(cls, context, writes=True)

    def asked(self, context):
        frames = self.frames(context.scene)
        keys = self.key_names(frames) if self.output == "KEYS" else ()
        return AnimationAsked.of(self, frames=frames, keys=tuple(keys))


classes = (LISSOM_OT_transfer_pose, LISSOM_OT_transfer_animation)
