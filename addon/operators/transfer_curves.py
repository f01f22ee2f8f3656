"""The list of curves: add and remove."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..bridge import markers as bridge_markers
from ..bridge import meshes
from ..core import markers
from ..core.curves import ordered
from ..core.refused import Refused
from ..translations import translated
from .job import answering
from .objects import SOURCE, TARGET


class LISSOM_OT_curve_add(bpy.types.Operator):
    """Pair the edges selected on the source with those selected on the target, such as rims of lids or lips.

    In Edit Mode, Alt-click an edge of a rim to select all of it, and Shift-Alt-click its counterpart"""

    bl_idname = "lissom.curve_add"
    bl_label = "Add Curve"
    bl_options = {"REGISTER", "UNDO"}

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    name: StringProperty(name="Name", description="What this rim is; empty: numbered", options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        ends = bridge_markers.pair_of_objects(context, self.source, self.target)
        paths = [tuple(ordered(meshes.selected_edges(obj).tolist(), obj.name)) for obj in ends]
        closed = [path[0] == path[-1] for path in paths]
        if closed[0] != closed[1]:
            loop, path = ends if closed[0] else ends[::-1]
            raise Refused(
                f"The selected edges of '{loop.name}' form a loop, those of '{path.name}' a path with "
                "two ends: select two of a kind"
            )
        pairs, warnings = bridge_markers.current(context.scene, *ends)
        known = bridge_markers.current_curves(context.scene, *ends)
        curves = [*known, markers.Curve(self.name or f"Curve {len(known) + 1}", *paths)]
        markers.check_curves(curves, *(len(obj.data.vertices) for obj in ends))
        bridge_markers.put(context.scene, pairs, *ends, curves=curves)
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        counts = [len(set(path)) for path in paths]
        self.report({"INFO"}, translated(f"'{curves[-1].name}': {counts[0]} to {counts[1]} vertices"))


class LISSOM_OT_curve_remove(bpy.types.Operator):
    """Remove a curve from the list"""

    bl_idname = "lissom.curve_remove"
    bl_label = "Remove Curve"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Index", description="Place in the list", min=0, options={"SKIP_SAVE"})

    @answering
    def execute(self, context):
        curves = context.scene.lissom_transfer.curves
        if self.index >= len(curves):
            raise Refused(f"There is no curve {self.index}: the list holds {len(curves)}")
        curves.remove(self.index)


classes = (LISSOM_OT_curve_add, LISSOM_OT_curve_remove)
