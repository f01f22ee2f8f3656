"""Job 4: a blink. On the straight way between open and closed the lids cut through the eyeballs."""

import time

import bpy
import numpy as np
import scene
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from studio import Tile

CLOSED = "eyes closed"
STRAIGHT = "eyes closed, straight"
SLIDER = "blink"
COUNT = 5
TIMES = np.linspace(0.0, 1.0, 21)
SHOWN = (0.0, 0.25, 0.5, 0.75, 1.0)


def run(face, given, made, studio, picture):
    """Bakes the arc by operator, measures how deep the lids sink into the eyes; returns figures for the report."""
    into = scene.collection("5 In-between")
    blinking = scene.face_object("Blinking face", face, face.neutral, made, into, (12.0, 0, 0))
    closed = face.expressions["eyeBlink_L"] + face.expressions["eyeBlink_R"]
    scene.add_keys(blinking, face.neutral, {CLOSED: closed, STRAIGHT: closed})

    started = time.perf_counter()
    scene.run(bpy.ops.lissom.inbetween_bake, object=blinking.name, end=CLOSED, count=COUNT, slider=SLIDER)
    seconds = time.perf_counter() - started

    eyes = Eyes(face)
    depth = {
        name: np.array([eyes.depth(_shown(blinking, {name: t})) for t in TIMES]) for name in (STRAIGHT, SLIDER)
    }
    studio.sheet(_tiles(blinking, given), picture)
    scene.posed(blinking, {SLIDER: 0.0})
    millimetres = 100.0  # a decimetre
    return {
        "vertices": len(face.neutral),
        "keys": COUNT + 1,
        "seconds": seconds,
        "straight_depth_mm": millimetres * float(depth[STRAIGHT].max()),
        "lissom_depth_mm": millimetres * float(depth[SLIDER].max()),
        "rest_depth_mm": millimetres * float(depth[SLIDER][0]),
    }


class Eyes:
    """How far vertices of the lids lie inside the eyeballs."""

    def __init__(self, face):
        first = np.cumsum(face.counts) - face.counts
        balls = np.flatnonzero(np.char.startswith(face.polygon_part.astype(str), "eyeball"))
        polygons = [face.loops[first[p] : first[p] + face.counts[p]].tolist() for p in balls]
        self._tree = BVHTree.FromPolygons(face.neutral.tolist(), polygons)
        closing = face.expressions["eyeBlink_L"] + face.expressions["eyeBlink_R"]
        moves = np.linalg.norm(closing, axis=1) > 0.02
        self._lids = np.flatnonzero(moves & (face.vertex_part == "face"))

    def depth(self, positions):
        """The greatest depth of a lid vertex below the surface of an eyeball, 0 where none is inside."""
        deepest = 0.0
        for position in positions[self._lids]:
            place, normal, _, distance = self._tree.find_nearest(Vector(position))
            if normal.dot(Vector(position) - place) < 0.0:
                deepest = max(deepest, distance)
        return deepest


def _shown(obj, values):
    mesh = scene.posed(obj, values)
    positions = scene.positions(mesh.vertices)
    bpy.data.meshes.remove(mesh)
    return positions


def _tiles(obj, given):
    rows = []
    for name, way in ((STRAIGHT, "straight line"), (SLIDER, "Lissom")):
        row = []
        for t in SHOWN:
            mesh = scene.posed(obj, {name: t, SLIDER: t if name == SLIDER else 0.0})
            if name == STRAIGHT:
                mesh.materials[scene.SKIN] = given
            row.append(Tile([mesh], f"{way}, {100 * t:.0f} %", (0.36, 0.36), 0.62, turn=40))
        rows.append(row)
    return rows
