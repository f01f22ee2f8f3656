"""Transfer of vertex groups, UV maps and colour attributes."""

import bpy
import numpy as np

from ..bridge import attributes, checks
from ..core import names
from ..core.attributes import attributes_work, skin
from ..core.refused import Refused, first
from ..properties.transfer import colours_property, exists_property, groups_property, uv_maps_property
from .job import JobOperator, allowed
from .transfer_fit import FitProperties, Request, ready, where


class LISSOM_OT_transfer_attributes(FitProperties, JobOperator, bpy.types.Operator):
    """Carry vertex groups, UV maps and colour attributes of the source over to the target"""

    bl_idname = "lissom.transfer_attributes"
    bl_label = "Transfer Attributes"
    bl_options = {"REGISTER", "UNDO"}

    vertex_groups: groups_property()
    uv_maps: uv_maps_property()
    colours: colours_property()
    exists: exists_property("UPDATE")

    @classmethod
    def poll(cls, context):
        if not ready(cls, context):
            return False
        settings = getattr(context, "lissom_transfer", None)
        if settings is None:
            return True
        targets = [settings.target, *(row.object for row in settings.target_parts if row.object)]
        sources = [settings.source, *(row.object for row in settings.source_parts if row.object)]
        reasons = [checks.refusal(obj, keys=False) for obj in targets]
        if not attributes.has_any(sources):
            reasons.append(f"'{settings.source.name}' has no vertex groups, UV maps or colours to carry over")
        return allowed(cls, next(filter(None, reasons), ""))

    def begin(self, context):
        self._request = request = Request(self, context)
        sources, targets = request.source.objects(), request.target.objects()
        for target in targets:
            _require_writable(target)
        layers = attributes.layers(sources, self.uv_maps, self.colours)
        editing = [obj.name for obj in sources if layers and obj.mode == "EDIT"]
        if editing:
            raise Refused(f"'{editing[0]}' is in edit mode: go to Object Mode first")
        groups, weights = attributes.weights(sources) if self.vertex_groups else ([], None)
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
        known = request.known_fit() or (request.markers, request.options)
        return attributes_work(*request.geometry(), known, np.concatenate(points, axis=1), corners, faces)

    def finish(self, context, result):
        request = self._request
        request.source.find()
        targets = request.target.find()
        for target in targets:
            _require_writable(target)
        request.remember(context, result.fit)
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
        for warning in [*request.told(result.fit), *result.warnings]:
            self.report({"WARNING"}, warning)
        for warning in filter(None, (checks.shared_data(obj, "attributes") for obj in targets)):
            self.report({"WARNING"}, warning)
        done = list(dict.fromkeys(written))
        self.report({"INFO"}, f"{len(done)} attributes on {where(targets)}: {first(done)}")

    def _plan_groups(self, targets, groups):
        """For each target, groups of the source -> names there."""
        plans = []
        for obj in targets:
            taken, plan = set(obj.vertex_groups.keys()), {}
            for name in groups:
                given = names.resolve(name, taken | set(plan.values()), self.exists)
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
                given = names.resolve(layer.name, taken, self.exists)
                if given is not None:
                    attributes.refuse_other_kinds(obj, layer, given)
                    plan[layer] = given
            attributes.refuse_too_many(obj, plan)
            plans.append(plan)
        return plans


def _require_writable(obj):
    reason = checks.refusal(obj, keys=False)
    if reason:
        raise Refused(reason)


classes = (LISSOM_OT_transfer_attributes,)
