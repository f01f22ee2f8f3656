"""Arcs of a whole face: to many shape keys in one go, and those that are out of date baked again."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ..bridge import arcs, checks
from ..core.refused import Refused, first
from ..core.work import Block, Work
from ..properties.inbetween import ArcSettings, PathSettings
from ..properties.transfer import exists_property
from ..translations import translated
from .inbetween_bake import arc_poll
from .job import JobOperator, answering
from .pose_handles import OBJECT


class _Together(JobOperator):
    """Mixin: computes many bridge.arcs.Baking as one row of work, then writes all."""

    def together(self, bakings):
        """Work whose result is what each of them writes."""
        self._bakings = bakings

        def steps():
            found = []
            for place, baking in enumerate(bakings):
                one, result = baking.steps(), None
                while True:
                    try:
                        job = one.send(result)
                    except StopIteration as stop:
                        found.append(stop.value)
                        break
                    result = yield Block(job, place, 1, len(bakings), "arc")
            return found

        return Work(steps())

    def finish(self, context, result):
        """Writes the arcs; what one has to say does not hold up the others."""
        made, warnings = 0, []
        for baking, sampled in zip(self._bakings, result, strict=True):
            count, said = baking.write(sampled)
            made += count
            warnings += [f"{baking.slider}: {line}" for line in said]
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        self.report({"INFO"}, translated(f"{made} shape keys under {len(self._bakings)} sliders"))


class LISSOM_OT_inbetween_bake_all(_Together, PathSettings, ArcSettings, bpy.types.Operator):
    """Bake the arcs from one shape key to many others, each under a slider of its own"""

    bl_idname = "lissom.inbetween_bake_all"
    bl_label = "Bake All"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    start: StringProperty(
        name="From", description="Shape key that all arcs start at; empty: the Basis", options={"SKIP_SAVE"}
    )
    keys: StringProperty(
        name="Keys",
        description="Names of the shape keys that the arcs lead to, one a line; empty: all but those of arcs",
        options={"SKIP_SAVE"},
    )
    exists: exists_property("UPDATE")

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def begin(self, context):
        obj = checks.mesh_object(self.object, context)
        arcs.require(obj)
        if self.playback == "ABSOLUTE":
            raise Refused("Absolute keys play one arc alone: choose another playback to bake several")
        wanted = [line for line in self.keys.splitlines() if line] or arcs.offered(obj, self.start)
        if not wanted:
            raise Refused(f"'{obj.name}' has no shape keys that arcs could lead to")
        asked = arcs.asked_of(self)
        return self.together([arcs.Baking(obj, arcs.asked_of(asked, end=name)) for name in wanted])


class LISSOM_OT_inbetween_update_all(_Together, bpy.types.Operator):
    """Bake all arcs again whose ends were changed since"""

    bl_idname = "lissom.inbetween_update_all"
    bl_label = "Update All"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    def begin(self, context):
        obj = checks.mesh_object(self.object, context)
        arcs.require(obj)
        stale = [arc for arc in obj.lissom_inbetween.arcs if arcs.is_stale(obj, arc)]
        if not stale:
            raise Refused("All arcs are as their ends are now: nothing to do")
        return self.together(
            [arcs.Baking(obj, arcs.asked_of(arc, slider=arc.name, exists="UPDATE")) for arc in stale]
        )


class LISSOM_OT_inbetween_choose(bpy.types.Operator):
    """Tick this shape key, to bake the arc that leads to it"""

    bl_idname = "lissom.inbetween_choose"
    bl_label = "Choose Keys"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    action: EnumProperty(
        name="Action",
        description="What to tick",
        items=[("TOGGLE", "Toggle", "One key"), ("ALL", "All", "All keys"), ("NONE", "None", "No key")],
    )
    key: StringProperty(name="Key", description="Name of the shape key", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        obj = checks.mesh_object(self.object, context)
        settings = obj.lissom_inbetween
        known = arcs.offered(obj, settings.start)
        if self.action == "TOGGLE" and self.key not in known:
            raise Refused(f"No arc can lead to a shape key named '{self.key}': there are {first(known)}")
        chosen = [row.name for row in settings.chosen]
        if self.action == "TOGGLE":
            chosen = [name for name in chosen if name != self.key] + [self.key] * (self.key not in chosen)
        else:
            chosen = known if self.action == "ALL" else []
        settings.chosen.clear()
        for name in known:
            if name in chosen:
                settings.chosen.add().name = name


classes = (LISSOM_OT_inbetween_bake_all, LISSOM_OT_inbetween_update_all, LISSOM_OT_inbetween_choose)
