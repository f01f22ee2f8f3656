"""Transfer of shape keys, and the choice of keys."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..bridge.assembly import objects_of
from ..jobs.fit import key_names
from ..jobs.transfer_keys import KeysAsked, TransferKeys, keys_of
from ..properties.transfer import (
    check_property,
    drivers_property,
    drop_empty_property,
    edited_property,
    exists_property,
)
from .job import answering
from .transfer_fit import TransferOperator, TransferProperties, ready


class LISSOM_OT_transfer_keys(TransferProperties, TransferOperator, bpy.types.Operator):
    """Carry shape keys of the source over to the target, with their names, values and ranges"""

    bl_idname = "lissom.transfer_keys"
    bl_label = "Transfer"
    bl_options = {"REGISTER", "UNDO"}

    keys: StringProperty(
        name="Keys", description="Names of the shape keys, one a line; empty: all", options={"SKIP_SAVE"}
    )
    exists: exists_property("UPDATE")
    edited: edited_property()
    drivers: drivers_property()
    drop_empty: drop_empty_property()
    check: check_property()

    job_class = TransferKeys

    @classmethod
    def poll(cls, context):
        return ready(cls, context, keys=True)

    def asked(self, context):
        return KeysAsked.of(self, keys=tuple(filter(None, self.keys.splitlines())))


class LISSOM_OT_transfer_choose(bpy.types.Operator):
    """Tick or untick shape keys for the transfer"""

    bl_idname = "lissom.transfer_choose"
    bl_label = "Choose Keys"
    bl_options = {"REGISTER", "UNDO"}

    action: EnumProperty(
        name="Action",
        description="Which ticks to set",
        items=[
            ("TOGGLE", "Toggle", "Tick or untick one key"),
            ("ALL", "All", "Tick all keys"),
            ("NONE", "None", "Untick all keys"),
        ],
    )
    key: StringProperty(name="Key", description="Name of the shape key to toggle", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        sources = objects_of(context, "source", "")
        if self.action == "TOGGLE":
            keys_of(sources, self.key)
            index = settings.chosen.find(self.key)
            if index >= 0:
                settings.chosen.remove(index)
            else:
                settings.chosen.add().name = self.key
            return
        settings.chosen.clear()
        if self.action == "ALL":
            for name in key_names(sources):
                settings.chosen.add().name = name


classes = (LISSOM_OT_transfer_keys, LISSOM_OT_transfer_choose)
