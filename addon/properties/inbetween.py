"""Settings of in-betweens, on the mesh object."""

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
from ..bridge import shape_keys
from ..core.easing import EASINGS
from ..core.inbetween import MAX_COUNT, PLAYBACK_ITEMS
from ..core.options import option
from ..translations import CONTEXT
from .options import option_property
from .ticks import LissomTick

# A file stores the place in these lists: only append.
OPTIONS = {
    "rotation": {
        "label": "Rotation",
        "labels": {"consistent": "Consistent", "shortest": "Shortest", "relative": "Relative"},
    },
    "stretch": {"label": "Stretch", "labels": {"linear": "Even", "logarithmic": "By Factors"}},
    "refinement": {"label": "Refinement", "high": 1000, "soft_high": 20},
    "preserve_volume": {"label": "Keep Volume"},
}
SAMPLING_ITEMS = [
    ("COUNT", "Even", "So many in-betweens, evenly spaced in time", 0),
    ("TOLERANCE", "Tolerance", "As few as keep every vertex within a distance of the arc", 1),
    ("PLACED", "Placed", "So many in-betweens, placed where they follow the arc best", 2),
]


def _obstacles(settings, context, text):
    own = settings.id_data if isinstance(settings.id_data, bpy.types.Object) else None
    return [obj.name for obj in bpy.data.objects if obj.type == "MESH" and obj != own]


def path_properties(**also):
    """{name: property} of the options of lissom.Inbetween."""
    return {
        **{
            name: option_property(option("inbetween", name, **label), **also)
            for name, label in OPTIONS.items()
        },
        "through": StringProperty(
            name="Through",
            description="Shape keys that the arc hits on its way, and when: 'half: 0.5, wide: 0.8'",
            **also,
        ),
        "clearance": StringProperty(
            name="Clearance",
            description="A closed mesh object, as an eyeball under a lid, that the arc comes no "
            "closer to and enters no deeper than its ends do. Where it has keys of their names, it moves "
            "by them",
            search=_obstacles,
            search_options=set(),
            **also,
        ),
    }


class PathSettings:
    """Mixin: the options of the path."""

    __annotations__ = path_properties()


class ArcSettings:
    """Mixin: how the path becomes keys, and how they are played."""

    sampling: EnumProperty(
        name="Keys",
        translation_context=CONTEXT,
        description="What decides the number of keys",
        items=SAMPLING_ITEMS,
        default="COUNT",
    )
    count: IntProperty(
        name="In-betweens",
        description="Shape keys between the two; more follow the arc more closely",
        default=5,
        min=1,
        soft_max=20,
        max=MAX_COUNT,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="How far the played shape may be from the arc, at any vertex and any time, in the scene",
        default=0.001,
        min=1e-7,
        soft_max=1.0,
        precision=4,
        subtype="DISTANCE",
    )
    easing: EnumProperty(
        name="Easing",
        description="How the slider runs through the arc",
        items=[(name, one.label, one.line, number) for number, (name, one) in enumerate(EASINGS.items())],
        default="LINEAR",
    )
    playback: EnumProperty(
        name="Playback", description="How the keys are played", items=PLAYBACK_ITEMS, default="RELATIVE"
    )
    reroute: BoolProperty(
        name="Take Over Animation",
        description="Drivers and animation of the end key move to the slider, and drivers that read the key "
        "read the slider; Remove hands them back",
        default=True,
    )


SETTINGS = (*PathSettings.__annotations__, *ArcSettings.__annotations__)


class LissomArcKey(bpy.types.PropertyGroup):
    """A baked shape key, by name."""

    name: StringProperty(name="Shape Key")
    time: FloatProperty(name="Time", description="Where on the arc it lies: 0 to 1, or beyond")
    offsets: StringProperty(description="From the Basis, as Bake wrote them", subtype="BYTE_STRING")
    probes: StringProperty(description="Some vertices of the Basis then", subtype="BYTE_STRING")


class LissomArc(PathSettings, ArcSettings, bpy.types.PropertyGroup):
    """A baked arc; its name is that of the slider."""

    name: StringProperty(name="Slider")
    start: StringProperty(name="From")
    end: StringProperty(name="To")
    digest: StringProperty(description="Hash of the shapes that it was baked from")
    warnings: StringProperty(name="Warnings", description="What Bake had to say about the arc")
    keys: CollectionProperty(type=LissomArcKey)


def ends(settings, context, text):
    """The shape keys that an arc can start or end at: all but those that show a live pose."""
    mesh = settings.id_data.data
    keys = mesh.shape_keys
    left_out = shape_keys.previews(mesh)
    return [name for name in (keys.key_blocks.keys() if keys else []) if name not in left_out]


def _changed(settings, _):
    changes.arc_choice.tell(settings.id_data)


class _GhostedPathSettings:
    """Mixin: the options of the path, which a ghost follows."""

    __annotations__ = path_properties(update=_changed)


class LissomInbetween(_GhostedPathSettings, ArcSettings, bpy.types.PropertyGroup):
    """Settings of one mesh object."""

    start: StringProperty(
        name="From",
        description="Shape key that the arc starts at. Empty: the Basis",
        search=ends,
        search_options=set(),
        update=_changed,
    )
    end: StringProperty(
        name="To",
        description="Shape key that the arc ends at",
        search=ends,
        search_options=set(),
        update=_changed,
    )
    slider: StringProperty(
        name="Slider",
        description="Name of the slider, and of the baked keys. Empty: named after the key it leads to",
    )
    ghost: BoolProperty(
        name="Ghost",
        description="Draw outlines of the arc and trails of what moves over the mesh, while its ends and "
        "options are being chosen",
        default=False,
        options=set(),
        update=_changed,
    )
    preview: FloatProperty(
        name="Preview At",
        description="Show the shape that the slider will have here, over the mesh: no key is touched, and "
        "nothing stays when Ghost is turned off",
        default=0.0,
        min=0.0,
        max=1.0,
        precision=3,
        subtype="FACTOR",
        options=set(),
        update=lambda settings, context: changes.arc_preview.tell(),
    )
    arcs: CollectionProperty(type=LissomArc)
    exported: BoolProperty(options={"HIDDEN"}, description="Keyframes stand in for the drivers of the arcs")
    several: BoolProperty(
        name="Several Keys",
        description="Bake arcs to many shape keys in one go, each under a slider of its own",
        options=set(),
    )
    chosen: CollectionProperty(type=LissomTick)


classes = (LissomArcKey, LissomArc, LissomInbetween)


def register():
    bpy.types.Object.lissom_inbetween = PointerProperty(type=LissomInbetween)


def unregister():
    del bpy.types.Object.lissom_inbetween
