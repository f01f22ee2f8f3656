"""Drawings: a flat mesh of an image, and a second image at the end of its arc."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..jobs.image import ImageAsked, ImageMesh, lay_second
from ..properties.image import ImageSettings
from .arcs import arc_poll
from .job import JobRunner, allowed, answering, report_done
from .objects import OBJECT

_FILTER = {
    "name": "Filter",
    "description": "What Blender's file browser shows",
    "default": True,
    "options": {"HIDDEN", "SKIP_SAVE"},
}


class ImageFile:
    """Mixin: an operator on an image of the file or on disk."""

    image: StringProperty(
        name="Image", description="Name of an image in this file; empty: the file", options={"SKIP_SAVE"}
    )
    filepath: StringProperty(
        name="File", description="Image file to open", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )
    filter_image: BoolProperty(**_FILTER)
    filter_folder: BoolProperty(**_FILTER)

    def invoke(self, context, event):
        if not self.image and not self.filepath:
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        return super().invoke(context, event)


class LISSOM_OT_inbetween_image(ImageFile, JobRunner, ImageSettings, bpy.types.Operator):
    """Make a flat mesh of what an image shows, to be posed by handles in its plane"""

    bl_idname = "lissom.inbetween_image"
    bl_label = "Image Mesh"
    bl_options = {"REGISTER", "UNDO"}

    height: FloatProperty(
        name="Height", description="Height of the whole image", default=2.0, min=1e-6, unit="LENGTH"
    )

    job_class, asked_class = ImageMesh, ImageAsked

    @classmethod
    def poll(cls, context):
        reason = "" if context.mode == "OBJECT" else "Go to Object Mode first"
        return allowed(cls, reason)


class _Plain:
    """The end of a chain of invoke(): what is left runs at once."""

    def invoke(self, context, event):
        return self.execute(context)


class LISSOM_OT_inbetween_second_image(ImageFile, _Plain, bpy.types.Operator):
    """Lay a second image under the end of an arc: its slider dissolves from the first image to it"""

    bl_idname = "lissom.inbetween_second_image"
    bl_label = "Second Image"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    slider: StringProperty(
        name="Slider",
        description="Slider of the arc; empty: that of the last one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return arc_poll(cls, context)

    @answering
    def execute(self, context):
        report_done(self, lay_second(context, self.object, self.slider, self.image, self.filepath))


def _draw_add(menu, context):
    menu.layout.operator_context = "INVOKE_DEFAULT"
    menu.layout.operator(LISSOM_OT_inbetween_image.bl_idname, icon="IMAGE_DATA")


def _draw_image(menu, context):
    if context.space_data.image is not None:
        made = menu.layout.operator(LISSOM_OT_inbetween_image.bl_idname, icon="MESH_DATA")
        made.image = context.space_data.image.name


def register():
    bpy.types.VIEW3D_MT_mesh_add.append(_draw_add)
    bpy.types.IMAGE_MT_image.append(_draw_image)


def unregister():
    bpy.types.IMAGE_MT_image.remove(_draw_image)
    bpy.types.VIEW3D_MT_mesh_add.remove(_draw_add)


classes = (LISSOM_OT_inbetween_image, LISSOM_OT_inbetween_second_image)
