"""Bake: the arc between two shape keys as shape keys under one slider.

Relative keys: the baked keys are Basis + P_i - P_0 of the path P at its knots, relative to the Basis as every
exporter takes them, and each driven by its hat function h_i of the slider t. Blender then adds
sum_i h_i(t) (P_i - P_0) to what the other keys show: with the start key on, that is the path from P_0 to
P_n, straight between the knots; P_0 needs no key. P_0 and P_n are what the artist sees with the start or the
end key on, whatever key they are relative to and whatever vertex group masks them: exporters know no masks.

Where the end key's range goes beyond 0 and 1, the path goes on straight to keys at the ends of that range.

Absolute keys: P_0 to P_n are keys one after the other behind those that were there, and the slider drives
the evaluation time through them; Blender goes straight from key to key by itself.
"""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ..bridge import animation, arcs, checks, images, kept, mirrors, shape_keys, sliders
from ..core import easing, hat, names
from ..core.easing import EASINGS
from ..core.inbetween import ArcAsked
from ..core.refused import Refused, first
from ..core.work import Block, Work
from . import Done
from .arc_corrections import ArcCorrections

# The evaluation time that an absolute arc takes. Blender puts a new key 10 behind the last one unless a key,
# this one too, is within 0.1 of the time asked for: hat.NEAREST must be more, and the last key is made first.
DURATION = 2000.0
GAP = 10.0  # between the last key and the first of the arc, as Blender itself spaces them


@dataclass(kw_only=True)
class BakeDone(Done):
    """``keys``: (name, time) of the baked keys under the ``slider`` of an ``object``."""

    object: str
    slider: str
    keys: list[tuple[str, float]]


@dataclass(kw_only=True)
class AllDone(Done):
    """``arcs``: a BakeDone for each."""

    arcs: list[BakeDone]


class Bake:
    """The arc between two shape keys under a slider; what is asked for is a core.inbetween.ArcAsked."""

    def __init__(self, context, asked):
        obj = checks.mesh_object(asked.object, context)
        arcs.require(obj)
        if not asked.end:
            raise Refused("Choose the shape key that the arc leads to first")
        self._asked, self._ends = asked, arcs.Ends(obj, asked)
        wanted = asked.slider or names.shorten(self._ends.names[1], " arc")
        sliders.check_name(obj, wanted)
        self.slider = names.resolve(wanted, set(obj.keys()), asked.exists)
        if self.slider is None:
            raise Refused(f"Slider '{wanted}' exists, and If Exists is Skip: choose another name")
        self._check_slider(obj)

    @cached_property
    def work(self):
        """Begins to compute."""
        return self._ends.path(self._asked)

    def steps(self):
        """The steps of its work, as a part of longer work."""
        return self._ends.path_steps(self._asked)

    def _check_slider(self, obj):
        slider = self.slider
        if slider in obj and slider not in obj.lissom_inbetween.arcs:
            raise Refused(
                f"'{slider}' is a custom property of another kind: choose another name for the slider"
            )
        other = arcs.absolute(obj)
        if other is not None and other.name != slider:
            raise Refused(f"The shape keys play the absolute arc '{other.name}': remove it first")
        old = sliders.baked_keys(obj, slider)
        if set(self._ends.names) & set(old):
            raise Refused(f"From and To must not be keys of slider '{slider}' itself: choose another slider")
        checks.require_unlocked([shape_keys.find(obj, name) for name in old])

    def write(self, context, sampled):
        """Writes core.inbetween.Sampled; a BakeDone."""
        obj = self._ends.mesh.find()
        arcs.require(obj)
        start, end = (shape_keys.find(obj, name) for name in self._ends.names)
        self._check_slider(obj)
        value = obj.get(self.slider)
        value = float(value) if isinstance(value, (int, float)) else 0.0
        before = obj.lissom_inbetween.arcs.get(self.slider)
        rerouted = before.end if before is not None and before.reroute else ""
        self._corrections = ArcCorrections(obj, before, (start.name, end.name))
        shapes = self._ends.back(sampled.shapes)
        arcs.remove_keys(obj, self.slider)
        description = f"Lissom: from '{start.name}' at 0 along an arc to '{end.name}' at 1"
        knots, shapes = hat.beyond(sampled.knots, shapes, end.slider_min, end.slider_max)
        sliders.add(obj, self.slider, description, value, (knots[0], knots[-1]))
        arc = obj.lissom_inbetween.arcs.add()
        for one in fields(ArcAsked):
            if hasattr(arc, one.name):
                setattr(arc, one.name, getattr(self._asked, one.name))
        arc.name, arc.start, arc.end = self.slider, start.name, end.name
        arc.digest = self._ends.digest()
        warnings = [*sampled.warnings, *self._corrections.warnings(), *mirrors.left_out(obj)]
        if rerouted and rerouted != end.name:
            arc.reroute = False  # what the slider has is another key's
            warnings.append(f"The slider keeps the animation that it took over from '{rerouted}'")
        elif self._asked.reroute:
            warnings += _reroute(obj, end, arc)
        else:
            arc.reroute = bool(rerouted)
        write = self._write_absolute if self._asked.playback == "ABSOLUTE" else self._write_relative
        warnings += write(obj, arc, start, end, knots, shapes)
        if self._asked.prepare_keys:
            warnings += sliders.take_over(obj, arc.name, start, end)
        warnings += images.lay_again(obj, arc)
        warnings += filter(None, [checks.shared_data(obj)])
        arc.warnings = "\n".join(warnings)
        return BakeDone(
            summary=f"{len(arc.keys)} shape keys under the slider '{self.slider}'",
            warnings=warnings,
            object=obj.name,
            slider=self.slider,
            keys=[(key.name, round(key.time, 6)) for key in arc.keys],
        )

    def _write_relative(self, obj, arc, start, end, knots, shapes):
        settings = shape_keys.Settings(mute=end.mute)
        curve = EASINGS[self._asked.easing]
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
        curve = EASINGS[self._asked.easing]
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
        name = arcs.key_name(arc.name, knot, taken)
        correction = self._corrections.at(knot, positions, self._ends.mesh.triangles)
        key = shape_keys.write(obj, name, positions + correction, settings)
        made = arc.keys.add()
        made.name, made.time = key.name, knot
        kept.keep(made, obj.data, kept.offsets(key) - correction)
        return key


def _reroute(obj, end, arc):
    keys, path, to = end.id_data, end.path_from_id("value"), sliders.data_path(arc.name)
    left = animation.move(keys, path, obj, to)
    animation.redirect(keys, path, obj, to)
    return [f"The animation of shape key '{end.name}' stays with it: {reason}" for reason in left]


class BakeAll:
    """Many arcs in one go: all are computed as one row of work, then all are written."""

    def __init__(self, context, asked):
        """``asked`` is a list of core.inbetween.ArcAsked."""
        self._bakes = [Bake(context, one) for one in asked]
        self.work = Work(self._steps())

    def _steps(self):
        found = []
        for place, bake in enumerate(self._bakes):
            one, result = bake.steps(), None
            while True:
                try:
                    job = one.send(result)
                except StopIteration as stop:
                    found.append(stop.value)
                    break
                result = yield Block(job, place, 1, len(self._bakes), "arc")
        return found

    def write(self, context, result):
        """Writes core.inbetween.Sampled of each arc; an AllDone."""
        made = [bake.write(context, sampled) for bake, sampled in zip(self._bakes, result, strict=True)]
        return AllDone(
            summary=f"{sum(len(one.keys) for one in made)} shape keys under {len(made)} sliders",
            warnings=[f"{one.slider}: {line}" for one in made for line in one.warnings],
            arcs=made,
        )


class UpdateAll(BakeAll):
    """All arcs of an object whose ends were changed since they were baked; those that have lost one stay."""

    def __init__(self, context, name):
        obj = checks.mesh_object(name, context)
        arcs.require(obj)
        old = [
            again(context, obj.name, arc.name) for arc in obj.lissom_inbetween.arcs if arcs.is_stale(obj, arc)
        ]
        lost = {asked.slider: arcs.missing(obj, asked) for asked in old}
        self._lost = [
            f"'{slider}' stays as it is: {first(map(repr, gone))} is gone"
            for slider, gone in lost.items()
            if gone
        ]
        if not old:
            raise Refused("All arcs are as their ends are now: nothing to do")
        if all(lost.values()):
            raise Refused(f"Nothing to do: {'; '.join(self._lost)}")
        super().__init__(context, [asked for asked in old if not lost[asked.slider]])

    def write(self, context, result):
        """As BakeAll's."""
        done = super().write(context, result)
        done.warnings += self._lost
        return done


def to_many(context, asked, keys):
    """[ArcAsked] of the arcs to shape keys of these names, by default all that arcs can lead to."""
    obj = checks.mesh_object(asked.object, context)
    arcs.require(obj)
    if asked.playback == "ABSOLUTE":
        raise Refused("Absolute keys play one arc alone: choose another playback to bake several")
    wanted = keys or arcs.offered(obj, asked.start)
    if not wanted:
        raise Refused(f"'{obj.name}' has no shape keys that arcs could lead to")
    return [ArcAsked.of(asked, end=name, object=obj.name) for name in wanted]


def again(context, name, slider):
    """The ArcAsked that bakes a baked arc anew, with its own settings."""
    obj = checks.mesh_object(name, context)
    arcs.require(obj)
    arc = arcs.find(obj, slider)
    arcs.find_ends(obj, arc)
    return ArcAsked.of(arc, slider=arc.name, exists="UPDATE", object=obj.name)
