"""Arcs as exporters take them: keyframes on the baked keys in place of the drivers that play them.

glTF's exporter writes actions by default, and sees no drivers; FBX and USD sample the scene, and agree. The
drivers are muted meanwhile, so that ``restore`` has but to let them play again.
"""

import bpy
import numpy as np

from ..core.refused import Refused
from . import animation, checks, shape_keys, sliders

SAME = 1e-6  # of a key's value: so far a frame may lie off the line between its neighbours without a keyframe


def played(obj):
    """The shape keys that arcs of an object drive, of relative ones."""
    arcs = [arc for arc in obj.lissom_inbetween.arcs if arc.playback != "ABSOLUTE"]
    return [shape_keys.find(obj, name) for arc in arcs for name in sliders.baked_keys(obj, arc.name)]


def prepare(obj, scene):
    """Puts keyframes on the keys of all arcs, mutes their drivers, and returns how many keys these are."""
    keys = played(obj)
    if not keys:
        raise Refused(f"'{obj.name}' has no arcs that export as relative keys: bake some first")
    if obj.lissom_inbetween.exported:
        restore(obj)
    checks.require_unlocked(keys)
    frames = np.arange(scene.frame_start, scene.frame_end + 1)
    values, before = np.empty((len(frames), len(keys))), scene.frame_current
    try:
        for row, frame in enumerate(frames.tolist()):
            scene.frame_set(frame)
            values[row] = [key.value for key in keys]
    finally:
        scene.frame_set(before)
    for key, own in zip(keys, values.T, strict=True):
        animation.driver(key.id_data, _path(key)).mute = True
        for row in np.flatnonzero(_corners(own)).tolist():
            key.value = own[row]
            key.keyframe_insert("value", frame=int(frames[row]))
        for point in animation.curve(key.id_data, _path(key)).keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.view_layer.update()
    obj.lissom_inbetween.exported = True
    return len(keys)


def restore(obj):
    """Takes the keyframes away, and lets the drivers play."""
    for key in played(obj):
        found = animation.driver(key.id_data, _path(key))
        if found is not None and found.mute:
            animation.remove_curve(key.id_data, _path(key))
            found.mute = False
    obj.lissom_inbetween.exported = False
    obj.data.shape_keys.update_tag()
    bpy.context.view_layer.update()


def _path(key):
    return key.path_from_id("value")


def _corners(values):
    """(k,) where keyframes have to be for straight lines to go through all (k,) values."""
    there = np.ones(len(values), dtype=bool)
    if len(values) > 2:
        there[1:-1] = np.abs(np.diff(values, 2)) > SAME
    return there
