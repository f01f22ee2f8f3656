"""Marks: pairs of places and of rims on source and target, made of what is selected, shown and mirrored."""

from ..bridge import markers as bridge_markers
from ..bridge import meshes
from ..core import marker_places, markers
from ..core.curves import ordered
from ..core.refused import Refused, first
from . import Done


def add(context, ends=("", ""), vertices=(-1, -1), name=""):
    """Pairs vertices of source and target, -1 for the selected ones; returns warnings."""
    objects = bridge_markers.pair_of_objects(context, *ends)
    sides = [
        [given] if given >= 0 else meshes.clicked_vertices(obj)
        for obj, given in zip(objects, vertices, strict=True)
    ]
    source, target = objects
    counts = [len(side) for side in sides]
    if counts[0] != counts[1] or not counts[0]:
        raise Refused(
            f"Select one vertex on each mesh: '{source.name}' has {counts[0]} selected, "
            f"'{target.name}' {counts[1]}"
        )
    if counts[0] > 1 and not (source.mode == target.mode == "EDIT"):
        raise Refused(
            f"{counts[0]} vertices are selected on each mesh: select one on each, or go to Edit Mode"
        )
    known, warnings = bridge_markers.current(context.scene, *objects)
    added = []
    for pair in zip(*sides, strict=True):
        added.append(markers.Marker(name or markers.new_name([*known, *added]), *pair))
    markers.check(known + added, *(len(obj.data.vertices) for obj in objects))
    bridge_markers.append(context.scene, added, *objects)
    return warnings


def at(settings, index):
    """Refused where the list has no marker at this place."""
    if index >= len(settings.markers):
        raise Refused(f"There is no marker {index}: the list holds {len(settings.markers)}")
    return index


def show(context, index):
    """Selects the vertices at a pair, or nearest to it, on both meshes."""
    settings = context.scene.lissom_transfer
    at(settings, index)
    ends = settings.source, settings.target
    marker = bridge_markers.current(context.scene, *ends)[0][index]
    markers.check([marker], *(len(obj.data.vertices) for obj in ends))
    for obj, point in zip(ends, marker.ends, strict=True):
        meshes.select_only(obj, point.vertex)
    settings.active_marker = index


def mirror(context, ends, axis):
    """Completes the pairs by their mirror images across an axis of the objects, "X", "Y" or "Z"; a Done."""
    objects = bridge_markers.pair_of_objects(context, *ends)
    known, warnings = bridge_markers.current(context.scene, *objects)
    markers.check(known, *(len(obj.data.vertices) for obj in objects))
    surfaces = [meshes.surface(obj) for obj in objects]
    images = [
        marker_places.mirrored(*surface, [marker.point(side) for marker in known], "XYZ".index(axis))
        for side, surface in zip(bridge_markers.SIDES, surfaces, strict=True)
    ]
    added, lost = marker_places.completed(known, images, [vertices for vertices, _ in surfaces])
    if not added and lost:
        raise Refused(f"No counterpart is on the other side of these: {first(map(repr, lost))}")
    bridge_markers.append(context.scene, added, *objects)
    if lost:
        warnings.append(f"Without a counterpart on the other side: {first(map(repr, lost))}")
    return Done(summary=f"{len(added)} marker pairs added", warnings=warnings)


def add_curve(context, ends, name):
    """Pairs the edges selected on source and target; a Done."""
    objects = bridge_markers.pair_of_objects(context, *ends)
    paths = [tuple(ordered(meshes.selected_edges(obj).tolist(), obj.name)) for obj in objects]
    closed = [path[0] == path[-1] for path in paths]
    if closed[0] != closed[1]:
        loop, path = objects if closed[0] else objects[::-1]
        raise Refused(
            f"The selected edges of '{loop.name}' form a loop, those of '{path.name}' a path with "
            "two ends: select two of a kind"
        )
    pairs, warnings = bridge_markers.current(context.scene, *objects)
    known = bridge_markers.current_curves(context.scene, *objects)
    curves = [*known, markers.Curve(name or f"Curve {len(known) + 1}", *paths)]
    markers.check_curves(curves, *(len(obj.data.vertices) for obj in objects))
    bridge_markers.put(context.scene, pairs, *objects, curves=curves)
    counts = [len(set(path)) for path in paths]
    told = f"'{curves[-1].name}': {counts[0]} to {counts[1]} vertices"
    return Done(summary=told, warnings=warnings)
