"""One side of a transfer: a mesh object, or several solved as one mesh, such as a face and its eyes."""

import bpy
import numpy as np

from ..core import space
from ..core.refused import Refused
from . import groups
from .checks import is_shown, mesh_object, require_mesh, require_own_mesh
from .meshes import Snapshot, polygons_of_triangles


def objects_of(context, side, names):
    """The mesh objects of one side, the main one first: by name, one a line, or as the scene has them."""
    settings = context.scene.lissom_transfer
    if names:
        found = [mesh_object(name, context) for name in names.splitlines() if name]
    else:
        if getattr(settings, side) is None:
            raise Refused(f"Choose the {side} object first")
        chosen = [getattr(settings, side), *(row.object for row in getattr(settings, f"{side}_parts"))]
        found = [require_mesh(obj) for obj in chosen if obj is not None]
    return list(dict.fromkeys(found))


def both_sides(context, source, target):
    """The objects of source and target; no object may be on both."""
    sides = [objects_of(context, *side) for side in (("source", source), ("target", target))]
    both = [obj.name for obj in sides[0] if obj in sides[1]]
    if both:
        raise Refused(f"Source and target are the same object, '{both[0]}': choose two")
    owners = {obj.data: obj for obj in sides[0]}
    for obj in sides[1]:
        require_own_mesh(obj, owners)
    return sides


def world_matrix(obj):
    """(4, 4): where an object is; Refused where only its evaluation tells, and Blender leaves that out.

    What is hidden in viewports, or in a collection that is excluded, has the matrix of when it was last seen.
    """
    if is_shown(obj) or obj.hide_get():
        return np.array(obj.matrix_world, dtype=np.float64)
    if obj.constraints or (obj.parent and obj.parent_type != "OBJECT"):
        raise Refused(f"'{obj.name}' is hidden, and Blender does not say where it is: show it first")
    own = np.array(obj.matrix_basis, dtype=np.float64)
    if obj.parent is None:
        return own
    return world_matrix(obj.parent) @ np.array(obj.matrix_parent_inverse, dtype=np.float64) @ own


class Assembly:
    """Mesh objects as one mesh, in the solve space of the first, whose location is the origin by default."""

    def __init__(self, objects, origin=None):
        self._matrices = np.array([world_matrix(obj) for obj in objects])
        matrices = zip(objects, self._matrices, strict=True)
        self.parts = [Snapshot.of(obj, space.linear_part(matrix, obj.name)) for obj, matrix in matrices]
        self.origin = self._matrices[0, :3, 3] if origin is None else origin
        self._offsets = self._matrices[:, :3, 3] - self.origin
        counts = [len(part.vertices) for part in self.parts]
        self._starts = np.concatenate([[0], np.cumsum(counts)])

    @property
    def name(self):
        """Of the first object."""
        return self.parts[0].name

    @property
    def names(self):
        """Of all objects."""
        return [part.name for part in self.parts]

    def objects(self):
        """The objects as they are now; for use in the same breath."""
        return [bpy.data.objects[part.key] for part in self.parts]

    def find(self):
        """The objects again, or Refused where one is gone or was remodelled meanwhile (row 42)."""
        return [part.find() for part in self.parts]

    def into(self, positions):
        """One (n, 3) array in solve space from those of each part in its object's coordinates."""
        rows = zip(self.parts, self._offsets, positions, strict=True)
        return np.concatenate([space.into(part.linear, own) + offset for part, offset, own in rows])

    def rest(self):
        """(n, 3): all vertices at rest, in solve space."""
        return self.into([part.vertices for part in self.parts])

    def posed(self, positions, matrices):
        """(n, 3) in solve space from other positions of each part, and other matrices (4, 4) of the objects.

        What the first object does as a whole is left out; the others' motion relative to it counts.
        """
        space.linear_part(matrices[0], self.name)
        rows = self.split(self.into(positions))
        for place in range(1, len(rows)):
            ends = (self._matrices[0], self._matrices[place]), (matrices[0], matrices[place])
            motion = space.part_motion(*ends[0], *ends[1])
            if motion is not None:
                about = self._offsets[0]
                rows[place] = (rows[place] - about) @ motion[:3, :3].T + motion[:3, 3] + about
        return np.concatenate(rows)

    def back(self, deltas):
        """For each part its own rows of displacements (n, 3), in its object's coordinates."""
        rows = np.split(deltas, self._starts[1:-1])
        return [space.back(part.linear, own) for part, own in zip(self.parts, rows, strict=True)]

    def split(self, values):
        """For each part its own rows of something per vertex."""
        return np.split(values, self._starts[1:-1])

    def geometry(self):
        """(vertices, triangles) in solve space."""
        triangles = [
            space.outward(part.linear, part.triangles) + start
            for part, start in zip(self.parts, self._starts[:-1], strict=True)
        ]
        return self.rest(), np.concatenate(triangles).astype(np.int32)

    def seen(self, vertices):
        """(k, 3): where some vertices are at rest in the world, and (3,) the way to look at them."""
        rest, triangles = self.geometry()
        normals = np.cross(*(rest[triangles[:, corner]] - rest[triangles[:, 0]] for corner in (1, 2)))
        inside = np.zeros(len(rest), dtype=bool)
        inside[vertices] = True
        outward = normals[inside[triangles].any(axis=1)].sum(axis=0)
        return rest[vertices] + self.origin, -outward if outward.any() else np.array([0.0, 1.0, 0.0])

    def polygons(self, triangles):
        """For each object the faces, ascending, that some triangles (k,) of ``geometry`` are part of."""
        counts = np.cumsum([0, *(len(part.triangles) for part in self.parts)])
        found = []
        for obj, low, high in zip(self.objects(), counts[:-1], counts[1:], strict=True):
            own = triangles[(triangles >= low) & (triangles < high)] - low
            found.append(np.unique(polygons_of_triangles(obj.data)[own]))
        return found

    def mask(self, group):
        """The vertices of a vertex group that one object has, or several; Refused where none has (row 25)."""
        found = [
            groups.members(obj, [group])[group] + start
            for obj, start in zip(self.objects(), self._starts[:-1], strict=True)
            if group in obj.vertex_groups
        ]
        return np.concatenate(found) if found else groups.mask(self.objects()[0], group)

    def weights(self, group):
        """(n,): the weight of every vertex in a vertex group; None where no object has it."""
        objects = self.objects()
        if not any(group in obj.vertex_groups for obj in objects):
            return None
        return np.concatenate([groups.weights(obj, group) for obj in objects])
