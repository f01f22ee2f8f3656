"""What operators share that bake a range of frames."""

from bpy.props import EnumProperty, IntProperty, StringProperty

from ..core import bake
from ..core.refused import Refused
from ..properties.pose import BAKE_ITEMS, BAKE_OUTPUT, BAKE_PATH, BAKE_STEP

CACHE_FILE = {
    "name": "Cache File",
    "description": BAKE_PATH,
    "subtype": "FILE_PATH",
    "options": {"SKIP_SAVE"},
}


class BakeProperties:
    """Mixin: a range of frames, and what their shapes are kept in."""

    output: EnumProperty(name="Output", description=BAKE_OUTPUT, items=BAKE_ITEMS, default="KEYS")
    frame_start: IntProperty(
        name="First Frame", description="Where not given, that of the scene", options={"SKIP_SAVE"}
    )
    frame_end: IntProperty(
        name="Last Frame", description="Where not given, that of the scene", options={"SKIP_SAVE"}
    )
    step: IntProperty(name="Step", description=BAKE_STEP, default=1, min=1, max=1000)
    name: StringProperty(
        name="Name", description="Of the shape keys, before the frame, or of the modifier", default="Pose"
    )

    def frames(self, scene):
        """The frames in rising order; Refused where there is no name, or no such range."""
        if not self.name:
            raise Refused("Give the baked keys a name first")
        for name in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(scene, name))
        return bake.frames(self.frame_start, self.frame_end, self.step, self.output == "KEYS")

    def key_names(self, frames):
        """The name of the shape key of each frame."""
        return bake.key_names(self.name, frames)
