"""Baked arcs of a mesh object: which there are, their ends as arrays, and what they show."""

import hashlib

import bpy
import numpy as np

from ..core import hat, names, space
from ..core import inbetween as core_inbetween
from ..core.inbetween import ArcAsked, path_steps
from ..core.refused import Refused, first
from ..core.work import Work
from . import checks, meshes, mirrors, shape_keys, sliders


def refusal(obj):
    """As checks.refusal; absolute keys are welcome where an arc of ours made them so."""
    return checks.refusal(obj, keys=absolute(obj) is None)


def absolute(obj):
    """The arc that plays by absolute keys, or None."""
    return next((arc for arc in obj.lissom_inbetween.arcs if arc.playback == "ABSOLUTE"), None)


def offered(obj, start):
    """Names of the shape keys that arcs can lead to: no live pose, not the start, not made by an arc."""
    keys = obj.data.shape_keys
    if keys is None:
        return []
    left_out = {key.name for arc in obj.lissom_inbetween.arcs for key in arc.keys}
    left_out |= {start or keys.reference_key.name, *shape_keys.previews(obj.data)}
    return [key.name for key in keys.key_blocks if key.name not in left_out]


def is_stale(obj, arc):
    """Whether an arc's ends have changed since it was baked, or are gone."""
    if not arc.digest:  # of an older version
        return False
    try:
        return Ends(obj, ArcAsked.of(arc)).digest() != arc.digest
    except Refused:
        return True


def out_of_date(obj):
    """A warning where arcs are stale, or ""."""
    stale = [repr(arc.name) for arc in obj.lissom_inbetween.arcs if is_stale(obj, arc)]
    return f"Arcs on '{obj.name}' are out of date, bake them again: {first(stale)}" if stale else ""


def missing(obj, arc):
    """Names of the shape keys that an arc lies between, or goes through, and that are gone."""
    keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
    try:
        through = [name for name, _ in core_inbetween.stops(arc.through)]
    except Refused:  # half typed
        through = []
    return [name for name in (arc.start, arc.end, *through) if name and name not in keys]


def find_ends(obj, arc):
    """An end of an arc that was renamed is known again by its shape, where the other is there."""
    lost = missing(obj, arc)
    field = next((field for field in ("start", "end") if [getattr(arc, field)] == lost), None)
    if field is None or not arc.digest:
        return
    of_arcs = {key.name for one in obj.lissom_inbetween.arcs for key in one.keys}
    for name in set(obj.data.shape_keys.key_blocks.keys()) - of_arcs - {arc.start, arc.end}:
        try:
            if Ends(obj, ArcAsked.of(arc, **{field: name})).digest() == arc.digest:
                setattr(arc, field, name)
                return
        except Refused:  # a key that is none for an arc
            continue


def find(obj, slider):
    """The arc of a slider; Refused where there is none."""
    arc = obj.lissom_inbetween.arcs.get(slider)
    if arc is None:
        raise Refused(f"'{obj.name}' has no arc with a slider named '{slider}'")
    return arc


class Ends:
    """Both ends of an arc as arrays and by name: they outlive undo and deletion."""

    def __init__(self, obj, asked):
        end = shape_keys.find(obj, asked.end)
        start = shape_keys.find(obj, asked.start) if asked.start else obj.data.shape_keys.reference_key
        stops = [(shape_keys.find(obj, name), time) for name, time in core_inbetween.stops(asked.through)]
        for key in (start, end, *(key for key, _ in stops)):
            shape_keys.refuse_preview(key)
        if start == end:
            raise Refused("From and To are the same shape key: choose two")
        self.names = start.name, end.name
        self.mesh = meshes.Snapshot.of(obj, space.linear_part(obj.matrix_world, obj.name))
        self.first, self.last = shape_keys.seen(obj, start), shape_keys.seen(obj, end)
        if end.relative_key == start:  # then the end is seen on top of the start
            self.last = self.first + (shape_keys.seen(obj, end, start) - shape_keys.shape(start))
        own = [key.name for key, _ in stops if key in (start, end)]
        if own:
            raise Refused(f"Through: '{own[0]}' is an end of the arc")
        self.stops = [(time, shape_keys.seen(obj, key)) for key, time in stops]
        self._mirrors = mirrors.of(obj, self.mesh.linear)
        self._obstacle = obstacle(obj, asked.clearance, self.names) if asked.clearance else None

    def digest(self):
        """Equal exactly where the shapes are those that it was of."""
        found = hashlib.blake2b(digest_size=16)
        for shape in (self.mesh.vertices, self.first, self.last, *(shape for _, shape in self.stops)):
            found.update(np.float32(shape).tobytes())
        return found.hexdigest()

    def path(self, asked):
        """Work whose result is ``path_steps``'s."""
        return Work(self.path_steps(asked))

    def path_steps(self, asked):
        """Steps of a Work whose result is core.inbetween.Sampled, in solve space."""
        linear = self.mesh.linear
        ends = space.into(linear, self.first), space.into(linear, self.last)
        stops = [(time, space.into(linear, shape)) for time, shape in self.stops]
        return path_steps(self.mesh.geometry(), *ends, asked, self._obstacle, stops, self._mirrors)

    def back(self, shapes):
        """Shapes of that path, in the object's coordinates."""
        return [space.back(self.mesh.linear, shape) for shape in shapes]


def obstacle(obj, name, ends):
    """Another object in the solve space of ``obj``: vertices at the start, triangles, vertices at the end.

    As it is seen now, modifiers included; where it has shape keys named as the ends, as these show it.
    """
    other = checks.mesh_object(name, bpy.context)
    if other == obj:
        raise Refused("Clearance names the mesh itself: choose another object")
    to_world = np.array(other.matrix_world, dtype=np.float64)
    keys = other.data.shape_keys
    own = [key for key in ends if keys and key in keys.key_blocks]
    if own:
        faces = meshes.triangles(other.data)
        shapes = [
            shape_keys.seen(other, keys.key_blocks[key]) if key in own else meshes.rest_positions(other.data)
            for key in ends
        ]
    else:
        graph = bpy.context.evaluated_depsgraph_get()
        mesh = bpy.data.meshes.new_from_object(other.evaluated_get(graph), depsgraph=graph)
        faces, seen = meshes.triangles(mesh), meshes.positions(mesh.vertices)
        bpy.data.meshes.remove(mesh)
        shapes = [seen, seen]
    linear, offset = to_world[:3, :3], to_world[:3, 3] - np.array(obj.matrix_world.translation)
    first_shape, last_shape = (space.into(linear, shape) + offset for shape in shapes)
    return first_shape, space.outward(linear, faces), last_shape


def require(obj):
    """Raises what ``refusal`` says."""
    reason = refusal(obj)
    if reason:
        raise Refused(reason)


def played(obj, slider, times):
    """(t, n, 3): what an arc shows at times on it, without easing and without the other keys' part."""
    arc = find(obj, slider)
    ends = Ends(obj, arc)
    keys = np.stack([shape_keys.shape(shape_keys.find(obj, key.name)) for key in arc.keys])
    times_of_keys = [key.time for key in arc.keys]
    if arc.playback != "ABSOLUTE":
        keys = np.insert(keys, np.searchsorted(times_of_keys, 0.0), ends.mesh.vertices, axis=0)
        keys -= ends.mesh.vertices - ends.first
    knots = np.union1d([0.0], times_of_keys)
    return np.tensordot(hat.weights(knots, times), keys, axes=1)


def key_name(slider, time, taken):
    """The name of the key of an arc at a time on it, that is none of ``taken``."""
    percent = f"{100 * time:.1f}".rstrip("0").rstrip(".")
    return names.unused(names.shorten(slider, f" {percent}%"), taken)


def remove_keys(obj, slider):
    """Removes the arc and its keys; the slider stays."""
    arcs = obj.lissom_inbetween.arcs
    arc = arcs.get(slider)
    if arc is None:
        return
    for name in sliders.baked_keys(obj, slider):
        shape_keys.remove(obj, name)
    keys = obj.data.shape_keys
    if arc.playback == "ABSOLUTE" and keys is not None:
        keys.driver_remove("eval_time")
        keys.eval_time = 0.0
        keys.use_relative = True
    arcs.remove(arcs.find(slider))
