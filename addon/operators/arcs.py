"""What operators on arcs of in-betweens share: which arc of which object, and whether it can be written."""

from bpy.props import StringProperty

from ..bridge import arcs
from ..jobs.arcs import arc_object
from ..translations import translated
from .job import allowed, shown_object
from .objects import OBJECT

SLIDER = {"name": "Slider", "description": "Name of the slider", "options": {"SKIP_SAVE"}}


def arc_poll(operator_class, context):
    """poll() of operators that write arcs."""
    obj = shown_object(context)
    return allowed(operator_class, "" if obj is None else arcs.refusal(obj))


class ArcOperator:
    """Mixin: an operator on the arc of one slider."""

    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    slider: StringProperty(**SLIDER)

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def _object(self, context):
        return arc_object(context, self.object)

    def _warn(self, warnings):
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
