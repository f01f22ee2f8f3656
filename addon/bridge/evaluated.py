"""What objects look like: their meshes with shape keys, armatures and modifiers, vertex by vertex."""

import contextlib

import bpy
import numpy as np

from ..core.refused import Refused
from . import meshes, playback
from .checks import is_shown
from .generative import evaluated, same_vertices, turn


@contextlib.contextmanager
def at_rest():
    """All armatures in their rest positions, and with them the objects that bones carry."""
    posed = [armature for armature in bpy.data.armatures if armature.pose_position == "POSE"]
    try:
        turn(posed, "pose_position", "REST")
        yield
    finally:
        turn(posed, "pose_position", "POSE")


def now(assembly):
    """(n, 3) in the solve space of an Assembly: what its objects look like now."""
    objects = assembly.find()
    _require_shown(objects)
    with same_vertices(objects):
        return _shape(assembly, objects)


def sample(scene, assembly, frames, follow):
    """(k, n, 3) in the solve space of an Assembly: what its objects look like at each of these frames.

    ``follow`` is called with each object that has a live pose after every change of the frame. The scene
    goes back to its frame.
    """
    objects = assembly.find()
    _require_shown(objects)
    bound = [obj for obj in objects if obj.lissom_pose.bound]
    shapes = []
    try:
        with same_vertices(objects), playback.at_its_frame(scene):
            for frame in frames:
                scene.frame_set(frame)
                for obj in bound:
                    follow(obj)
                shapes.append(_shape(assembly, objects))
    finally:
        for obj in bound:
            follow(obj)
    return np.array(shapes)


def _require_shown(objects):
    for obj in objects:
        if not is_shown(obj):
            raise Refused(f"'{obj.name}' is hidden, and Blender evaluates only what it shows: show it first")
        if obj.mode in ("EDIT", "SCULPT"):
            raise Refused(f"'{obj.name}' is in {obj.mode.lower()} mode: go to Object Mode first")


def _shape(assembly, objects):
    seen = [evaluated(obj) for obj in objects]
    for obj, shown in zip(objects, seen, strict=True):
        counts = len(shown.data.vertices), len(obj.data.vertices)
        if counts[0] != counts[1]:
            names = ", ".join(repr(modifier.name) for modifier in shown.modifiers if modifier.show_viewport)
            raise Refused(
                f"'{obj.name}' is shown with {counts[0]} vertices, its mesh has {counts[1]}: switch off the "
                f"modifier that makes them, one of {names or 'none that is shown'}"
            )
    positions = [meshes.positions(shown.data.vertices) for shown in seen]
    return assembly.posed(positions, np.array([shown.matrix_world for shown in seen], dtype=np.float64))
