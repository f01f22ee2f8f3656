"""The marker pairs of a request: given as text, as a file, or in the scene's list."""

import bpy

from ..core import markers
from ..core.refused import Refused
from .assembly import both_sides
from .meshes import signature


def pair_of_objects(context, source, target):
    """The main object of source and target, which the markers lie on."""
    return [side[0] for side in both_sides(context, source, target)]


def gather(context, sources, targets, text, filepath):
    """The checked pairs (a list of core.markers.Marker) on the first objects of both sides, and warnings."""
    source, target, warnings = sources[0], targets[0], []
    if text and filepath:
        raise Refused("Give the markers as text or as a file, not both")
    if text or filepath:
        loaded = markers.loads(text) if text else markers.load(bpy.path.abspath(filepath))
        pairs = loaded.pairs
        warnings = file_warnings(loaded, source, target)
    else:
        pairs = of_scene(context.scene)
    if not pairs and not needless(sources, targets):
        raise Refused(
            "There are no markers: select one vertex on each mesh and press +, at least three times, "
            "or load a marker file"
        )
    markers.check(pairs, len(source.data.vertices), len(target.data.vertices))
    return pairs, warnings


def needless(sources, targets):
    """True where both sides have the same faces, object by object: each vertex belongs to its own like."""
    return len(sources) == len(targets) and all(map(_alike, sources, targets))


def _alike(source, target):
    meshes = source.data, target.data
    counts = [(len(mesh.vertices), len(mesh.loops), len(mesh.polygons)) for mesh in meshes]
    return counts[0] == counts[1] and signature(meshes[0]) == signature(meshes[1])


def of_scene(scene):
    """The scene's list of pairs."""
    return [markers.Marker(row.name, row.source, row.target) for row in scene.lissom_transfer.markers]


def append(scene, pairs):
    """Adds pairs to the scene's list; the last becomes the active one."""
    settings = scene.lissom_transfer
    for marker in pairs:
        row = settings.markers.add()
        row.name, row.source, row.target = marker
    settings.active_marker = len(settings.markers) - 1


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
