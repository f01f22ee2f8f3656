"""A shape key driven by a bone."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..jobs.drive import DriveAsked, drive
from .job import answering, report_done, writable_mesh
from .objects import OBJECT


class LISSOM_OT_pose_drive(bpy.types.Operator):
    """Have a bone drive this shape key: 0 where the bone rests, 1 where it is now"""

    bl_idname = "lissom.pose_drive"
    bl_label = "Drive by Bone"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    key: StringProperty(
        name="Key", description="Name of the shape key; empty: the active one", options={"SKIP_SAVE"}
    )
    armature: StringProperty(
        name="Armature",
        description="Name of the armature object; empty: that of the bone which moves the mesh most now",
        options={"SKIP_SAVE"},
    )
    bone: StringProperty(
        name="Bone",
        description="Name of the bone; empty: that turned furthest",
        options={"SKIP_SAVE"},
    )
    motion: EnumProperty(
        name="Motion",
        description="What of its motion counts",
        items=[
            ("SWING", "Swing", "Where the bone points to, as of an elbow"),
            ("TWIST", "Twist", "Its turn about itself, as of a forearm"),
        ],
    )

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context)

    @answering
    def execute(self, context):
        done = drive(context, DriveAsked.of(self))
        self.armature, self.bone, self.key = done.armature, done.bone, done.key
        report_done(self, done)


classes = (LISSOM_OT_pose_drive,)
