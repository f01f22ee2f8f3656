"""A shape key driven by a bone."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..bridge import bones, checks, shape_keys
from ..core.refused import Refused
from ..translations import translated
from .job import answering, writable_mesh
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
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        key = shape_keys.find(obj, self.key) if self.key else obj.active_shape_key
        if key is None or key == key.id_data.reference_key:
            raise Refused(f"Choose a shape key of '{obj.name}' other than the Basis first")
        shape_keys.refuse_preview(key)
        found = bones.likely(obj)
        rig = bpy.data.objects.get(self.armature) if self.armature else found and found[0]
        name = self.bone or (found[1] if found else "")
        if rig is None:
            raise Refused(f"No armature moves '{obj.name}': name an armature and a bone")
        bone = bones.bone_of(rig, name)
        bones.drive(key, rig, bone, self.motion)
        self.armature, self.bone, self.key = rig.name, bone.name, key.name
        self.report(
            {"INFO"}, translated(f"'{key.name}' follows the {self.motion.lower()} of bone '{bone.name}'")
        )


classes = (LISSOM_OT_pose_drive,)
