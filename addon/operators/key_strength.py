"""How strong transferred keys are."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..bridge.checks import mesh_object
from ..jobs.strength import LEAST, MOST, StrengthAsked, strength_of, strengthen
from .job import answering, report_done, writable_mesh
from .objects import KEYS, OBJECT


class LISSOM_OT_key_strength(bpy.types.Operator):
    """Make keys stronger or weaker than they were transferred; transferred again, they stay so"""

    bl_idname = "lissom.key_strength"
    bl_label = "Strength of Keys"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    keys: StringProperty(**KEYS)
    every: BoolProperty(
        name="Every Key", description="All keys that were transferred", default=False, options={"SKIP_SAVE"}
    )
    strength: FloatProperty(
        name="Strength",
        description="Over that of the transfer",
        default=1.0,
        min=LEAST,
        soft_max=2.0,
        max=MOST,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context)

    def invoke(self, context, event):
        return self._ask(context)

    @answering
    def _ask(self, context):
        self.strength = strength_of(mesh_object(self.object, context))
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(self, "strength")
        self.layout.prop(self, "every")

    @answering
    def execute(self, context):
        report_done(self, strengthen(context, StrengthAsked.of(self)))


classes = (LISSOM_OT_key_strength,)
