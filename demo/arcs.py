"""Arcs on known ground: a lid that turns about a ball, a jaw that turns about its hinge, twisted bars.

Every shape here is what the operators baked and the sliders play.
"""

import time

import bpy
import numpy as np
import scene
from mathutils import Vector
from studio import Tile

MILLIMETRES = 100.0  # in a decimetre
MEASURED = np.linspace(0.0, 1.0, 101)
STEPS = (0.0, 0.25, 0.5, 0.75, 1.0)

LID_TURN, LID_TOLERANCE = 100.0, 0.002  # degrees; in radii of the ball, which is 1
OPEN, CLOSE = "jawOpen", "eyeBlink_L"
NEAR_EYE = (-0.31, 0.36), 0.42  # centre and height of the picture
CHIN = 8  # of the 68 landmarks
TURNS = (0.5, 1.5, 2.5)
ROTATIONS = ("relative", "consistent", "shortest")
LENGTH, SIDE, RINGS, AROUND = 20.0, 0.4, 200, 40
THICKER = 6.0  # in the picture than they are


def run(face, given, made, studio, pictures):
    """Bakes, measures and draws; ``pictures`` has the paths of "lid", "jaw", "blink" and "twist"."""
    into = scene.collection("6 Arcs")
    return {
        "lid": lid(given, made, into, studio, pictures["lid"]),
        "jaw": jaw(face, made, into, studio, pictures["jaw"]),
        "blink": blink(face, made, into, studio, pictures["blink"]),
        "twist": twist(made, into, studio, pictures["twist"]),
    }


# The lid: a strip from pole to pole of a ball of radius 1, which turns about the axis through the poles.


def lid(given, made, into, studio, picture):
    ball = _mesh_object("Ball", *_sphere(0.994), given, into, (22.0, 0, 0))
    vertices, faces = _strip(np.radians(-62.0), np.radians(-8.0))
    strip = _mesh_object("Lid", vertices, faces, made, into, (22.0, 0, 0))
    closed = vertices @ _about_x(np.radians(LID_TURN)).T
    scene.add_keys(strip, vertices, {"closed": closed - vertices})
    scene.run(
        bpy.ops.lissom.inbetween_bake,
        object=strip.name,
        end="closed",
        sampling="TOLERANCE",
        tolerance=LID_TOLERANCE,
        slider="lid",
    )
    ways = {"straight": "closed", "lissom": "lid"}
    depth = {
        way: max(1.0 - np.linalg.norm(shown(strip, {name: t}), axis=1).min() for t in MEASURED)
        for way, name in ways.items()
    }
    rows = [
        [_over(ball, strip, {name: t}, f"{label}, {100 * t:.0f} %") for t in STEPS]
        for label, name in (("straight line", "closed"), ("Lissom", "lid"))
    ]
    studio.sheet(rows, picture, aspect=1.0)
    keys = len(strip.lissom_inbetween.arcs["lid"].keys)
    return {"depth": {way: float(value) for way, value in depth.items()}, "keys": keys}


def _over(ball, strip, values, label):
    return Tile([_copy(ball), at(strip, values)], label, (0.0, -0.12), 2.7, turn=28)


def _strip(low, high, around=72, across=24):
    """A strip of the unit sphere between two angles about the x axis, from pole to pole."""
    latitudes, angles = (
        np.linspace(-np.pi / 2, np.pi / 2, around + 1)[1:-1],
        np.linspace(low, high, across + 1),
    )
    rows = [(np.sin(a), -np.cos(a) * np.cos(-b), -np.cos(a) * np.sin(b)) for a in latitudes for b in angles]
    count = across + 1
    faces = [
        (r * count + i, r * count + i + 1, (r + 1) * count + i + 1, (r + 1) * count + i)
        for r in range(around - 2)
        for i in range(across)
    ]
    first, last = len(rows), len(rows) + 1
    faces += [(first, i + 1, i) for i in range(across)]
    end = (around - 2) * count
    faces += [(last, end + i, end + i + 1) for i in range(across)]
    return np.array([*rows, (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)]), faces


def _about_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


# The jaw: lower teeth are rigid, so their motion has an axis, and the chin should go round it.


def jaw(face, made, into, studio, picture):
    head = scene.face_object("Jaw", face, face.neutral, made, into, (26.0, 0, 0))
    scene.add_keys(head, face.neutral, {OPEN: face.expressions[OPEN]})
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.inbetween_bake, object=head.name, end=OPEN, count=7, slider="jaw")
    seconds = time.perf_counter() - started
    chin = int(face.landmarks[CHIN])
    paths = {
        way: np.array([shown(head, {name: t})[chin] for t in MEASURED])
        for way, name in {"straight": OPEN, "lissom": "jaw"}.items()
    }
    first, last = paths["straight"][0], paths["straight"][-1]
    centre, angle = _best_circle(first, last, _hinge(face))
    circle = np.array([_around(first, centre, angle * t) for t in MEASURED])
    off = {
        way: float(np.linalg.norm(path - circle, axis=1).max() * MILLIMETRES) for way, path in paths.items()
    }
    colours = {
        "circle": scene.material("Circle", (0.03, 0.03, 0.03), 0.6),
        "straight": scene.material("Straight", (0.60, 0.16, 0.05), 0.5),
        "lissom": scene.material("Arc", (0.05, 0.42, 0.60), 0.4),
    }
    tiles = [
        Tile([at(head, {"jaw": t})], f"jawOpen, {100 * t:.0f} %", (-0.25, -0.45), 2.6, turn=-90)
        for t in (0.0, 0.5, 1.0)
    ]
    marks = []
    for way, path in ({"circle": circle} | paths).items():
        size, every = {"circle": (0.0022, 1), "straight": (0.005, 10), "lissom": (0.005, 10)}[way]
        marks += [((-1.5, *point[1:]), size, colours[way]) for point in path[::every]]
    middle = 0.5 * (circle[0] + circle[-1])
    height = 1.7 * np.ptp(circle[:, 2])
    near = Tile(
        [at(head, {})],
        "the chin's path: line red, Lissom blue",
        (middle[1], middle[2] - 0.1 * height),
        height,
        turn=-90,
        note="black: its best circle about the hinge",
        marks=[(np.array(place), radius * height / 0.5, colour) for place, radius, colour in marks],
    )
    studio.sheet([[*tiles, near]], picture, aspect=1.15)
    return {"off_circle_mm": off, "degrees": float(np.degrees(angle)), "seconds": seconds}


def _hinge(face):
    """Centre (y, z) of the turn of the lower teeth about x: their best rigid motion (Kabsch 1976)."""
    moved = np.linalg.norm(face.expressions[OPEN], axis=1)
    teeth = np.flatnonzero((face.vertex_part == "teeth") & (moved > 0.5 * moved.max()))
    before = face.neutral[teeth][:, 1:]
    after = before + face.expressions[OPEN][teeth][:, 1:]
    a, b = (points - points.mean(axis=0) for points in (before, after))
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.linalg.solve(np.eye(2) - turn, after.mean(axis=0) - turn @ before.mean(axis=0))


def _best_circle(start, end, hinge):
    """The centre nearest to the hinge of a circle through both ends, (y, z), and the angle between them."""
    a, b = start[1:], end[1:]
    chord = (b - a) / np.linalg.norm(b - a)
    centre = hinge - chord * (chord @ (hinge - 0.5 * (a + b)))
    u, v = a - centre, b - centre
    return centre, np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v)


def _around(point, centre, angle):
    y, z = point[1:] - centre
    c, s = np.cos(angle), np.sin(angle)
    return np.array([point[0], centre[0] + c * y - s * z, centre[1] + s * y + c * z])


# The blink: a lid over an eyeball that is no part of the mesh, as a clearance.


def blink(face, made, into, studio, picture):
    skin = face.only("face", "head_and_neck", "mouth_socket", "eye_sockets")
    head = scene.face_object("Blink", skin, skin.neutral, made, into, (28.0, 0, 0))
    scene.add_keys(head, skin.neutral, {CLOSE: skin.expressions[CLOSE]})
    eye = face.only("eyeball_left")
    centre, radius = _best_sphere(eye.neutral)
    points, faces = _sphere(radius, 160, 80)
    ball = _mesh_object("Eyeball", points, faces, scene.eye(), into, (28.0, 0, 0))
    scene.set_gaze(ball.data, np.degrees(np.arccos(-points[:, 1] / radius)) / scene.IRIS_ANGLE)
    ball.location += Vector(centre)
    bpy.context.view_layer.update()
    for slider, clearance in (("plain", ""), ("clear", ball.name)):
        scene.run(
            bpy.ops.lissom.inbetween_bake,
            object=head.name, end=CLOSE, count=15, slider=slider, clearance=clearance,
        )  # fmt: skip
    moved = np.linalg.norm(skin.expressions[CLOSE], axis=1) > 0

    def depths(values):
        return radius - np.linalg.norm(shown(head, values)[moved] - centre, axis=1)

    ends = np.maximum(np.maximum(depths({}), depths({CLOSE: 1.0})), 0.0)
    deeper = {
        way: MILLIMETRES * float(max((depths({name: t}) - ends).max() for t in MEASURED))
        for way, name in {"straight": CLOSE, "plain": "plain", "clear": "clear"}.items()
    }
    shift = points + centre
    rows = [
        [
            Tile([_moved(ball, shift), at(head, {name: t})], f"{label}, {100 * t:.0f} %", *NEAR_EYE, turn=-40)
            for t in STEPS
        ]
        for label, name in (("straight line", CLOSE), ("Lissom", "clear"))
    ]
    studio.sheet(rows, picture, aspect=0.8)
    return {"deeper_mm": deeper, "radius_mm": radius * MILLIMETRES}


def _moved(obj, vertices):
    mesh = obj.data.copy()
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.update()
    return mesh


def _best_sphere(points):
    """Centre and radius by linear least squares: |p|^2 = 2 c p + (r^2 - |c|^2)."""
    system = np.column_stack([2 * points, np.ones(len(points))])
    solution = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)[0]
    return solution[:3], float(np.sqrt(solution[3] + solution[:3] @ solution[:3]))


# The bars: slender, square, and twisted by more than half a turn.


def twist(made, into, studio, picture):
    rest, faces = _bar()
    figures, rows = {}, []
    stripe = scene.material("Stripe", (0.85, 0.42, 0.08), 0.5)
    bars = {}
    for turns in TURNS:
        bar = bars[turns] = _mesh_object(f"Bar {turns}", rest, faces, made, into, (30.0 + turns, 0, 0))
        bar.data.materials.append(stripe)
        sides = np.tile(np.arange(AROUND) < AROUND // 4, RINGS - 1).astype(np.int32)
        bar.data.polygons.foreach_set("material_index", sides)
        angles = 2 * np.pi * turns * rest[:, 2] / LENGTH
        c, s = np.cos(angles), np.sin(angles)
        twisted = np.stack(
            [c * rest[:, 0] - s * rest[:, 1], s * rest[:, 0] + c * rest[:, 1], rest[:, 2]], axis=1
        )
        scene.add_keys(bar, rest, {"twisted": twisted - rest})
    for rotation in ROTATIONS:
        row = []
        for turns, bar in bars.items():
            scene.run(
                bpy.ops.lissom.inbetween_bake,
                object=bar.name, end="twisted", rotation=rotation, count=1, slider=rotation,
            )  # fmt: skip
            half = shown(bar, {rotation: 0.5})
            figures.setdefault(rotation, []).append(_bar_figures(rest, half, turns))
            row.append((bar, {rotation: 0.5}, turns))
        rows.append((rotation, row))
    rows.append(("straight line", [(bar, {"twisted": 0.5}, turns) for turns, bar in bars.items()]))
    tiles = [
        _bar_tile(bar, values, label, f"{turns} turns") for label, row in rows for bar, values, turns in row
    ]
    studio.sheet([tiles[:6], tiles[6:]], picture, aspect=1.6)
    return figures


def _bar():
    """An open square bar along z, centred on the axis."""
    s = 4 * np.arange(AROUND) / AROUND
    corner = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * SIDE / 2
    square = np.stack([np.interp(s, np.arange(5), corner[:, i]) for i in range(2)], axis=1)
    heights = np.linspace(0.0, LENGTH, RINGS)
    vertices = np.array([(x, y, z) for z in heights for x, y in square])
    faces = [
        (
            r * AROUND + i,
            r * AROUND + (i + 1) % AROUND,
            (r + 1) * AROUND + (i + 1) % AROUND,
            (r + 1) * AROUND + i,
        )
        for r in range(RINGS - 1)
        for i in range(AROUND)
    ]
    return vertices, faces


def _bar_figures(rest, half, turns):
    """Degrees that the end misses half of its twist by (whole turns included), and the mean side's length."""
    first, last = half[:AROUND], half[-AROUND:]
    rings = half.reshape(RINGS, AROUND, 3)
    around = rings[:, 0, :2] - rings[:, :, :2].mean(axis=1)
    angles = np.unwrap(np.arctan2(around[:, 1], around[:, 0]))
    side = np.linalg.norm(np.roll(last, -1, axis=0) - last, axis=1).sum() / (4 * SIDE)
    return {
        "turns": turns,
        "degrees_off": float(abs(abs(np.degrees(angles[-1] - angles[0])) - 180.0 * turns)),
        "end_girth": float(side),
        "length": float((last.mean(axis=0) - first.mean(axis=0))[2] / LENGTH),
    }


def _bar_tile(bar, values, label, note):
    mesh = at(bar, values)
    positions = scene.positions(mesh.vertices) * [THICKER, THICKER, 1.0]
    mesh.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    mesh.update()
    return Tile([mesh], label, (0.0, 8.6), 26.5, turn=30, note=note)


# Shared


def at(obj, values):
    """A mesh of the object at these values of keys and sliders, all others at 0."""
    return scene.posed(obj, {arc.name: 0.0 for arc in obj.lissom_inbetween.arcs} | values)


def shown(obj, values):
    """(n, 3): what the object shows at these values of keys and sliders, all others at 0."""
    mesh = at(obj, values)
    positions = scene.positions(mesh.vertices)
    bpy.data.meshes.remove(mesh)
    return positions


def _copy(obj):
    return obj.data.copy()


def _mesh_object(name, vertices, faces, material, into, location):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    made.location = location
    into.objects.link(made)
    bpy.context.view_layer.update()
    return made


def _sphere(radius, around=64, across=32):
    angles, latitudes = 2 * np.pi * np.arange(around) / around, np.pi * np.arange(1, across) / across
    vertices = [(np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)) for b in latitudes for a in angles]
    faces = [
        (
            r * around + (i + 1) % around,
            r * around + i,
            (r + 1) * around + i,
            (r + 1) * around + (i + 1) % around,
        )
        for r in range(across - 2)
        for i in range(around)
    ]
    top, bottom = len(vertices), len(vertices) + 1
    faces += [(top, i, (i + 1) % around) for i in range(around)]
    end = (across - 2) * around
    faces += [(bottom, end + (i + 1) % around, end + i) for i in range(around)]
    return radius * np.array([*vertices, (0, 0, 1), (0, 0, -1)]), faces
