"""Bind, update, reset and unbind a pose."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..core import pose_options
from ..core.pose_options import by_name, options_of
from ..core.refused import Refused, first
from ..jobs.pose import Bind, BindAsked, Solve, SolveAsked, reset, unbind
from ..layouts import draw_options, split_column
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
from .job import JobRunner, allowed, answering, shown_object, writable_mesh
from .objects import OBJECT, BoundObject


class _Options:
    """Mixin: every option of every pose method as a property, by the name that lissom.Pose gives it."""

    __annotations__ = {
        name: option_property(option, options={"SKIP_SAVE"}) for name, option in by_name().items()
    }

    def pose_asked(self):
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
        return pose_options.Asked.of(self, self.base, lambda _, name: getattr(self, name))

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


class LISSOM_OT_pose_bind(_Options, JobRunner, bpy.types.Operator):
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

    job_class = Bind

    @classmethod
    def poll(cls, context):
        obj = shown_object(context)
        if obj is not None and not obj.lissom_pose.bound and not len(obj.lissom_pose.handles):
            return allowed(cls, "Add a handle first")
        return writable_mesh(cls, context, bound=False)

    def asked(self, context):
        names = tuple(filter(None, self.company.splitlines()))
        return BindAsked(object=self.object, pose=self.pose_asked(), stands=self.stands, company=names)


class LISSOM_OT_pose_update(BoundObject, JobRunner, bpy.types.Operator):
    """Let the mesh follow its handles now, until the method has converged"""

    bl_idname = "lissom.pose_update"
    bl_label = "Update"
    bl_options = {"REGISTER", "UNDO"}

    max_iterations: iterations_property()

    job_class, asked_class = Solve, SolveAsked


class LISSOM_OT_pose_reset(BoundObject, bpy.types.Operator):
    """Put the handles back where they were at Bind"""

    bl_idname = "lissom.pose_reset"
    bl_label = "Reset Handles"
    bl_options = {"REGISTER", "UNDO"}

    @answering
    def execute(self, context):
        reset(context, self.object)


class LISSOM_OT_pose_unbind(BoundObject, bpy.types.Operator):
    """Release the mesh: the pose is dropped and the handles go back, applied poses stay"""

    bl_idname = "lissom.pose_unbind"
    bl_label = "Unbind"
    bl_options = {"REGISTER", "UNDO"}

    @answering
    def execute(self, context):
        unbind(context, self.object)


classes = (LISSOM_OT_pose_bind, LISSOM_OT_pose_update, LISSOM_OT_pose_reset, LISSOM_OT_pose_unbind)
