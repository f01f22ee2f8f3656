"""A contact sheet: shapes of one mesh side by side in rows, rendered in one go to a picture file.

By Cycles on the processor, for a Blender without a window has no graphics card to ask. Light comes from
suns alone, without shadows or bounces: nothing is noisy, and a few samples smooth the edges. All that is made
for it is removed again.
"""

import pathlib

import bpy
import numpy as np
from mathutils import Euler

from ..core.files import image_format
from ..core.refused import Refused

WIDTH = 1600  # pixels
SAMPLES = 16
MARGIN = 0.12  # around the largest shape, as a part of it
CAPTION = 0.055  # height of a line, as a part of a tile's
PAPER, INK, CLAY = (0.90, 0.90, 0.885), (0.012, 0.014, 0.018), (0.07, 0.27, 0.31)
SUNS = ((2.6, (52, 0, 38)), (1.0, (65, 0, -55)), (0.5, (120, 0, 10)))  # strength, Euler angles in degrees


def render(obj, rows, path, turn=30.0, tilt=10.0, width=WIDTH):
    """Writes rows of tiles, (label, [(caption, (n, 3) in object coordinates)]) each, as a picture.

    Seen from the front, turned by ``turn`` degrees about the vertical and tilted by ``tilt`` towards the
    camera; the object's rotation and scale are applied.
    """
    kind = image_format(path)
    linear = np.array(obj.matrix_world.to_3x3(), dtype=np.float64)
    tilted, turned = (Euler(np.radians(angles)) for angles in ((tilt, 0, 0), (0, 0, turn)))
    view = np.array(tilted.to_matrix() @ turned.to_matrix())
    placed = [(label, [(text, shape @ (view @ linear).T) for text, shape in tiles]) for label, tiles in rows]
    every = [shape for _, tiles in placed for _, shape in tiles]
    low, high = np.min([s.min(axis=0) for s in every], axis=0), np.max([s.max(axis=0) for s in every], axis=0)
    tile = (high - low) * (1 + 2 * MARGIN)
    tile[[0, 2]] = np.maximum(tile[[0, 2]], 0.4 * tile[[0, 2]].max())  # room for words beside slender things
    columns = max(len(tiles) for _, tiles in placed)
    with _Stage(obj, tile[1]) as stage:
        for r, (label, tiles) in enumerate(placed):
            for c, (text, shape) in enumerate(tiles):
                corner = np.array([(c + 0.5) * tile[0], 0.0, -(r + 0.5) * tile[2]])
                stage.shape(shape - 0.5 * (low + high) + corner)
                stage.text(f"{label}, {text}" if label else text, corner, tile[2])
        stage.picture(np.array([columns * tile[0], len(placed) * tile[2]]), path, kind, width)


class _Stage:
    """A scene of its own, looked at along y without perspective."""

    def __init__(self, obj, depth):
        self._source, self._depth = obj.data, depth
        self._made = []  # (collection of bpy.data, block), the last made first to go
        self.scene = self._new("scenes", "Lissom sheet")

    def __enter__(self):
        try:
            self.scene.render.engine = "CYCLES"
        except TypeError:
            raise Refused("The sheet needs Cycles: enable it in Blender's add-ons") from None
        self._settings()
        self._clay, self._ink = self._material("Clay", CLAY, False), self._material("Ink", INK, True)
        return self

    def __exit__(self, *_):
        for where, block in reversed(self._made):
            getattr(bpy.data, where).remove(block)

    def _new(self, where, name, *arguments):
        made = getattr(bpy.data, where).new(name, *arguments)
        self._made.append((where, made))
        return made

    def _add(self, name, data):
        made = self._new("objects", name, data)
        self.scene.collection.objects.link(made)
        return made

    def _settings(self):
        scene = self.scene
        scene.cycles.device = "CPU"
        scene.cycles.samples = SAMPLES
        scene.cycles.use_denoising = False
        scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
        scene.cycles.max_bounces = 0
        scene.view_settings.view_transform = "Standard"
        scene.world = world = self._new("worlds", "Lissom sheet")
        if world.node_tree is None:
            world.use_nodes = True
        background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value = (*PAPER, 1.0)
        seen = world.node_tree.nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"]
        world.node_tree.links.new(seen, background.inputs["Strength"])  # paper, but no light
        for strength, degrees in SUNS:
            light = self._new("lights", "Sun", "SUN")
            light.energy, light.angle, light.use_shadow = strength, 0.0, False
            self._add("Sun", light).rotation_euler = Euler(np.radians(degrees))

    def _material(self, name, colour, flat):
        made = self._new("materials", name)
        if made.node_tree is None:
            made.use_nodes = True
        nodes = made.node_tree.nodes
        nodes.clear()
        shader = nodes.new("ShaderNodeEmission" if flat else "ShaderNodeBsdfDiffuse")
        shader.inputs["Color"].default_value = (*colour, 1.0)
        made.node_tree.links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        return made

    def shape(self, vertices):
        """Adds the mesh at (n, 3) positions."""
        source, mesh = self._source, self._new("meshes", "Shape")
        mesh.vertices.add(len(source.vertices))
        mesh.loops.add(len(source.loops))
        mesh.polygons.add(len(source.polygons))
        for one, other, name, kind, size in (
            (source.loops, mesh.loops, "vertex_index", np.int32, len(source.loops)),
            (source.polygons, mesh.polygons, "loop_start", np.int32, len(source.polygons)),
            (source.polygons, mesh.polygons, "use_smooth", bool, len(source.polygons)),
        ):
            values = np.empty(size, dtype=kind)
            one.foreach_get(name, values)
            other.foreach_set(name, values)
        mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, dtype=np.float32).ravel())
        mesh.update(calc_edges=True)
        mesh.materials.append(self._clay)
        self._add("Shape", mesh)

    def text(self, words, corner, height):
        """Adds a caption at the foot of the tile that is centred at ``corner``."""
        curve = self._new("curves", "Caption", "FONT")
        curve.body, curve.size, curve.align_x = words, CAPTION * height, "CENTER"
        curve.materials.append(self._ink)
        made = self._add("Caption", curve)
        made.location = corner + [0, -self._depth, -0.5 * height + 0.4 * CAPTION * height]
        made.rotation_euler = (np.pi / 2, 0, 0)

    def picture(self, size, path, kind, width):
        """Renders what lies between (0, 0) and (size, -size)."""
        camera = self._new("cameras", "Camera")
        camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", float(size.max()), 10 * self._depth + 1
        camera.clip_start = 1e-4 * self._depth
        made = self._add("Camera", camera)
        made.location = (0.5 * size[0], -3 * self._depth, -0.5 * size[1])
        made.rotation_euler = (np.pi / 2, 0, 0)
        scene, render = self.scene, self.scene.render
        scene.camera = made
        render.resolution_x, render.resolution_y = width, max(1, round(width * size[1] / size[0]))
        render.resolution_percentage = 100
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "IMAGE"
        render.image_settings.file_format = kind
        render.filepath, render.use_file_extension = str(pathlib.Path(path).resolve()), False
        bpy.ops.render.render(scene=scene.name, write_still=True)
