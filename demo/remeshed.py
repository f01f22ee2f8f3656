"""Job 2: expressions to another person on another triangulation, measured against the known answer.

The target is neutral + identity, thinned out by Blender's Decimate, so it shares neither vertices nor faces
with the source. The answer is known all the same: neutral + identity + expression. At a vertex of the thinned
mesh it is the expression's offset at the closest point of the full surface, interpolated in its triangle.
"""

import time

import bpy
import numpy as np
import scene
import source
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from studio import Tile

from addon.core.marker_file import save
from addon.core.markers import Marker

RATIO = 0.5  # of the faces are kept
REACH = 0.03  # decimetres: how far from the full surface a thinned vertex is looked for

# Landmarks that serve as markers, in the Multi-PIE numbering: jaw 0-16, brows 17-26, nose 27-35, eyes 36-47,
# outer lips 48-59. Those inside the lips are left out: both lips touch there.
MARKED = range(60)


FILM = 5  # steps into an expression
PLAYED = ("joy", "surprise", "kiss")


def run(face, obj, made, studio, folder, picture, film):
    """Transfers all keys of ``obj`` by operators; returns figures, lengths in percent of the diagonal."""
    full = face.neutral + face.identity
    into = scene.collection("3 Remeshed identity")
    target = decimated(face, full, made, into, (6.0, 0, 0))
    surface = Surface(obj, full)
    rest = scene.vertices(target)
    place, offset_of = surface.locate(rest, vertex_normals(target))

    markers = folder / "remeshed_markers.json"
    pairs = marker_pairs(face, full, rest, vertex_normals(target), surface.normals)
    save(markers, pairs, (obj.name, len(full)), (target.name, len(rest)))

    started = time.perf_counter()
    objects = {"source": obj.name, "target": target.name, "filepath": str(markers)}
    scene.run(bpy.ops.lissom.transfer_fit, **objects)
    fitted = time.perf_counter()
    scene.run(bpy.ops.lissom.transfer_keys, **objects)
    transferred = time.perf_counter()

    # What copying offsets from the closest point of the source would give, for comparison.
    _, copied_of = Surface(obj, face.neutral).locate(rest, vertex_normals(target))
    percent = 100.0 / scene.diagonal(rest)
    rows, errors = [], {}
    for name, expression in face.expressions.items():
        known, got = offset_of(expression), scene.key_vertices(target, name) - rest
        errors[name] = percent * (got - known)
        error, motion, copied = (
            np.linalg.norm(offsets, axis=1)
            for offsets in (errors[name], percent * known, percent * (copied_of(expression) - known))
        )
        rows.append(
            {
                "expression": name,
                "rms": rms(error),
                "p99": float(np.quantile(error, 0.99)),
                "max": float(error.max()),
                "motion_rms": rms(motion),
                "motion_max": float(motion.max()),
                "closest_point_rms": rms(copied),
            }
        )

    studio.sheet(_tiles(obj, target, errors), picture)
    studio.film(_frames(obj, target), film)
    return {
        "source_vertices": len(full),
        "source_triangles": len(scene.triangles(obj)),
        "target_vertices": len(rest),
        "target_triangles": len(scene.triangles(target)),
        "markers": len(pairs),
        "fit_seconds": fitted - started,
        "transfer_seconds": transferred - fitted,
        "keys": len(rows),
        "distance_to_full_surface": {"rms": rms(percent * place), "max": float(percent * place.max())},
        "expressions": rows,
    }  # fmt: skip


def decimated(face, positions, skin, into, location):
    """The face at these positions as Blender's Decimate leaves it."""
    whole = scene.face_object("Identity", face, positions, skin, into, location)
    modifier = whole.modifiers.new("Decimate", "DECIMATE")
    modifier.ratio = RATIO
    mesh = scene.posed(whole, {})
    thinned = bpy.data.objects.new("Identity, remeshed", mesh)
    thinned.location = location
    into.objects.link(thinned)
    unused = whole.data
    bpy.data.objects.remove(whole)
    bpy.data.meshes.remove(unused)
    return thinned


def vertex_normals(obj):
    """(n, 3) of the rest shape."""
    flat = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    obj.data.vertices.foreach_get("normal", flat)
    return flat.reshape(-1, 3)


class Surface:
    """The triangles of an object at other positions (n, 3), to find places on."""

    def __init__(self, obj, positions):
        self.positions = positions
        self.triangles = scene.triangles(obj)
        self._tree = BVHTree.FromPolygons(positions.tolist(), self.triangles.tolist())
        corners = positions[self.triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.normals = np.zeros_like(positions)
        for corner in range(3):
            np.add.at(self.normals, self.triangles[:, corner], faces)
        self.normals /= np.linalg.norm(self.normals, axis=1, keepdims=True)

    def locate(self, points, normals):
        """The closest points that face the same way: upper and lower lid, lips and teeth lie back to back.

        Returns the distances (n,) and a function that interpolates there what it is given per vertex of this
        surface.
        """
        found = [self._nearest(Vector(p), Vector(n)) for p, n in zip(points, normals, strict=True)]
        triangles = self.triangles[[index for _, index, _ in found]]
        weights = barycentric(np.array([point for point, _, _ in found]), self.positions[triangles])
        distances = np.array([distance for _, _, distance in found])
        return distances, lambda values: np.einsum("pc,pcx->px", weights, values[triangles])

    def _nearest(self, point, normal):
        near = [hit for hit in self._tree.find_nearest_range(point, REACH) if hit[1].dot(normal) > 0.0]
        place, _, index, distance = (
            min(near, key=lambda hit: hit[3]) if near else self._tree.find_nearest(point)
        )
        return place, index, distance


def barycentric(points, corners):
    """(n, 3) weights of points that lie in the planes of triangles with corners (n, 3, 3)."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    uu, uv, vv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (u, v), (v, v)))
    wu, wv = (np.einsum("ij,ij->i", *pair) for pair in ((w, u), (w, v)))
    determinant = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
    second, third = (vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant
    weights = np.clip(np.stack([1.0 - second - third, second, third], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)


def marker_pairs(face, full, rest, normals, full_normals):
    """Landmarks and the vertices next to them, as an artist would click them."""
    pairs, taken = [], set()
    for number in MARKED:
        vertex = int(face.landmarks[number])
        distance = np.linalg.norm(rest - full[vertex], axis=1)
        distance[normals @ full_normals[vertex] < 0.5] = np.inf
        nearest = int(distance.argmin())
        if nearest not in taken:
            taken.add(nearest)
            pairs.append(Marker(f"landmark {number}", vertex, nearest))
    return pairs


def rms(lengths):
    """Root mean square."""
    return float(np.sqrt(np.mean(lengths**2)))


def _tiles(obj, target, errors):
    frame = {"centre": (0.0, -0.02), "height": 2.9, "turn": 25}
    wire = {"centre": (0.33, 0.26), "height": 0.95, "turn": 12}
    first = [
        Tile([_wired(scene.posed(obj, {}))], "ICT face", note=f"{len(obj.data.vertices)} vertices", **wire),
        Tile([_wired(scene.posed(target, {}))], "another person, remeshed",
             note=f"{len(target.data.vertices)} vertices", **wire),
    ]  # fmt: skip
    rows = [[tile] for tile in first]
    for label, mix in {**source.MIXES, **source.WINK}.items():
        error = rms(np.linalg.norm(sum(value * errors[name] for name, value in mix.items()), axis=1))
        rows[0].append(Tile([scene.posed(obj, mix)], label, note="given", **frame))
        rows[1].append(
            Tile([scene.posed(target, mix)], label, note=f"transferred, off by {error:.2f} %", **frame)
        )
    return rows


def _frames(obj, target):
    """Into each expression and on into the next, on both faces."""
    frame = {"centre": (0.0, -0.02), "height": 2.9, "turn": 25}
    mixes = [source.MIXES[name] for name in PLAYED]
    for before, after in zip([mixes[-1], *mixes[:-1]], mixes, strict=True):
        for step in range(1, FILM + 1):
            t = step / FILM
            names = {**before, **after}
            mix = {name: (1 - t) * before.get(name, 0.0) + t * after.get(name, 0.0) for name in names}
            yield [
                Tile([scene.posed(obj, mix)], "given", **frame),
                Tile([scene.posed(target, mix)], "transferred", note="half the vertices", **frame),
            ]


def _wired(mesh):
    """The mesh with the edges of its triangles drawn."""
    skin = mesh.materials[scene.SKIN]
    wired = bpy.data.materials.get(skin.name + " wire")
    if wired is None:
        wired = skin.copy()
        wired.name = skin.name + " wire"
        nodes, links = wired.node_tree.nodes, wired.node_tree.links
        edges, mix = nodes.new("ShaderNodeWireframe"), nodes.new("ShaderNodeMixRGB")
        edges.inputs["Size"].default_value = 0.0016
        links.new(edges.outputs[0], mix.inputs["Fac"])
        surface = nodes["Principled BSDF"]
        mix.inputs["Color1"].default_value = surface.inputs["Base Color"].default_value
        mix.inputs["Color2"].default_value = (0.02, 0.02, 0.02, 1.0)
        links.new(mix.outputs[0], surface.inputs["Base Color"])
    mesh.materials[scene.SKIN] = wired
    return mesh
