"""In-betweens as shape keys under one slider."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..bridge import arcs, checks
from ..core.work import Work
from ..properties.inbetween import ArcSettings, PathSettings
from ..properties.transfer import exists_property
from ..translations import translated
from .job import JobOperator, allowed, shown_object
from .pose_handles import OBJECT


def arc_poll(operator_class, context):
    """poll() of operators that write arcs."""
    obj = shown_object(context)
    return allowed(operator_class, "" if obj is None else arcs.refusal(obj))


class BakeOperator(JobOperator):
    """Mixin: writes what a bridge.arcs.Baking in ``self._baking`` has computed."""

    def finish(self, context, result):
        count, warnings = self._baking.write(result)
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        self.report({"INFO"}, translated(f"{count} shape keys under the slider '{self._baking.slider}'"))


class LISSOM_OT_inbetween_bake(BakeOperator, PathSettings, ArcSettings, bpy.types.Operator):
    """Bake the arc between two shape keys as shape keys under one slider"""

    bl_idname = "lissom.inbetween_bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    start: StringProperty(
        name="From", description="Shape key that the arc starts at; empty: the Basis", options={"SKIP_SAVE"}
    )
    end: StringProperty(name="To", description="Shape key that the arc ends at", options={"SKIP_SAVE"})
    slider: StringProperty(
        name="Slider",
        description="Name of the slider and of the baked keys; empty: named after the key it leads to",
        options={"SKIP_SAVE"},
    )
    exists: exists_property("UPDATE")
    prepare_keys: BoolProperty(
        name="Prepare Keys",
        description="Set the start key to 1 and the end key to 0, whose value the slider takes, so that the "
        "slider alone plays from one to the other. Driven, animated or locked keys are left as they are",
        default=True,
    )

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def begin(self, context):
        obj = checks.mesh_object(self.object, context)
        self._baking = arcs.Baking(obj, arcs.asked_of(self))
        return Work(self._baking.steps())


classes = (LISSOM_OT_inbetween_bake,)
