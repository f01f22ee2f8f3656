"""Transfer of vertex groups, UV maps and colour attributes."""

from dataclasses import dataclass

import numpy as np

from ..bridge import attributes
from ..core import names
from ..core.attributes import attributes_work, skin
from ..core.refused import Refused, first
from .fit import FitAsked, FitDone, Request, where


@dataclass(kw_only=True)
class AttributesAsked(FitAsked):
    """What a transfer of attributes is made of."""

    vertex_groups: bool = True
    uv_maps: bool = True
    colours: bool = True
    exists: str = "UPDATE"


@dataclass(kw_only=True)
class AttributesDone(FitDone):
    """``written``: the names that the target has now, each once."""

    written: list[str]


class TransferAttributes:
    """Vertex groups, UV maps and colour attributes of the source carried over to the target."""

    def __init__(self, context, asked):
        self._request = request = Request(context, asked)
        sources, targets = request.source.objects(), request.require_writable(keys=False)
        self._exists = asked.exists
        layers = attributes.layers(sources, asked.uv_maps, asked.colours)
        editing = [obj.name for obj in sources if layers and obj.mode == "EDIT"]
        if editing:
            raise Refused(f"'{editing[0]}' is in edit mode: go to Object Mode first")
        groups, weights = attributes.weights(sources) if asked.vertex_groups else ([], None)
        if not groups and not layers:
            raise Refused(f"'{request.source.name}' has none of what is to be carried over")
        self._groups = self._plan_groups(targets, groups)
        self._layers = self._plan_layers(targets, layers)
        kept = [name for name in groups if any(name in plan for plan in self._groups)]
        self._names = kept
        self._used = [layer for layer in layers if any(layer in plan for plan in self._layers)]
        if not kept and not self._used:
            raise Refused(f"'{request.target.name}' has all of these, and If Exists is Skip: nothing to do")
        columns = [groups.index(name) for name in kept]
        self._weights = weights[:, columns] if kept else np.zeros((len(request.source.rest()), 0))
        points = [self._weights]
        points += [attributes.read(sources, layer) for layer in self._used if layer.kind == "POINT"]
        (from_corners, _), (self._corners, faces) = (
            attributes.triangle_corners(objects, [part.linear for part in side.parts])
            for objects, side in ((sources, request.source), (targets, request.target))
        )
        corners = [
            attributes.read(sources, layer)[from_corners] for layer in self._used if layer.kind != "POINT"
        ]
        values = np.concatenate(points, axis=1)
        self.work = attributes_work(*request.geometry(), request.fit(), values, corners, faces)

    def write(self, context, result):
        """Writes a core.attributes.Carried; an AttributesDone."""
        request = self._request
        request.source.find()
        targets = request.require_writable(keys=False)
        fit = request.remember(context, result.fit)
        count = len(self._names)
        weights = skin(result.points[:, :count], self._weights)
        corners = iter(result.corners)
        colours = result.points[:, count:].reshape(len(weights), -1, 4)
        points = (colours[:, place] for place in range(colours.shape[1]))
        starts = np.cumsum([len(obj.data.loops) for obj in targets])
        written = []
        for obj, own, plan in zip(targets, request.target.split(weights), self._groups, strict=True):
            for column, name in enumerate(self._names):
                if name in plan and (
                    own[:, column].any() or obj == targets[0] or plan[name] in obj.vertex_groups
                ):
                    attributes.write_weights(obj, plan[name], own[:, column])
                    written.append(plan[name])
        for layer in self._used:
            if layer.kind == "POINT":
                parts = request.target.split(next(points))
            else:
                values = np.zeros((starts[-1], layer.channels))
                values[self._corners] = next(corners)
                parts = np.split(values, starts[:-1])
            for obj, own, plan in zip(targets, parts, self._layers, strict=True):
                if layer in plan:
                    attributes.write(obj, layer, plan[layer], own)
                    written.append(plan[layer])
        done = list(dict.fromkeys(written))
        return AttributesDone(
            summary=f"{len(done)} attribute{'' if len(done) == 1 else 's'} on "
            f"{where(targets)}: {first(done)}",
            warnings=request.told_of_transfer(result.fit, result.warnings, "attributes"),
            fit=fit,
            written=done,
        )

    def _plan_groups(self, targets, groups):
        """For each target, groups of the source -> names there."""
        plans = []
        for obj in targets:
            taken, plan = set(obj.vertex_groups.keys()), {}
            for name in groups:
                given = names.resolve(name, taken | set(plan.values()), self._exists)
                if given is not None:
                    plan[name] = given
            locked = [name for name in plan.values() if name in taken and obj.vertex_groups[name].lock_weight]
            if locked:
                raise Refused(f"Vertex group '{locked[0]}' of '{obj.name}' is locked: unlock it first")
            plans.append(plan)
        return plans

    def _plan_layers(self, targets, layers):
        """For each target, layers of the source -> names there."""
        plans = []
        for obj in targets:
            plan = {}
            for layer in layers:
                taken = attributes.taken(obj) | set(plan.values())
                given = names.resolve(layer.name, taken, self._exists)
                if given is not None:
                    attributes.refuse_other_kinds(obj, layer, given)
                    plan[layer] = given
            attributes.refuse_too_many(obj, plan)
            plans.append(plan)
        return plans
