"""Baked arcs of a mesh object: shape keys under one slider.

Relative keys: the baked keys are Basis + P_i - P_0 of the path P at its knots, relative to the Basis as every
exporter takes them, and each driven by its hat function h_i of the slider t. Blender then adds
sum_i h_i(t) (P_i - P_0) to what the other keys show: with the start key on, that is the path from P_0 to
P_n, straight between the knots; P_0 needs no key. P_0 and P_n are what the artist sees with the start or the
end key on, whatever key they are relative to and whatever vertex group masks them: exporters know no masks.

Where the end key's range goes beyond 0 and 1, the path goes on straight to keys at the ends of that range.

Absolute keys: P_0 to P_n are keys one after the other behind those that were there, and the slider drives
the evaluation time through them; Blender goes straight from key to key by itself.
"""

import hashlib
from dataclasses import fields

import bpy
import numpy as np

from ..core import easing, hat, names, space
from ..core import inbetween as core_inbetween
from ..core.easing import EASINGS
from ..core.inbetween import Asked, path_steps
from ..core.refused import Refused, first
from ..core.work import Work
from . import animation, checks, images, meshes, mirrors, shape_keys, sliders

# The evaluation time that an absolute arc takes. Blender puts a new key 10 behind the last one unless a key,
# this one too, is within 0.1 of the time asked for: hat.NEAREST must be more, and the last key is made first.
DURATION = 2000.0
GAP = 10.0  # between the last key and the first of the arc, as Blender itself spaces them


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
        return Ends(obj, asked_of(arc)).digest() != arc.digest
    except Refused:
        return True


def find(obj, slider):
    """The arc of a slider; Refused where there is none."""
    arc = obj.lissom_inbetween.arcs.get(slider)
    if arc is None:
        raise Refused(f"'{obj.name}' has no arc with a slider named '{slider}'")
    return arc


def asked_of(settings, **also):
    """What an operator, the panel or a baked arc asks for."""
    known = {one.name: getattr(settings, one.name) for one in fields(Asked) if hasattr(settings, one.name)}
    return Asked(**known | also)


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


class Baking:
    """An arc on its way into shape keys: read here, computed by ``steps``, written by ``write``."""

    def __init__(self, obj, asked):
        require(obj)
        if not asked.end:
            raise Refused("Choose the shape key that the arc leads to first")
        self.asked, self._ends = asked, Ends(obj, asked)
        wanted = asked.slider or names.shorten(self._ends.names[1], " arc")
        sliders.check_name(obj, wanted)
        self.slider = names.resolve(wanted, set(obj.keys()), asked.exists)
        if self.slider is None:
            raise Refused(f"Slider '{wanted}' exists, and If Exists is Skip: choose another name")
        self._check_slider(obj)

    def steps(self):
        """Steps of a Work whose result ``write`` takes."""
        return self._ends.path_steps(self.asked)

    def _check_slider(self, obj):
        slider = self.slider
        if slider in obj and slider not in obj.lissom_inbetween.arcs:
            raise Refused(
                f"'{slider}' is a custom property of another kind: choose another name for the slider"
            )
        other = absolute(obj)
        if other is not None and other.name != slider:
            raise Refused(f"The shape keys play the absolute arc '{other.name}': remove it first")
        old = sliders.baked_keys(obj, slider)
        if set(self._ends.names) & set(old):
            raise Refused(f"From and To must not be keys of slider '{slider}' itself: choose another slider")
        checks.require_unlocked([shape_keys.find(obj, name) for name in old])

    def write(self, sampled):
        """Writes core.inbetween.Sampled; returns the number of keys, and warnings."""
        obj = self._ends.mesh.find()
        require(obj)
        start, end = (shape_keys.find(obj, name) for name in self._ends.names)
        self._check_slider(obj)
        value = obj.get(self.slider)
        value = float(value) if isinstance(value, (int, float)) else 0.0
        before = obj.lissom_inbetween.arcs.get(self.slider)
        rerouted = before.end if before is not None and before.reroute else ""
        shapes = self._ends.back(sampled.shapes)
        _remove_keys(obj, self.slider)
        description = f"Lissom: from '{start.name}' at 0 along an arc to '{end.name}' at 1"
        knots, shapes = hat.beyond(sampled.knots, shapes, end.slider_min, end.slider_max)
        sliders.add(obj, self.slider, description, value, (knots[0], knots[-1]))
        arc = obj.lissom_inbetween.arcs.add()
        for one in fields(Asked):
            if hasattr(arc, one.name):
                setattr(arc, one.name, getattr(self.asked, one.name))
        arc.name, arc.start, arc.end = self.slider, start.name, end.name
        arc.digest = self._ends.digest()
        warnings = [*sampled.warnings, *mirrors.left_out(obj)]
        if rerouted and rerouted != end.name:
            arc.reroute = False  # what the slider has is another key's
            warnings.append(f"The slider keeps the animation that it took over from '{rerouted}'")
        elif self.asked.reroute:
            warnings += _reroute(obj, end, arc)
        else:
            arc.reroute = bool(rerouted)
        write = self._write_absolute if self.asked.playback == "ABSOLUTE" else self._write_relative
        warnings += write(obj, arc, start, end, knots, shapes)
        if self.asked.prepare_keys:
            warnings += sliders.take_over(obj, arc.name, start, end)
        warnings += images.lay_again(obj, arc)
        warnings += filter(None, [checks.shared_data(obj)])
        arc.warnings = "\n".join(warnings)
        return len(arc.keys), warnings

    def _write_relative(self, obj, arc, start, end, knots, shapes):
        settings = shape_keys.Settings(mute=end.mute)
        curve = EASINGS[self.asked.easing]
        offset = self._ends.mesh.vertices - self._ends.first
        for index in np.flatnonzero(knots):
            key = self._key(obj, arc, knots[index], shapes[index] + offset, settings)
            sliders.drive(key, "value", obj, arc.name, hat.corners(knots, index, curve))
        if end.mute:
            return [f"Shape key '{end.name}' is muted, and so are the keys of its arc"]
        return []

    def _write_absolute(self, obj, arc, start, end, knots, shapes):
        keys = obj.data.shape_keys
        others = [key.name for key in keys.key_blocks if key not in (keys.reference_key, start, end)]
        offset = max(key.frame for key in keys.key_blocks) + GAP - DURATION * knots[0]
        keys.use_relative = False
        for knot, shape in reversed(list(zip(knots, shapes, strict=True))):
            keys.eval_time = offset + DURATION * knot  # where Blender puts a new absolute key
            self._key(obj, arc, knot, shape, shape_keys.Settings()).interpolation = "KEY_LINEAR"
            arc.keys.move(len(arc.keys) - 1, 0)
        curve = EASINGS[self.asked.easing]
        times = np.unique([knots[0], 0.0, 1.0, knots[-1]])
        slopes = curve.slope(np.clip(times, 0.0, 1.0))
        before = DURATION * np.where((times <= 0) | (times > 1), 1.0, slopes)
        after = DURATION * np.where((times < 0) | (times >= 1), 1.0, slopes)
        corners = easing.bezier(times, offset + DURATION * times, before, after)
        sliders.drive(keys, "eval_time", obj, arc.name, corners)
        if not others:
            return []
        listed = first(repr(name) for name in others)
        return [f"Absolute keys show the arc alone: shape key {listed} no longer adds to it"]

    def _key(self, obj, arc, knot, positions, settings):
        taken = set(obj.data.shape_keys.key_blocks.keys())
        name = names.unused(names.shorten(arc.name, f" {_percent(knot)}%"), taken)
        key = shape_keys.write(obj, name, positions, settings)
        made = arc.keys.add()
        made.name, made.time = key.name, knot
        return key


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


def remove(obj, slider):
    """Removes an arc with its keys and its slider; returns warnings."""
    arc = find(obj, slider)
    checks.require_unlocked([shape_keys.find(obj, name) for name in sliders.baked_keys(obj, slider)])
    start, end, rerouted = arc.start, arc.end, arc.reroute
    _remove_keys(obj, slider)
    warnings = []
    keys = obj.data.shape_keys
    value = obj.get(slider)
    if rerouted and keys is not None and end in keys.key_blocks:
        path, back = sliders.data_path(slider), keys.key_blocks[end].path_from_id("value")
        left = animation.move(obj, path, keys, back)
        animation.redirect(obj, path, keys, back)
        if left:
            warnings.append(f"The animation of slider '{slider}' is not handed back: {left[0]}")
    if keys is not None and {start, end} <= set(keys.key_blocks.keys()) and isinstance(value, (int, float)):
        sliders.hand_back(value, keys.key_blocks[start], keys.key_blocks[end])
    images.take_away(obj, slider)
    if slider in obj:
        del obj[slider]
    orphans = sliders.driven_keys(obj, slider)
    if orphans:
        listed = first(repr(name) for name in orphans)
        warnings.append(f"The driver of shape key {listed} has lost its slider '{slider}'")
    return warnings


def rename(obj, slider, name):
    """Renames the slider of an arc, its keys, and what animates or reads it; returns warnings."""
    arc = find(obj, slider)
    if name == slider:
        return []
    sliders.check_name(obj, name)
    if name in obj:
        raise Refused(f"'{name}' is a custom property already: choose another name for the slider")
    baked = sliders.baked_keys(obj, slider)
    checks.require_unlocked([shape_keys.find(obj, key) for key in baked])
    description = obj.id_properties_ui(slider).as_dict().get("description", "") if slider in obj else ""
    times = [0.0, 1.0, *(key.time for key in arc.keys)]
    sliders.add(obj, name, description, obj.get(slider, 0.0), (min(times), max(times)))
    left = animation.move(obj, sliders.data_path(slider), obj, sliders.data_path(name))
    animation.redirect(obj, sliders.data_path(slider), obj, sliders.data_path(name))
    if slider in obj:
        del obj[slider]
    arc.name = name
    taken = set(obj.data.shape_keys.key_blocks.keys()) - set(baked)
    for made in arc.keys:
        if made.name in baked:
            key = shape_keys.find(obj, made.name)
            made.name = names.unused(names.shorten(name, f" {_percent(made.time)}%"), taken)
            taken.add(made.name)
            key.name = made.name
    return [f"The animation of slider '{slider}' stayed behind: {left[0]}"] if left else []


def _percent(time):
    return f"{100 * time:.1f}".rstrip("0").rstrip(".")


def _remove_keys(obj, slider):
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


def _reroute(obj, end, arc):
    keys, path, to = end.id_data, end.path_from_id("value"), sliders.data_path(arc.name)
    left = animation.move(keys, path, obj, to)
    animation.redirect(keys, path, obj, to)
    return [f"The animation of shape key '{end.name}' stays with it: {reason}" for reason in left]
