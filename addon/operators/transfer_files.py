"""Marker files: load and save."""

import os

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ..bridge import markers as bridge_markers
from ..core import marker_file, markers
from ..core.refused import Refused
from ..translations import translated
from .job import answering
from .markers import needs_markers
from .objects import SOURCE, TARGET


def _held(pairs, curves):
    return f"{len(pairs)} marker pairs" + (f" and {len(curves)} curves" if curves else "")


class LISSOM_OT_marker_load(ImportHelper, bpy.types.Operator):
    """Read marker pairs from a file in place of the list: JSON, .cons or lines of two vertices"""

    bl_idname = "lissom.marker_load"
    bl_label = "Load Markers"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json;*.cons;*.txt", options={"HIDDEN"})

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        loaded = marker_file.load(bpy.path.abspath(self.filepath))
        if not (loaded.pairs or loaded.curves):
            raise Refused(f"Marker file '{self.filepath}' holds no pairs: the list stays as it is")
        pairs, curves, warnings = loaded.pairs, loaded.curves, []
        ends = settings.source, settings.target
        if all(ends):
            pairs, warnings = bridge_markers.of_file(loaded, *ends)
            curves = bridge_markers.curves_of_file(loaded, *ends)
            counts = [len(obj.data.vertices) for obj in ends]
            markers.check(pairs, *counts)
            markers.check_curves(curves, *counts)
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        bridge_markers.put(context.scene, pairs, *(ends if all(ends) else (None, None)), curves=curves)
        settings.active_marker = 0
        held = _held(pairs, curves)
        self.report({"INFO"}, translated(f"{held} from {os.path.basename(self.filepath)}"))


class LISSOM_OT_marker_save(ExportHelper, bpy.types.Operator):
    """Write the list of marker pairs to a JSON file"""

    bl_idname = "lissom.marker_save"
    bl_label = "Save Markers"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)

    @classmethod
    def poll(cls, context):
        return needs_markers(cls, context, or_curves=True)

    @answering
    def execute(self, context):
        source, target = bridge_markers.pair_of_objects(context, self.source, self.target)
        ends = [(obj.name, len(obj.data.vertices)) for obj in (source, target)]
        pairs, warnings = bridge_markers.current(context.scene, source, target)
        pairs = [marker for marker in pairs if not marker.guessed]
        markers.check(pairs, *(count for _, count in ends))
        curves = bridge_markers.current_curves(context.scene, source, target)
        markers.check_curves(curves, *(count for _, count in ends))
        pairs = bridge_markers.placed(pairs, source, target)
        curves = bridge_markers.curves_placed(curves, source, target)
        path = bpy.path.abspath(self.filepath)
        try:
            marker_file.save(path, pairs, *ends, curves)
        except OSError as error:
            raise Refused(f"Marker file '{path}' cannot be written: {error.strerror}") from error
        for warning in warnings:
            self.report({"WARNING"}, translated(warning))
        self.report({"INFO"}, translated(f"{_held(pairs, curves)} in {os.path.basename(path)}"))


classes = (LISSOM_OT_marker_load, LISSOM_OT_marker_save)
