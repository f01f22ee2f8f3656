"""Objects of the demo's scene, and their vertices as arrays."""

import bpy
import numpy as np

SKIN, MOUTH, TEETH, WHITE, IRIS, PUPIL = range(6)
MATERIAL_OF_PART = {
    "face": SKIN, "head_and_neck": SKIN, "mouth_socket": MOUTH, "eye_sockets": SKIN, "gums_and_tongue": MOUTH,
    "teeth": TEETH, "eyeball_left": WHITE, "eyeball_right": WHITE,
}  # fmt: skip

# Half the angle that iris and pupil take of the eyeball, in degrees.
IRIS_ANGLE, PUPIL_ANGLE = 28.0, 11.0


def run(operator, **properties):
    """Calls an operator; anything but {'FINISHED'} is an error."""
    answer = operator(**properties)
    if answer != {"FINISHED"}:
        raise RuntimeError(f"{operator.idname_py()} answered {answer}")


def collection(name):
    """A new collection of the scene."""
    made = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(made)
    return made


def face_object(name, face, vertices, skin, into, location):
    """A mesh object with the face's polygons, materials and the given (n, 3) positions."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(len(face.loops))
    mesh.loops.foreach_set("vertex_index", face.loops)
    mesh.polygons.add(len(face.counts))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(face.counts) - face.counts).astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(face.counts), dtype=bool))
    mesh.update(calc_edges=True)
    for material in (skin, *anatomy()):
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", _material_indices(face))
    made = bpy.data.objects.new(name, mesh)
    made.location = location
    into.objects.link(made)
    return made


def add_keys(obj, rest, offsets):
    """Shape keys Basis and rest + offset for each name, all at value 0."""
    obj.shape_key_add(name="Basis", from_mix=False)
    for name, offset in offsets.items():
        key = obj.shape_key_add(name=name, from_mix=False)
        key.data.foreach_set("co", (rest + offset).astype(np.float32).ravel())
        key.value = 0.0


def vertices(obj):
    """(n, 3) rest positions."""
    return _positions(obj.data.vertices)


def key_vertices(obj, name):
    """(n, 3) positions of a shape key."""
    return _positions(obj.data.shape_keys.key_blocks[name].data)


def triangles(obj):
    """(m, 3) vertex indices of Blender's own triangulation."""
    obj.data.calc_loop_triangles()
    indices = np.empty(3 * len(obj.data.loop_triangles), dtype=np.int32)
    obj.data.loop_triangles.foreach_get("vertices", indices)
    return indices.reshape(-1, 3)


def components(mesh):
    """(n,) a label for every vertex, the same for all vertices of a connected component."""
    edges = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.edges.foreach_get("vertices", edges)
    a, b = edges.reshape(-1, 2).T
    label = np.arange(len(mesh.vertices))
    while True:
        lower = np.minimum(label[a], label[b])
        before = label.copy()
        np.minimum.at(label, a, lower)
        np.minimum.at(label, b, lower)
        label = label[label]
        if np.array_equal(before, label):
            return label


def diagonal(positions):
    """Length of the diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(positions, axis=0)))


def posed(obj, values):
    """A mesh of the object as its shape keys show it at the given values, all other keys at 0.

    The caller removes it. Values may also name custom properties of the object, such as sliders.
    """
    keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
    for key in list(keys)[1:]:
        key.value = 0.0
    for name, value in values.items():
        if name in keys:
            keys[name].value = value
        else:
            obj[name] = value
    obj.update_tag()
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    return bpy.data.meshes.new_from_object(obj.evaluated_get(graph), depsgraph=graph)


def _positions(collection_of_points):
    flat = np.empty(3 * len(collection_of_points), dtype=np.float32)
    collection_of_points.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def anatomy():
    """The materials of MOUTH and what follows; slot SKIN comes before them."""
    return (
        material("Mouth", (0.42, 0.13, 0.12), 0.4),
        material("Teeth", (0.80, 0.76, 0.66), 0.3),
        material("Eye white", (0.85, 0.84, 0.82), 0.15),
        material("Iris", (0.10, 0.16, 0.17), 0.15),
        material("Pupil", (0.01, 0.01, 0.01), 0.1),
    )


def material(name, colour, roughness=0.5):
    """The material of that name; made with a linear RGB colour where there is none yet."""
    made = bpy.data.materials.get(name)
    if made is None:
        made = bpy.data.materials.new(name)
        if not made.use_nodes:
            made.use_nodes = True
        surface = made.node_tree.nodes["Principled BSDF"]
        surface.inputs["Base Color"].default_value = (*colour, 1.0)
        surface.inputs["Roughness"].default_value = roughness
        made.diffuse_color = (*colour, 1.0)
    return made


def _material_indices(face):
    indices = np.array([MATERIAL_OF_PART[part] for part in face.polygon_part], dtype=np.int32)
    first = np.cumsum(face.counts) - face.counts
    centres = np.add.reduceat(face.neutral[face.loops], first) / face.counts[:, None]
    for eyeball in ("eyeball_left", "eyeball_right"):
        ball = face.neutral[face.vertex_part == eyeball]
        gaze = centres - (ball.min(axis=0) + ball.max(axis=0)) / 2
        angle = np.degrees(np.arccos(-gaze[:, 1] / np.linalg.norm(gaze, axis=1)))
        of_eye = face.polygon_part == eyeball
        indices[of_eye & (angle < IRIS_ANGLE)] = IRIS
        indices[of_eye & (angle < PUPIL_ANGLE)] = PUPIL
    return indices
