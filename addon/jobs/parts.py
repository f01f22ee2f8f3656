"""Further objects of source and target, and what the table of quality says of faces."""

import os

import numpy as np

from .. import session
from ..bridge import checks, views
from ..bridge.meshes import rest_positions, select_vertices
from ..core.files import write_json
from ..core.quality import as_dicts, badness, unpack_faces
from ..core.refused import Refused
from . import Done


def add(context, side):
    """Adds the selected mesh objects to "source" or "target"."""
    settings = context.scene.lissom_transfer
    rows = [*settings.source_parts, *settings.target_parts]
    taken = {settings.source, settings.target, *(row.object for row in rows)}
    new = [obj for obj in context.selected_objects if obj.type == "MESH" and obj not in taken]
    if not new:
        raise Refused(
            f"Select mesh objects that go along with the {side}, such as eyes or teeth, then press again"
        )
    if getattr(settings, side) is None:
        raise Refused(f"Choose the {side} object first")
    for obj in new:
        getattr(settings, f"{side}_parts").add().object = obj


def remove(context, side, place):
    """Takes the object at a place of a side's list away."""
    parts = getattr(context.scene.lissom_transfer, f"{side}_parts")
    if place >= len(parts):
        raise Refused(f"There is no further object {place}: there are {len(parts)}")
    parts.remove(place)


def quality_told(settings):
    """The table as dicts, the worst first, to whose row the list scrolls; a review stays at its own."""
    rows = settings.quality
    if len(rows) and session.review is None:
        by = settings.quality_order
        settings.active_quality = max(range(len(rows)), key=lambda place: badness(rows[place], by))
    return as_dicts(rows)


def save_quality(context, path):
    """Writes the table of quality as JSON; a Done."""
    rows = as_dicts(context.scene.lissom_transfer.quality)
    try:
        write_json(path, {"keys": rows})
    except OSError as error:
        raise Refused(f"'{path}' cannot be written: {error.strerror}") from error
    return Done(summary=f"{len(rows)} shape keys in {os.path.basename(path)}", warnings=[])


def select_faces(context, key):
    """Selects the faces of a key that are to be looked at, and makes it the active one; a Done."""
    row = context.scene.lissom_transfer.quality.get(key)
    if row is None:
        raise Refused(f"The table has no shape key named '{key}'")
    faces = unpack_faces(row.faces)
    if not faces:
        raise Refused(f"'{key}' has no faces to look at")
    found = {checks.mesh_object(name, context): own for name, own in faces.items()}
    for obj, own in found.items():
        checks.require_writable(obj)
        if max(own) >= len(obj.data.polygons):
            raise Refused(f"The mesh of '{obj.name}' was changed since: transfer again")
    for obj, own in found.items():
        select_vertices(obj, {v for face in own for v in obj.data.polygons[face].vertices})
        keys = obj.data.shape_keys
        if keys and key in keys.key_blocks:
            obj.active_shape_key_index = keys.key_blocks.find(key)
    for obj, own in found.items():
        _look_at(context, obj, own)
    count = sum(map(len, faces.values()))
    told = f"{count} faces to look at, which Edit Mode shows selected: {', '.join(row.reasons.splitlines())}"
    return Done(summary=told, warnings=[])


def _look_at(context, obj, faces):
    matrix, polygons = np.array(obj.matrix_world), obj.data.polygons
    places = views.places(obj)
    if len(places) != len(obj.data.vertices):  # modifiers make others
        places = rest_positions(obj.data) @ matrix[:3, :3].T + matrix[:3, 3]
    corners = np.unique([vertex for face in faces for vertex in polygons[face].vertices])
    outward = np.sum([polygons[face].area * polygons[face].normal for face in faces], axis=0)
    towards = -matrix[:3, :3] @ outward if outward.any() else np.array([0.0, 1.0, 0.0])
    views.show_places(context, [obj], places[corners], places, towards)
