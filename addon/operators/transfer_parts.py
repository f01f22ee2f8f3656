"""Further objects of the source and the target; the table of quality as a file, and its faces selected."""

import json
import os

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ..bridge import checks
from ..bridge.meshes import select_vertices
from ..core.quality import as_dicts, unpack_faces
from ..core.refused import Refused
from ..translations import translated
from .job import allowed, answering


class LISSOM_OT_transfer_parts(bpy.types.Operator):
    """Add the selected mesh objects to this side: eyes, teeth, lashes that are objects of their own"""

    bl_idname = "lissom.transfer_parts"
    bl_label = "Add Selected Objects"
    bl_options = {"REGISTER", "UNDO"}

    side: EnumProperty(
        name="Side",
        description="Which side they belong to",
        items=[("SOURCE", "Source", "Where keys come from"), ("TARGET", "Target", "Where keys go to")],
    )
    remove: IntProperty(
        name="Remove",
        description="Place of the object to take away; -1: add the selected ones",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        parts = getattr(settings, f"{self.side.lower()}_parts")
        if self.remove >= 0:
            if self.remove >= len(parts):
                raise Refused(f"There is no further object {self.remove}: there are {len(parts)}")
            parts.remove(self.remove)
            return
        rows = [*settings.source_parts, *settings.target_parts]
        taken = {settings.source, settings.target, *(row.object for row in rows)}
        new = [obj for obj in context.selected_objects if obj.type == "MESH" and obj not in taken]
        if not new:
            raise Refused(
                f"Select mesh objects that go along with the {self.side.lower()}, such as eyes or teeth, "
                "then press again"
            )
        if getattr(settings, self.side.lower()) is None:
            raise Refused(f"Choose the {self.side.lower()} object first")
        for obj in new:
            parts.add().object = obj


def _judged(operator_class, context):
    there = len(context.scene.lissom_transfer.quality)
    return allowed(operator_class, "" if there else "Transfer with Check Quality first")


class LISSOM_OT_quality_save(ExportHelper, bpy.types.Operator):
    """Write what was said about each transferred shape key to a JSON file"""

    bl_idname = "lissom.quality_save"
    bl_label = "Save Quality"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return _judged(cls, context)

    @answering
    def execute(self, context):
        path = bpy.path.abspath(self.filepath)
        rows = as_dicts(context.scene.lissom_transfer.quality)
        try:
            with open(path, "w", encoding="utf-8") as file:
                json.dump({"keys": rows}, file, indent=1, ensure_ascii=False)
        except OSError as error:
            raise Refused(f"'{path}' cannot be written: {error.strerror}") from error
        self.report({"INFO"}, translated(f"{len(rows)} shape keys in {os.path.basename(path)}"))


class LISSOM_OT_quality_select(bpy.types.Operator):
    """Select the faces of this key that are to be looked at, and make it the active one"""

    bl_idname = "lissom.quality_select"
    bl_label = "Select Faces"
    bl_options = {"REGISTER", "UNDO"}

    key: StringProperty(name="Key", description="Name of the shape key in the table", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return _judged(cls, context)

    @answering
    def execute(self, context):
        row = context.scene.lissom_transfer.quality.get(self.key)
        if row is None:
            raise Refused(f"The table has no shape key named '{self.key}'")
        faces = unpack_faces(row.faces)
        if not faces:
            raise Refused(f"'{self.key}' has no faces to look at")
        found = {checks.mesh_object(name, context): own for name, own in faces.items()}
        for obj, own in found.items():
            checks.require_writable(obj)
            if max(own) >= len(obj.data.polygons):
                raise Refused(f"The mesh of '{obj.name}' was changed since: transfer again")
        for obj, own in found.items():
            select_vertices(obj, {v for face in own for v in obj.data.polygons[face].vertices})
            keys = obj.data.shape_keys
            if keys and self.key in keys.key_blocks:
                obj.active_shape_key_index = keys.key_blocks.find(self.key)
        count = sum(map(len, faces.values()))
        self.report({"INFO"}, translated(f"{count} faces to look at: {', '.join(row.reasons.splitlines())}"))


classes = (LISSOM_OT_transfer_parts, LISSOM_OT_quality_save, LISSOM_OT_quality_select)
