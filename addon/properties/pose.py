"""Settings of a posed mesh, on its object."""

import bpy
from bpy.props import (
    BoolProperty,
    BoolVectorProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import changes
from ..bridge import handles
from ..core.mirrors import SYMMETRIES
from ..core.pose import PROBES
from ..core.pose_options import METHODS, OPTIONS, PAPERS, SHOWN_FIRST
from ..core.stays import STAYS
from .options import option_property

# The table's place is what a file stores.
_METHODS = {
    name: (name, label, f"{line} ({PAPERS[name]})", number)
    for number, (name, label, line) in enumerate(METHODS)
}
METHOD_ITEMS = [_METHODS[name] for name in dict.fromkeys((*SHOWN_FIRST, *_METHODS))]
STAY_ITEMS = [(*item, number) for number, item in enumerate(STAYS)]

BAKE_ITEMS = [
    (
        "KEYS",
        "Shape Keys",
        "A shape key for every frame, with keyframes on its value: exports to any engine",
        0,
    ),
    (
        "CACHE",
        "Point Cache",
        "A PC2 file and a Mesh Cache modifier that plays it: for long or dense animation",
        1,
    ),
]
BAKE_OUTPUT = "What the motion of the mesh is kept in"
BAKE_STEP = "Frames from one baked shape to the next; between them the mesh goes straight"
BAKE_PATH = "Where to put the point cache. Empty: beside the .blend file, named after the object"


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


def stays_property(**also):
    """What else is held where nothing but what is dragged holds a mesh."""
    return EnumProperty(
        name="What Stays",
        description="What stays in its place where no region, pin or other handle says so",
        items=STAY_ITEMS,
        default="FAR",
        **also,
    )


def reach_property(**also):
    """From where on a mesh is far from its handles."""
    return FloatProperty(
        name="Beyond",
        description="Distance from the handles, along the mesh, beyond which everything stays. "
        "0: Bind chooses one by the size of the largest",
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
        **also,
    )


def symmetry_property(**also):
    """Across which axis of the object one side follows the other."""
    return EnumProperty(
        name="Symmetry",
        description="One side of a symmetric mesh follows the handles of the other; "
        "handles in the middle stay in the middle",
        items=[(*item, number) for number, item in enumerate(SYMMETRIES)],
        default="OFF",
        **also,
    )


def stands_property(**also):
    """Whether Bind takes the mesh as it is seen."""
    return BoolProperty(
        name="As It Stands",
        description="Pose the mesh as armature, other keys and modifiers show it now, and make the key that "
        "shows this through them. Off: pose its rest shape",
        default=True,
        **also,
    )


def _changed(settings, _):
    obj = settings.id_data
    if obj.lissom_pose.bound:
        changes.pose_options.tell(obj)


def _turn_changed(handle, _):
    obj = handle.id_data
    if obj.lissom_pose.bound:
        changes.handle_turn.tell(obj)


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


def _rename(handle, wanted):
    handles.rename(handle.id_data, handle, wanted)


class LissomHandle(bpy.types.PropertyGroup):
    """One handle; its name is that of the vertex group."""

    name: StringProperty(name="Vertex Group", description="The vertices that this handle moves")
    label: StringProperty(
        name="Handle",
        description="Double-click to rename the handle with its vertex group and its Empty",
        get=lambda handle: handle.name,
        set=_rename,
        options={"SKIP_SAVE"},
    )
    empty: PointerProperty(
        type=bpy.types.Object, poll=_is_handle, name="Empty", description="The Empty that moves this handle"
    )
    turns_by_itself: BoolProperty(
        name="Turn by Itself",
        description="While the Empty is only moved, its vertices turn about their centre as suits where they "
        "go. They turn as the Empty does from when it is rotated on, or where this is off",
        default=True,
        update=_turn_changed,
    )
    dragged: BoolProperty(options={"HIDDEN"}, description="Made on the mesh, to be dragged")
    rest: FloatVectorProperty(
        size=16, description="Matrix of the Empty at Bind, in the object's coordinates, by rows"
    )
    rotation_mode: StringProperty(description="Rotation mode of the Empty at Bind")
    rotation: FloatVectorProperty(
        size=4, description="Rotation of the Empty at Bind as its mode keeps it, to count whole turns from"
    )


def _is_mesh(_, obj):
    return obj.type == "MESH"


class LissomCompanion(bpy.types.PropertyGroup):
    """A further object under the handles."""

    object: PointerProperty(type=bpy.types.Object, poll=_is_mesh, name="Object")
    way: EnumProperty(
        name="Goes Along",
        description="How the object goes along with the mesh",
        items=[
            ("RIDE", "Rigid", "As rigid parts, which ride on the nearest surface: eyes, teeth, buttons"),
            ("DRAPE", "Cloth", "With the surface that it lies on: clothes, lashes, a mask"),
        ],
    )
    # Written by Bind.
    matrix: FloatVectorProperty(size=16, description="From its coordinates to the bound object's, by rows")
    topology: StringProperty(options={"HIDDEN"}, description="Hash of the faces at Bind")
    preview: StringProperty(options={"HIDDEN"}, description="Name of the shape key that shows the pose")
    made_basis: BoolProperty(options={"HIDDEN"}, description="Bind gave the mesh its first shape key")
    stood: BoolProperty(options={"HIDDEN"}, description="It was bound as armature and modifiers have it")


class LissomBakedKey(bpy.types.PropertyGroup):
    """A shape key that Bake made, by name."""

    name: StringProperty()
    muted: BoolProperty(options={"HIDDEN"}, description="The artist had muted it before Bind")


def _row_chosen(settings, row):
    settings.active_handle = row
    if 0 <= row < len(settings.handles):
        handles.select(settings.id_data, settings.handles[row])


class LissomPose(bpy.types.PropertyGroup):
    """Settings of one mesh object."""

    roi: StringProperty(
        name="Region",
        description="Region of interest (ROI): only this group may move. Empty: the whole mesh may move",
    )
    handles: CollectionProperty(type=LissomHandle)
    company: CollectionProperty(type=LissomCompanion)
    active_handle: IntProperty(name="Active Handle", options=set())
    chosen_handle: IntProperty(
        name="Handle",
        description="The active row of the list; choosing one selects its Empty",
        get=lambda settings: settings.active_handle,
        set=_row_chosen,
        options={"SKIP_SAVE"},
    )
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
    stays: stays_property(update=_changed)
    reach: reach_property(update=_changed)
    symmetry: symmetry_property(update=_changed)
    live: BoolProperty(
        name="Live",
        description="Let the mesh follow while an Empty moves. Off: it follows when Update is pressed",
        default=True,
    )
    key_name: StringProperty(
        name="Key", description="Name of the shape key that Apply makes of the pose", default="Pose"
    )
    bake_output: EnumProperty(name="Output", description=BAKE_OUTPUT, items=BAKE_ITEMS, default="KEYS")
    bake_step: IntProperty(name="Step", description=BAKE_STEP, default=1, min=1, max=1000)
    bake_path: StringProperty(name="Cache File", description=BAKE_PATH, subtype="FILE_PATH")
    baked: CollectionProperty(type=LissomBakedKey)
    baked_cache: StringProperty(options={"HIDDEN"}, description="Name of the modifier that plays the cache")
    cache_hidden: BoolVectorProperty(
        size=2, options={"HIDDEN"}, description="The artist had hidden it before Bind: viewport, render"
    )
    stands: stands_property(update=_changed)
    # Written by Bind.
    stood: BoolProperty(options={"HIDDEN"}, description="It was bound as armature and modifiers have it")
    bound: BoolProperty(options={"HIDDEN"})
    warnings: StringProperty(name="Warnings", description="What Bind had to say, one a line")
    preview: StringProperty(options={"HIDDEN"}, description="Name of the shape key that shows the pose")
    applied: StringProperty(options={"HIDDEN"}, description="Name of the shape key that Apply made last")
    made_basis: BoolProperty(options={"HIDDEN"}, description="Bind gave the mesh its first shape key")
    topology: StringProperty(options={"HIDDEN"}, description="Hash of the faces at Bind")
    probes: FloatVectorProperty(
        size=3 * PROBES, options={"HIDDEN"}, description="Some vertices of the rest shape when last looked at"
    )
    linear: FloatVectorProperty(
        size=9, options={"HIDDEN"}, description="Rotation and scale of the object that Bind applied, by rows"
    )


classes = (LissomHandle, LissomCompanion, LissomBakedKey, *_GROUPS.values(), LissomPoseOptions, LissomPose)


def register():
    bpy.types.Object.lissom_pose = PointerProperty(type=LissomPose)
    bpy.types.Object.lissom_handle_of = PointerProperty(
        type=bpy.types.Object, name="Handle of", description="The mesh object that this Empty is a handle of"
    )


def unregister():
    del bpy.types.Object.lissom_handle_of
    del bpy.types.Object.lissom_pose
