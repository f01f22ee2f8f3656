"""The face that comes along as an object of the scene."""

import bpy
import numpy as np
from lissom import data, names

from . import shape_keys

METRES = 0.01  # a centimetre


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
    made.location = context.scene.cursor.location
    (context.collection or context.scene.collection).objects.link(made)
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
