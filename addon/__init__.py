"""Lissom: pose meshes by handles, transfer shape keys between meshes, and bake in-betweens along an arc."""

import pathlib

import bpy
import lissom

from . import changes, commands, live, manual, preferences, rebind, rows, saving, session, translations, watch
from .core import build
from .drawing import ghost, guide, marks
from .jobs import learn_shown, review
from .operators import (
    face,
    inbetween_all,
    inbetween_arcs,
    inbetween_bake,
    inbetween_export,
    inbetween_image,
    key_sides,
    key_strength,
    learn,
    page,
    pose_apply,
    pose_bake,
    pose_bind,
    pose_company,
    pose_drive,
    pose_handles,
    pose_tool,
    presets,
    transfer_attributes,
    transfer_curves,
    transfer_files,
    transfer_fit,
    transfer_keys,
    transfer_landmarks,
    transfer_markers,
    transfer_parts,
    transfer_pick,
    transfer_pose,
    transfer_review,
    transfer_show,
    transfer_sides,
    transfer_views,
    warnings,
)
from .panels import inbetween as inbetween_panel
from .panels import keys as keys_panel
from .panels import main as main_panel
from .panels import markers as marker_panel
from .panels import menus
from .panels import pose as pose_panel
from .panels import presets as preset_menus
from .panels import quality as quality_panel
from .panels import transfer as transfer_panel
from .properties import inbetween as inbetween_properties
from .properties import main as main_properties
from .properties import markers as marker_properties
from .properties import pose as pose_properties
from .properties import shown as shown_properties
from .properties import ticks
from .properties import transfer as transfer_properties

_PROPERTIES = (
    main_properties,
    shown_properties,
    pose_properties,
    marker_properties,
    transfer_properties,
    inbetween_properties,
)
_OPERATORS = (
    page,
    pose_handles,
    pose_company,
    pose_bind,
    pose_apply,
    pose_bake,
    pose_drive,
    pose_tool,
    face,
    transfer_sides,
    transfer_markers,
    transfer_curves,
    transfer_files,
    transfer_landmarks,
    transfer_pick,
    transfer_views,
    transfer_fit,
    transfer_keys,
    transfer_pose,
    transfer_review,
    transfer_attributes,
    transfer_parts,
    transfer_show,
    key_sides,
    key_strength,
    learn,
    inbetween_bake,
    inbetween_all,
    inbetween_arcs,
    inbetween_export,
    inbetween_image,
    warnings,
    presets,
)
_PANELS = (
    main_panel,
    pose_panel,
    quality_panel,
    marker_panel,
    keys_panel,
    transfer_panel,
    inbetween_panel,
)  # in the order of the tab
_DRAWING = (ghost, marks, guide)
_MODULES = (ticks, *_PROPERTIES, *_OPERATORS, preset_menus, *_PANELS, menus, preferences)
_CLASSES = [cls for module in _MODULES for cls in module.classes]


def register():
    session.other_build = build.differs(pathlib.Path(__file__).with_name("wheels"), lissom.__file__)
    if session.other_build:
        print(f"Lissom: {build.MESSAGE}")
    translations.register()
    manual.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for module in _PROPERTIES:
        module.register()
    inbetween_image.register()
    pose_tool.register()
    menus.register()
    live.register()
    rebind.register()
    watch.register()
    rows.register()
    saving.register()
    changes.quality_row.append(review.show_row)
    changes.learned_row.append(learn_shown.show_row)
    for module in _DRAWING:
        module.register()
    commands.register()


def unregister():
    commands.unregister()
    for module in reversed(_DRAWING):
        module.unregister()
    changes.quality_row.remove(review.show_row)
    changes.learned_row.remove(learn_shown.show_row)
    saving.unregister()
    rows.unregister()
    watch.unregister()
    rebind.unregister()
    live.unregister()
    menus.unregister()
    pose_tool.unregister()
    inbetween_image.unregister()
    for module in reversed(_PROPERTIES):
        module.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    manual.unregister()
    translations.unregister()
