"""Drawings: images as alpha, flat meshes of them, and the material that shows one or dissolves between two.

A mesh lies in its object's plane z = 0, the middle of the image at the origin. Where on that plane the image
is, the mesh itself tells by its UVs, so that it may be scaled and moved. A second image lies on the same
plane with its middle on the first one's and its pixels as large.
"""

import pathlib

import bpy
import numpy as np

from ..core import easing
from ..core.easing import EASINGS
from ..core.refused import Refused
from . import animation, meshes, shape_keys, sliders

UV, SECOND_UV = "Image", "Second Image"  # UV maps, and the nodes with the images
DISSOLVE = 'nodes["Dissolve"].outputs[0].default_value'


def find(name, path=""):
    """The image datablock of that name, or the one of a file."""
    if name:
        image = bpy.data.images.get(name)
        if image is None:
            raise Refused(f"There is no image named '{name}'")
    elif path and pathlib.Path(bpy.path.abspath(path)).is_file():
        try:
            image = bpy.data.images.load(path, check_existing=True)
        except RuntimeError as error:
            raise Refused(f"'{path}' cannot be read as an image") from error
    else:
        raise Refused(f"There is no file '{path}'" if path else "Choose an image first")
    if not image.has_data and not image.size[0]:
        raise Refused(f"Image '{image.name}' has no pixels: is its file there?")
    return image


def alpha(image):
    """(h, w) opacity of the pixels, the top row first; 1 where the image has none."""
    width, height = image.size
    if image.channels != 4 or image.alpha_mode == "NONE":
        return np.ones((height, width))
    flat = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(flat)
    return np.clip(flat[3::4].reshape(height, width)[::-1], 0.0, 1.0).astype(np.float64)


def make(image, made, height):
    """A mesh object of a lissom.ImageMesh, the image ``height`` scene units high, at the 3D cursor."""
    size = np.array(image.size, dtype=np.float64)
    place = np.zeros((len(made.uv), 3))
    place[:, :2] = (made.uv - 0.5) * size * (height / size[1])
    mesh = bpy.data.meshes.new(image.name)
    mesh.from_pydata(place, [], made.triangles.tolist(), shade_flat=True)
    _set_uv(mesh, UV, made.uv)
    mesh.materials.append(_material(image))
    obj = bpy.data.objects.new(image.name, mesh)
    bpy.context.collection.objects.link(obj)
    obj.location = bpy.context.scene.cursor.location
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def lay(obj, image, arc):
    """Lays a second image under the end key of an arc, whose slider dissolves into it; returns warnings.

    A second UV map has the places of the end key in that image, the material shows both.
    """
    texture = _image_of(obj)
    if obj.data.uv_layers.get(UV) is None or texture is None:
        raise Refused(f"'{obj.name}' is no mesh of an image: make one by Image Mesh first")
    tree = _own_material(obj).node_tree
    _second(tree, texture, image)
    return _follow(obj, tree, arc)


def lay_again(obj, arc):
    """Has the second image, where the arc's slider dissolves into one, follow an arc that was baked anew."""
    warnings = []
    for tree in _dissolving(obj, arc.name):
        warnings += _follow(obj, tree, arc)
    return warnings


def take_away(obj, slider):
    """Leaves the first image alone where the slider that dissolves into the second is gone."""
    for tree in _dissolving(obj, slider):
        tree.driver_remove(DISSOLVE)
        _alone(tree, tree.nodes[UV].image)
        second = obj.data.uv_layers.get(SECOND_UV)
        if second is not None:
            obj.data.uv_layers.remove(second)


def _dissolving(obj, slider):
    """Node trees of the object's materials whose dissolve this slider drives."""
    trees = {slot.material.node_tree for slot in obj.material_slots if slot.material}
    return [
        tree
        for tree in filter(None, trees)
        if {UV, SECOND_UV} <= set(tree.nodes.keys())
        and animation.driven_by(tree, DISSOLVE, obj, sliders.data_path(slider))
    ]


def _follow(obj, tree, arc):
    """Second UV map and dissolve, by the end key and the easing of an arc; returns warnings."""
    mesh, first, second = obj.data, tree.nodes[UV].image, tree.nodes[SECOND_UV].image
    if mesh.uv_layers.get(UV) is None or first is None or second is None:
        return []
    uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
    mesh.uv_layers[UV].data.foreach_get("uv", uv)
    rest = meshes.rest_positions(mesh)[meshes.corners(mesh)]
    # The image's place on the plane: an affine map that the first UVs give away.
    known = np.column_stack([rest[:, :2], np.ones(len(rest))])
    to_uv = np.linalg.lstsq(known, uv.reshape(-1, 2), rcond=None)[0]
    posed = shape_keys.seen(obj, shape_keys.find(obj, arc.end))
    sizes = np.array(first.size, dtype=np.float64) / np.array(second.size)
    places = 0.5 + ((np.column_stack([posed[:, :2], np.ones(len(posed))]) @ to_uv) - 0.5) * sizes
    _set_uv(mesh, SECOND_UV, places)
    curve = EASINGS[arc.easing]
    ends = np.array([0.0, 1.0])
    shape = easing.bezier(ends, ends, curve.slope(ends), curve.slope(ends))
    sliders.drive(tree, DISSOLVE, obj, arc.name, shape)
    outside = np.flatnonzero(((places < 0) | (places > 1)).any(1))
    if not len(outside):
        return []
    return [f"{len(outside)} vertices lie beyond '{second.name}' at the end: they fade out"]


def _set_uv(mesh, name, uv):
    """A UV map of (n, 2) places of vertices."""
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    if layer is None:
        raise Refused("The mesh has as many UV maps as it can: remove one first")
    layer.data.foreach_set("uv", uv[meshes.corners(mesh)].astype(np.float32).ravel())


def _image_of(obj):
    material = obj.active_material
    node = material.node_tree.nodes.get(UV) if material is not None and material.node_tree else None
    return getattr(node, "image", None)


def _own_material(obj):
    """The material, made the object's alone: its dissolve follows this object's slider."""
    material = obj.active_material
    if material.users > 1:
        obj.active_material = material = material.copy()
    return material


def _material(image):
    material = bpy.data.materials.new(image.name)
    if material.node_tree is None:  # before 5.0
        material.use_nodes = True
    material.surface_render_method = "BLENDED"
    _alone(material.node_tree, image)
    return material


def _alone(tree, image):
    """One drawing in place of what the material had."""
    nodes, links = tree.nodes, tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    output.location = (300, 0)
    links.new(_drawn(tree, UV, image, 0), output.inputs["Surface"])


def _second(tree, first, image):
    """Both drawings and the mix between them, in place of what the material had."""
    nodes, links = tree.nodes, tree.links
    nodes.clear()
    output, mix, value = (nodes.new(f"ShaderNode{kind}") for kind in ("OutputMaterial", "MixShader", "Value"))
    value.name = value.label = "Dissolve"
    output.location, mix.location, value.location = (500, 0), (300, 0), (100, 200)
    links.new(value.outputs[0], mix.inputs[0])
    links.new(_drawn(tree, UV, first, 0), mix.inputs[1])
    links.new(_drawn(tree, SECOND_UV, image, -500), mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])


def _drawn(tree, uv, image, y):
    """The output of nodes that show an image as it is, whatever the light, and nothing where it is clear."""
    nodes, links = tree.nodes, tree.links
    kinds = ("UVMap", "TexImage", "Emission", "BsdfTransparent", "MixShader")
    places, texture, colour, clear, mix = (nodes.new(f"ShaderNode{kind}") for kind in kinds)
    for node, x, lower in ((places, -700, 0), (texture, -500, 0), (colour, -200, 0), (clear, -200, 150)):
        node.location = (x, y - lower)
    mix.location = (50, y)
    places.uv_map, texture.name, texture.label = uv, uv, uv
    texture.image, texture.extension = image, "CLIP"
    links.new(places.outputs[0], texture.inputs[0])
    links.new(texture.outputs["Color"], colour.inputs["Color"])
    links.new(clear.outputs[0], mix.inputs[1])
    links.new(colour.outputs[0], mix.inputs[2])
    links.new(texture.outputs["Alpha"], mix.inputs[0])
    return mix.outputs[0]
