"""The report's own setting: two drawings, one slider.

A worm lies stretched out, and curled up by 300 degrees. The first drawing becomes a mesh, pins lay it on the
second, and the slider plays shape and cross-dissolve; beside it the same without consistent turns.
"""

import time

import bpy
import numpy as np
import scene
from mathutils import Matrix
from studio import Tile

SIZE = (480, 360)  # pixels
HEIGHT = 2.0  # scene units
UNIT = HEIGHT / SIZE[1]
LENGTH, TURN = 360.0, np.radians(300.0)
LYING, CURLED = (60.0, 130.0), (240.0, 110.0)  # the head's middle
PINS = np.linspace(0.0, LENGTH, 9)
PIN_RADIUS = 9.0
SHOWN = (0.0, 0.25, 0.5, 0.75, 1.0)
MEASURED = np.linspace(0.0, 1.0, 50)
COUNT = 24  # in-betweens
BANDS = 17
WAYS = {"consistent": "consistent", "inconsistent": "shortest"}


def run(studio, picture):
    """Makes mesh, pose, arcs and dissolve by operators and draws them; returns figures for the report."""
    into = scene.collection("7 Drawing")
    first = _image("Worm", line(LYING, 0.0), ((0.93, 0.72, 0.21), (0.62, 0.20, 0.12)))
    second = _image("Worm, curled", line(CURLED, TURN), ((0.25, 0.62, 0.70), (0.10, 0.18, 0.42)))
    started = time.perf_counter()
    scene.run(bpy.ops.lissom.inbetween_image, image=first.name, height=HEIGHT)
    obj = bpy.context.object
    into.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    _pose(obj)
    for slider, rotation in WAYS.items():
        scene.run(
            bpy.ops.lissom.inbetween_bake,
            object=obj.name, end="curled", slider=slider, rotation=rotation, count=COUNT,
        )  # fmt: skip
    scene.run(bpy.ops.lissom.inbetween_second_image, object=obj.name, image=second.name, slider="consistent")
    seconds = time.perf_counter() - started
    figures = {"vertices": len(obj.data.vertices), "triangles": len(obj.data.polygons), "seconds": seconds}
    figures["flipped"], figures["off_plane"] = {}, 0.0
    for slider in WAYS:
        shapes = [_shape(obj, {slider: t}) for t in MEASURED]
        figures["flipped"][slider] = max(int((_areas(obj, shape) <= 0).sum()) for shape in shapes)
        figures["off_plane"] = max(figures["off_plane"], *(float(np.abs(s[:, 2]).max()) for s in shapes))
    rows = [[_tile(obj, slider, t) for t in SHOWN] for slider in WAYS]
    studio.sheet(rows, picture, aspect=0.8)
    obj.location.x = 21.0
    scene.posed(obj, {"consistent": 0.5, "inconsistent": 0.0})
    return figures


def line(head, turn, points=400):
    """The worm's middle: places (k, 2), and the way along it (k,), which turns evenly by ``turn``."""
    along = np.linspace(0.0, LENGTH, points)
    angle = along / LENGTH * turn
    if turn == 0.0:
        return np.stack([head[0] + along, np.full(points, head[1])], 1), along, angle
    radius = LENGTH / turn
    offset = np.stack([np.sin(angle), 1.0 - np.cos(angle)], 1)
    return head + radius * offset, along, angle


def _image(name, worm, colours):
    """An image of the worm in bands of two colours, smooth over the pixels at its edge."""
    places, along, _ = worm
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    pixels = np.stack([x.ravel(), y.ravel()], 1)
    nearest = np.array([np.argmin(((places - p) ** 2).sum(1)) for p in pixels])
    way = along[nearest] / LENGTH
    width = 24.0 - 13.0 * way**2
    distance = np.linalg.norm(pixels - places[nearest], axis=1)
    light, dark = np.array(colours)
    shade = np.clip(4.0 * np.cos(np.pi * BANDS * way) + 0.5, 0.0, 1.0)[:, None]
    colour = shade * light + (1.0 - shade) * dark
    eye = np.linalg.norm(pixels - places[8] - (0.0, 7.0), axis=1)
    for radius, ink in ((7.0, (0.98, 0.98, 0.96)), (3.2, (0.05, 0.05, 0.06))):
        cover = np.clip(radius + 0.5 - eye, 0.0, 1.0)[:, None]
        colour = cover * np.array(ink) + (1.0 - cover) * colour
    rgba = np.column_stack([colour, np.clip(0.5 + width - distance, 0.0, 1.0)])
    image = bpy.data.images.new(name, *SIZE, alpha=True)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.pack()
    return image


def _pose(obj):
    """Pins along the worm laid on the second drawing; the pose becomes the key 'curled'."""
    start, way, _ = line(LYING, 0.0)
    end, _, angle = line(CURLED, TURN)
    pixels = scene.vertices(obj)[:, :2] / UNIT + np.array(SIZE) / 2
    for pin in PINS:
        at = int(np.argmin(np.abs(way - pin)))
        near = np.flatnonzero(np.linalg.norm(pixels - start[at], axis=1) < PIN_RADIUS)
        group = obj.vertex_groups.new(name=f"pin {pin:.0f}")
        group.add(near.tolist(), 1.0, "REPLACE")
        scene.run(bpy.ops.lissom.pose_handle_add, object=obj.name, vertex_group=group.name)
    scene.run(bpy.ops.lissom.pose_bind, object=obj.name)
    for pin, handle in zip(PINS, obj.lissom_pose.handles, strict=True):
        at = int(np.argmin(np.abs(way - pin)))
        middle = np.array(handle.empty.location[:2]) / UNIT + np.array(SIZE) / 2 - start[at]
        turned = np.array([[np.cos(angle[at]), -np.sin(angle[at])], [np.sin(angle[at]), np.cos(angle[at])]])
        place = (end[at] + turned @ middle - np.array(SIZE) / 2) * UNIT
        handle.empty.location[:2] = place.tolist()
        handle.empty.rotation_euler.z = angle[at]
    scene.run(bpy.ops.lissom.pose_apply, object=obj.name, name="curled", value=0.0)
    scene.run(bpy.ops.lissom.pose_unbind, object=obj.name)


def _shape(obj, values):
    mesh = scene.posed(obj, {**dict.fromkeys(WAYS, 0.0), **values})
    shape = scene.positions(mesh.vertices)
    bpy.data.meshes.remove(mesh)
    return shape


def _areas(obj, shape):
    a, b, c = (shape[scene.triangles(obj)[:, k], :2] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _tile(obj, slider, time):
    """The mesh upright, its material as the slider has it."""
    mesh = scene.posed(obj, {**dict.fromkeys(WAYS, 0.0), slider: time})
    mesh.transform(Matrix.Rotation(np.pi / 2, 4, "X"))
    material = obj.active_material.copy()
    material.node_tree.animation_data_clear()
    material.node_tree.nodes["Dissolve"].outputs[0].default_value = time
    mesh.materials[0] = material
    return Tile([mesh], f"{slider}, {time:g}", (0.0, -0.12), HEIGHT * 1.15)
