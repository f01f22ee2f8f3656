"""Vertex groups, UV maps and colour attributes as arrays, of one mesh object or of several as one mesh."""

from typing import NamedTuple

import numpy as np

from ..core import space
from ..core.refused import Refused
from . import colours
from .meshes import corners, polygons_of_triangles

MOST_UV_MAPS = 8  # Blender makes no more, and says nothing


class Layer(NamedTuple):
    """What tells one layer from another: "UV", or the domain of a colour attribute; its name and its type."""

    kind: str
    name: str
    type: str = ""

    @property
    def channels(self):
        """Numbers at each vertex or corner."""
        return 2 if self.kind == "UV" else 4


def layers(objects, uv_maps, colour_attributes):
    """The layers that any of the objects has, each name once, in their order."""
    found = {}
    for obj in objects:
        if uv_maps:
            for layer in obj.data.uv_layers:
                found.setdefault(("UV", layer.name), Layer("UV", layer.name))
        for layer in obj.data.color_attributes if colour_attributes else ():
            if layer.name != colours.NAME:
                made = Layer(layer.domain, layer.name, layer.data_type)
                found.setdefault(("COLOUR", layer.name), made)
    return list(found.values())


def has_any(objects):
    """Whether there is anything to carry over."""
    return any(obj.vertex_groups for obj in objects) or bool(layers(objects, True, True))


def read(objects, layer):
    """(n, k) of a layer of points, (c, k) of one of corners; 0 on objects without one of that kind."""
    return np.concatenate([_read(obj.data, layer) for obj in objects])


def _data(mesh, layer):
    """Where Blender keeps the numbers, and what it calls them; None where there is no such layer."""
    if layer.kind == "UV":
        found = mesh.uv_layers.get(layer.name)
        return found and (found.uv, "vector")
    found = mesh.color_attributes.get(layer.name)
    return (found.data, "color") if found and found.domain == layer.kind else None


def _read(mesh, layer):
    count = len(mesh.vertices) if layer.kind == "POINT" else len(mesh.loops)
    values = np.zeros(count * layer.channels, dtype=np.float32)
    data = _data(mesh, layer)
    if data:
        data[0].foreach_get(data[1], values)
    return values.reshape(count, layer.channels).astype(np.float64)


def write(obj, layer, name, values):
    """Writes (n, k) or (c, k) under a name, which a layer of that kind may have already."""
    mesh, layer = obj.data, layer._replace(name=name)
    if not _data(mesh, layer):
        if layer.kind == "UV":
            mesh.uv_layers.new(name=name, do_init=False)
        else:
            mesh.color_attributes.new(name, layer.type, layer.kind)
    data, field = _data(mesh, layer)
    data.foreach_set(field, np.ascontiguousarray(values, dtype=np.float32).ravel())
    mesh.update()


def taken(obj):
    """Names that a new layer cannot have."""
    return {attribute.name for attribute in obj.data.attributes} | set(obj.data.uv_layers.keys())


def refuse_other_kinds(obj, layer, name):
    """Refused where the name is taken by something that such a layer cannot be written to."""
    there = name in obj.data.attributes or name in obj.data.uv_layers
    if there and not _data(obj.data, layer._replace(name=name)):
        raise Refused(
            f"'{obj.name}' has an attribute '{name}' of another kind: rename it first, or set If Exists to "
            "Rename"
        )


def refuse_too_many(obj, plan):
    """Refused where there is no room for the new UV maps of {layer: name}."""
    new = {name for layer, name in plan.items() if layer.kind == "UV"} - set(obj.data.uv_layers.keys())
    if len(obj.data.uv_layers) + len(new) > MOST_UV_MAPS:
        raise Refused(
            f"'{obj.name}' would have {len(obj.data.uv_layers) + len(new)} UV maps, and Blender has room for "
            f"{MOST_UV_MAPS}: remove some first"
        )


def triangle_corners(objects, linears):
    """(m, 3): the corners, counted through, of all triangles; (m,): their polygons, counted through.

    As bridge.assembly has triangles: those of an object mirrored by ``linears`` (3, 3) are turned around.
    """
    found, polygons, corner, polygon = [], [], 0, 0
    for obj, linear in zip(objects, linears, strict=True):
        mesh = obj.data
        mesh.calc_loop_triangles()
        loops = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("loops", loops)
        found.append(space.outward(linear, loops.reshape(-1, 3)) + corner)
        polygons.append(polygons_of_triangles(mesh) + polygon)
        corner, polygon = corner + len(corners(mesh)), polygon + len(mesh.polygons)
    return np.concatenate(found), np.concatenate(polygons)


def weights(objects):
    """The names of all vertex groups, and (n, k): the weight of every vertex in each."""
    names = list(dict.fromkeys(group.name for obj in objects for group in obj.vertex_groups))
    column = {name: place for place, name in enumerate(names)}
    found = np.zeros((sum(len(obj.data.vertices) for obj in objects), len(names)))
    start = 0
    for obj in objects:
        columns = [column[group.name] for group in obj.vertex_groups]
        for vertex in obj.data.vertices:
            for element in vertex.groups:
                if element.group < len(columns):
                    found[start + vertex.index, columns[element.group]] = element.weight
        start += len(obj.data.vertices)
    return names, found


def write_weights(obj, name, values):
    """Makes a vertex group hold (n,) weights, and no vertex of weight 0; made where there is none."""
    group = obj.vertex_groups.get(name)
    if group is None:
        group = obj.vertex_groups.new(name=name)
    else:
        group.remove(range(len(obj.data.vertices)))
    for index in np.flatnonzero(values > 0).tolist():
        group.add([index], float(min(values[index], 1.0)), "REPLACE")
