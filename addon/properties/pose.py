"""Settings of a posed mesh, on its object."""

import bpy
import lissom
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import live

# Name, label, one line for the artist. A file stores the place in this list: only append.
_METHODS = (
    ("laplacian", "Laplacian", "Keeps the details' vectors; fast, for small motions without turns"),
    ("laplacian_fitted", "Laplacian, fitted", "Turns and scales the details to fit; for medium turns"),
    ("rotation_invariant", "Rotation-invariant", "Spreads the handles' turns over the mesh, also full turns"),
    ("thin_shell", "Thin shell", "Stretches and bends like a thin sheet; smooth, for small motions"),
    ("poisson", "Poisson", "Blends the handles' transforms by smooth weights; fast"),
    ("multiresolution", "Multiresolution", "Poses a smooth base, then puts the details back on it"),
    ("arap", "As rigid as possible", "Keeps every small piece of the mesh rigid; for large turns and bends"),
)

METHOD_ITEMS = [
    (name, label, line, number)
    for number, (name, label, line) in enumerate(_METHODS)
    if name in lissom.POSE_METHODS
]


def _is_handle(_, obj):
    return obj.type == "EMPTY"


def _method_changed(settings, _):
    if settings.bound:
        live.mark(settings.id_data)


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
        update=_method_changed,
    )
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


classes = (LissomHandle, LissomPose)


def register():
    bpy.types.Object.lissom_pose = PointerProperty(type=LissomPose)
    bpy.types.Object.lissom_handle_of = PointerProperty(
        type=bpy.types.Object, name="Handle of", description="The mesh object that this Empty is a handle of"
    )


def unregister():
    del bpy.types.Object.lissom_handle_of
    del bpy.types.Object.lissom_pose
