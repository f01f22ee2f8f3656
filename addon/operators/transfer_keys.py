"""Transfer of shape keys, and the choice of keys."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..bridge import animation, checks, shape_keys
from ..core import names, space
from ..core.refused import Refused, first
from ..core.transfer import Keys, transfer_work
from ..properties.transfer import (
    drivers_property,
    exists_property,
    mask_property,
    match_distance_property,
    unmatched_property,
)
from .job import JobOperator, answering
from .transfer_fit import MARKER_FILE, MARKERS, Request, ready
from .transfer_markers import SOURCE, TARGET


class LISSOM_OT_transfer_keys(JobOperator, bpy.types.Operator):
    """Carry shape keys of the source over to the target, with their names, values and ranges"""

    bl_idname = "lissom.transfer_keys"
    bl_label = "Transfer"
    bl_options = {"REGISTER", "UNDO"}

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    keys: StringProperty(
        name="Keys", description="Names of the shape keys, one a line; empty: all", options={"SKIP_SAVE"}
    )
    exists: exists_property("UPDATE")
    markers: StringProperty(**MARKERS)
    filepath: StringProperty(**MARKER_FILE)
    match_distance: match_distance_property()
    source_mask: mask_property("Source")
    target_mask: mask_property("Target")
    unmatched: unmatched_property()
    drivers: drivers_property()

    @classmethod
    def poll(cls, context):
        return ready(cls, context, keys=True)

    def begin(self, context):
        self._request = request = Request(self, context)
        source = bpy.data.objects[request.source.name]
        target = bpy.data.objects[request.target.name]
        checks.require_writable(target)
        wanted = [line for line in self.keys.splitlines() if line] or shape_keys.key_names(source)
        if not wanted:
            raise Refused(f"'{source.name}' has no shape keys to carry over")
        twice = [name for name in wanted if wanted.count(name) > 1]
        if twice:
            raise Refused(f"Shape key '{twice[0]}' is asked for twice")
        keys = [shape_keys.find(source, name) for name in wanted]
        for key in keys:
            shape_keys.refuse_preview(key)
        self._plan = self._destinations(target, keys)
        kept = [key for key in keys if key.name in self._plan]
        if not kept:
            raise Refused(f"'{target.name}' has all of these keys, and If Exists is Skip: nothing to do")
        self._settings = {key.name: (key.relative_key.name, shape_keys.Settings.of(key)) for key in kept}
        into = request.source.linear
        self._shapes = Keys(
            space.into(into, request.source.vertices),
            [
                (
                    space.into(into, shape_keys.shape(key)),
                    space.into(into, shape_keys.shape(key.relative_key)),
                )
                for key in kept
            ],
        )
        return transfer_work(
            *request.geometry(),
            request.known_fit() or (request.markers, request.options),
            self._shapes.shapes,
            {"unmatched": self.unmatched},
        )

    def _destinations(self, target, keys):
        """Names on the source -> names on the target; locked keys are refused before anything is computed."""
        blocks = target.data.shape_keys.key_blocks if target.data.shape_keys else {}
        taken = set(blocks.keys())
        plan = {}
        for key in keys:
            name = names.resolve(key.name, taken, self.exists)
            if name is None:
                continue
            plan[key.name] = name
            taken.add(name)
        if blocks and target.data.shape_keys.reference_key.name in plan.values():
            raise Refused(
                f"'{target.data.shape_keys.reference_key.name}' is the Basis of '{target.name}': "
                "rename the source's key, or choose Rename"
            )
        overwritten = [blocks[name] for name in plan.values() if name in blocks]
        for key in overwritten:
            shape_keys.refuse_preview(key)
        checks.require_unlocked(overwritten)
        return plan

    def finish(self, context, result):
        fit, shapes, warnings = result
        request = self._request
        source, target = request.source.find(), request.target.find()
        checks.require_writable(target)
        request.remember(fit)
        rest = request.target.vertices
        deltas = self._shapes.deltas(space.into(request.target.linear, rest), shapes)
        written = {}
        for name, delta in zip(self._settings, deltas, strict=True):
            written[name] = space.back(request.target.linear, delta)
        self._write(target, rest, written)
        if self.drivers != "NONE":
            self._copy_drivers(source, target)
        warnings = [*request.warnings, *fit.report["warnings"], *warnings, checks.shared_data(target)]
        for warning in filter(None, warnings):
            self.report({"WARNING"}, warning)
        renamed = [new for old, new in self._plan.items() if new != old]
        note = f", renamed: {first(renamed)}" if renamed else ""
        self.report({"INFO"}, f"{len(written)} shape keys on '{target.name}'{note}")

    def _copy_drivers(self, source, target):
        old, new = source.data.shape_keys, target.data.shape_keys
        instead = [(source, target), (source.data, target.data), (old, new)]
        for name, made in self._plan.items():
            if name in old.key_blocks and made in new.key_blocks:
                paths = old.key_blocks[name].path_from_id("value"), new.key_blocks[made].path_from_id("value")
                animation.copy_driver(
                    old, paths[0], new, paths[1], instead if self.drivers == "REWIRE" else []
                )

    def _write(self, target, rest, deltas):
        """Writes relative keys before the keys that count from them."""
        order = _relative_first(deltas, {name: relative for name, (relative, _) in self._settings.items()})
        basis = shape_keys.ensure_basis(target)
        for name in order:
            relative_name, settings = self._settings[name]
            relative = target.data.shape_keys.key_blocks.get(
                self._plan.get(relative_name, relative_name), basis
            )
            shape = shape_keys.shape(relative) if relative != basis else rest
            shape_keys.write(target, self._plan[name], shape + deltas[name], settings, relative)


def _relative_first(names_of_keys, relative):
    order = []
    for name in names_of_keys:
        chain = []
        while name in names_of_keys and name not in order and name not in chain:
            chain.append(name)
            name = relative[name]
        order += reversed(chain)
    return order


class LISSOM_OT_transfer_choose(bpy.types.Operator):
    """Tick or untick shape keys for the transfer"""

    bl_idname = "lissom.transfer_choose"
    bl_label = "Choose Keys"
    bl_options = {"REGISTER", "UNDO"}

    action: EnumProperty(
        name="Action",
        description="Which ticks to set",
        items=[
            ("TOGGLE", "Toggle", "Tick or untick one key"),
            ("ALL", "All", "Tick all keys"),
            ("NONE", "None", "Untick all keys"),
        ],
    )
    key: StringProperty(name="Key", description="Name of the shape key to toggle", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        if settings.source is None:
            raise Refused("Choose the source object first")
        if self.action == "TOGGLE":
            shape_keys.find(settings.source, self.key)
            index = settings.chosen.find(self.key)
            if index >= 0:
                settings.chosen.remove(index)
            else:
                settings.chosen.add().name = self.key
            return
        settings.chosen.clear()
        if self.action == "ALL":
            for name in shape_keys.key_names(settings.source):
                settings.chosen.add().name = name


classes = (LISSOM_OT_transfer_keys, LISSOM_OT_transfer_choose)
