"""Job 1: a bust by two handles, head and chest; then one ear by its tip, in a region of its own."""

import time
from dataclasses import dataclass

import bpy
import numpy as np
import scene
from mathutils import Euler, Matrix
from studio import Tile

# The neck between these two planes is free. In decimetres: z below CHEST is held; the head is what lies above
# a plane that rises from the throat to the nape (z at y = 0, and its rise with y, which points backwards).
CHEST = -1.42
HEAD = (-0.52, 0.70)
SPINE = (0.0, 0.25, -0.45)  # about where the head sits on it

EAR = slice(6706, 7433)  # FaceKit numbers the left ear in one run
EAR_TIP = (6943, 0.17)  # a vertex of its rim, and the radius of the handle around it


@dataclass
class Pose:
    """The last handle's motion: Euler angles in degrees about ``pivot``, then a shift."""

    name: str
    degrees: tuple
    shift: tuple
    pivot: tuple


FILM = 8  # steps of the turn


def run(face, made, studio, picture, film):
    """Poses the bust by operators, each pose a shape key, and draws it; returns figures for the report."""
    bust = scene.face_object("Bust", face, face.neutral, made, scene.collection("1 Pose"), (0, 0, 0))
    groups = regions(face)
    tip = tuple(face.neutral[EAR_TIP[0]])
    of_head = [
        Pose("head turned by 60°", (0, 0, -60), (0, 0, 0), SPINE),
        Pose("head on the shoulder", (8, 38, 10), (0.08, -0.05, -0.06), SPINE),
    ]
    turns = [
        Pose(f"head turned, {step}/{FILM}", (0, 0, -60 * step / FILM), (0, 0, 0), SPINE)
        for step in range(1, FILM)
    ]
    of_ear = [Pose("ear pulled up", (-20, 0, 12), (0.10, 0.24, 0.34), tip)]
    figures = [
        solve(bust, groups, ("chest", "head"), "", of_head + turns)[: len(of_head)],
        solve(bust, groups, ("tip of the ear",), "ear", of_ear),
    ]
    whole, near = (
        {"centre": (0.05, -0.30), "height": 4.0, "turn": 20},
        {"centre": (0.52, 0.22), "height": 1.5, "turn": -40},
    )
    head, shoulder, ear = (pose.name for pose in (*of_head, *of_ear))
    studio.sheet(
        [
            [
                Tile(
                    [_marked(bust, groups, "chest", "head")],
                    "rest",
                    note="orange: handle, blue: held",
                    **whole,
                ),
                Tile([scene.posed(bust, {head: 1.0})], head, **whole),
                Tile([scene.posed(bust, {shoulder: 1.0})], shoulder, **whole),
                Tile([_marked(bust, groups, None, "tip of the ear")], "rest", note="orange: handle", **near),
                Tile([scene.posed(bust, {ear: 1.0})], ear, note="only the ear may move", **near),
            ]
        ],
        picture,
    )
    keys = [None, *(pose.name for pose in turns), head, head, head]
    studio.film((_frame(bust, groups, key, whole) for key in keys), film, back=True)
    for pose in turns:
        bust.shape_key_remove(bust.data.shape_keys.key_blocks[pose.name])
    scene.posed(bust, {head: 1.0})
    return {"vertices": len(face.neutral), "poses": [row for rows in figures for row in rows]}


def regions(face):
    """Vertex indices by name. The head has in it all that is not skin: eyes, teeth, tongue."""
    y, z = face.neutral[:, 1], face.neutral[:, 2]
    skin = np.isin(face.vertex_part, ("face", "head_and_neck"))
    centre, radius = face.neutral[EAR_TIP[0]], EAR_TIP[1]
    ear = np.arange(EAR.start, EAR.stop)
    return {
        "chest": np.flatnonzero(skin & (z < CHEST)),
        "head": np.flatnonzero(~skin | (z > HEAD[0] + HEAD[1] * y)),
        "ear": ear,
        "tip of the ear": ear[np.linalg.norm(face.neutral[ear] - centre, axis=1) < radius],
    }


def solve(bust, groups, handles, region, poses):
    """Moves the last of the handles through the poses, and keeps each as a shape key; returns figures."""
    names = [*handles, *([region] if region else [])]
    for name in names:
        bust.vertex_groups.new(name=name).add(groups[name].tolist(), 1.0, "REPLACE")
    for name in handles:
        scene.run(bpy.ops.lissom.pose_handle_add, object=bust.name, vertex_group=name)
    bust.lissom_pose.roi = region
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.pose_bind, object=bust.name)
    bind_seconds = time.perf_counter() - started

    movable = len(groups[region]) if region else len(bust.data.vertices)
    free = movable - sum(len(groups[name]) for name in handles)
    empty = bust.lissom_pose.handles[handles[-1]].empty
    rest, at = empty.matrix_world.copy(), bust.matrix_world
    rows = []
    for pose in poses:
        pivot = Matrix.Translation(pose.pivot)
        turn = Euler(np.radians(pose.degrees)).to_matrix().to_4x4()
        motion = Matrix.Translation(pose.shift) @ pivot @ turn @ pivot.inverted()
        empty.matrix_world = at @ motion @ at.inverted() @ rest
        started = time.perf_counter()
        scene.run(bpy.ops.lissom.pose_apply, object=bust.name, name=pose.name, value=0.0)
        seconds = time.perf_counter() - started
        rows.append(
            {"pose": pose.name, "free_vertices": free, "bind_seconds": bind_seconds, "seconds": seconds}
        )

    scene.run(bpy.ops.lissom.pose_unbind, object=bust.name)
    for name in handles:
        scene.run(bpy.ops.lissom.pose_handle_remove, object=bust.name, handle=name)
    return rows


def _frame(bust, groups, key, view):
    """The handles, and what is seen of them."""
    shown = scene.posed(bust, {key: 1.0} if key else {})
    return [
        Tile([_marked(bust, groups, "chest", "head", key)], "the handle turns", note="blue: held", **view),
        Tile([shown], "the neck follows", **view),
    ]


def _marked(bust, groups, held, moved, key=None):
    """The rest shape, or a key's, with the handles in colours of their own."""
    mesh = scene.posed(bust, {key: 1.0} if key else {})
    colours = {held: ("Held", (0.03, 0.06, 0.16)), moved: ("Handle", (0.55, 0.13, 0.015))}
    slot_of = np.zeros(len(mesh.vertices), dtype=np.int32)
    for name in filter(None, (held, moved)):
        slot_of[groups[name]] = len(mesh.materials)
        mesh.materials.append(scene.material(*colours[name]))
    for polygon in mesh.polygons:
        slots = {int(slot_of[v]) for v in polygon.vertices}
        if polygon.material_index == scene.SKIN and len(slots) == 1 and slots != {0}:
            polygon.material_index = slots.pop()
    return mesh
