"""Face keys by one press, and the face that they come from."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from .. import session
from ..bridge import source_face
from ..core.refused import Refused, first
from ..jobs.blinks import Blinks, BlinksAsked
from ..jobs.face import FaceAsked, FaceKeys
from ..properties.transfer_options import edited_property, exists_property, face_names_property
from .job import JobRunner, allowed, answering


def _head_property():
    return StringProperty(
        name="Head", description="Name of the mesh object; empty: the target, or else active"
    )


def _head(operator, context):
    """The name of the head that an operator is for."""
    head = context.scene.lissom_transfer.target or context.object
    if not operator.target and head is None:
        raise Refused("Choose the head as target first")
    return operator.target or head.name


class LISSOM_OT_face_keys(JobRunner, bpy.types.Operator):
    """Give this head the shape keys of a face, found by its shape; it stands upright and looks along -Y"""

    bl_idname = "lissom.face_keys"
    bl_label = "Face Keys"
    bl_options = {"REGISTER", "UNDO"}

    target: _head_property()
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
    landmarks: StringProperty(
        name="Landmark File",
        description="JSON of landmarks that an outside detector has found, in the head's own coordinates",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    kinds: StringProperty(
        name="Kinds",
        description="What parts are where their shape misleads, one a line as in EYE Lamp: EYE, UPPER or "
        "LOWER for teeth and tongue, RIDE for what goes with the skin",
    )

    job_class, keeps = FaceKeys, "lissom_transfer"

    @classmethod
    def poll(cls, context):
        return allowed(cls, "")

    def invoke(self, context, event):
        """From a button the review opens once all is done."""
        self._pressed = not bpy.app.background and context.window is not None
        return super().invoke(context, event)

    def asked(self, context):
        settings = context.scene.lissom_transfer
        own = "\n".join(row.object.name for row in settings.target_parts if row.object)
        named = {"target": _head(self, context), "parts": self.parts or ("" if self.target else own)}
        kinds = self.kinds or ("" if self.target else _kinds(settings))
        path = bpy.path.abspath(self.landmarks) if self.landmarks else ""
        return FaceAsked.of(self, **named, kinds=kinds, landmarks=path)

    def said(self, done):
        """With what to do next where no key was made."""
        if not done.stopped:
            return done.summary
        then = f"press Pick and click on '{self._job.head}': {', '.join(done.landmarks)}"
        if done.guessed:
            then = f"look at the grey marks, above all {first(done.landmarks)}; drag what is off, and confirm"
        return f"{done.summary}. Do this: {then}; then press Face Keys again"

    def after(self, context, done):
        """Says in the panel what parts were taken for; from a button opens the review."""
        settings = context.scene.lissom_transfer
        for row in settings.target_parts:
            if row.object is not None and row.object.name in done.kinds:
                row.found = ", ".join(sorted(set(done.kinds[row.object.name])))
        if not done.stopped and getattr(self, "_pressed", False):
            _review(context, self._job.head, self.names)


def _kinds(settings):
    rows = [row for row in settings.target_parts if row.object is not None and row.kind != "AUTO"]
    return "\n".join(f"{row.kind} {row.object.name}" for row in rows)


def _review(context, name, kind):
    """Opens the review of the keys, with the face that they come from beside the head."""
    settings, head = context.scene.lissom_transfer, bpy.data.objects[name]
    if not source_face.is_it(settings.source):
        settings.source = source_face.add_beside(context, head, kind)
    settings.target = head
    if session.review is None and bpy.ops.lissom.review.poll():
        bpy.ops.lissom.review("INVOKE_DEFAULT")


class LISSOM_OT_face_blinks(JobRunner, bpy.types.Operator):
    """Have lids go round the eyeballs: arcs of the keys that close one eye, each under a slider"""

    bl_idname = "lissom.face_blinks"
    bl_label = "Round the Eyes"
    bl_options = {"REGISTER", "UNDO"}

    target: _head_property()
    eyes: StringProperty(
        name="Eyes",
        description="Eyeballs that are objects of their own, one name a line; empty: the parts that are eyes",
    )

    job_class = Blinks

    @classmethod
    def poll(cls, context):
        return allowed(cls, "")

    def asked(self, context):
        settings, head = context.scene.lissom_transfer, _head(self, context)
        of_panel = settings.target is not None and settings.target.name == head
        found = "\n".join(eye.name for eye in _eyes(settings)) if of_panel else ""
        return BlinksAsked(target=head, eyes=self.eyes or found)


def _eyes(settings):
    """The parts of the target that are eyeballs, as Face Keys has found or was told."""
    parts = [part for part in settings.target_parts if part.object is not None]
    return [part.object for part in parts if (part.kind if part.kind != "AUTO" else part.found) == "EYE"]


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


classes = (LISSOM_OT_face_keys, LISSOM_OT_face_blinks, LISSOM_OT_source_face_add)
