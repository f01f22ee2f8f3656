"""Bind, update, reset and unbind a pose."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from .. import session
from ..bridge import checks, empties, meshes, poses, shape_keys
from ..core import names, space
from ..core.refused import Refused
from ..properties.pose import METHOD_ITEMS
from .job import JobOperator, allowed, answering, shown_object, writable_mesh
from .pose_handles import OBJECT

PREVIEW = "Lissom Pose"

MAX_ITERATIONS = {
    "name": "Iterations",
    "description": "The most iterations to make, for methods that iterate",
    "default": 200,
    "min": 1,
    "max": 100_000,
}


class LISSOM_OT_pose_bind(bpy.types.Operator):
    """Bind the mesh to its handles: from here on it follows their Empties, in a shape key of its own"""

    bl_idname = "lissom.pose_bind"
    bl_label = "Bind"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    method: EnumProperty(
        name="Method",
        description="How the mesh between the handles follows them",
        items=METHOD_ITEMS,
        default="arap",
    )

    @classmethod
    def poll(cls, context):
        obj = shown_object(context)
        if obj is not None and not obj.lissom_pose.bound and not len(obj.lissom_pose.handles):
            return allowed(cls, "Add a handle first")
        return writable_mesh(cls, context, bound=False)

    @answering
    def execute(self, context):
        context.view_layer.update()
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        settings = obj.lissom_pose
        if settings.bound:
            raise Refused(f"'{obj.name}' is bound already: press Unbind first")
        linear = space.linear_part(obj.matrix_world, obj.name)
        rests = []
        for handle in poses.alive_handles(obj):
            space.linear_part(handle.empty.matrix_world, handle.empty.name)
            rests.append(empties.matrix_in(obj, handle.empty).ravel())
        bound = poses.build(obj, linear, self.method)

        warnings = [*bound.warnings, checks.shared_data(obj)]
        settings.made_basis = obj.data.shape_keys is None
        basis = shape_keys.ensure_basis(obj)
        settings.preview = names.unused(PREVIEW, obj.data.shape_keys.key_blocks.keys())
        shape_keys.write(obj, settings.preview, shape_keys.shape(basis), shape_keys.Settings(value=1.0))
        for handle, rest in zip(settings.handles, rests, strict=True):
            handle.rest = rest
        settings.topology = meshes.signature(obj.data)
        settings.linear = linear.ravel()
        settings.method = self.method
        settings.bound = True
        session.poses[obj.session_uid] = bound
        session.status[obj.name] = ("CHECKMARK", "Bound: move an Empty")
        for warning in filter(None, warnings):
            self.report({"WARNING"}, warning)


class LISSOM_OT_pose_update(JobOperator, bpy.types.Operator):
    """Let the mesh follow its handles now, until the method has converged"""

    bl_idname = "lissom.pose_update"
    bl_label = "Update"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    max_iterations: IntProperty(**MAX_ITERATIONS)

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)

    def begin(self, context):
        context.view_layer.update()
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        bound = poses.current(obj)
        poses.preview(obj)
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        return bound.work(poses.transforms(obj), max_iterations=self.max_iterations)

    def finish(self, context, result):
        vertices, report = result
        poses.show(self._mesh.find(), vertices)
        for warning in report.get("warnings", ()):
            self.report({"WARNING"}, warning)


class LISSOM_OT_pose_reset(bpy.types.Operator):
    """Put the handles back where they were at Bind"""

    bl_idname = "lissom.pose_reset"
    bl_label = "Reset Handles"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        poses.current(obj)
        poses.reset(obj)


class LISSOM_OT_pose_unbind(bpy.types.Operator):
    """Release the mesh: the pose is dropped and the handles go back, applied poses stay"""

    bl_idname = "lissom.pose_unbind"
    bl_label = "Unbind"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        settings = obj.lissom_pose
        if not settings.bound:
            raise Refused(f"'{obj.name}' is not bound")
        poses.place_at_rest(obj)
        poses.drop_foreign_handles(obj)
        settings.bound = False
        poses.remove_preview(obj)
        settings.property_unset("preview")
        session.poses.pop(obj.session_uid, None)
        session.status.pop(obj.name, None)


classes = (LISSOM_OT_pose_bind, LISSOM_OT_pose_update, LISSOM_OT_pose_reset, LISSOM_OT_pose_unbind)
