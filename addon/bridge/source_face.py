"""The face that comes along as an object of the scene."""

import bpy
import numpy as np
from lissom import data, names

from ..core.face_found import middles
from ..core.landmarks import FACE, MIDDLES
from ..core.surface import closest
from . import shape_keys

METRES = 0.01  # a centimetre
BESIDE = 1.3  # widths of the head from its middle to the face's
IT = "lissom_face"  # marks the object
LEAST_MARKS = 3


def is_it(obj):
    """Whether an object is the face that comes along, with its vertices."""
    return (
        obj is not None
        and obj.type == "MESH"
        and IT in obj
        and len(obj.data.vertices) == len(data.face().neutral)
    )


def rest():
    """(n, 3) of the face, in centimetres."""
    return data.face().neutral


def landmarks():
    """{name: (3,)} of all landmarks that the face bears, in centimetres."""
    face = data.face()
    found = {mark.name: face.neutral[vertex] for mark, vertex in zip(FACE, face.landmarks, strict=True)}
    return found | {mark.name: place for mark, place in zip(MIDDLES, middles(face), strict=True)}


def add_beside(context, head, kind="ARKIT"):
    """The face beside a head, as high, with the keys of a set of names; what is selected stays so."""
    selected, active = list(context.selected_objects), context.view_layer.objects.active
    for obj in selected:
        obj.select_set(False)
    head.select_set(True)
    context.view_layer.objects.active = head
    made = add(context, kind)
    corners = np.array(head.bound_box) @ np.array(head.matrix_world)[:3, :3].T
    made.location = head.matrix_world.translation
    made.location.x -= BESIDE * max(np.ptp(corners[:, 0]), 1e-6)
    made.select_set(False)
    for obj in selected:
        obj.select_set(True)
    context.view_layer.objects.active = active
    return made


def add(context, kind):
    """The face at the 3D cursor, with the keys of a set of names and a vertex group for each region.

    It is as high as the active mesh where one is selected, else of its own size, 34 cm.
    """
    face, like = data.face(), context.object
    scale = METRES
    if like is not None and like.type == "MESH" and like.select_get() and like.dimensions.z:
        corners = np.array(like.bound_box) @ np.array(like.matrix_world)[:3, :3].T
        scale = np.ptp(corners[:, 2]) / np.ptp(face.neutral[:, 2])
    mesh = bpy.data.meshes.new("Source Face")
    mesh.vertices.add(len(face.neutral))
    mesh.vertices.foreach_set("co", (scale * face.neutral).astype(np.float32).ravel())
    mesh.loops.add(len(face.loops))
    mesh.loops.foreach_set("vertex_index", face.loops)
    mesh.polygons.add(len(face.counts))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(face.counts) - face.counts).astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(face.counts), dtype=bool))
    mesh.update(calc_edges=True)
    made = bpy.data.objects.new("Source Face", mesh)
    made[IT] = True
    made.location = context.scene.cursor.location
    (context.collection or context.scene.collection).objects.link(made)
    points, _ = closest(face.neutral, face.triangles, np.array(list(landmarks().values())))
    for name, point in zip(landmarks(), points, strict=True):
        row = made.lissom_landmarks.add()
        row.name, row.corners, row.weights = name, point.corners, point.weights
        row.place = scale * point.position(face.neutral)
    for name, vertices in face.regions.items():
        made.vertex_groups.new(name=name).add(vertices.tolist(), 1.0, "REPLACE")
    called, offsets, _ = names.combined(kind, face.expression_names, face.expressions)
    for name, offset in zip(called, offsets, strict=True):
        shape_keys.write(made, name, scale * (face.neutral + offset))
    for other in context.selected_objects:
        other.select_set(False)
    made.select_set(True)
    context.view_layer.objects.active = made
    return made
