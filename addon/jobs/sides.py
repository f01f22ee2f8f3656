"""Keys of a mesh made from others of it: mirrored, summed, split into left and right."""

from dataclasses import dataclass

import numpy as np

from ..bridge import checks, shape_keys
from ..bridge.meshes import surface
from ..bridge.written import Written
from ..core import names, sides
from ..core.mirrors import AXES
from ..core.refused import Refused, first
from ..core.work import Work
from . import Asked, Done

FAR = 1e-4  # of the mesh's diagonal: twins further away are told of


@dataclass(kw_only=True)
class SidesAsked(Asked):
    """Keys of an object by name, one a line, "" for the active one; and what is made of them."""

    object: str = ""
    keys: str = ""
    exists: str = "UPDATE"
    edited: str = "KEEP"  # keys that were edited since they were made or transferred, or "OVERWRITE"


@dataclass(kw_only=True)
class MirrorAsked(SidesAsked):
    """``axis`` is across the plane of symmetry, which goes through the object's origin."""

    axis: str = "X"


@dataclass(kw_only=True)
class SplitAsked(MirrorAsked):
    """``falloff``: how wide the band is where a key goes over from left to right, of the mesh's width."""

    falloff: float = 0.1


@dataclass(kw_only=True)
class SumAsked(SidesAsked):
    """``name`` of the sum; with ``by_value`` each key counts as much as its value says."""

    name: str = "Sum"
    by_value: bool = False


@dataclass(kw_only=True)
class SidesDone(Done):
    """``written``: the names of the keys; ``away``: how far off the mirrored vertices are on average."""

    written: list[str]
    away: float = 0.0


class _Job:
    """What the three share: keys that are read, and others of the same mesh that are written."""

    def __init__(self, context, asked):
        self._asked = asked
        obj = checks.mesh_object(asked.object, context)
        checks.require_writable(obj)
        self._name = obj.name
        self._names = list(filter(None, asked.keys.splitlines())) or self._chosen(obj)
        keys = [shape_keys.find(obj, name) for name in self._names]
        for key in keys:
            shape_keys.refuse_preview(key)
        self._values = [key.value for key in keys]
        self._vertices, self._triangles = surface(obj)
        self._offsets = np.array([shape_keys.shape(key) - shape_keys.shape(key.relative_key) for key in keys])
        self._edited = []  # what is kept
        self._made = self._destinations(obj, self._wanted())
        self.work = Work(self._steps())

    def _chosen(self, obj):
        """Names of the keys where none are asked for."""
        active = obj.active_shape_key
        if active is None or active == active.id_data.reference_key:
            raise Refused(f"Choose a shape key of '{obj.name}' other than the Basis first")
        return [active.name]

    def _destinations(self, obj, wanted):
        """{the key that one is made of: its name}, without those that are left as they are."""
        keys = obj.data.shape_keys.key_blocks
        taken, made = set(keys.keys()), {}
        for place, name in wanted:
            given = names.resolve(name, taken, self._asked.exists)
            if given == obj.data.shape_keys.reference_key.name:
                raise Refused(f"'{given}' is the Basis of '{obj.name}': choose another name, or Rename")
            if given is not None:
                taken.add(given)
                made[place] = given
        if not made:
            raise Refused(f"'{obj.name}' has all of these keys, and If Exists is Skip: nothing to do")
        if self._asked.edited == "KEEP":
            known = [Written(obj, kind) for kind in ("lissom_written", "lissom_made")]
            self._edited = [name for name in made.values() if name in keys and _is_edited(known, name)]
            made = {place: name for place, name in made.items() if name not in self._edited}
        found = [keys[name] for name in made.values() if name in keys]
        for key in found:
            shape_keys.refuse_preview(key)
        checks.require_unlocked(found)
        return made

    def _write(self, found):
        """Writes {place: offsets (n, 3)}; names in order."""
        obj = checks.mesh_object(self._name, None)
        checks.require_writable(obj)
        keys, written = obj.data.shape_keys.key_blocks, []
        known = Written(obj, "lissom_made")
        known.tidy()
        for place, offsets in found.items():
            name, like = self._made[place], keys.get(self._names[self._like(place)])
            settings = shape_keys.Settings.of(like) if like and name not in keys else None
            if settings:
                settings.value = 0.0
            relative = keys[name].relative_key if name in keys else obj.data.shape_keys.reference_key
            shape_keys.write(obj, name, shape_keys.shape(relative) + offsets, settings, relative)
            known.remember(name)
            written.append(name)
        return written

    def _told(self, done, written, away=0.0, warnings=()):
        told = f"{done} on '{self._name}': {first(repr(name) for name in written) or 'nothing'}"
        warnings = list(warnings)
        if self._edited:
            kept = first(map(repr, self._edited))
            warnings.append(f"Edited by hand, and kept: {kept}. Overwrite, below the view, replaces them")
        return SidesDone(summary=told, warnings=warnings, written=written, away=away)


def _is_edited(known, name):
    """Whether a key is neither as a transfer has written it nor as it was made of others, by both Written."""
    states = [written.state(name) for written in known]
    return "WRITTEN" not in states and states != ["FOREIGN", "FOREIGN"]


class MirrorKeys(_Job):
    """Each key mirrored to the one of the other side."""

    def _like(self, place):
        return place

    def _wanted(self):
        """A key without a side is mirrored into one beside it."""
        return [
            (place, sides.swapped(name) or names.shorten(name, " mirrored"))
            for place, name in enumerate(self._names)
        ]

    def _steps(self):
        axis = AXES.index(self._asked.axis)
        twins = yield from sides.twins_work(self._vertices, self._triangles, axis)
        return twins, {place: sides.mirrored(self._offsets[place], twins, axis) for place in self._made}

    def write(self, context, result):
        """Writes what the work has found; a SidesDone."""
        twins, found = result
        away = twins.away[np.isfinite(twins.away)]
        mean = float(away.mean()) if len(away) else 0.0
        size = float(np.linalg.norm(np.ptp(self._vertices, axis=0)))
        warnings = []
        if mean > FAR * size:
            warnings.append(
                f"The mesh is not symmetric: its places are {100 * mean / size:.2g} % of its size off "
                f"their mirror image on average, {100 * float(away.max()) / size:.2g} % at most"
            )
        alone = int(np.isnan(twins.away).sum())
        if alone:
            warnings.append(f"{alone} vertices have nothing opposite, and stay")
        return self._told("Mirrored", self._write(found), mean, warnings)


class SplitKeys(_Job):
    """Each key as two, of the left and of the right, which add up to it."""

    def _like(self, place):
        return place // 2

    def _wanted(self):
        return [
            (2 * place + side, half)
            for place, name in enumerate(self._names)
            for side, half in enumerate(sides.names_of_halves(name))
        ]

    def _steps(self):
        axis = AXES.index(self._asked.axis)
        width = self._asked.falloff * float(np.ptp(self._vertices[:, axis]))
        share = sides.left_share(self._vertices, axis, width)
        halves = [half for offsets in self._offsets for half in sides.split(offsets, share)]
        return {place: halves[place] for place in self._made}
        yield  # makes it steps: nothing takes long

    def write(self, context, found):
        """Writes what the work has found; a SidesDone."""
        return self._told("Split", self._write(found))


class SumKeys(_Job):
    """One key that is the sum of others."""

    def _like(self, place):
        return 0

    def _chosen(self, obj):
        keys = obj.data.shape_keys
        found = [name for name in shape_keys.key_names(obj) if keys.key_blocks[name].value]
        if not found:
            raise Refused(f"Raise the shape keys of '{obj.name}' that are to be summed first")
        return found

    def _wanted(self):
        if not self._asked.name:
            raise Refused("Give the sum a name")
        return [(0, self._asked.name)]

    def _steps(self):
        total = sides.total(self._offsets, self._values if self._asked.by_value else None)
        return dict.fromkeys(self._made, total)
        yield  # makes it steps: nothing takes long

    def write(self, context, found):
        """Writes what the work has found; a SidesDone."""
        return self._told("Summed", self._write(found))
