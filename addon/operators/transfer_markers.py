"""The list of marker pairs: add, remove, clear, show and mirror."""

import bmesh
import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ..bridge import markers as bridge_markers
from ..bridge import meshes
from ..bridge.screen import redraw_views
from ..core import marker_places, markers
from ..core.refused import Refused, first
from ..translations import translated
from .job import answering
from .markers import needs_markers, needs_pair
from .objects import SOURCE, TARGET


def _selected(obj):
    """The selected vertices, in the order of the clicks where Blender remembers it."""
    chosen = meshes.selected_vertices(obj).tolist()
    if obj.mode == "EDIT" and len(chosen) > 1:
        history = bmesh.from_edit_mesh(obj.data).select_history
        clicked = [element.index for element in history if isinstance(element, bmesh.types.BMVert)]
        if sorted(clicked) == chosen:
            return clicked
        raise Refused(
            f"{len(chosen)} vertices of '{obj.name}' are selected, not one by one: "
            "select one vertex on each mesh, or click the vertices one after the other"
        )
    return chosen


class LISSOM_OT_marker_add(bpy.types.Operator):
    """Pair the vertex selected on the source with the one selected on the target.

    Select both objects, go to Edit Mode, click a vertex and Shift-click its counterpart on the other"""

    bl_idname = "lissom.marker_add"
    bl_label = "Add Marker Pair"
    bl_options = {"REGISTER", "UNDO"}

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    source_vertex: IntProperty(
        name="Source Vertex", description="Index of the vertex; -1: the selected one", default=-1, min=-1,
        options={"SKIP_SAVE"},
    )  # fmt: skip
    target_vertex: IntProperty(
        name="Target Vertex", description="Index of the vertex; -1: the selected one", default=-1, min=-1,
        options={"SKIP_SAVE"},
    )  # fmt: skip
    name: StringProperty(
        name="Name", description="What this place is; empty: numbered", options={"SKIP_SAVE"}
    )

    @answering
    def execute(self, context):
        source, target = bridge_markers.pair_of_objects(context, self.source, self.target)
        sides = [
            [given] if given >= 0 else _selected(obj)
            for obj, given in ((source, self.source_vertex), (target, self.target_vertex))
        ]
        counts = [len(side) for side in sides]
        if counts[0] != counts[1] or not counts[0]:
            raise Refused(
                f"Select one vertex on each mesh: '{source.name}' has {counts[0]} selected, "
                f"'{target.name}' {counts[1]}"
            )
        if counts[0] > 1 and not (source.mode == target.mode == "EDIT"):
            raise Refused(
                f"{counts[0]} vertices are selected on each mesh: select one on each, or go to Edit Mode"
            )
        known, warnings = bridge_markers.current(context.scene, source, target)
        added = []
        for pair in zip(*sides, strict=True):
            name = self.name or markers.new_name([*known, *added])
            added.append(markers.Marker(name, *pair))
        markers.check(known + added, len(source.data.vertices), len(target.data.vertices))
        bridge_markers.append(context.scene, added, source, target)
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))


class LISSOM_OT_marker_remove(bpy.types.Operator):
    """Remove a marker pair from the list"""

    bl_idname = "lissom.marker_remove"
    bl_label = "Remove Marker Pair"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(
        name="Index",
        description="Place in the list; -1: the active one",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return needs_markers(cls, context)

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        index = self.index if self.index >= 0 else settings.active_marker
        if index >= len(settings.markers):
            raise Refused(f"There is no marker {index}: the list holds {len(settings.markers)}")
        bridge_markers.remove(context.scene, index)


class LISSOM_OT_marker_clear(bpy.types.Operator):
    """Remove all marker pairs and curves"""

    bl_idname = "lissom.marker_clear"
    bl_label = "Remove All Marker Pairs"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return needs_markers(cls, context, or_curves=True)

    @answering
    def execute(self, context):
        context.scene.lissom_transfer.markers.clear()
        context.scene.lissom_transfer.curves.clear()
        context.scene.lissom_transfer.active_marker = 0
        redraw_views()


class LISSOM_OT_marker_show(bpy.types.Operator):
    """Select the vertices at this marker pair, or nearest to it, on both meshes"""

    bl_idname = "lissom.marker_show"
    bl_label = "Show Marker Pair"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Index", description="Place in the list", min=0, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return needs_pair(cls, context) and needs_markers(cls, context)

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        if self.index >= len(settings.markers):
            raise Refused(f"There is no marker {self.index}: the list holds {len(settings.markers)}")
        ends = settings.source, settings.target
        marker = bridge_markers.current(context.scene, *ends)[0][self.index]
        markers.check([marker], *(len(obj.data.vertices) for obj in ends))
        for obj, point in zip(ends, marker.ends, strict=True):
            meshes.select_only(obj, point.vertex)
        settings.active_marker = self.index


class LISSOM_OT_marker_mirror(bpy.types.Operator):
    """Complete the pairs of one side of the face by their mirror images on the other.

    Pairs whose mirror symbol is off, that lie in the middle or that have a counterpart stay alone"""

    bl_idname = "lissom.marker_mirror"
    bl_label = "Mirror Markers"
    bl_options = {"REGISTER", "UNDO"}

    axis: EnumProperty(
        name="Axis",
        description="Across which plane through the objects' origins",
        items=[(axis, axis, f"Along the objects' own {axis}") for axis in "XYZ"],
    )
    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)

    @classmethod
    def poll(cls, context):
        return needs_markers(cls, context)

    @answering
    def execute(self, context):
        ends = bridge_markers.pair_of_objects(context, self.source, self.target)
        known, warnings = bridge_markers.current(context.scene, *ends)
        counts = [len(obj.data.vertices) for obj in ends]
        markers.check(known, *counts)
        surfaces = [meshes.surface(obj) for obj in ends]
        images = [
            marker_places.mirrored(*surface, [marker.point(side) for marker in known], "XYZ".index(self.axis))
            for side, surface in zip(bridge_markers.SIDES, surfaces, strict=True)
        ]
        added, lost = marker_places.completed(known, images, [vertices for vertices, _ in surfaces])
        if not added and lost:
            raise Refused(f"No counterpart is on the other side of these: {first(map(repr, lost))}")
        bridge_markers.append(context.scene, added, *ends)
        if lost:
            warnings.append(f"Without a counterpart on the other side: {first(map(repr, lost))}")
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        self.report({"INFO"}, translated(f"{len(added)} marker pairs added"))


classes = (
    LISSOM_OT_marker_add,
    LISSOM_OT_marker_remove,
    LISSOM_OT_marker_clear,
    LISSOM_OT_marker_show,
    LISSOM_OT_marker_mirror,
)
