"""Job 3: the same expressions to Suzanne, linked by the marker pairs in suzanne_markers.json."""

import time
from pathlib import Path

import bpy
import numpy as np
import scene
import source
from studio import Tile

from addon.core import markers

MARKERS = Path(__file__).with_name("suzanne_markers.json")

# Subdivision keeps the vertices it starts from, so markers on those hold for any number of levels.
LEVELS = 2
# Suzanne's mouth is a closed pit. Without its floor, the faces between these vertices, it can open.
MOUTH_FLOOR = range(223, 231)
EYE_CENTRE, IRIS_RADIUS = (0.353, 0.243), 0.13  # seen from the front, (x, z)


def run(face, obj, given, made, studio, picture):
    """Transfers all keys of the skin of ``obj`` by operators; returns figures for the report."""
    into = scene.collection("4 Suzanne")
    skin = source.make("ICT skin", face.only(*source.SKIN), given, into, (9.0, 0, 0))
    suzanne, eyes = make(made, into, (12.0, 0, 0))
    objects = {"source": skin.name, "target": suzanne.name, "filepath": str(MARKERS)}
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_fit, **objects)
    fitted = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_keys, **objects)
    transferred = time.perf_counter()

    pairs = markers.load(str(MARKERS)).pairs
    rest = scene.vertices(suzanne)
    motion = {
        key.name: float(np.linalg.norm(scene.key_vertices(suzanne, key.name) - rest, axis=1).max())
        for key in list(suzanne.data.shape_keys.key_blocks)[1:]
    }
    studio.sheet(_tiles(obj, suzanne, eyes, pairs), picture, aspect=1.1)
    return {
        "source_vertices": len(skin.data.vertices),
        "target_vertices": len(rest),
        "target_triangles": len(scene.triangles(suzanne)),
        "markers": len(pairs),
        "fit_seconds": fitted - started,
        "transfer_seconds": transferred - fitted,
        "keys": len(motion),
        "largest_motion_percent": {
            name: 100 * length / scene.diagonal(rest) for name, length in motion.items()
        },
    }


def make(skin, into, location):
    """Blender's monkey, subdivided: the head, its mouth cut open, and the eyes as an object of their own."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    whole = bpy.context.object
    whole.name = "Monkey"
    label = scene.components(whole.data)
    head = label == np.bincount(label).argmax()
    made = [
        _part("Suzanne", whole.data, head, into, location),
        _part("Suzanne's eyes", whole.data, ~head, into, location),
    ]
    unused = whole.data
    bpy.data.objects.remove(whole)
    bpy.data.meshes.remove(unused)
    made[0].data.materials.append(skin)
    made[1].data.materials.append(scene.eye())
    x, _, z = scene.vertices(made[1]).T
    scene.set_gaze(made[1].data, np.hypot(np.abs(x) - EYE_CENTRE[0], z - EYE_CENTRE[1]) / IRIS_RADIUS)
    return made


def _part(name, mesh, kept, into, location):
    """The kept vertices and their faces as an object, subdivided."""
    renumbered = np.cumsum(kept) - 1
    polygons = [list(p.vertices) for p in mesh.polygons]
    faces = [renumbered[p].tolist() for p in polygons if kept[p[0]] and not set(p) <= set(MOUTH_FLOOR)]
    coarse = bpy.data.meshes.new(name)
    coarse.from_pydata(scene.positions(mesh.vertices)[kept].tolist(), [], faces)
    made = bpy.data.objects.new(name, coarse)
    made.location = location
    into.objects.link(made)
    made.modifiers.new("Subdivision", "SUBSURF").levels = LEVELS
    fine = scene.posed(made, {})
    made.modifiers.clear()
    made.data = fine
    bpy.data.meshes.remove(coarse)
    fine.name = name
    fine.polygons.foreach_set("use_smooth", np.ones(len(fine.polygons), dtype=bool))
    return made


def _tiles(obj, suzanne, eyes, pairs):
    dot = scene.material("Marker", (0.85, 0.10, 0.03), 0.3)
    human = {"centre": (0.03, -0.02), "height": 2.6, "turn": 14}
    monkey = {"centre": (0.03, -0.30), "height": 2.25, "turn": 10}
    marked = f"{len(pairs)} marker pairs"
    rows = []
    for shown, side, frame, note, others in (
        (obj, "source", human, "given", ()),
        (suzanne, "target", monkey, "transferred", (eyes,)),
    ):
        rest = scene.vertices(shown)
        marks = [(rest[getattr(pair, side)], 0.028, dot) for pair in pairs]

        def meshes(mix, shown=shown, others=others):
            return [scene.posed(shown, mix), *(scene.posed(other, {}) for other in others)]

        row = [Tile(meshes({}), shown.name, note=marked, marks=marks, **frame)]
        for label, mix in {**source.MIXES, **source.SADNESS}.items():
            row.append(Tile(meshes(mix), label, note=note, **frame))
        rows.append(row)
    return rows
