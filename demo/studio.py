"""The pictures: every tile is one small render in a scene of its own, and a sheet is tiles side by side.

A film is sheets one after another.

Tiles are seen through an orthographic camera along y, so that a figure has the same size in all of them.
"""

import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Vector

BACKGROUND = (0.90, 0.90, 0.885)
INK = (0.012, 0.014, 0.018)
SAMPLES = 16
GUTTER = 10  # pixels between tiles
WIDTH = 720  # of a film, in pixels
COLOURS = 128  # of a film: enough for two skins in one light, and small


@dataclass
class Tile:
    """What one tile shows.

    ``meshes`` are shown with the materials they have, turned by ``turn`` degrees about z, the vertical, and
    framed by ``centre`` (x, z) and ``height`` in scene units, label included. ``marks`` are spheres:
    position, radius, material.
    """

    meshes: list
    label: str
    centre: tuple[float, float]
    height: float
    turn: float = 0.0
    note: str = ""
    marks: list = field(default_factory=list)
    text: float = 1.0  # size of the letters


class Studio:
    """A scene with light and camera, made for the renders and removed with ``close``."""

    def __init__(self, samples=SAMPLES):
        self.scene = scene = bpy.data.scenes.new("Studio")
        scene.render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.samples = samples
        scene.cycles.use_adaptive_sampling = True
        scene.cycles.adaptive_threshold = 0.03
        scene.cycles.use_denoising = True
        scene.cycles.max_bounces = 3
        scene.render.use_persistent_data = True
        scene.view_settings.view_transform = "Standard"
        scene.render.image_settings.file_format = "PNG"
        scene.world = self._world = _world()
        self._lights = [
            self._sun("Key", 2.3, (52, 0, 38), 22, (1.0, 0.955, 0.90)),
            self._sun("Fill", 0.25, (65, 0, -55), 60, (0.86, 0.93, 1.0)),
            self._sun("Rim", 1.6, (-62, 0, 155), 15, (1.0, 1.0, 1.0)),
        ]
        camera = bpy.data.cameras.new("Studio camera")
        camera.type = "ORTHO"
        camera.clip_end = 200.0
        self._camera = self._add("Studio camera", camera)
        self._camera.rotation_euler = Euler((np.pi / 2, 0, 0))
        scene.camera = self._camera
        self.seconds = 0.0
        self._ink, self._paper = _flat("Ink", INK), _flat("Paper", BACKGROUND)

    def close(self):
        """Removes the scene and all that was made for it."""
        for data in [*self._lights, self._camera]:
            _remove(data)
        bpy.data.materials.remove(self._ink)
        bpy.data.materials.remove(self._paper)
        bpy.data.worlds.remove(self._world)
        bpy.data.scenes.remove(self.scene)

    def sheet(self, rows, path, aspect=1.2, width=1600, samples=None):
        """Renders rows of tiles of one ``aspect`` (height by width) to a file; removes their meshes."""
        started = time.perf_counter()
        usual = self.scene.cycles.samples
        self.scene.cycles.samples = min(samples or usual, usual)
        write(self._sheet(rows, aspect, width), path)
        self.scene.cycles.samples = usual
        self.seconds += time.perf_counter() - started

    def film(self, frames, path, aspect=1.2, back=False):
        """Renders frames, each a row of tiles, to a GIF that plays for ever, with ``back`` to and fro.

        Removes their meshes; ``frames`` may be a generator, so that those of one frame are there at a time.
        """
        from PIL import Image  # here, so that tests and pictures do without

        started = time.perf_counter()
        usual, self.scene.cycles.samples = self.scene.cycles.samples, min(self.scene.cycles.samples, 6)
        shown = [
            Image.fromarray(np.round(255 * self._sheet([row], aspect, WIDTH)[..., :3]).astype(np.uint8))
            for row in frames
        ]
        self.scene.cycles.samples = usual
        if back:
            shown += shown[::-1]
        palette = Image.fromarray(np.concatenate([np.asarray(picture) for picture in shown[::3]]))
        palette = palette.quantize(COLOURS, Image.Quantize.MEDIANCUT)
        first, *others = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in shown)
        first.save(path, save_all=True, append_images=others, duration=80, loop=0, optimize=True)
        self.seconds += time.perf_counter() - started

    def _sheet(self, rows, aspect, width):
        """Pixels of rows of tiles; their meshes are removed."""
        columns = max(len(row) for row in rows)
        tile_width = width // columns
        size = tile_width - GUTTER, int(tile_width * aspect) - GUTTER
        sheet = [np.concatenate([_framed(self._render(tile, *size)) for tile in row], axis=1) for row in rows]
        for mesh in {mesh for row in rows for tile in row for mesh in tile.meshes}:
            bpy.data.meshes.remove(mesh)
        return np.concatenate(sheet, axis=0)

    def _render(self, tile, width, height):
        shown = [self._add("Figure", mesh) for mesh in tile.meshes]
        for obj in shown:
            obj.rotation_euler.z = np.radians(tile.turn)
        shown += [self._ball(*mark, tile.turn) for mark in tile.marks]
        x, z = tile.centre
        self._camera.location = (x, -60.0, z)
        self._camera.data.ortho_scale = tile.height * max(1.0, width / height)
        unit = tile.height
        bottom = z - 0.5 * tile.height
        letter = tile.text * unit
        shown.append(self._plate(x, bottom, unit * max(1.0, width / height), 0.125 * letter))
        shown.append(self._text(tile.label, x, bottom + 0.062 * letter, 0.052 * letter))
        if tile.note:
            shown.append(self._text(tile.note, x, bottom + 0.018 * letter, 0.040 * letter))
        self.scene.render.resolution_x, self.scene.render.resolution_y = width, height
        pixels = self._pixels()
        for obj in shown:
            _remove(obj, keep=obj.data in tile.meshes)
        return pixels

    def _pixels(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "tile.png"
            self.scene.render.filepath = str(path)
            bpy.ops.render.render(scene=self.scene.name, write_still=True)
            return read(path)

    def _add(self, name, data):
        made = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(made)
        return made

    def _sun(self, name, strength, degrees, size, colour):
        light = bpy.data.lights.new(name, "SUN")
        light.energy, light.angle, light.color = strength, np.radians(size), colour
        made = self._add(name, light)
        made.rotation_euler = Euler(np.radians(degrees))
        return made

    def _text(self, text, x, z, size):
        curve = bpy.data.curves.new("Label", "FONT")
        curve.body, curve.size, curve.align_x = text, size, "CENTER"
        curve.materials.append(self._ink)
        made = self._add("Label", curve)
        made.location, made.rotation_euler = (x, -50.0, z), (np.pi / 2, 0, 0)
        made.visible_shadow = made.visible_diffuse = made.visible_glossy = False
        return made

    def _plate(self, x, bottom, unit, top):
        """The strip under the figure that the label stands on."""
        mesh = bpy.data.meshes.new("Plate")
        corners = [
            (-unit, 0, -0.1 * unit),
            (unit, 0, -0.1 * unit),
            (unit, 0, top),
            (-unit, 0, top),
        ]
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        mesh.materials.append(self._paper)
        made = self._add("Plate", mesh)
        made.location = (x, -45.0, bottom)
        made.visible_shadow = made.visible_diffuse = made.visible_glossy = False
        return made

    def _ball(self, position, radius, material, turn):
        mesh = bpy.data.meshes.new("Mark")
        points, faces = _octasphere(3)
        mesh.from_pydata((points * radius).tolist(), [], faces)
        mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
        mesh.materials.append(material)
        made = self._add("Mark", mesh)
        made.location = Euler((0, 0, np.radians(turn))).to_matrix() @ _vector(position)
        return made


def _framed(pixels):
    """Pixels with half a gutter of the background around them."""
    framed = np.pad(pixels, ((GUTTER // 2,) * 2, (GUTTER // 2,) * 2, (0, 0)))
    linear = np.array(BACKGROUND)
    border = np.append(1.055 * linear ** (1 / 2.4) - 0.055, 1.0)  # sRGB
    inner = np.zeros(framed.shape[:2], dtype=bool)
    inner[GUTTER // 2 : -(GUTTER // 2), GUTTER // 2 : -(GUTTER // 2)] = True
    framed[~inner] = border
    return framed


def write(pixels, path, quality=90):
    """Writes (height, width, 4) display values, top row first; the suffix decides: .png or .jpg."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("sheet", width, height, alpha=False)
    image.pixels.foreach_set(np.ascontiguousarray(pixels[::-1], dtype=np.float32).ravel())
    image.file_format = "JPEG" if path.suffix == ".jpg" else "PNG"
    image.save(filepath=str(path), quality=quality)
    bpy.data.images.remove(image)


def read(path):
    """Reads an image as (height, width, 4) display values, top row first."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    flat = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(height, width, 4)[::-1]


def publish(picture, copy):
    """Writes a small JPEG copy of a picture."""
    copy.parent.mkdir(parents=True, exist_ok=True)
    write(read(picture), copy, quality=86)


def _world():
    """Soft light from everywhere, while the camera sees the plain background."""
    world = bpy.data.worlds.new("Studio")
    if not world.use_nodes:
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    light, seen = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeBackground")
    light.inputs["Color"].default_value = (0.93, 0.96, 1.0, 1.0)
    light.inputs["Strength"].default_value = 0.28
    seen.inputs["Color"].default_value = (*BACKGROUND, 1.0)
    ray, mix = nodes.new("ShaderNodeLightPath"), nodes.new("ShaderNodeMixShader")
    links.new(ray.outputs["Is Camera Ray"], mix.inputs[0])
    links.new(light.outputs[0], mix.inputs[1])
    links.new(seen.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    return world


def _flat(name, colour):
    """A material of one colour whatever the light."""
    made = bpy.data.materials.new(name)
    if not made.use_nodes:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*colour, 1.0)
    links.new(emission.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def _octasphere(level):
    """Points on the unit sphere and triangles: an octahedron, each face split in four ``level`` times."""
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(level):
        middle = {}

        def between(a, b, middle=middle):
            edge = (min(a, b), max(a, b))
            if edge not in middle:
                middle[edge] = len(points)
                points.append(tuple(np.add(points[a], points[b]) / 2))
            return middle[edge]

        split = []
        for a, b, c in faces:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = split
    points = np.array(points, dtype=np.float64)
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


def _vector(position):
    return Vector(np.asarray(position, dtype=np.float64).tolist())


_DATA_OF_TYPE = {"MESH": "meshes", "FONT": "curves", "LIGHT": "lights", "CAMERA": "cameras"}


def _remove(obj, keep=False):
    kind, data = _DATA_OF_TYPE[obj.type], obj.data
    bpy.data.objects.remove(obj)
    if not keep:
        getattr(bpy.data, kind).remove(data)
