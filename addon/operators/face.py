"""Face keys by one press, and the face that they come from."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..bridge import source_face
from ..core.refused import Refused
from ..jobs.face import FaceAsked, FaceKeys
from ..properties.transfer_options import edited_property, exists_property, face_names_property
from .job import JobRunner, allowed, answering


class LISSOM_OT_face_keys(JobRunner, bpy.types.Operator):
    """Give this head the shape keys of a whole face, found by its shape alone.

    It has to stand upright and look along -Y. Eyes, teeth and lashes, in the mesh or as objects, go along"""

    bl_idname = "lissom.face_keys"
    bl_label = "Face Keys"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Head", description="Name of the mesh object; empty: the target, or else active"
    )
    parts: StringProperty(
        name="Parts", description="Eyes, teeth and lashes that are objects of their own, one name a line"
    )
    names: face_names_property()
    exists: exists_property("UPDATE")
    edited: edited_property()
    strength: FloatProperty(
        name="Strength", description="Of all keys", default=1.0, min=0.0, soft_max=2.0, max=10.0
    )
    contact: BoolProperty(
        name="Contact",
        description="Lids and lips meet where they do on the face that comes along",
        default=True,
    )

    job_class, keeps = FaceKeys, "lissom_transfer"

    @classmethod
    def poll(cls, context):
        return allowed(cls, "")

    def asked(self, context):
        settings = context.scene.lissom_transfer
        head = settings.target or context.object
        if not self.target and head is None:
            raise Refused("Choose the head as target first")
        own = "\n".join(row.object.name for row in settings.target_parts if row.object)
        named = {"target": self.target or head.name, "parts": self.parts or ("" if self.target else own)}
        return FaceAsked.of(self, **named)


class LISSOM_OT_source_face_add(bpy.types.Operator):
    """Add the face that comes along, with its expressions as shape keys; as high as the selected mesh"""

    bl_idname = "lissom.source_face_add"
    bl_label = "Source Face"
    bl_options = {"REGISTER", "UNDO"}

    names: face_names_property()

    @answering
    def execute(self, context):
        if context.mode != "OBJECT":
            raise Refused("Go to Object Mode first")
        source_face.add(context, self.names)


classes = (LISSOM_OT_face_keys, LISSOM_OT_source_face_add)
