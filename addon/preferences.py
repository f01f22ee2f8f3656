"""Preferences of the extension: marks and ghosts, whether views jump, and the key of the pie menu."""

from typing import NamedTuple

import bpy
import rna_keymap_ui
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty

from .bridge.screen import redraw_views

ADDON = __package__
PIE = "LISSOM_MT_pie"


class Look(NamedTuple):
    """What marks and ghosts look like; these are the defaults."""

    mark_size: float = 5.5
    number_size: float = 12.0
    ghost_start: tuple[float, float, float] = (0.10, 0.45, 0.85)
    ghost_end: tuple[float, float, float] = (0.95, 0.50, 0.10)
    ghost_opacity: float = 0.85


def look():
    """The Look that the artist has chosen."""
    addon = bpy.context.preferences.addons.get(ADDON)
    if addon is None or addon.preferences is None:  # registered by hand, as tests do
        return Look()
    chosen = (getattr(addon.preferences, name) for name in Look._fields)
    return Look(*(value if isinstance(value, float) else tuple(value) for value in chosen))


def jumps():
    """Whether views jump to where the next landmark is to be expected."""
    addon = bpy.context.preferences.addons.get(ADDON)
    return addon is None or addon.preferences is None or addon.preferences.jump


def _redraw(_, __):
    redraw_views()


def _number(name, field, description, low, high):
    return FloatProperty(
        name=name,
        description=description,
        default=Look._field_defaults[field],
        min=low,
        max=high,
        update=_redraw,
    )


def _colour(name, field, description):
    return FloatVectorProperty(
        name=name,
        description=description,
        default=Look._field_defaults[field],
        min=0.0,
        max=1.0,
        subtype="COLOR",
        update=_redraw,
    )


class LissomPreferences(bpy.types.AddonPreferences):
    """Edit > Preferences > Add-ons > Lissom."""

    bl_idname = ADDON

    mark_size: _number("Mark Size", "mark_size", "Radius of markers in pixels", 2.0, 20.0)
    number_size: _number("Number Size", "number_size", "Size of the numbers beside markers", 6.0, 40.0)
    ghost_start: _colour("Ghost at the Start", "ghost_start", "Color of an arc's ghost where it begins")
    ghost_end: _colour("Ghost at the End", "ghost_end", "Color of an arc's ghost where it ends")
    ghost_opacity: _number(
        "Ghost Opacity", "ghost_opacity", "How much a ghost hides of what is behind it", 0.05, 1.0
    )

    jump: BoolProperty(
        name="Views Jump to Landmarks",
        description="While a set of landmarks is picked, the view shows where the next is to be expected, "
        "as soon as two are marked",
        default=True,
    )

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in (*Look._fields, "jump"):
            column.prop(self, name)
        configuration = context.window_manager.keyconfigs.user
        keymap = configuration.keymaps.get("3D View") if configuration else None
        for item in keymap.keymap_items if keymap else ():
            if item.idname == "wm.call_menu_pie" and item.properties.name == PIE:
                rna_keymap_ui.draw_kmi([], configuration, keymap, item, self.layout, 0)


classes = (LissomPreferences,)
