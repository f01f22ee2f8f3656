"""Vertex groups: their members and weights as arrays, and groups made of weights or of the selection."""

import bmesh
import numpy as np

from ..core.refused import Refused
from .meshes import selected_vertices


def weighted_members(obj, names):
    """Sorted vertex indices with a weight above 0, and these weights, by name: {name: ((k,), (k,))}.

    Names without a group are left out.
    """
    wanted = {obj.vertex_groups[name].index: name for name in names if name in obj.vertex_groups}
    found = {name: ([], []) for name in wanted.values()}
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            name = wanted.get(element.group)
            if name is not None and element.weight > 0.0:
                indices, weights = found[name]
                indices.append(vertex.index)
                weights.append(element.weight)
    return {
        name: (np.array(indices, dtype=np.int64), np.array(weights, dtype=np.float64))
        for name, (indices, weights) in found.items()
    }


def members(obj, names):
    """The vertex indices of ``weighted_members`` alone."""
    return {name: indices for name, (indices, _) in weighted_members(obj, names).items()}


def weights(obj, name):
    """(n,): the weight of every vertex in a group, 0 without one."""
    found = np.zeros(len(obj.data.vertices))
    for indices, values in weighted_members(obj, [name]).values():
        found[indices] = values
    return found


def make(obj, name, values):
    """Makes a vertex group of (n,) weights; those of 0 stay out of it."""
    group = obj.vertex_groups.new(name=name)
    for index in np.flatnonzero(values > 0).tolist():
        group.add([index], float(min(values[index], 1.0)), "REPLACE")


def mask(obj, name):
    """The vertices of a group that is named as a mask, (k,); Refused where there is none (row 25)."""
    found = members(obj, [name])
    if name not in found:
        raise Refused(f"'{obj.name}' has no vertex group named '{name}': choose the mask anew, or clear it")
    return found[name]


def from_selection(obj, name):
    """Makes a vertex group of the selected vertices, in edit or in object mode; returns its name."""
    indices = selected_vertices(obj)
    if not len(indices):
        raise Refused(f"No vertex of '{obj.name}' is selected: select some in Edit Mode, then press again")
    group = obj.vertex_groups.new(name=name)
    if obj.mode == "EDIT":
        edit = bmesh.from_edit_mesh(obj.data)
        layer = edit.verts.layers.deform.verify()
        edit.verts.ensure_lookup_table()
        for index in indices:
            edit.verts[index][layer][group.index] = 1.0
        bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
        obj.update_from_editmode()
    else:
        group.add(indices.tolist(), 1.0, "REPLACE")
    return group.name
