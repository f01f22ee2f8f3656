"""The list of marker pairs: add, remove, clear, show and mirror."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ..bridge import markers as bridge_markers
from ..bridge.screen import redraw_views
from ..jobs import marks
from ..translations import translated
from .job import answering, report_done
from .markers import needs_markers, needs_pair
from .objects import SOURCE, TARGET


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
        ends, vertices = (self.source, self.target), (self.source_vertex, self.target_vertex)
        for warning in marks.add(context, ends, vertices, self.name):
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
        bridge_markers.remove(context.scene, marks.at(settings, index))


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
        marks.show(context, self.index)


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
        report_done(self, marks.mirror(context, (self.source, self.target), self.axis))


classes = (
    LISSOM_OT_marker_add,
    LISSOM_OT_marker_remove,
    LISSOM_OT_marker_clear,
    LISSOM_OT_marker_show,
    LISSOM_OT_marker_mirror,
)
