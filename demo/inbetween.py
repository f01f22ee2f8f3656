"""Job 4: the way between two shape keys.

A head turned from one shoulder to the other: on the straight way it shrinks to half its width.
And a blink: on the straight way the lids cut through the eyes.
"""

import time

import bpy
import numpy as np
import pose
import scene
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from studio import Tile

COUNT = 5  # in-betweens, for either arc
SHOWN = (0.0, 0.25, 0.5, 0.75, 1.0)
PLAYED = np.linspace(0.0, 1.0, 11)
MEASURED = np.linspace(0.0, 1.0, 21)
MILLIMETRES = 100.0  # in a decimetre

TURN = 60.0  # degrees to either side
EYES_HANG_ON = (36, 45, 28)  # landmarks: the outer corners of the eyes, the nose
LEFT, RIGHT, HEAD_SLIDER = "head to the left", "head to the right", "turn"
CLOSED, STRAIGHT, BLINK_SLIDER = "eyes closed", "eyes closed, straight", "blink"


def run(face, given, made, studio, picture, film):
    """Bakes both arcs by operators and draws them; returns figures for the report."""
    into = scene.collection("5 In-between")
    head, eyes = turning_head(face, made, into, (15.0, 0, 0))
    blinking = scene.face_object("Blinking face", face, face.neutral, made, into, (18.0, 0, 0))
    closed = face.expressions["eyeBlink_L"] + face.expressions["eyeBlink_R"]
    scene.add_keys(blinking, face.neutral, {CLOSED: closed, STRAIGHT: closed})

    started = time.perf_counter()
    bake = bpy.ops.lissom.inbetween_bake
    scene.run(bake, object=head.name, start=LEFT, end=RIGHT, count=COUNT, slider=HEAD_SLIDER)
    turned = time.perf_counter()
    scene.run(bake, object=blinking.name, end=CLOSED, count=COUNT, slider=BLINK_SLIDER)
    blinked = time.perf_counter()

    lengths = {way: edge_error(head, values) for way, values in _halfway().items()}
    lids = Lids(face)
    depth = {
        way: np.max([lids.depth(_shown(blinking, {way: t})) for t in MEASURED])
        for way in (STRAIGHT, BLINK_SLIDER)
    }
    studio.sheet(_tiles(head, eyes, blinking, given), picture, aspect=1.0)
    studio.film(_frames(head, eyes, given), film, aspect=1.0, back=True)
    scene.posed(head, {LEFT: 1.0, HEAD_SLIDER: 0.5})
    scene.posed(blinking, {BLINK_SLIDER: 0.5})
    return {
        "keys": COUNT + 1,
        "turn_vertices": len(head.data.vertices),
        "turn_seconds": turned - started,
        "turn_edge_error_percent": {way: 100.0 * error for way, error in lengths.items()},
        "blink_vertices": len(face.neutral),
        "blink_seconds": blinked - turned,
        "blink_depth_mm": {
            "straight": MILLIMETRES * float(depth[STRAIGHT]),
            "lissom": MILLIMETRES * float(depth[BLINK_SLIDER]),
        },
    }


def turning_head(face, made, into, location):
    """A head without eyes, posed to the left and to the right, and its eyes as an object of their own.

    Loose components go straight from key to key, so the eyes are left out and hang on three vertices of the
    head, by Blender's vertex parenting.
    """
    skin = face.only("face", "head_and_neck", "mouth_socket", "eye_sockets")
    head = scene.face_object("Turning head", skin, skin.neutral, made, into, location)
    balls = face.only("eyeball_left", "eyeball_right")
    eyes = scene.face_object("Eyes", balls, balls.neutral, made, into, (0, 0, 0))
    eyes.parent, eyes.parent_type = head, "VERTEX_3"
    eyes.parent_vertices = [int(face.landmarks[number]) for number in EYES_HANG_ON]
    bpy.context.view_layer.update()
    eyes.matrix_parent_inverse = eyes.matrix_world.inverted() @ head.matrix_world
    poses = [
        pose.Pose(name, (0, 0, degrees), (0, 0, 0), pose.SPINE)
        for name, degrees in ((LEFT, TURN), (RIGHT, -TURN))
    ]
    pose.solve(head, pose.regions(skin), ("chest", "head"), "", poses)
    return head, eyes


def edge_error(head, values):
    """Root mean square of the edge lengths' relative difference from the mean of both ends."""
    edges = np.empty(2 * len(head.data.edges), dtype=np.int32)
    head.data.edges.foreach_get("vertices", edges)
    a, b = edges.reshape(-1, 2).T

    def lengths(positions):
        return np.linalg.norm(positions[a] - positions[b], axis=1)

    ends = lengths(scene.key_vertices(head, LEFT)) + lengths(scene.key_vertices(head, RIGHT))
    return float(np.sqrt(np.mean((2.0 * lengths(_shown(head, values)) / ends - 1.0) ** 2)))


class Lids:
    """How far lids sink into the eyes on their way, deeper than where they start or end."""

    def __init__(self, face):
        first = np.cumsum(face.counts) - face.counts
        balls = np.flatnonzero(np.char.startswith(face.polygon_part.astype(str), "eyeball"))
        polygons = [face.loops[first[p] : first[p] + face.counts[p]].tolist() for p in balls]
        self._eyes = BVHTree.FromPolygons(face.neutral.tolist(), polygons)
        closing = face.expressions["eyeBlink_L"] + face.expressions["eyeBlink_R"]
        self._lids = np.flatnonzero((np.linalg.norm(closing, axis=1) > 0.02) & (face.vertex_part == "face"))
        self._ends = np.maximum(self._depths(face.neutral), self._depths(face.neutral + closing))

    def depth(self, positions):
        """The greatest depth below the surface of an eyeball, in excess of the deeper end; at least 0."""
        return float((self._depths(positions) - self._ends).max(initial=0.0))

    def _depths(self, positions):
        depths = np.zeros(len(self._lids))
        for row, position in enumerate(positions[self._lids]):
            place, normal, _, distance = self._eyes.find_nearest(Vector(position))
            if normal.dot(Vector(position) - place) < 0.0:
                depths[row] = distance
        return depths


def _halfway():
    return {"straight": {LEFT: 0.5, RIGHT: 0.5, HEAD_SLIDER: 0.0}, "lissom": {LEFT: 1.0, HEAD_SLIDER: 0.5}}


def _shown(obj, values):
    mesh = scene.posed(obj, values)
    positions = scene.positions(mesh.vertices)
    bpy.data.meshes.remove(mesh)
    return positions


def _tiles(head, eyes, blinking, given):
    far, near = {"centre": (0.0, -0.30), "height": 3.9}, {"centre": (0.36, 0.38), "height": 0.58, "turn": 40}
    ends = [_with_eyes(head, eyes, {key: 1.0, HEAD_SLIDER: 0.0}, given) for key in (LEFT, RIGHT)]
    straight, arc, blink = [], [], []
    for t in SHOWN:
        percent = f"{100 * t:.0f} %"
        straight.append(
            Tile([_blend(*pair, t) for pair in zip(*ends, strict=True)], f"straight way, {percent}", **far)
        )
        meshes = _with_eyes(head, eyes, {LEFT: 1.0, HEAD_SLIDER: t})
        arc.append(Tile(meshes, f"Lissom, {percent}", **far))
        blink.append(Tile([scene.posed(blinking, {BLINK_SLIDER: t})], f"blink, {percent}", **near))
    return [straight, arc, blink]


def _frames(head, eyes, given):
    """Straight and along the arc."""
    frame = {"centre": (0.0, -0.30), "height": 3.9}
    for t in PLAYED:
        ends = [_with_eyes(head, eyes, {key: 1.0, HEAD_SLIDER: 0.0}, given) for key in (LEFT, RIGHT)]
        straight = [_blend(*pair, t) for pair in zip(*ends, strict=True)]
        yield [
            Tile(straight, "straight", **frame),
            Tile(_with_eyes(head, eyes, {LEFT: 1.0, HEAD_SLIDER: t}), "Lissom", **frame),
        ]
        for mesh in (mesh for end in ends for mesh in end):
            bpy.data.meshes.remove(mesh)


def _with_eyes(head, eyes, values, skin=None):
    meshes = [scene.posed(head, values), scene.posed(eyes, {})]
    meshes[1].transform(head.matrix_world.inverted() @ eyes.matrix_world)
    if skin is not None:
        meshes[0].materials[scene.SKIN] = skin
    return meshes


def _blend(start, end, t):
    """A mesh on the straight way between two."""
    mesh = start.copy()
    positions = (1.0 - t) * scene.positions(start.vertices) + t * scene.positions(end.vertices)
    mesh.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    mesh.update()
    return mesh
