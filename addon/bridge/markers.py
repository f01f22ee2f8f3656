"""The marker pairs and curves of a request: given as text, as a file, or in the scene's lists."""

import json
from itertools import pairwise

import bpy
import numpy as np

from ..core import marker_file, marker_places, markers
from ..core.picking import Mark
from ..core.refused import Refused, first
from . import landmarks
from .assembly import both_sides
from .meshes import edge_signature, rest_place, rest_positions, signature, surface
from .screen import redraw_views

SIDES = ("source", "target")
UNKNOWN = "unknown"  # edges of a mesh that was not there when its markers were read


def pair_of_objects(context, source, target):
    """The main object of source and target, which the markers lie on."""
    return [side[0] for side in both_sides(context, source, target)]


def gather(context, sources, targets, text, filepath):
    """The checked pairs and curves (of core.markers) on the first objects of both sides, and warnings.

    The scene's lists may be empty: then the shapes alone tell. What is given on purpose may not.
    """
    source, target = sources[0], targets[0]
    if text and filepath:
        raise Refused("Give the markers as text or as a file, not both")
    if text or filepath:
        loaded = marker_file.loads(text) if text else marker_file.load(bpy.path.abspath(filepath))
        if not (loaded.pairs or loaded.curves):
            raise Refused("The markers that were given hold no pairs: leave them out to do without any")
        pairs, warnings = of_file(loaded, source, target)
        curves = curves_of_file(loaded, source, target)
    else:
        pairs, warnings = current(context.scene, source, target)
        pairs = [marker for marker in pairs if not marker.guessed]
        curves = current_curves(context.scene, source, target)
    counts = len(source.data.vertices), len(target.data.vertices)
    markers.check(pairs, *counts)
    markers.check_curves(curves, *counts)
    return pairs, curves, warnings


def needless(sources, targets):
    """True where both sides have the same faces, object by object: each vertex belongs to its own like."""
    return len(sources) == len(targets) and all(map(_alike, sources, targets))


def _alike(source, target):
    meshes = source.data, target.data
    counts = [(len(mesh.vertices), len(mesh.loops), len(mesh.polygons)) for mesh in meshes]
    return counts[0] == counts[1] and signature(meshes[0]) == signature(meshes[1])


def of_scene(scene):
    """The scene's list of pairs, as it stands there."""
    return [_marker(row) for row in scene.lissom_transfer.markers]


def _marker(row):
    marker = markers.Marker.between(row.name, *row.ends)
    places = {f"{side}_place": row.place(side) for side in SIDES}
    return marker._replace(mirror=row.mirror, number=row.number, guessed=row.guessed, **places)


def curves_of_scene(scene):
    """The scene's list of curves, as it stands there."""

    def curve(row):
        places = [json.loads(text) if text else None for text in (row.source_places, row.target_places)]
        places = [None if one is None else tuple(map(tuple, one)) for one in places]
        return markers.Curve(row.name, *(tuple(map(int, text.split())) for text in row.vertices), *places)

    return [curve(row) for row in scene.lissom_transfer.curves]


def current(scene, source, target):
    """The scene's pairs, found again by their places where a mesh was remodelled since; and warnings."""
    ends = source, target
    return _found_again(of_scene(scene), ends, _remodelled(scene, ends))


def current_curves(scene, source, target):
    """The scene's curves, found again likewise."""
    ends = source, target
    return _curves_found_again(curves_of_scene(scene), ends, _remodelled(scene, ends))


def curves_of_file(loaded, source, target):
    """The curves of a file, found again by their places where it counts other vertices."""
    counts = loaded.source_vertices, loaded.target_vertices
    ends = source, target
    changed = [count not in (None, len(obj.data.vertices)) for count, obj in zip(counts, ends, strict=True)]
    return _curves_found_again(loaded.curves, ends, changed)


def _remodelled(scene, ends):
    settings = scene.lissom_transfer
    known = settings.source_edges, settings.target_edges
    return [edges not in ("", edge_signature(obj.data)) for edges, obj in zip(known, ends, strict=True)]


def _curves_found_again(curves, ends, changed):
    curves = list(curves)
    for side, obj, other in zip(SIDES, ends, changed, strict=True):
        if not other or not curves:
            continue
        vertices, edges = rest_positions(obj.data), {frozenset(edge.vertices) for edge in obj.data.edges}
        for number, curve in enumerate(curves):
            places = getattr(curve, f"{side}_places")
            if places is None or not len(vertices):
                continue
            found, away = marker_places.nearest(vertices, np.array(places))
            found = tuple(found.tolist())
            joined = all(frozenset(pair) in edges for pair in pairwise(found))
            if not joined or away.max() > marker_places.FAR * marker_places.diagonal(vertices):
                raise Refused(
                    f"'{obj.name}' was remodelled where curve '{curve.name}' runs, or is another mesh: "
                    "remove the curve, and add it anew"
                )
            curves[number] = curve._replace(**{side: found})
    return curves


def of_file(loaded, source, target):
    """The pairs of a file, found again by their places where it counts other vertices; and warnings."""
    ends, counts = (source, target), (loaded.source_vertices, loaded.target_vertices)
    changed = [count not in (None, len(obj.data.vertices)) for count, obj in zip(counts, ends, strict=True)]
    pairs, warnings = _found_again(loaded.pairs, ends, changed)
    for side, obj, count, other in zip(SIDES, ends, counts, changed, strict=True):
        if other and None in (marker.place(side) for marker in loaded.pairs):
            warnings.append(
                f"The markers were made for a {side} of {count} vertices, '{obj.name}' has "
                f"{len(obj.data.vertices)}: check where they lie"
            )
    return pairs, warnings


def _found_again(pairs, ends, changed):
    pairs, warnings = list(pairs), []
    for side, obj, other in zip(SIDES, ends, changed, strict=True):
        placed = [number for number, marker in enumerate(pairs) if marker.place(side)]
        if not other or not placed:
            continue
        places = np.array([pairs[number].place(side) for number in placed])
        found = marker_places.found_again(*surface(obj), places)
        lost = [pairs[number].name for number, point in zip(placed, found, strict=True) if point is None]
        if lost:
            raise Refused(
                f"'{obj.name}' is not the mesh that these markers were placed on, or lost their places: "
                f"{first(map(repr, lost))}. Correct or remove them, or choose the object they were made for"
            )
        if found != [pairs[number].point(side) for number in placed]:
            warnings.append(
                f"'{obj.name}' was remodelled since its markers were placed: each was put where its surface "
                "is nearest to its place"
            )
        for number, point in zip(placed, found, strict=True):
            pairs[number] = pairs[number].on(side, point)
    return pairs, warnings


def placed(pairs, source, target):
    """The pairs with the places that their points have now; None where a mesh has no such vertices."""
    rests = dict(zip(SIDES, (rest_positions(obj.data) for obj in (source, target)), strict=True))

    def place(point, rest):
        there = max(point.corners) < len(rest)
        return tuple(point.position(rest).tolist()) if there else None

    return [
        marker._replace(**{f"{side}_place": place(marker.point(side), rest) for side, rest in rests.items()})
        for marker in pairs
    ]


def curves_placed(curves, source, target):
    """The curves with the places that their vertices have now."""
    for side, obj in zip(SIDES, (source, target), strict=True):
        rest = rest_positions(obj.data)
        curves = [
            curve._replace(**{f"{side}_places": tuple(map(tuple, rest[list(getattr(curve, side))].tolist()))})
            for curve in curves
        ]
    return curves


def append(scene, pairs, source, target):
    """Adds pairs to the scene's list, the last as the active one; the others are found again first.

    Those without a name are called by their numbers.
    """
    known, _ = current(scene, source, target)
    for marker in pairs:
        known.append(marker if marker.name else marker._replace(name=markers.new_name(known)))
    put(scene, known, source, target)
    scene.lissom_transfer.show_markers = True
    scene.lissom_transfer.active_marker = len(scene.lissom_transfer.markers) - 1


def put(scene, pairs, source=None, target=None, curves=None):
    """Makes these pairs the scene's list, with their places now; without objects, with those given.

    So it does with ``curves``; by None those that are there are found again.
    """
    settings = scene.lissom_transfer
    rows, ends = settings.markers, (source, target)
    if curves is None:
        curves = current_curves(scene, *ends) if all(ends) else curves_of_scene(scene)
    if all(ends):
        pairs, curves = placed(pairs, *ends), curves_placed(curves, *ends)
        for side, obj in zip(SIDES, ends, strict=True):
            landmarks.keep(obj, pairs, side)
    settings.curves.clear()
    for curve in curves:
        row = settings.curves.add()
        row.name = curve.name
        row.source, row.target = curve.texts
        for side in SIDES:
            places = getattr(curve, f"{side}_places")
            setattr(row, f"{side}_places", "" if places is None else json.dumps(places))
    while len(rows) > len(pairs):
        rows.remove(len(rows) - 1)
    while len(rows) < len(pairs):
        rows.add()
    for row, marker in zip(rows, markers.numbered(pairs), strict=True):
        row.name, row.mirror, row.number = marker.name, marker.mirror, marker.number
        row.guessed = marker.guessed
        for side in SIDES:
            row.put(side, marker.point(side), marker.place(side))
    for side, obj in zip(SIDES, ends, strict=True):
        setattr(settings, f"{side}_edges", edge_signature(obj.data) if all(ends) else UNKNOWN)
    settings.active_marker = max(0, min(settings.active_marker, len(rows) - 1))
    redraw_views()


def remove(scene, index):
    """Takes one pair out of the scene's list; the others keep their numbers."""
    settings = scene.lissom_transfer
    _number(settings.markers)
    settings.markers.remove(index)
    settings.active_marker = max(0, min(index, len(settings.markers) - 1))
    redraw_views()


def move(scene, index, side, point):
    """Puts one end of a pair at another point, unless another pair is there."""
    settings = scene.lissom_transfer
    others = [row.point(side) for place, row in enumerate(settings.markers) if place != index]
    if point not in others:
        rest = [rest_place(getattr(settings, side).data, corner) for corner in point.corners]
        row = settings.markers[index]
        row.put(side, point, tuple(np.array(point.weights) @ np.array(rest)))
        row.guessed = False
        landmarks.keep(getattr(settings, side), [_marker(row)], side)


def _number(rows):
    for row, marker in zip(rows, markers.numbered([_marker(row) for row in rows]), strict=True):
        row.number = marker.number


def marks_of(scene, begun=None):
    """All marks, as core.picking.Mark; that of a pair that is ``begun``, core.picking.Picking, comes last."""
    pairs = markers.numbered(of_scene(scene))
    for index, marker in enumerate(pairs):
        for side in SIDES:
            yield Mark(index, marker.number, side, marker.point(side))
    if begun is not None and begun.side:
        yield Mark(-1, max((marker.number for marker in pairs), default=0) + 1, begun.side, begun.point)
