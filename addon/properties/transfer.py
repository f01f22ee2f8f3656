"""Settings of a transfer, on the scene."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)

from .. import session
from ..bridge.meshes import rest_place
from ..bridge.screen import redraw_views
from ..core.options import option
from ..core.surface import Point
from ..translations import CONTEXT
from .options import option_property
from .pose import BAKE_ITEMS, BAKE_OUTPUT, BAKE_PATH, BAKE_STEP

EXISTS_ITEMS = [
    ("UPDATE", "Update", "Write over what has the same name"),
    ("SKIP", "Skip", "Leave what has the same name as it is"),
    ("RENAME", "Rename", "Keep what has the same name and number the new one"),
]


def exists_property(default):
    """What a key or an attribute gets whose name is taken (row 32)."""
    return EnumProperty(
        name="If Exists",
        description="What to do where one of that name is there already",
        items=EXISTS_ITEMS,
        default=default,
    )


def edited_property():
    """What becomes of keys that the artist has edited since a transfer wrote them."""
    return EnumProperty(
        name="Edited Keys",
        description="What becomes of shape keys that were edited by hand since they were transferred",
        items=[
            ("KEEP", "Keep", "They stay as they are"),
            ("CARRY", "Carry Over", "The new result, with what was changed by hand on top of it"),
            ("OVERWRITE", "Overwrite", "The new result: what was changed by hand is lost"),
        ],
    )


def match_distance_property():
    """The option of the same name of lissom.start_fit."""
    label = {"label": "Match Distance", "low": 1e-6, "high": 1.0, "soft_high": 0.1}
    return option_property(option("fit", "match_distance", **label), precision=3)


def marker_tolerance_property():
    """The option of the same name of lissom.start_fit."""
    label = {"label": "Marker Tolerance", "high": 1.0, "soft_high": 0.1}
    return option_property(option("fit", "marker_tolerance", **label), precision=3)


def closest_property():
    """The option of the same name of lissom.start_fit."""
    return option_property(option("fit", "closest", "Tightness", high=1e6), precision=0)


def overlap_property():
    """The option of the same name of lissom.start_fit."""
    return option_property(option("fit", "overlap", "They Overlap"))


def mask_property(side):
    """A vertex group of the source or the target, for the option of lissom.start_fit of that name."""
    return StringProperty(
        name=f"{side} Mask",
        description=f"Vertex group of the {side.lower()} that matches nothing, such as the inside of the "
        "mouth. Empty: everything may match",
    )


def unmatched_property():
    """The option of the same name of lissom.Transfer (row 30)."""
    labels = {"follow": "Follow", "rest": "Stay"}
    return option_property(option("transfer", "unmatched", "Loose Parts", labels))


def scale_property():
    """The option of the same name of lissom.Transfer."""
    labels = {"target": "Target's Size", "source": "As Far"}
    return option_property(option("transfer", "scale", "Scale", labels))


def drivers_property():
    """What becomes of the drivers of the keys."""
    return EnumProperty(
        name="Drivers",
        description="What becomes of the drivers of the shape keys",
        items=[
            ("REWIRE", "To Target", "They come along, and read the target where they read the source", 0),
            ("KEEP", "As They Are", "They come along, and go on reading the source", 1),
            ("NONE", "None", "They stay behind: the new keys keep their values", 2),
        ],
    )


def contact_property():
    """The option of the same name of lissom.Transfer."""
    return option_property(option("transfer", "contact", "Contact"))


def face_names_property():
    """Which face keys, and what they are called."""
    return EnumProperty(
        name="Names",
        description="Which keys, and what they are called",
        items=[
            ("ARKIT", "ARKit", "The 52 of Apple's ARKit, as Live Link Face and VSeeFace have them"),
            ("ICT", "ICT", "The 53 of the face that comes along, left and right apart"),
            ("VRM", "VRM", "The preset expressions of VRM 1.0"),
            ("VISEMES", "Visemes", "The 15 of Oculus's lip sync"),
        ],
    )


def drop_empty_property():
    """Whether keys that move nothing are left out."""
    return BoolProperty(
        name="Drop Empty",
        description="Leave out shape keys that do not move the target. Further objects of the target get "
        "only those that move them in any case",
    )


def check_property():
    """Whether the quality of each key is found."""
    return BoolProperty(
        name="Check Quality",
        description="Judge every key by what one sees, and list which of them deserve a look",
        default=True,
    )


def groups_property():
    """Whether vertex groups are carried over."""
    return BoolProperty(
        name="Vertex Groups",
        description="Weights of all vertex groups; each vertex is in no more of them than on the source, "
        "and their sum is as there",
        default=True,
    )


def uv_maps_property():
    """Whether UV maps are carried over."""
    return BoolProperty(
        name="UV Maps",
        description="All UV maps; each face of the target lies on one side of their seams",
        default=True,
    )


def colours_property():
    """Whether colour attributes are carried over."""
    return BoolProperty(
        name="Colors", description="All color attributes, of vertices and of face corners", default=True
    )


def _is_mesh(_, obj):
    return obj.type == "MESH"


def _at_vertex(side):
    """Puts a mark on the vertex whose number was changed by hand."""

    def update(row, _):
        obj, vertex = getattr(row.id_data.lissom_transfer, side), getattr(row, side)
        row.put(side, Point.at(vertex), rest_place(obj.data, vertex) if obj else None)
        redraw_views()

    return update


class LissomMarker(bpy.types.PropertyGroup):
    """One marker pair, as core.markers.Marker has it; weights are 0 where a point is at its vertex.

    Its places, of the points at rest, survive edits of the meshes.
    """

    name: StringProperty(name="Name", description="What this place is, such as: left corner of the mouth")
    source: IntProperty(
        name="Source Vertex", min=0, update=_at_vertex("source"),
        description="The vertex of the source that the mark is at or nearest to; another one puts it there",
    )  # fmt: skip
    target: IntProperty(
        name="Target Vertex", min=0, update=_at_vertex("target"),
        description="The vertex of the target that the mark is at or nearest to; another one puts it there",
    )  # fmt: skip
    source_corners: IntVectorProperty(size=3)
    target_corners: IntVectorProperty(size=3)
    source_weights: FloatVectorProperty(size=3)
    target_weights: FloatVectorProperty(size=3)
    number: IntProperty(description="The one that the pair is known by; 0: not numbered yet")
    source_place: FloatVectorProperty(size=3)
    target_place: FloatVectorProperty(size=3)
    guessed: BoolProperty(
        name="Guessed",
        description="It lies where the fit has it, and tells the fit nothing until it is confirmed or moved",
    )
    source_placed: BoolProperty()
    target_placed: BoolProperty()
    mirror: BoolProperty(
        name="Symmetric",
        description="Complete this pair on the other side when Mirror is pressed",
        default=True,
    )

    def place(self, side):
        """(x, y, z) at rest on "source" or "target", in the object's coordinates, or None."""
        return tuple(getattr(self, f"{side}_place")) if getattr(self, f"{side}_placed") else None

    def point(self, side):
        """The Point on "source" or "target"."""
        weights = tuple(getattr(self, f"{side}_weights"))
        if not any(weights):
            return Point.at(getattr(self, side))
        return Point.of(getattr(self, f"{side}_corners"), weights)

    @property
    def ends(self):
        """Its points on (source, target)."""
        return self.point("source"), self.point("target")

    def put(self, side, point, place):
        """Keeps a point and its place, or that there is none."""
        if getattr(self, side) != point.vertex:
            setattr(self, side, point.vertex)
        setattr(self, f"{side}_corners", point.corners)
        setattr(self, f"{side}_weights", (0, 0, 0) if point.is_vertex else point.weights)
        setattr(self, f"{side}_placed", place is not None)
        if place is not None:
            setattr(self, f"{side}_place", place)

    def swap(self):
        """Exchanges its points on source and target."""
        (source, target), places = self.ends, (self.place("source"), self.place("target"))
        self.put("source", target, places[1])
        self.put("target", source, places[0])


class LissomLandmark(bpy.types.PropertyGroup):
    """A named point of a mesh object, and its place at rest in the object's coordinates."""

    name: StringProperty(name="Name")
    corners: IntVectorProperty(size=3)
    weights: FloatVectorProperty(size=3)
    place: FloatVectorProperty(size=3)


class LissomCurve(bpy.types.PropertyGroup):
    """One curve: paths along edges of both meshes by their vertices, and their places at rest as JSON."""

    name: StringProperty(name="Name", description="What this rim is, such as: upper lip")
    source: StringProperty(description="Vertices of the source, with spaces between")
    target: StringProperty(description="Vertices of the target, with spaces between")
    source_places: StringProperty()
    target_places: StringProperty()

    @property
    def vertices(self):
        """(source, target)."""
        return self.source, self.target


class LissomPart(bpy.types.PropertyGroup):
    """A further object of the source or the target."""

    object: PointerProperty(type=bpy.types.Object, poll=_is_mesh, name="Object")


class LissomKeyQuality(bpy.types.PropertyGroup):
    """What the last transfer said about one shape key; see lissom.Transfer.quality."""

    name: StringProperty(name="Shape Key")
    source: StringProperty(description="Name of the source's shape key")
    verdict: EnumProperty(
        name="Verdict",
        description="Whether the key can be taken as it is",
        items=[
            ("good", "Good", "It can be taken as it is"),
            ("look", "Look", "It may be right: look at it"),
            ("bad", "Bad", "It has to be mended"),
        ],
    )
    reasons: StringProperty(name="Reasons", description="Why it is not good, one a line, the worst first")
    faces: StringProperty(name="Faces", description="Faces to look at, by object, as JSON")
    flipped_triangles: IntProperty(name="Flipped", description="Triangles of the target that are turned over")
    torn_triangles: IntProperty(name="Torn", description="Triangles 2.5 times as long as was asked")
    contacts: IntProperty(name="Contacts", description="Vertices of the target that meet another surface")
    contact_gap: FloatProperty(
        name="Gap",
        description="How much wider apart they are than on the source, in percent of the target's size",
    )
    closing: FloatProperty(name="Closing", description="What part of the way they come together", default=1.0)
    strength: FloatProperty(
        name="Strength", description="Motion over that of the source, as Scale has it", default=1.0
    )
    crooked: FloatProperty(
        name="Crooked", description="Difference of left and right where there is none on the source"
    )
    motion: FloatProperty(name="Motion", description="Largest motion, in percent of the target's size")
    residual: FloatProperty(
        name="Residual", description="How far the key is from what was asked of each face, of its own size"
    )


class LissomKeyChoice(bpy.types.PropertyGroup):
    """The name of a shape key that is ticked."""

    name: StringProperty(name="Shape Key")


class LissomWritten(bpy.types.PropertyGroup):
    """What a transfer wrote to one shape key; see bridge.written."""

    name: StringProperty(description="Name of the shape key then")
    topology: StringProperty(description="The hash of the faces then")
    offsets: StringProperty(subtype="BYTE_STRING")


class LissomBaked(bpy.types.PropertyGroup):
    """What a transfer of animation made on an object, so that the next of that name takes its place."""

    name: StringProperty(description="Name of the shape key, or of the modifier")
    bake: StringProperty(description="Name that the transfer was given")
    cached: BoolProperty(description="It is a modifier that plays a cache")


def _show_key(settings, _):
    """The key of a row that is clicked becomes the active one of the target, and is shown in a review."""
    if session.review is not None:
        session.review.show(settings)
        return
    row = settings.quality[settings.active_quality]
    keys = settings.target.data.shape_keys if settings.target else None
    if keys and row.name in keys.key_blocks:
        settings.target.active_shape_key_index = keys.key_blocks.find(row.name)


class LissomTransfer(bpy.types.PropertyGroup):
    """Settings of the scene's transfer."""

    source: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Source",
        description="The mesh whose shape keys are carried over",
    )
    target: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Target",
        description="The mesh that receives the shape keys",
    )
    source_parts: CollectionProperty(type=LissomPart)
    target_parts: CollectionProperty(type=LissomPart)
    markers: CollectionProperty(type=LissomMarker)
    curves: CollectionProperty(type=LissomCurve)
    source_edges: StringProperty(description="The hash of the source's edges when its markers were placed")
    target_edges: StringProperty(description="The hash of the target's edges when its markers were placed")
    face_names: face_names_property()
    landmarks: EnumProperty(
        name="Landmarks",
        translation_context=CONTEXT,
        description="Which places Pick asks for, one after the other",
        items=[
            ("FREE", "Free", "Any places, in any order"),
            ("FACE_7", "Face, 7", "Corners of the eyes and the mouth, tip of the nose"),
            ("FACE_24", "Face, 24", "With brows, lids, lips, nostrils, jaw and ears"),
            ("FACE_68", "Face, 68", "The 68 of Multi-PIE, in its order"),
            ("BODY", "Body, 26", "Joints, fingertips, toes, head and trunk"),
            ("OWN", "As on Source", "The named ones that the source bears already"),
        ],
        update=lambda settings, context: redraw_views(),
    )
    show_markers: BoolProperty(
        name="Show Markers",
        description="Show the marker pairs as numbered dots on both meshes",
        update=lambda settings, context: redraw_views(),
    )
    active_marker: IntProperty(name="Active Marker", options=set())
    what: EnumProperty(
        name="Transfer",
        translation_context=CONTEXT,
        description="What of the source is carried over",
        items=[
            ("KEYS", "Keys", "Its shape keys"),
            ("POSE", "Pose", "What it looks like now, by armature, modifiers and keys, as one shape key"),
            ("ANIMATION", "Animation", "What it looks like at each frame of a range"),
            ("ATTRIBUTES", "Attributes", "Its vertex groups, UV maps and color attributes"),
        ],
    )
    pose_name: StringProperty(
        name="Name", description="Of the new shape key; for an animation before the frame", default="Pose"
    )
    bake_output: EnumProperty(name="Output", description=BAKE_OUTPUT, items=BAKE_ITEMS, default="KEYS")
    bake_step: IntProperty(name="Step", description=BAKE_STEP, default=1, min=1, max=1000)
    bake_path: StringProperty(name="Cache File", description=BAKE_PATH, subtype="FILE_PATH")
    which: EnumProperty(
        name="Keys",
        description="Which shape keys of the source to carry over",
        items=[
            ("ALL", "All", "All shape keys of the source"),
            ("SELECTED", "Selected", "Only the shape keys that are ticked in the list"),
        ],
    )
    chosen: CollectionProperty(type=LissomKeyChoice)
    overlap: overlap_property()
    marker_tolerance: marker_tolerance_property()
    match_distance: match_distance_property()
    closest: closest_property()
    source_mask: mask_property("Source")
    target_mask: mask_property("Target")
    unmatched: unmatched_property()
    scale: scale_property()
    exists: exists_property("UPDATE")
    edited: edited_property()
    drivers: drivers_property()
    contact: contact_property()
    drop_empty: drop_empty_property()
    vertex_groups: groups_property()
    uv_maps: uv_maps_property()
    colours: colours_property()
    check: check_property()
    quality: CollectionProperty(type=LissomKeyQuality)
    active_quality: IntProperty(name="Shape Key", options=set(), update=_show_key)
    quality_order: EnumProperty(
        name="Order",
        description="What the table is sorted by, the worst first",
        items=[
            ("verdict", "Verdict", "Bad keys, then those that deserve a look"),
            ("flipped_triangles", "Flipped", "Faces that are turned over"),
            ("torn_triangles", "Torn", "Faces that are stretched beyond what was asked"),
            ("contact_gap", "Gap", "Lids and lips that stay apart"),
            ("strength", "Strength", "Motions that are lost or exaggerated"),
            ("residual", "Residual", "How far the key is from what was asked of each face"),
        ],
    )

    def swap(self):
        """Source and target change places, with their further objects, marks, curves and masks."""
        for name in ("", "_mask", "_edges"):
            _exchange(self, name)
        for row in self.markers:
            row.swap()
        for row in self.curves:
            _exchange(row, "")
            _exchange(row, "_places")
        sides = [[row.object for row in parts] for parts in (self.target_parts, self.source_parts)]
        for parts, objects in zip((self.source_parts, self.target_parts), sides, strict=True):
            parts.clear()
            for obj in objects:
                parts.add().object = obj


def _exchange(row, what):
    """Swaps ``source`` and ``target`` of a row, or what is named after them."""
    names = f"source{what}", f"target{what}"
    values = [getattr(row, name) for name in names]
    for name, value in zip(names, reversed(values), strict=True):
        setattr(row, name, value)


classes = (
    LissomMarker,
    LissomLandmark,
    LissomCurve,
    LissomKeyChoice,
    LissomPart,
    LissomKeyQuality,
    LissomBaked,
    LissomWritten,
    LissomTransfer,
)


def register():
    bpy.types.Scene.lissom_transfer = PointerProperty(type=LissomTransfer)
    bpy.types.Object.lissom_landmarks = CollectionProperty(type=LissomLandmark)
    bpy.types.Object.lissom_baked = CollectionProperty(type=LissomBaked)
    bpy.types.Key.lissom_written = CollectionProperty(type=LissomWritten)


def unregister():
    del bpy.types.Key.lissom_written
    del bpy.types.Object.lissom_baked
    del bpy.types.Object.lissom_landmarks
    del bpy.types.Scene.lissom_transfer
