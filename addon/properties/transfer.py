"""Settings of a transfer, on the scene."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import changes
from ..bridge.screen import redraw_views
from ..core.quality import MEASURES, ORDERS
from ..translations import CONTEXT
from .markers import LissomCurve, LissomMarker
from .pose import BAKE_ITEMS, BAKE_OUTPUT, BAKE_PATH, BAKE_STEP
from .ticks import LissomTick
from .transfer_options import (
    check_property,
    colours_property,
    drivers_property,
    drop_empty_property,
    edited_property,
    exists_property,
    face_names_property,
    fit_properties,
    groups_property,
    learn_strength_property,
    transfer_properties,
    uv_maps_property,
)


def _show_learned(settings, _):
    changes.learned_row.tell(settings.id_data)


def _is_mesh(_, obj):
    return obj.type == "MESH"


class LissomPart(bpy.types.PropertyGroup):
    """A further object of the source or the target."""

    object: PointerProperty(type=bpy.types.Object, poll=_is_mesh, name="Object")
    kind: EnumProperty(
        name="Kind",
        description="What Face Keys moves it as",
        items=[
            ("AUTO", "By Shape", "As its shape and its place tell"),
            ("EYE", "Eyeball", "It turns about its middle where the eyes look"),
            ("UPPER", "Upper Teeth", "It stays"),
            ("LOWER", "Lower Teeth, Tongue", "It goes with the jaw"),
            ("RIDE", "Lashes, Hair", "It goes with the skin beside it"),
        ],
    )
    found: StringProperty(name="Found", description="What Face Keys has taken its pieces for")


class _Measures:
    """Mixin: the numbers of a key."""

    __annotations__ = {
        name: (IntProperty if isinstance(one.fine, int) else FloatProperty)(
            name=one.label, description=one.line, default=one.fine
        )
        for name, one in MEASURES.items()
    }


class LissomKeyQuality(_Measures, bpy.types.PropertyGroup):
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


class LissomWritten(bpy.types.PropertyGroup):
    """What was written to one shape key; see bridge.written."""

    name: StringProperty(description="Name of the shape key then")
    topology: StringProperty(description="The hash of the edges then")
    offsets: StringProperty(subtype="BYTE_STRING")
    probes: StringProperty(description="Some vertices of the Basis then", subtype="BYTE_STRING")
    strength: FloatProperty(description="Over that of the transfer", default=1.0)
    transferred: StringProperty(
        description="The same before it was learned; empty: it was not", subtype="BYTE_STRING"
    )


class LissomLearned(bpy.types.PropertyGroup):
    """How much one shape key would change by what is learned from those that were corrected."""

    name: StringProperty(name="Shape Key")
    change: FloatProperty(description="Of its motion; of a corrected key, what the correction is")
    corrected: BoolProperty(description="Whether it is one of those that were corrected")
    foretold: FloatProperty(description="What part of its correction the others foretell")


class LissomBaked(bpy.types.PropertyGroup):
    """What a transfer of animation made on an object, so that the next of that name takes its place."""

    name: StringProperty(description="Name of the shape key, or of the modifier")
    bake: StringProperty(description="Name that the transfer was given")
    cached: BoolProperty(description="It is a modifier that plays a cache")


def _row_chosen(settings, _):
    changes.quality_row.tell(settings.id_data)


class _TransferOptions:
    """Mixin: the options of fit and transfer."""

    __annotations__ = fit_properties() | transfer_properties()


class LissomTransfer(_TransferOptions, bpy.types.PropertyGroup):
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
            ("FACE_3", "Face, 3", "The middles of both eyes and of the mouth: enough for Face Keys"),
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
    chosen: CollectionProperty(type=LissomTick)
    exists: exists_property("UPDATE")
    edited: edited_property()
    drivers: drivers_property()
    drop_empty: drop_empty_property()
    vertex_groups: groups_property()
    uv_maps: uv_maps_property()
    colours: colours_property()
    check: check_property()
    warnings: StringProperty(name="Warnings", description="What the last job had to say, one a line")
    warned_source: PointerProperty(type=bpy.types.Object, description="The source that it was said of")
    warned_target: PointerProperty(type=bpy.types.Object, description="The target that it was said of")
    quality: CollectionProperty(type=LissomKeyQuality)
    active_quality: IntProperty(name="Shape Key", options=set(), update=_row_chosen)
    quality_order: EnumProperty(
        name="Order",
        description="What the table is sorted by, the worst first",
        items=[
            (name, MEASURES[name].label if name in MEASURES else "Verdict", line)
            for name, (_, _, line) in ORDERS.items()
        ],
    )
    split_views: StringProperty(
        options={"HIDDEN"}, description="In a file: the two views that were one before"
    )
    learned: CollectionProperty(type=LissomLearned)
    active_learned: IntProperty(name="Key", update=_show_learned)
    learn_strength: learn_strength_property()

    def keep(self, warnings):
        """Keeps the lines of what a job had to say of source and target, as these are now."""
        self.warnings = "\n".join(warnings)
        self.warned_source, self.warned_target = self.source, self.target

    @property
    def told(self):
        """The warnings that are kept of source and target; "" while there is another."""
        same = (self.warned_source, self.warned_target) == (self.source, self.target)
        return self.warnings if same else ""

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
    LissomPart,
    LissomKeyQuality,
    LissomBaked,
    LissomWritten,
    LissomLearned,
    LissomTransfer,
)


def register():
    bpy.types.Scene.lissom_transfer = PointerProperty(type=LissomTransfer)
    bpy.types.Object.lissom_baked = CollectionProperty(type=LissomBaked)
    bpy.types.Key.lissom_written = CollectionProperty(type=LissomWritten)
    bpy.types.Key.lissom_made = CollectionProperty(type=LissomWritten)


def unregister():
    del bpy.types.Key.lissom_made
    del bpy.types.Key.lissom_written
    del bpy.types.Object.lissom_baked
    del bpy.types.Scene.lissom_transfer
