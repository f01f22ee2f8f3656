"""Scenes for the tests, and what Blender shows of them."""

import contextlib

import bmesh
import bpy
import numpy as np


class Pause:
    """A job that is done at once."""

    done = True

    def __init__(self, fraction, stage):
        self.progress = (fraction, stage)

    def cancel(self):
        pass

    def result(self):
        return None


def by_turns(cases):
    """Of cases that ask more of the core than of Blender every other one: 5.2 takes what 4.2 has left out."""
    turns = {(4, 2): slice(0, None, 2), (5, 2): slice(1, None, 2)}
    return list(cases)[turns.get(bpy.app.version[:2], slice(None))]


def monkey(levels=2, name="Monkey"):
    """Suzanne, subdivided: 7,958 vertices at two levels, quads and a few triangles, eyes as loose parts."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.object
    obj.name = obj.data.name = name
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    return obj


def mesh_object(name, vertices, triangles):
    """An object of (n, 3) vertices and (m, 3) triangles."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], np.asarray(triangles).tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj


def tube(rings=60, around=40, name="Tube"):
    """An open cylinder of quads along z, length 6, radius 1: one piece, (rings + 1) * around vertices."""
    angles = 2 * np.pi * np.arange(around) / around
    heights = np.linspace(-3, 3, rings + 1)
    vertices = [(np.cos(a), np.sin(a), z) for z in heights for a in angles]
    faces = [
        (
            r * around + i,
            r * around + (i + 1) % around,
            (r + 1) * around + (i + 1) % around,
            (r + 1) * around + i,
        )
        for r in range(rings)
        for i in range(around)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def group(obj, name, where):
    """A vertex group of the vertices whose rest position fulfils ``where``; returns their indices."""
    members = [vertex.index for vertex in obj.data.vertices if where(vertex.co)]
    obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    return np.array(members)


def bound_tube(by_itself=False, **options):
    """A tube with a handle at either end, bound; ``by_itself`` turns those that are only moved."""
    obj = tube(**options)
    group(obj, "bottom", lambda co: co.z < -2.5)
    group(obj, "top", lambda co: co.z > 2.5)
    for name in ("bottom", "top"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    for handle in obj.lissom_pose.handles:
        handle.turns_by_itself = by_itself
    bpy.ops.lissom.pose_bind(object=obj.name)
    return obj


def empty(obj, handle):
    """The Empty of a handle."""
    return obj.lissom_pose.handles[handle].empty


def select(obj, vertices, mode="OBJECT"):
    """Selects just these vertices, as an artist does, and leaves the object in ``mode``."""
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    edit.verts.ensure_lookup_table()
    bpy.ops.mesh.select_all(action="DESELECT")
    for vertex in vertices:
        edit.verts[vertex].select_set(True)
    bmesh.update_edit_mesh(obj.data)
    bpy.ops.object.mode_set(mode=mode)


def points(key):
    """(n, 3) of a shape key or of a mesh's vertices."""
    positions = np.empty(3 * len(key), dtype=np.float32)
    key.foreach_get("co", positions)
    return positions.reshape(-1, 3).astype(float)


def key_points(obj, name):
    """(n, 3) absolute positions of a shape key."""
    return points(obj.data.shape_keys.key_blocks[name].data)


def shown(obj):
    """(n, 3): what Blender shows of the object, in its own coordinates."""
    graph = bpy.context.evaluated_depsgraph_get()
    return points(obj.evaluated_get(graph).data.vertices)


def add_key(obj, name, positions, **settings):
    """A shape key of absolute positions, value 0 unless told otherwise."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name=name, from_mix=False)
    key.value = 0.0
    key.data.foreach_set("co", np.float32(positions).ravel())
    for setting, value in settings.items():
        setattr(key, setting, value)
    return key


def snapshot():
    """Everything of the file that an operator might change, to compare before and after an error."""
    return {
        obj.name: (
            obj.matrix_world.copy().freeze(),
            {name for name in dict(obj) if not name.startswith("lissom_")},  # until 5.0 also registered ones
            obj.lissom_pose.bound,
            tuple(obj.vertex_groups.keys()),
            _keys(obj) if obj.type == "MESH" else None,
        )
        for obj in bpy.data.objects
    } | {"scene": [_marker(row) for row in bpy.context.scene.lissom_transfer.markers]}


def _marker(row):
    return row.name, row.source, row.target, row.mirror, row.place("source"), row.place("target")


def _keys(obj):
    if obj.data.shape_keys is None:
        return None
    return [
        (key.name, key.value, key.mute, key.slider_min, key.slider_max, key.relative_key.name)
        + (points(key.data).tobytes(),)
        for key in obj.data.shape_keys.key_blocks
    ]


@contextlib.contextmanager
def refused(message):
    """The operator inside must fail with this text, and change nothing."""
    before = snapshot()
    try:
        yield
    except RuntimeError as error:
        assert message in str(error), f"expected: {message}\ngot: {error}"
    else:
        raise AssertionError(f"not refused; expected: {message}")
    assert snapshot() == before
