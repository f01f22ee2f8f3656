"""Transfer of shape keys, and the choice of keys."""

import bpy
from bpy.props import StringProperty

from ..bridge.assembly import objects_of
from ..jobs.fit import key_names
from ..jobs.transfer_keys import KeysAsked, TransferKeys
from ..properties.transfer_options import (
    check_property,
    drivers_property,
    drop_empty_property,
    edited_property,
    exists_property,
)
from .job import JobRunner, answering
from .ticks import TickProperties
from .transfer import TransferProperties, ready


class LISSOM_OT_transfer_keys(TransferProperties, JobRunner, bpy.types.Operator):
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


class LISSOM_OT_transfer_choose(TickProperties, bpy.types.Operator):
    """Tick or untick shape keys for the transfer"""

    bl_idname = "lissom.transfer_choose"
    bl_label = "Choose Keys"
    bl_options = {"REGISTER", "UNDO"}

    @answering
    def execute(self, context):
        self.tick(context.scene.lissom_transfer.chosen, key_names(objects_of(context, "source", "")))


classes = (LISSOM_OT_transfer_keys, LISSOM_OT_transfer_choose)
