"""Bind, update, reset and unbind a pose."""

import bpy
from bpy.props import EnumProperty, StringProperty

from .. import live, rebind, session
from ..bridge import applied, baked, checks, company, empties, meshes, poses, shape_keys, standing
from ..core import names, space
from ..core.pose_options import Asked, by_name, options_of
from ..core.refused import Refused, first
from ..panels.common import draw_options, split_column
from ..properties.options import iterations_property, option_property
from ..properties.pose import (
    METHOD_ITEMS,
    reach_property,
    stands_property,
    stays_property,
    symmetry_property,
    use_weights_property,
    weld_property,
)
from ..translations import translated
from .job import JobOperator, allowed, answering, shown_object, writable_mesh
from .pose_handles import OBJECT

PREVIEW = "Lissom Pose"


class _Options:
    """Mixin: every option of every pose method as a property, by the name that lissom.Pose gives it."""

    __annotations__ = {
        name: option_property(option, options={"SKIP_SAVE"}) for name, option in by_name().items()
    }

    def asked(self):
        """The options of the chosen method; what was not given takes the method's own default."""
        wanted = options_of(self.method, self.base)
        names = [name for _, name in wanted]
        given = [name for name in by_name() if self.properties.is_property_set(name)]
        foreign = [name for name in given if name not in names]
        if foreign and not self.options.is_repeat:  # the redo panel may change the method
            raise Refused(f"'{self.method}' has no option {first(foreign)}; it has {', '.join(names)}")
        for (_, name), option in wanted.items():
            if name not in given:
                setattr(self, name, option.default)
        return Asked.of(self, self.base, lambda _, name: getattr(self, name))

    def draw(self, context):
        column = split_column(self.layout)
        column.prop(self, "method")
        draw_options(column, self.method, self.base, lambda _: self)
        column.prop(self, "use_weights")
        column.prop(self, "weld")
        column.prop(self, "stays")
        column.prop(self, "reach")
        column.prop(self, "symmetry")
        column.prop(self, "stands")


class LISSOM_OT_pose_bind(_Options, JobOperator, bpy.types.Operator):
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
    use_weights: use_weights_property(options={"SKIP_SAVE"})
    weld: weld_property(options={"SKIP_SAVE"})
    stays: stays_property(options={"SKIP_SAVE"})
    reach: reach_property(options={"SKIP_SAVE"})
    symmetry: symmetry_property(options={"SKIP_SAVE"})
    stands: stands_property(options={"SKIP_SAVE"})
    company: StringProperty(
        name="Further Objects",
        description="Names of objects that go along, as eyes, one a line; empty: as the panel has them",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        obj = shown_object(context)
        if obj is not None and not obj.lissom_pose.bound and not len(obj.lissom_pose.handles):
            return allowed(cls, "Add a handle first")
        return writable_mesh(cls, context, bound=False)

    def begin(self, context):
        context.view_layer.update()
        obj = checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        if obj.lissom_pose.bound:
            raise Refused(f"'{obj.name}' is bound already: press Unbind first")
        linear = space.linear_part(obj.matrix_world, obj.name)
        self._rests = {}  # by the handle's name
        for handle in poses.alive_handles(obj):
            space.linear_part(handle.empty.matrix_world, handle.empty.name)
            self._rests[handle.name] = (
                empties.matrix_in(obj, handle.empty).ravel(),
                *empties.channels(handle.empty),
            )
        settings = obj.lissom_pose
        if self.company:
            others = [checks.mesh_object(name, context) for name in self.company.splitlines() if name]
            settings.company.clear()
            for other in others:
                company.add(obj, other)
        with live.paused():
            settings.stands = self.stands
            self._skin = standing.read(obj) if self.stands else None
            company.begin(obj)
        self._mesh = meshes.Snapshot.of(obj, linear)
        return poses.bind_work(obj, linear, self.asked(), self._skin)

    def finish(self, context, result):
        obj = self._mesh.find()
        checks.require_writable(obj)
        settings = obj.lissom_pose
        if settings.handles.keys() != list(self._rests):
            raise Refused(
                f"The handles of '{obj.name}' were changed meanwhile: nothing was written, run again"
            )
        settings.stands, settings.stood = self.stands, self._skin is not None
        left_out = poses.left_out(obj)
        if self._skin is not None:
            left_out += self._flat(obj)
        warnings = [*result.warnings, checks.shared_data(obj), *left_out]
        settings.made_basis = obj.data.shape_keys is None
        company.finish(obj)
        basis = shape_keys.ensure_basis(obj)
        settings.preview = names.unused(PREVIEW, obj.data.shape_keys.key_blocks.keys())
        shape_keys.write(obj, settings.preview, shape_keys.shape(basis), shape_keys.Settings(value=1.0))
        for handle in settings.handles:
            handle.rest, handle.rotation_mode, handle.rotation = self._rests[handle.name]
        settings.topology = self._mesh.topology
        settings.linear = self._mesh.linear.ravel()
        poses.keep(settings, result.asked)
        baked.mute(obj, True)
        applied.note(obj)
        settings.bound = True
        session.poses[obj.session_uid] = result
        session.skins.pop(obj.session_uid, None)
        if self._skin is not None:
            session.skins[obj.session_uid] = self._skin
            session.stances[obj.session_uid] = standing.stance(obj)
        told = ("INFO", left_out[0]) if left_out else ("CHECKMARK", "Bound: move an Empty")
        session.status[obj.name] = told
        for warning in filter(None, warnings):
            self.report({"WARNING"}, translated(warning))

    def _flat(self, obj):
        """Warns of vertices that the modifiers have collapsed, and selects them."""
        flat = self._skin.flat()
        if not len(flat):
            return []
        meshes.select_vertices(obj, set(flat.tolist()))
        return [f"No key can move {len(flat)} vertices, which the modifiers collapse: they are selected"]


class LISSOM_OT_pose_update(JobOperator, bpy.types.Operator):
    """Let the mesh follow its handles now, until the method has converged"""

    bl_idname = "lissom.pose_update"
    bl_label = "Update"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    max_iterations: iterations_property()

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
        return bound.work(poses.motion(obj), max_iterations=self.max_iterations)

    def finish(self, context, result):
        vertices, report = result
        poses.show(self._mesh.find(), vertices)
        for warning in report.get("warnings", ()):
            self.report({"WARNING"}, translated(warning))


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
        if not obj.lissom_pose.bound:
            raise Refused(f"'{obj.name}' is not bound")
        unbind(obj)


def unbind(obj):
    """Drops the live pose of a bound mesh."""
    settings = obj.lissom_pose
    poses.place_at_rest(obj)
    poses.drop_foreign_handles(obj)
    settings.bound = False
    poses.remove_preview(obj)
    settings.property_unset("preview")
    baked.mute(obj, False)
    rebind.drop(obj)
    for known in (session.poses, session.skins, session.stances):
        known.pop(obj.session_uid, None)
    session.status.pop(obj.name, None)


classes = (LISSOM_OT_pose_bind, LISSOM_OT_pose_update, LISSOM_OT_pose_reset, LISSOM_OT_pose_unbind)
