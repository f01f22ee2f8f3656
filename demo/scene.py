"""Objects of the demo's scene, and their vertices as arrays."""

import bpy
import numpy as np

SKIN, MOUTH, TEETH, EYE = range(4)
MATERIAL_OF_PART = {
    "face": SKIN, "head_and_neck": SKIN, "mouth_socket": MOUTH, "eye_sockets": SKIN,
    "gums_and_tongue": MOUTH, "teeth": TEETH, "eyeball_left": EYE, "eyeball_right": EYE,
}  # fmt: skip

# A vertex attribute: the angle to the middle of the pupil, as a part of the angle at the iris's rim. Eyes are
# coloured by it, so that the iris stays round on any triangulation.
GAZE = "gaze"
IRIS_ANGLE = 27.0  # degrees
PUPIL = 0.42  # of the iris


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
    slots = np.array([MATERIAL_OF_PART[part] for part in face.polygon_part], dtype=np.int32)
    mesh.polygons.foreach_set("material_index", slots)
    set_gaze(mesh, _gaze(face))
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
    return positions(obj.data.vertices)


def key_vertices(obj, name):
    """(n, 3) positions of a shape key."""
    return positions(obj.data.shape_keys.key_blocks[name].data)


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


def positions(points):
    """(n, 3) of mesh vertices or shape key points."""
    flat = np.empty(3 * len(points), dtype=np.float32)
    points.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def anatomy():
    """The materials of the slots that follow SKIN."""
    return material("Mouth", (0.42, 0.13, 0.12), 0.4), material("Teeth", (0.80, 0.76, 0.66), 0.3), eye()


def set_gaze(mesh, gaze):
    """Stores (n,) values of GAZE."""
    mesh.attributes.new(GAZE, "FLOAT", "POINT").data.foreach_set("value", gaze.astype(np.float32))


def eye():
    """White, iris and pupil by the attribute GAZE."""
    made = bpy.data.materials.get("Eye")
    if made is None:
        made = material("Eye", (0.8, 0.8, 0.8), 0.12)
        nodes, links = made.node_tree.nodes, made.node_tree.links
        gaze, ramp = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeValToRGB")
        gaze.attribute_name = GAZE
        ramp.color_ramp.interpolation = "CONSTANT"
        stops = ramp.color_ramp.elements
        stops[0].color = (0.008, 0.008, 0.008, 1.0)
        stops[1].position, stops[1].color = PUPIL, (0.09, 0.15, 0.15, 1.0)
        white = stops.new(1.0)
        white.color = (0.80, 0.79, 0.77, 1.0)
        links.new(gaze.outputs["Fac"], ramp.inputs["Fac"])
        links.new(ramp.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return made


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


def _gaze(face):
    """GAZE at every vertex, from the pole that faces forward; skin and teeth have what is beyond the iris."""
    gaze = np.full(len(face.neutral), 2.0)
    valence = np.bincount(face.loops, minlength=len(face.neutral))
    for eyeball in ("eyeball_left", "eyeball_right"):
        ball = np.flatnonzero(face.vertex_part == eyeball)
        if not len(ball):
            continue
        out = face.neutral[ball] - face.neutral[ball].mean(axis=0)
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        pole = np.where(out[:, 1] < 0.0, valence[ball], 0).argmax()
        gaze[ball] = np.degrees(np.arccos(np.clip(out @ out[pole], -1.0, 1.0))) / IRIS_ANGLE
    return gaze
