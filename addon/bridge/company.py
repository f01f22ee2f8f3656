"""Further objects under the handles of a mesh: eyes and teeth ride on it, clothes go with its surface."""

import numpy as np

from ..core import names, space
from ..core.pose import Company
from ..core.refused import Refused
from . import baked, checks, groups, meshes, shape_keys, standing

CLOTH = 0.3  # of the object's size: what is smaller is a rigid part, as an eye
PREVIEW = "Lissom Pose"


def suggested(obj, other):
    """How another object goes along: small ones as rigid parts, large ones as clothes."""
    return "RIDE" if other.dimensions.length < CLOTH * obj.dimensions.length else "DRAPE"


def add(obj, other):
    """Has another object go along."""
    if other != obj and other not in [row.object for row in obj.lissom_pose.company]:
        row = obj.lissom_pose.company.add()
        row.object, row.way = other, suggested(obj, other)


def rows(obj):
    """The rows of further objects, those that ride first; Refused where one cannot go along.

    An object that was deleted is none of them: the pose goes on without it.
    """
    found = [row for row in obj.lissom_pose.company if is_there(row)]
    for row in found:
        other = row.object
        if other == obj or other.data == obj.data:
            raise Refused(f"'{other.name}' is the mesh that is posed: take it off the list")
        if other.lissom_pose.bound:
            raise Refused(f"'{other.name}' is bound by handles of its own: press Unbind there first")
        checks.require_writable(other)
    return sorted(found, key=lambda row: row.way != "RIDE")


def is_there(row):
    """Whether the object of a row was not deleted: Blender keeps those that are still referred to."""
    return row.object is not None and len(row.object.users_scene) > 0


def begin(obj):
    """Writes down where further objects stand against a mesh object at Bind; {session_uid: Skin} of them."""
    skins, listed = {}, obj.lissom_pose.company
    for place in reversed(range(len(listed))):
        if not is_there(listed[place]):
            listed.remove(place)
    inverse = np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64))
    for row in rows(obj):
        space.linear_part(row.object.matrix_world, row.object.name)
        row.matrix = (inverse @ np.array(row.object.matrix_world)).ravel()
        row.topology = meshes.signature(row.object.data)
        skin = standing.read(row.object) if obj.lissom_pose.stands else None
        row.stood = skin is not None
        if row.stood:
            skins[row.object.session_uid] = skin
    return skins


def finish(obj):
    """Gives every further object the key that shows its part of the live pose."""
    for row in rows(obj):
        other = row.object
        baked.mute(other, True)
        row.made_basis = other.data.shape_keys is None
        basis = shape_keys.ensure_basis(other)
        row.preview = names.unused(PREVIEW, other.data.shape_keys.key_blocks.keys())
        shape_keys.write(other, row.preview, shape_keys.shape(basis), shape_keys.Settings(value=1.0))


def release(obj):
    """Takes these keys away again."""
    for row in obj.lissom_pose.company:
        other = row.object
        if other is None:
            continue
        keys = other.data.shape_keys
        if keys and row.preview in keys.key_blocks:
            shape_keys.remove(other, row.preview)
        if row.made_basis and other.data.shape_keys and len(other.data.shape_keys.key_blocks) == 1:
            other.shape_key_clear()
        baked.mute(other, False)
        row.property_unset("preview")


def of(obj, linear, skin_of):
    """core.pose.Company of a mesh object in solve space; ``skin_of(row)`` is the Skin of a row, or None."""
    parts = {"RIDE": [], "DRAPE": []}
    for row in rows(obj):
        if row.topology != meshes.signature(row.object.data):
            raise Refused(f"'{row.object.name}' was remodelled since Bind: press Unbind, then Bind")
        skin = skin_of(row)
        matrix = linear @ _matrix(row)[:3, :3]
        rest = meshes.rest_positions(row.object.data) if skin is None else skin.shown
        vertices = rest @ matrix.T + linear @ _matrix(row)[:3, 3]
        parts[row.way].append((vertices, space.outward(matrix, meshes.triangles(row.object.data))))
    return Company(*map(tuple, parts.values()))


def members(obj, wanted):
    """{name: (indices, weights)} of groups of these names on what rides, and all vertices of that.

    They are counted on from the mesh's own vertices.
    """
    found = {name: ([], []) for name in wanted}
    start = len(obj.data.vertices)
    for row in rows(obj):
        if row.way == "RIDE":
            for name, (indices, weights) in groups.weighted_members(row.object, wanted).items():
                found[name][0].append(indices + start)
                found[name][1].append(weights)
            start += len(row.object.data.vertices)
    return found, np.arange(len(obj.data.vertices), start)


def shapes(obj, linear, vertices, skin_of):
    """(object, its key that shows the pose, (n, 3) shape) of each further object.

    ``vertices`` are those of a solve: the mesh's own come first.
    """
    place = len(obj.data.vertices)
    for row in rows(obj):
        count = len(row.object.data.vertices)
        own = space.back(linear, vertices[place : place + count]) - _matrix(row)[:3, 3]
        shape = space.back(_matrix(row)[:3, :3], own)
        skin = skin_of(row)
        yield row.object, preview(row), shape if skin is None else skin.key(shape)
        place += count


def put_to_rest(obj):
    """The keys of further objects at rest."""
    for row in rows(obj):
        shape_keys.write_points(preview(row), meshes.rest_positions(row.object.data))


def _matrix(row):
    return np.array(row.matrix, dtype=np.float64).reshape(4, 4)


def preview(row):
    """The shape key of a further object that shows its part of the pose."""
    return shape_keys.preview(row.object, row.preview)
