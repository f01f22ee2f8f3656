"""Shape keys mirrored, summed, and split into left and right."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from ..core.mirrors import AXES
from ..jobs.sides import MirrorAsked, MirrorKeys, SplitAsked, SplitKeys, SumAsked, SumKeys
from ..properties.transfer_options import exists_property
from .job import JobRunner, writable_mesh
from .objects import KEYS, OBJECT


def _axis():
    return EnumProperty(
        name="Axis",
        description="Left is on its side of +; the plane of symmetry goes through the object's origin",
        items=[(axis, axis, f"Left and right along {axis}") for axis in AXES],
    )


def _edited():
    return EnumProperty(
        name="Edited Keys",
        description="What becomes of shape keys that were edited by hand since they were made or transferred",
        items=[
            ("KEEP", "Keep", "They stay as they are"),
            ("OVERWRITE", "Overwrite", "What was changed by hand is lost"),
        ],
    )


class _SidesOperator(JobRunner):
    """Mixin: one job on the keys of one object."""

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context)


class LISSOM_OT_key_mirror(_SidesOperator, bpy.types.Operator):
    """Make the key of the other side from this one, as the mesh mirrors; vertices need not be symmetric"""

    bl_idname = "lissom.key_mirror"
    bl_label = "Mirror to Other Side"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    keys: StringProperty(**KEYS)
    axis: _axis()
    exists: exists_property("UPDATE")
    edited: _edited()

    job_class, asked_class = MirrorKeys, MirrorAsked


class LISSOM_OT_key_split(_SidesOperator, bpy.types.Operator):
    """Make a left and a right key of this one, which add up to it"""

    bl_idname = "lissom.key_split"
    bl_label = "Split Left and Right"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    keys: StringProperty(**KEYS)
    axis: _axis()
    falloff: FloatProperty(
        name="Falloff",
        description="How wide the band is in which left goes over into right, as a part of the mesh's width",
        default=0.1,
        min=0.0,
        max=2.0,
        precision=3,
    )
    exists: exists_property("UPDATE")
    edited: _edited()

    job_class, asked_class = SplitKeys, SplitAsked


class LISSOM_OT_key_sum(_SidesOperator, bpy.types.Operator):
    """Make one key that is the sum of several"""

    bl_idname = "lissom.key_sum"
    bl_label = "Sum of Keys"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    keys: StringProperty(
        name="Keys",
        description="Names of the shape keys, one a line; empty: all that are not at 0",
        options={"SKIP_SAVE"},
    )
    name: StringProperty(name="Name", description="Of the key that is made", default="Sum")
    by_value: BoolProperty(
        name="By Value", description="Each counts as much as its value says, and not wholly", default=True
    )
    exists: exists_property("RENAME")
    edited: _edited()

    job_class, asked_class = SumKeys, SumAsked


classes = (LISSOM_OT_key_mirror, LISSOM_OT_key_split, LISSOM_OT_key_sum)
