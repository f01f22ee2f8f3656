"""Job 3: the same expressions to Suzanne, linked by the marker pairs in suzanne_markers.json."""

import time
from pathlib import Path

import bpy
import numpy as np
import scene
import source
from addon.core import markers
from studio import Tile

MARKERS = Path(__file__).with_name("suzanne_markers.json")
HEAD_VERTEX = 90  # on the chin
EYE_CENTRE, IRIS_RADIUS = (0.353, 0.243), 0.13  # seen from the front, (x, z)
LEVELS = 2  # of subdivision: 507 vertices become 7958, of which the first 507 are the old ones


def run(obj, made, studio, picture):
    """Transfers all keys of ``obj`` by operators; returns figures for the report."""
    suzanne = make(made, (9.0, 0, 0))
    objects = {"source": obj.name, "target": suzanne.name, "filepath": str(MARKERS)}
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_fit, **objects)
    fitted = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_keys, **objects)
    transferred = time.perf_counter()

    pairs = markers.load(str(MARKERS)).pairs
    studio.sheet(_tiles(obj, suzanne, pairs), picture)
    rest = scene.vertices(suzanne)
    diagonal = scene.diagonal(rest)
    return {
        "target_vertices": len(rest),
        "target_triangles": len(scene.triangles(suzanne)),
        "markers": len(pairs),
        "fit_seconds": fitted - started,
        "transfer_seconds": transferred - fitted,
        "keys": len(suzanne.data.shape_keys.key_blocks) - 1,
        "largest_motion_percent": {
            key.name: 100 * float(np.linalg.norm(scene.key_vertices(suzanne, key.name) - rest, axis=1).max()) / diagonal
            for key in list(suzanne.data.shape_keys.key_blocks)[1:]
        },
    }


def make(skin, location):
    """Blender's monkey, subdivided, with white eyes."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    suzanne = bpy.context.object
    suzanne.name = "Suzanne"
    modifier = suzanne.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = LEVELS
    mesh = scene.posed(suzanne, {})
    unused, suzanne.data = suzanne.data, mesh
    suzanne.modifiers.clear()
    bpy.data.meshes.remove(unused)
    mesh.name = "Suzanne"
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    suzanne.location = location
    for collection in list(suzanne.users_collection):
        collection.objects.unlink(suzanne)
    scene.collection("4 Suzanne").objects.link(suzanne)
    _paint(mesh, skin)
    return suzanne


def _paint(mesh, skin):
    """Skin on the head, eyes on the two eyeballs, which are components of their own."""
    mesh.materials.clear()
    for material in (skin, *scene.anatomy()):
        mesh.materials.append(material)
    component, at = scene.components(mesh), scene.positions(mesh.vertices)
    for polygon in mesh.polygons:
        if component[polygon.vertices[0]] != component[HEAD_VERTEX]:
            polygon.material_index = scene.EYE
    x, z = np.abs(at[:, 0]) - EYE_CENTRE[0], at[:, 2] - EYE_CENTRE[1]
    scene.set_gaze(mesh, np.hypot(x, z) / IRIS_RADIUS)


def _tiles(obj, suzanne, pairs):
    dot = scene.material("Marker", (0.85, 0.10, 0.03), 0.3)
    face_frame = {"centre": (0.0, 0.02), "height": 2.9, "turn": 18}
    monkey_frame = {"centre": (0.06, -0.17), "height": 3.15, "turn": 18}
    above, below = [], []
    for row, side, frame, other in ((above, "source", face_frame, obj), (below, "target", monkey_frame, suzanne)):
        rest = scene.vertices(other)
        marks = [(rest[getattr(pair, side)], 0.030, dot) for pair in pairs]
        label = "ICT face" if other is obj else "Suzanne"
        row.append(Tile([scene.posed(other, {})], label, note=f"{len(pairs)} marker pairs", marks=marks, **frame))
        for mix_label, mix in source.SHOWN.items():
            note = "given" if other is obj else "transferred"
            row.append(Tile([scene.posed(other, mix)], mix_label, note=note, **frame))
    return [above, below]
