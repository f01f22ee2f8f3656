"""Transfer of shape keys."""

from dataclasses import dataclass

from ..bridge import animation, arcs, groups, shape_keys
from ..core import names
from ..core.quality import pack_faces
from ..core.refused import Refused, first
from ..core.transfer import Keys, carried_weights, transfer_work
from .corrections import Corrections, Found
from .fit import FitDone, Request, TransferAsked, key_names, where
from .parts import quality_told


@dataclass(kw_only=True)
class KeysAsked(TransferAsked):
    """What a transfer of shape keys is made of."""

    keys: tuple[str, ...] = ()  # their names; none: all
    exists: str = "UPDATE"
    edited: str = "KEEP"  # keys that were edited since they were written: "CARRY" or "OVERWRITE" them
    drivers: str = "REWIRE"
    drop_empty: bool = False
    check: bool = True


@dataclass(kw_only=True)
class KeysDone(FitDone):
    """``written``: the names on each object; ``quality``: rows of core.quality.as_dict, the worst first.

    ``found`` has the keys that were there, and were locked or edited by hand.
    """

    written: dict[str, list[str]]
    quality: list[dict]
    found: Found


class TransferKeys:
    """Shape keys of the source carried over to the target, with their names, values and ranges."""

    def __init__(self, context, asked):
        self._asked = asked
        self._request = request = Request(context, asked)
        sources, targets = request.source.objects(), request.require_writable()
        wanted = list(asked.keys) or key_names(sources)
        if not wanted:
            raise Refused(f"'{request.source.name}' has no shape keys to carry over")
        twice = [name for name in wanted if wanted.count(name) > 1]
        if twice:
            raise Refused(f"Shape key '{twice[0]}' is asked for twice")
        found = {name: keys_of(sources, name) for name in wanted}
        self._plan = destinations(targets, wanted, asked.exists)
        if not any(self._plan):
            raise Refused(
                f"'{request.target.name}' has all of these keys, and If Exists is Skip: nothing to do"
            )
        self._corrections = Corrections(asked.edited)
        self._plan = self._corrections.leave(targets, self._plan)
        self._corrections.require_any(self._plan)
        kept = [name for name in wanted if any(name in plan for plan in self._plan)]
        self._settings = {}
        for name in kept:
            key = next(filter(None, found[name]))
            relative = key.relative_key
            counts_from = relative.name if relative != key.id_data.reference_key else ""
            self._settings[name] = counts_from, shape_keys.Settings.of(key)
        self._shapes = Keys(
            request.source.rest(),
            [
                tuple(request.source.into(shapes) for shapes in _shapes(request.source.parts, found[name]))
                for name in kept
            ],
        )
        self.work = transfer_work(
            *request.geometry(), request.fit(), self._shapes.shapes, asked.options, asked.check
        )

    def write(self, context, result):
        """Writes a core.transfer.Carried; a KeysDone."""
        request, asked = self._request, self._asked
        sources, targets = request.source.find(), request.require_writable()
        self._plan = self._corrections.leave(targets, self._plan)  # again: the artist was at work too
        fit = request.remember(context, result.fit)
        deltas = [{} for _ in targets]
        found = self._shapes.deltas(request.target.rest(), result.shapes)
        for name, delta in zip(self._settings, found, strict=True):
            for own, part in zip(deltas, request.target.back(delta), strict=True):
                own[name] = part
        self._bring_groups(result.fit, targets)
        written, warnings = {}, []
        for place, (obj, own) in enumerate(zip(targets, deltas, strict=True)):
            plan = without_empty(obj, own, self._plan[place], place > 0, asked.drop_empty)
            self._plan[place] = plan
            self._write(obj, request.target.parts[place], own, plan)
            if asked.drivers != "NONE":
                warnings += self._copy_drivers(sources, targets[0], obj, plan)
            written[obj.name] = list(plan.values())
        renamed = [new for plan in self._plan for old, new in plan.items() if new != old]
        reached = [obj for obj, plan in zip(targets, self._plan, strict=True) if plan]
        told = [f"{sum(map(len, written.values()))} shape keys on {where(reached or targets)}"]
        if renamed:
            told.append(f"renamed: {first(dict.fromkeys(renamed))}")
        return KeysDone(
            summary="; ".join(told),
            warnings=[
                *warnings,
                *self._corrections.warnings(),
                *filter(None, map(arcs.out_of_date, targets)),
                *request.told_of_transfer(result.fit, result.warnings),
            ],
            fit=fit,
            written=written,
            found=self._corrections.found,
            quality=self._remember_quality(context, result.quality or {}),
        )

    def _bring_groups(self, fit, targets):
        """Vertex groups that keys are limited to, where the target has none of that name."""
        source, target = self._request.source, self._request.target
        for name in {settings.vertex_group for _, settings in self._settings.values()} - {""}:
            missing = [name not in obj.vertex_groups for obj in targets]
            weights = source.weights(name) if any(missing) else None
            if weights is None:
                continue
            carried = target.split(carried_weights(fit, source.geometry()[1], weights))
            for obj, own, lacks in zip(targets, carried, missing, strict=True):
                if lacks:
                    groups.make(obj, name, own)

    def _remember_quality(self, context, quality):
        rows, found = context.scene.lissom_transfer.quality, self._corrections.found
        left = {
            name for by in (found.locked, found.edited, found.unknown) for own in by.values() for name in own
        }
        left -= {new for plan in self._plan for new in plan.values()}
        for place in reversed(range(len(rows))):
            if rows[place].name not in left:
                rows.remove(place)
        for place, name in enumerate(self._settings if quality else ()):
            new = next((plan[name] for plan in self._plan if name in plan), None)
            if new is not None:
                row = rows.add()
                row.name, row.source = new, name
                found = self._shapes.of_key(place, quality)
                if found:
                    found["reasons"] = "\n".join(found["reasons"])
                    parts = self._request.target.polygons(found["faces"])
                    objects = [part.name for part in self._request.target.parts]
                    found["faces"] = pack_faces(dict(zip(objects, parts, strict=True)))
                for field, value in found.items():
                    setattr(row, field, value)
        return quality_told(context.scene.lissom_transfer)

    def _copy_drivers(self, sources, main, target, plan):
        left = []
        for source in sources:
            old, new = source.data.shape_keys, target.data.shape_keys
            instead = [(sources[0], main), (sources[0].data, main.data), (sources[0].data.shape_keys, new)]
            instead += [(source, target), (source.data, target.data), (old, new)]
            known = {name: made for name, made in plan.items() if old and name in old.key_blocks}
            paths = {  # of values on the source -> on the target
                old.key_blocks[name].path_from_id("value"): new.key_blocks[made].path_from_id("value")
                for name, made in known.items()
            }
            for path, made in paths.items():
                rewired = instead if self._asked.drivers == "REWIRE" else []
                left += animation.copy_driver(old, path, new, made, rewired, paths)
        listed = first(dict.fromkeys(left))
        told = f"Drivers of '{target.name}' go on reading the source, for want of the like: {listed}"
        return [told] if left else []

    def _write(self, target, part, deltas, plan):
        """Writes relative keys before the keys that count from them."""
        relative = {name: self._settings[name][0] for name in plan}
        if not plan:
            return
        basis = shape_keys.ensure_basis(target)
        writer = self._corrections.writer(target, part.triangles)
        for name in _relative_first(list(plan), relative):
            relative_name, settings = self._settings[name]
            blocks, counts_from = target.data.shape_keys.key_blocks, basis
            if relative_name:
                counts_from = blocks.get(plan.get(relative_name, relative_name), basis)
            shape = shape_keys.shape(counts_from) if counts_from != basis else part.vertices
            writer.write(plan[name], shape, deltas[name], settings, counts_from)


def destinations(targets, wanted, exists):
    """For each target, names on the source -> names there."""
    # Where there are no keys yet, the first one will be the Basis.
    blocks = [obj.data.shape_keys.key_blocks if obj.data.shape_keys else {"Basis": None} for obj in targets]
    taken = set().union(*(keys.keys() for keys in blocks))
    plans = [{} for _ in targets]
    for name in wanted:
        renamed = names.resolve(name, taken, "RENAME") if exists == "RENAME" else None
        for keys, plan in zip(blocks, plans, strict=True):
            given = renamed or names.resolve(name, {*keys.keys(), *plan.values()}, exists)
            if given is not None:
                plan[name] = given
                taken.add(given)
    for obj, keys, plan in zip(targets, blocks, plans, strict=True):
        basis = obj.data.shape_keys.reference_key.name if obj.data.shape_keys else "Basis"
        if basis in plan.values():
            raise Refused(
                f"'{basis}' is the Basis of '{obj.name}': choose another name for the key, or Rename"
            )
        for name in plan.values():
            if name in keys:
                shape_keys.refuse_preview(keys[name])
    return plans


def without_empty(obj, deltas, plan, further, drop_empty=False):
    """The plan without new keys that move nothing: by option, or of further objects."""
    there = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
    return {
        name: new
        for name, new in plan.items()
        if new in there or deltas[name].any() or not (drop_empty or further)
    }


def keys_of(objects, name):
    """The shape key of that name on each object, None where it has none; Refused where none has."""
    blocks = [obj.data.shape_keys.key_blocks if obj.data.shape_keys else {} for obj in objects]
    if not any(name in keys for keys in blocks):
        shape_keys.find(objects[0], name)
    found = [keys.get(name) for keys in blocks]
    for key in filter(None, found):
        shape_keys.refuse_preview(key)
    return found


def _shapes(parts, keys):
    """The absolute shapes of a key and of its relative key, part by part; the rest where there is no key."""
    rows = list(zip(parts, keys, strict=True))
    yield [shape_keys.shape(key) if key else part.vertices for part, key in rows]
    yield [shape_keys.shape(key.relative_key) if key else part.vertices for part, key in rows]


def _relative_first(names_of_keys, relative):
    order = []
    for name in names_of_keys:
        chain = []
        while name in names_of_keys and name not in order and name not in chain:
            chain.append(name)
            name = relative[name]
        order += reversed(chain)
    return order
