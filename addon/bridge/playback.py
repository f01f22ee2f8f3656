"""Frames: reading a pose at each of them, and playing the result back."""

import contextlib
import os

import bpy

from ..core import cache
from ..core.pose import steady
from ..core.refused import Refused
from ..core.turns import Tracker
from . import animation, poses


def sample(scene, obj, frames):
    """The core.pose.Motion of a bound object at each of these frames, in rising order.

    Every frame between them is looked at too: turns that no channel tells are counted from frame to frame.
    A handle that is turned at one of the frames turns by itself at none.
    """
    tracker, wanted, found = Tracker(), set(frames), []
    with at_its_frame(scene):
        for frame in range(frames[0], frames[-1] + 1):
            scene.frame_set(frame)
            motion = poses.motion(obj, tracker)
            if frame in wanted:
                found.append(motion)
    return steady(found)


@contextlib.contextmanager
def at_its_frame(scene):
    """Puts the scene back at its frame."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        scene.frame_set(frame, subframe=subframe)


def play_keys(obj, names, frames):
    """Keyframes on shape keys: each is alone at its frame, and straight lines lead from one to the next."""
    blocks = obj.data.shape_keys.key_blocks
    for index, name in enumerate(names):
        for neighbour in range(max(index - 1, 0), min(index + 2, len(frames))):
            blocks[name].value = float(neighbour == index)
            blocks[name].keyframe_insert("value", frame=frames[neighbour])
        curve = animation.curve(obj.data.shape_keys, blocks[name].path_from_id("value"))
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
        curve.update()


def play_cache(obj, name, path, first, step):
    """A Mesh Cache modifier, first of all, that plays a point cache in the place of the mesh; its name."""
    modifier = obj.modifiers.get(name)
    if modifier is None or modifier.type != "MESH_CACHE":
        modifier = obj.modifiers.new(name, "MESH_CACHE")
        obj.modifiers.move(len(obj.modifiers) - 1, 0)
    modifier.show_viewport = modifier.show_render = True
    modifier.cache_format = "PC2"
    modifier.filepath = path
    modifier.factor = 1.0
    modifier.deform_mode, modifier.interpolation = "OVERWRITE", "LINEAR"
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    # The sample that is played is the frame times the scale less the start.
    modifier.frame_scale, modifier.frame_start = 1 / step, first / step
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    return modifier.name


def cache_path(path, obj):
    """The absolute path of a cache; Refused where none can be written there."""
    if not path:
        path = f"//{bpy.path.clean_name(obj.name)}.pc2"
    if path.startswith("//") and not bpy.data.filepath:
        raise Refused("Save the file first, or choose where to put the cache: it is kept beside the file")
    absolute = bpy.path.abspath(path)
    folder = os.path.dirname(absolute)
    if not os.path.isdir(folder):
        raise Refused(f"There is no folder '{folder}': make it first, or choose another")
    if not os.access(folder, os.W_OK) or os.path.isdir(absolute):
        raise Refused(f"'{absolute}' cannot be written: choose another file")
    if os.path.exists(absolute) and not cache.is_cache(absolute):
        raise Refused(f"'{absolute}' exists and is no point cache: choose another file")
    return path, absolute
