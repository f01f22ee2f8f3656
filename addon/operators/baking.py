"""What operators share that bake a range of frames."""

from bpy.props import EnumProperty, IntProperty, StringProperty

from ..core import names
from ..core.refused import Refused
from ..properties.pose import BAKE_ITEMS, BAKE_OUTPUT, BAKE_PATH, BAKE_STEP

MOST_KEYS = 10_000
MOST_FRAMES = 1_000_000
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
        start, end = self.frame_start, self.frame_end
        if end < start:
            raise Refused(f"The last frame, {end}, is before the first, {start}")
        count = (end - start) // self.step + 1
        if count > MOST_FRAMES:
            raise Refused(f"{count} frames are too many: raise the step, or bake in parts")
        frames = list(range(start, end + 1, self.step))
        if self.output == "KEYS" and len(frames) > MOST_KEYS:
            raise Refused(
                f"{len(frames)} shape keys are too many for Blender: raise the step, or bake a cache"
            )
        return frames

    def key_names(self, frames):
        """The name of the shape key of each frame."""
        return [names.shorten(self.name, f" {frame:04d}") for frame in frames]

    def summary(self, where, frames):
        """What was baked, in one line."""
        what = "a point cache" if self.output == "CACHE" else f"{len(frames)} shape keys"
        return f"{where} plays frames {frames[0]} to {frames[-1]} from {what}"
