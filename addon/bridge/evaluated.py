"""What objects look like: their meshes with shape keys, armatures and modifiers, vertex by vertex."""

import contextlib

import bpy
import numpy as np

from ..core.refused import Refused
from . import meshes, playback
from .checks import is_shown

# Modifiers that make other vertices than the mesh has.
GENERATIVE = {
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "MASK", "MIRROR", "MULTIRES",
    "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "VOLUME_TO_MESH", "WELD",
    "WIREFRAME",
}  # fmt: skip
# Modifiers that may: only trying tells.
DOUBTFUL = {"FLUID", "MESH_SEQUENCE_CACHE", "NODES", "OCEAN"}


@contextlib.contextmanager
def at_rest():
    """All armatures in their rest positions, and with them the objects that bones carry."""
    posed = [armature for armature in bpy.data.armatures if armature.pose_position == "POSE"]
    try:
        _turn(posed, "pose_position", "REST")
        yield
    finally:
        _turn(posed, "pose_position", "POSE")


def now(assembly):
    """(n, 3) in the solve space of an Assembly: what its objects look like now."""
    objects = assembly.find()
    _require_shown(objects)
    with _same_vertices(objects):
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
        with _same_vertices(objects), playback.at_its_frame(scene):
            for frame in frames:
                scene.frame_set(frame)
                for obj in bound:
                    follow(obj)
                shapes.append(_shape(assembly, objects))
    finally:
        for obj in bound:
            follow(obj)
    return np.array(shapes)


def _turn(blocks, name, value):
    for block in blocks:
        setattr(block, name, value)
    if blocks:
        bpy.context.view_layer.update()


def _require_shown(objects):
    for obj in objects:
        if not is_shown(obj):
            raise Refused(f"'{obj.name}' is hidden, and Blender evaluates only what it shows: show it first")
        if obj.mode in ("EDIT", "SCULPT"):
            raise Refused(f"'{obj.name}' is in {obj.mode.lower()} mode: go to Object Mode first")


@contextlib.contextmanager
def _same_vertices(objects):
    """Modifiers that make other vertices are off meanwhile, in the viewport."""
    off = []
    try:
        for obj in objects:
            _switch_off(_visible(obj, GENERATIVE), off)
            doubtful = _visible(obj, DOUBTFUL)
            if doubtful and not _matches(obj):
                _switch_off(doubtful, off)
                _switch_on_harmless(obj, doubtful, off)
        yield
    finally:
        _turn(off, "show_viewport", True)


def _visible(obj, kinds):
    return [modifier for modifier in obj.modifiers if modifier.show_viewport and modifier.type in kinds]


def _switch_off(modifiers, off):
    off += modifiers  # before the first is off: an error on the way must not leave it so
    _turn(modifiers, "show_viewport", False)


def _switch_on_harmless(obj, modifiers, off):
    for modifier in modifiers if _matches(obj) else ():
        _turn([modifier], "show_viewport", True)
        if _matches(obj):
            off.remove(modifier)
        else:
            _turn([modifier], "show_viewport", False)


def _evaluated(obj):
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())


def _matches(obj):
    return len(_evaluated(obj).data.vertices) == len(obj.data.vertices)


def _shape(assembly, objects):
    evaluated = [_evaluated(obj) for obj in objects]
    for obj, shown in zip(objects, evaluated, strict=True):
        counts = len(shown.data.vertices), len(obj.data.vertices)
        if counts[0] != counts[1]:
            names = ", ".join(repr(modifier.name) for modifier in shown.modifiers if modifier.show_viewport)
            raise Refused(
                f"'{obj.name}' is shown with {counts[0]} vertices, its mesh has {counts[1]}: switch off the "
                f"modifier that makes them, one of {names or 'none that is shown'}"
            )
    positions = [meshes.positions(shown.data.vertices) for shown in evaluated]
    return assembly.posed(positions, np.array([shown.matrix_world for shown in evaluated], dtype=np.float64))
