"""Options of fits and transfers as Blender properties, for settings and operators alike."""

from bpy.props import BoolProperty, EnumProperty, StringProperty
from lissom import names

from ..core.names import EDITED_ITEMS, EXISTS_ITEMS
from ..core.options import option
from ..core.transfer_options import MASKS, OPTIONS
from .options import option_property


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
        items=EDITED_ITEMS,
    )


def learn_strength_property():
    """The option ``strength`` of lissom.learn."""
    return option_property(option("learn", "strength", label="Strength", high=2.0, soft_high=1.0))


def mask_property(side):
    """A vertex group of the source or the target, for the option of lissom.start_fit of that name."""
    return StringProperty(
        name=f"{side} Mask",
        description=f"Vertex group of the {side.lower()} that matches nothing, such as the inside of the "
        "mouth. Empty: everything may match",
    )


def fit_properties():
    """{name: property} of what a fit is asked for but its meshes and markers."""
    own = {name: option_property(one) for name, one in OPTIONS["fit"].items()}
    return own | {mask: mask_property(mask.partition("_")[0].capitalize()) for mask in MASKS}


def transfer_properties():
    """{name: property} of the options of lissom.Transfer."""
    return {name: option_property(one) for name, one in OPTIONS["transfer"].items()}


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


def face_names_property():
    """Which face keys, and what they are called."""
    return EnumProperty(
        name="Names",
        description="Which keys, and what they are called",
        items=[(name, *told) for name, told in names.SETS.items()],
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
