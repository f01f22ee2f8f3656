"""Job 3: the same expressions to Suzanne, linked by pairs of markers and curves in suzanne_markers.json."""

import time
from pathlib import Path

import bpy
import numpy as np
import scene
import source
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from studio import Tile

from addon.core import marker_file

MARKERS = Path(__file__).with_name("suzanne_markers.json")

# Subdivision keeps the vertices it starts from, so markers on those hold for any number of levels.
LEVELS = 2
# Suzanne's mouth is a closed pit. Without its floor, the faces between these vertices, it can open.
MOUTH_FLOOR = range(223, 231)
EYE_CENTRE, IRIS_RADIUS = (0.353, 0.243), 0.13  # seen from the front, (x, z)

# Pressed tightly onto a face of such other proportions the human one would fold. Her lids are to close over
# her eyes, which stay as they are and match nothing: ICT's keys do not turn eyeballs.
EYES = "Eyes"
FIT = {"target_mask": EYES}
KEYS = {"contact": True, "unmatched": "rest"}

ABOVE = 20.0  # degrees: where eyes are looked at from, besides from the front
RAYS = 60  # across an eye
COLUMNS = 9  # of the picture of all keys


def run(face, obj, given, made, studio, picture, all_keys):
    """Transfers all keys of the skin of ``obj`` by operators; returns figures for the report."""
    into = scene.collection("4 Suzanne")
    skin = source.make("ICT skin", face.only(*source.SKIN), given, into, (9.0, 0, 0))
    suzanne, eyes = make(made, into, (12.0, 0, 0))
    seconds = transfer(skin, suzanne, eyes)

    pairs = marker_file.load(str(MARKERS)).pairs
    rest = scene.vertices(suzanne)
    names = [key.name for key in list(suzanne.data.shape_keys.key_blocks)[1:]]
    motion = {
        name: float(np.linalg.norm(scene.key_vertices(suzanne, name) - rest, axis=1).max()) for name in names
    }
    quality = bpy.context.scene.lissom_transfer.quality
    studio.sheet(_tiles(obj, suzanne, eyes, pairs), picture, aspect=1.1)
    studio.sheet(_all_keys(suzanne, eyes, names), all_keys, aspect=1.0, width=1800, samples=6)
    return {
        "source_vertices": len(skin.data.vertices),
        "target_vertices": len(rest),
        "target_triangles": len(scene.triangles(suzanne)),
        "markers": len(pairs),
        "fit_seconds": seconds[0],
        "transfer_seconds": seconds[1],
        "keys": len(motion),
        "flipped_percent": 100
        * sum(row.flipped_triangles for row in quality)
        / (len(quality) * len(scene.triangles(suzanne))),
        "eye_visible_percent": {
            f"{name} {view}": 100 * visible(suzanne, eyes, name, degrees)
            for name in (None, "eyeBlink_L", "eyeBlink_R")
            for view, degrees in (("front", 0.0), ("above", ABOVE))
        },
        "largest_motion_percent": {
            name: 100 * length / scene.diagonal(rest) for name, length in motion.items()
        },
    }


def transfer(skin, suzanne, eyes, keys=()):
    """Carries keys of the skin over, all or those named; returns the seconds of fit and of transfer."""
    everything = range(len(eyes.data.vertices))
    eyes.vertex_groups.new(name=EYES).add(list(everything), 1.0, "REPLACE")
    fit = {"source": skin.name, "target": f"{suzanne.name}\n{eyes.name}", "filepath": str(MARKERS), **FIT}
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_fit, **fit)
    fitted = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_keys, **fit, **KEYS, keys="\n".join(keys))
    return fitted - started, time.perf_counter() - fitted


def visible(suzanne, eyes, key=None, degrees=0.0):
    """The part of an eye's outline in which the eye is seen, from the front or from ``degrees`` above.

    It is the left eye but for keys that end on R; without a key the head is at rest.
    """
    head = scene.key_vertices(suzanne, key) if key else scene.vertices(suzanne)
    balls, triangles = scene.vertices(eyes), scene.triangles(eyes)
    right = bool(key) and key.endswith("_R")
    triangles = triangles[(balls[triangles[:, 0], 0] < 0) == right]
    trees = [
        BVHTree.FromPolygons(points.tolist(), faces.tolist())
        for points, faces in ((balls, triangles), (head, scene.triangles(suzanne)))
    ]
    angle = np.radians(degrees)
    along = Vector((0.0, np.cos(angle), -np.sin(angle)))
    across, up = np.array([1.0, 0.0, 0.0]), np.array([0.0, np.sin(angle), np.cos(angle)])
    ball = balls[np.unique(triangles)]
    ranges = [np.linspace((ball @ axis).min(), (ball @ axis).max(), RAYS) for axis in (across, up)]
    hits = inside = 0
    for u in ranges[0]:
        for v in ranges[1]:
            start = Vector(u * across + v * up) - 10.0 * along
            eye, skin = (tree.ray_cast(start, along)[3] for tree in trees)
            inside += eye is not None
            hits += eye is not None and (skin is None or eye < skin)
    return hits / inside


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
        for label, mix in {**source.MIXES, **source.BLINK}.items():
            row.append(Tile(meshes(mix), label, note=note, **frame))
        rows.append(row)
    return rows


def _all_keys(suzanne, eyes, names):
    """Rest and every key on its own, in rows."""
    frame = {"centre": (0.03, -0.38), "height": 2.15, "turn": 10, "text": 1.2}
    tiles = [
        Tile(
            [scene.posed(suzanne, {name: 1.0} if name else {}), scene.posed(eyes, {})],
            name or "rest",
            **frame,
        )
        for name in (None, *names)
    ]
    return [tiles[first : first + COLUMNS] for first in range(0, len(tiles), COLUMNS)]
