"""Mesh data as arrays."""

from dataclasses import dataclass, field

import bmesh
import bpy
import numpy as np

from ..core import space, topology
from ..core.refused import Refused


def positions(points):
    """(n, 3) float64 of anything with ``co``: vertices of a mesh or points of a shape key."""
    flat = np.empty(3 * len(points), dtype=np.float32)  # Blender's own precision: a plain copy
    points.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def rest_positions(mesh):
    """(n, 3): the reference shape key where there is one, else the vertices."""
    return positions(mesh.shape_keys.reference_key.points if mesh.shape_keys else mesh.vertices)


def rest_place(mesh, vertex):
    """(x, y, z) of one vertex at rest, or None where there is no such vertex."""
    points = mesh.shape_keys.reference_key.points if mesh.shape_keys else mesh.vertices
    return tuple(points[vertex].co) if vertex < len(points) else None


def triangles(mesh):
    """(m, 3) int32: Blender's own triangulation of the faces."""
    mesh.calc_loop_triangles()
    flat = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", flat)
    return flat.reshape(-1, 3)


def require_vertices(obj):
    """Refused where there is nothing to look at."""
    if not obj.data.vertices:
        raise Refused(f"'{obj.name}' has no vertices: choose another object")


def surface(obj):
    """(vertices, triangles) of an object at rest, in its own coordinates."""
    require_vertices(obj)
    return rest_positions(obj.data), triangles(obj.data)


def polygons_of_triangles(mesh):
    """(m,) int32: the face that each triangle of Blender's own triangulation is part of."""
    mesh.calc_loop_triangles()
    found = np.empty(len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", found)
    return found


def corners(mesh):
    """(c,) int32: the vertex of every corner of every face."""
    return _of_corners(mesh, ".corner_vert", "vertex_index")


def _of_corners(mesh, attribute, own):
    flat = np.empty(len(mesh.loops), dtype=np.int32)
    found = mesh.attributes.get(attribute)
    if found is not None:  # a plain copy, 50 times as fast as the loops' own property
        found.data.foreach_get("value", flat)
    else:  # in edit mode
        mesh.loops.foreach_get(own, flat)
    return flat


def rims(mesh):
    """(r, 2) vertices of the edges that one face has, and (r,) these faces."""
    edges = _of_corners(mesh, ".corner_edge", "edge_index")
    totals = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    rim = np.bincount(edges, minlength=len(mesh.edges))[edges] == 1
    ends = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)[edges[rim]], np.repeat(np.arange(len(totals)), totals)[rim]


def signature(mesh):
    """The hash of the faces (row 26)."""
    starts = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    return topology.signature(len(mesh.vertices), corners(mesh), starts)


def edges(mesh):
    """(m, 2) int32: the two vertices of each edge."""
    ends = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)


def edge_signature(mesh):
    """The hash of the edges: unlike ``signature`` it is the same after flipping faces."""
    ends = np.sort(edges(mesh), axis=1)
    return topology.signature(len(mesh.vertices), ends[np.lexsort(ends.T)], np.empty(0))


def selected_vertices(obj):
    """Indices of the selected vertices, as last seen in edit mode or, where it is in edit mode, now."""
    obj.update_from_editmode()
    flags = np.empty(len(obj.data.vertices), dtype=bool)
    obj.data.vertices.foreach_get("select", flags)
    return np.flatnonzero(flags)


def clicked_vertices(obj):
    """The selected vertices in the order of the clicks, where Blender remembers it; else one alone."""
    chosen = selected_vertices(obj).tolist()
    if obj.mode == "EDIT" and len(chosen) > 1:
        history = bmesh.from_edit_mesh(obj.data).select_history
        clicked = [element.index for element in history if isinstance(element, bmesh.types.BMVert)]
        if sorted(clicked) == chosen:
            return clicked
        raise Refused(
            f"{len(chosen)} vertices of '{obj.name}' are selected, not one by one: "
            "select one vertex on each mesh, or click the vertices one after the other"
        )
    return chosen


def selected_edges(obj):
    """(k, 2) vertices of the selected edges, as last seen in edit mode or, where it is in edit mode, now."""
    obj.update_from_editmode()
    mesh = obj.data
    flags = np.empty(len(mesh.edges), dtype=bool)
    mesh.edges.foreach_get("select", flags)
    return edges(mesh)[flags]


def select_only(obj, vertex):
    """Selects one vertex and nothing else of a mesh, in edit or in object mode."""
    if obj.mode == "EDIT":
        edit = bmesh.from_edit_mesh(obj.data)
        edit.verts.ensure_lookup_table()
        for element in (*edit.faces, *edit.edges, *edit.verts):
            element.select_set(False)
        edit.select_history.clear()
        edit.verts[vertex].select_set(True)
        edit.select_history.add(edit.verts[vertex])
        bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
        return
    select_vertices(obj, {vertex})


def select_vertices(obj, vertices):
    """Selects a set of vertices and nothing else of a mesh in object mode."""
    mesh = obj.data
    chosen = np.zeros(len(mesh.vertices), dtype=bool)
    chosen[list(vertices)] = True
    mesh.vertices.foreach_set("select", chosen)
    # Without the attribute none is selected; writing the selection of edges crashes 5.0.1.
    for name in (".select_edge", ".select_poly"):
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])
    mesh.update()


@dataclass
class Snapshot:
    """A mesh object as arrays, and by name: it outlives undo and deletion of the object."""

    name: str
    library: str | None
    uid: int
    topology: str
    in_scene: bool
    linear: np.ndarray
    vertices: np.ndarray = field(repr=False)
    triangles: np.ndarray = field(repr=False)

    @classmethod
    def of(cls, obj, linear):
        """``linear`` (3, 3) is kept for the way back from solve space."""
        obj.update_from_editmode()
        require_vertices(obj)
        mesh = obj.data
        return cls(
            name=obj.name,
            library=obj.library.filepath if obj.library else None,
            uid=obj.session_uid,
            topology=signature(mesh),
            in_scene=bool(obj.users_scene),
            linear=linear,
            vertices=rest_positions(mesh),
            triangles=triangles(mesh),
        )

    @property
    def key(self):
        """By which bpy.data.objects has it, also beside a linked object of the same name."""
        return self.name, self.library

    def geometry(self):
        """(vertices, triangles) in solve space."""
        return space.into(self.linear, self.vertices), space.outward(self.linear, self.triangles)

    def find(self):
        """The object again, or Refused where it was deleted, replaced or remodelled meanwhile (row 42)."""
        obj = bpy.data.objects.get(self.key)
        if obj is None or obj.session_uid != self.uid or (self.in_scene and not obj.users_scene):
            raise Refused(f"Object '{self.name}' is gone: nothing was changed")
        if signature(obj.data) != self.topology:
            raise Refused(f"The mesh of '{self.name}' was changed meanwhile: nothing was written, run again")
        return obj
