"""Transfer of vertex groups, UV maps and colour attributes."""

import bpy

from ..bridge import attributes, checks
from ..jobs.attributes import AttributesAsked, TransferAttributes
from ..properties.transfer_options import colours_property, exists_property, groups_property, uv_maps_property
from .job import JobRunner, allowed
from .transfer import FitProperties, ready


class LISSOM_OT_transfer_attributes(FitProperties, JobRunner, bpy.types.Operator):
    """Carry vertex groups, UV maps and colour attributes of the source over to the target"""

    bl_idname = "lissom.transfer_attributes"
    bl_label = "Transfer Attributes"
    bl_options = {"REGISTER", "UNDO"}

    vertex_groups: groups_property()
    uv_maps: uv_maps_property()
    colours: colours_property()
    exists: exists_property("UPDATE")

    job_class, asked_class = TransferAttributes, AttributesAsked

    @classmethod
    def poll(cls, context):
        if not ready(cls, context):
            return False
        settings = getattr(context, "lissom_transfer", None)
        if settings is None:
            return True
        targets = [settings.target, *(row.object for row in settings.target_parts if row.object)]
        sources = [settings.source, *(row.object for row in settings.source_parts if row.object)]
        reasons = [checks.refusal(obj, keys=False) for obj in targets]
        if not attributes.has_any(sources):
            reasons.append(f"'{settings.source.name}' has no vertex groups, UV maps or colours to carry over")
        return allowed(cls, next(filter(None, reasons), ""))


classes = (LISSOM_OT_transfer_attributes,)
