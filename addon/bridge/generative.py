"""Modifiers that make other vertices than a mesh has, switched off meanwhile: it shows vertex by vertex."""

import contextlib

import bpy

# Modifiers that make other vertices than the mesh has.
GENERATIVE = {
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "MASK", "MIRROR", "MULTIRES",
    "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "VOLUME_TO_MESH", "WELD",
    "WIREFRAME",
}  # fmt: skip
# Modifiers that may: only trying tells.
DOUBTFUL = {"FLUID", "MESH_SEQUENCE_CACHE", "NODES", "OCEAN"}


def turn(blocks, name, value):
    """Sets a property of all these blocks, and has Blender evaluate that."""
    for block in blocks:
        setattr(block, name, value)
    if blocks:
        bpy.context.view_layer.update()


@contextlib.contextmanager
def same_vertices(objects):
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
        turn(off, "show_viewport", True)


def _visible(obj, kinds):
    return [modifier for modifier in obj.modifiers if modifier.show_viewport and modifier.type in kinds]


def _switch_off(modifiers, off):
    off += modifiers  # before the first is off: an error on the way must not leave it so
    turn(modifiers, "show_viewport", False)


def _switch_on_harmless(obj, modifiers, off):
    for modifier in modifiers if _matches(obj) else ():
        turn([modifier], "show_viewport", True)
        if _matches(obj):
            off.remove(modifier)
        else:
            turn([modifier], "show_viewport", False)


def evaluated(obj):
    """The object as the dependency graph has it now."""
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())


def _matches(obj):
    return len(evaluated(obj).data.vertices) == len(obj.data.vertices)
