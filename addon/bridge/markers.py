"""The marker pairs of a request: given as text, as a file, or in the scene's list."""

import bpy

from ..core import markers
from ..core.refused import Refused
from .checks import mesh_object
from .meshes import signature


def pair_of_objects(context, source, target):
    """Source and target by name, or as chosen in the scene; two different mesh objects."""
    settings = context.scene.lissom_transfer
    found = []
    for side, name, chosen in (("source", source, settings.source), ("target", target, settings.target)):
        if not name and chosen is None:
            raise Refused(f"Choose the {side} object first")
        found.append(mesh_object(name or chosen.name, context))
    if found[0] == found[1]:
        raise Refused("Source and target are the same object: choose two")
    return found


def gather(context, source, target, text, filepath):
    """The checked pairs (a list of core.markers.Marker) for two mesh objects, and warnings."""
    warnings = []
    if text and filepath:
        raise Refused("Give the markers as text or as a file, not both")
    if text or filepath:
        loaded = markers.loads(text) if text else markers.load(bpy.path.abspath(filepath))
        pairs = loaded.pairs
        warnings = file_warnings(loaded, source, target)
    else:
        pairs = of_scene(context.scene)
    if not pairs and not needless(source, target):
        raise Refused(
            "There are no markers: select one vertex on each mesh and press +, at least three times, "
            "or load a marker file"
        )
    markers.check(pairs, len(source.data.vertices), len(target.data.vertices))
    return pairs, warnings


def needless(source, target):
    """True where two meshes have the same faces: each vertex then belongs to its own like."""
    meshes = source.data, target.data
    counts = [(len(mesh.vertices), len(mesh.loops), len(mesh.polygons)) for mesh in meshes]
    return counts[0] == counts[1] and signature(meshes[0]) == signature(meshes[1])


def of_scene(scene):
    """The scene's list of pairs."""
    return [markers.Marker(row.name, row.source, row.target) for row in scene.lissom_transfer.markers]


def file_warnings(loaded, source, target):
    """What a file's own vertex counts say against these objects."""
    return [
        f"The markers were made for a {side} of {count} vertices, '{obj.name}' has {len(obj.data.vertices)}: "
        "check where they lie"
        for side, count, obj in (
            ("source", loaded.source_vertices, source),
            ("target", loaded.target_vertices, target),
        )
        if count is not None and obj is not None and count != len(obj.data.vertices)
    ]
