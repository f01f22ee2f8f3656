"""Settings of a posed mesh, on its object."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import rebind
from ..core.pose_options import METHODS, OPTIONS

# The table's place is what a file stores.
METHOD_ITEMS = [(*item, number) for number, item in enumerate(METHODS)]


def option_property(option, **also):
    """The Blender property of one option of the table."""
    settings = {"name": option.label, "description": option.line, "default": option.default, **also}
    if option.items:
        items = [(*item, number) for number, item in enumerate(option.items)]
        return EnumProperty(items=items, **settings)
    if isinstance(option.default, bool):
        return BoolProperty(**settings)
    settings |= {"min": option.low, "max": option.high, "soft_max": option.soft_high or option.high}
    return (IntProperty if isinstance(option.default, int) else FloatProperty)(**settings)


def _is_handle(_, obj):
    return obj.type == "EMPTY"


def use_weights_property(**also):
    """Whether vertices belong to a handle by their weight in its group."""
    return BoolProperty(
        name="Use Weights",
        description="Vertices of a weight below 1 follow their handle in part: its edge is soft. "
        "Off: a handle takes every vertex of its group along",
        default=False,
        **also,
    )


def weld_property(**also):
    """Whether lissom.Mesh welds vertices in the very same place (row 11)."""
    return BoolProperty(
        name="Weld Seams",
        description="Vertices in the very same place move as one, as at the seams of an imported mesh; "
        "the mesh itself keeps them all",
        default=False,
        **also,
    )


def _changed(settings, _):
    obj = settings.id_data
    if obj.lissom_pose.bound:
        rebind.ask(obj)


# One group a method, so that each keeps its own options while the artist tries another.
_GROUPS = {
    owner: type(
        f"LissomPoseOptions_{owner}",
        (bpy.types.PropertyGroup,),
        {
            "__doc__": f"Options of a pose method: {owner}.",
            "__annotations__": {
                name: option_property(option, update=_changed) for name, option in options.items()
            },
        },
    )
    for owner, options in OPTIONS.items()
}


class LissomPoseOptions(bpy.types.PropertyGroup):
    """The options of all methods, by method."""

    __annotations__ = {owner: PointerProperty(type=group) for owner, group in _GROUPS.items()}


class LissomHandle(bpy.types.PropertyGroup):
    """One handle; its name is that of the vertex group."""

    name: StringProperty(name="Vertex Group", description="The vertices that this handle moves")
    empty: PointerProperty(
        type=bpy.types.Object, poll=_is_handle, name="Empty", description="The Empty that moves this handle"
    )
    rest: FloatVectorProperty(
        size=16, description="Matrix of the Empty at Bind, in the object's coordinates, by rows"
    )


class LissomPose(bpy.types.PropertyGroup):
    """Settings of one mesh object."""

    roi: StringProperty(
        name="Region",
        description="Region of interest (ROI): only this group may move. Empty: the whole mesh may move",
    )
    handles: CollectionProperty(type=LissomHandle)
    active_handle: IntProperty(name="Active Handle", options=set())
    method: EnumProperty(
        name="Method",
        description="How the mesh between the handles follows them",
        items=METHOD_ITEMS,
        default="arap",
        update=_changed,
    )
    options: PointerProperty(type=LissomPoseOptions)
    use_weights: use_weights_property(update=_changed)
    weld: weld_property(update=_changed)
    live: BoolProperty(
        name="Live",
        description="Let the mesh follow while an Empty moves. Off: it follows when Update is pressed",
        default=True,
    )
    key_name: StringProperty(
        name="Key", description="Name of the shape key that Apply makes of the pose", default="Pose"
    )
    # Written by Bind.
    bound: BoolProperty(options={"HIDDEN"})
    preview: StringProperty(options={"HIDDEN"}, description="Name of the shape key that shows the pose")
    made_basis: BoolProperty(options={"HIDDEN"}, description="Bind gave the mesh its first shape key")
    topology: StringProperty(options={"HIDDEN"}, description="Hash of the faces at Bind")
    linear: FloatVectorProperty(
        size=9, options={"HIDDEN"}, description="Rotation and scale of the object that Bind applied, by rows"
    )


classes = (LissomHandle, *_GROUPS.values(), LissomPoseOptions, LissomPose)


def register():
    bpy.types.Object.lissom_pose = PointerProperty(type=LissomPose)
    bpy.types.Object.lissom_handle_of = PointerProperty(
        type=bpy.types.Object, name="Handle of", description="The mesh object that this Empty is a handle of"
    )


def unregister():
    del bpy.types.Object.lissom_handle_of
    del bpy.types.Object.lissom_pose
