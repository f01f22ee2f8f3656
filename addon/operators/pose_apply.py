"""The pose as a shape key."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..bridge import checks, meshes, poses, shape_keys
from ..core import names
from ..core.refused import Refused
from ..properties.options import iterations_property
from ..properties.transfer import exists_property
from ..translations import translated
from .job import JobOperator, writable_mesh
from .pose_handles import OBJECT


class LISSOM_OT_pose_apply(JobOperator, bpy.types.Operator):
    """Keep the pose as a shape key, and put the handles back for the next one"""

    bl_idname = "lissom.pose_apply"
    bl_label = "Apply as Shape Key"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
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

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)

    def begin(self, context):
        context.view_layer.update()
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        bound = poses.current(obj)
        preview = poses.preview(obj)
        if not self.name:
            raise Refused("Give the shape key a name first")
        taken = obj.data.shape_keys.key_blocks.keys()
        self._name = names.resolve(self.name, taken, self.exists)
        if self._name is None:
            raise Refused(f"Shape key '{self.name}' exists, and If Exists is Skip: choose another name")
        key = obj.data.shape_keys.key_blocks.get(self._name)
        if key is not None:
            if key in (preview, obj.data.shape_keys.reference_key):
                raise Refused(f"'{self._name}' is the shape key that the pose builds on: choose another name")
            checks.require_unlocked([key])
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        return bound.work(poses.motion(obj), max_iterations=self.max_iterations)

    def finish(self, context, result):
        vertices, report = result
        obj = self._mesh.find()
        for other, preview, shape in poses.key_shapes(obj, vertices):
            taken = other.data.shape_keys.key_blocks
            name = self._name if other == obj else names.resolve(self._name, taken.keys(), self.exists)
            key = name and taken.get(name)
            if name and key not in (preview, other.data.shape_keys.reference_key):
                shape_keys.write(other, name, shape, shape_keys.Settings(value=self.value))
        if self.reset:
            poses.reset(obj)
        else:
            poses.show(obj, vertices)
        for warning in report.get("warnings", ()):
            self.report({"WARNING"}, translated(warning))
        self.report({"INFO"}, translated(f"Shape key '{self._name}' holds the pose"))


classes = (LISSOM_OT_pose_apply,)
