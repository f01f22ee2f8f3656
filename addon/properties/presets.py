"""What presets of the options of the three jobs hold."""

from ..core.pose_options import OPTIONS as POSE_OPTIONS
from ..core.transfer_options import OPTIONS as TRANSFER_OPTIONS
from .inbetween import OPTIONS as PATH_OPTIONS
from .inbetween import ArcSettings

# What a preset holds is what does not name parts of one mesh, as masks and keys do.
POSE = ("method", "symmetry", "stands", "use_weights", "weld", "stays")
TRANSFER = (
    *(name for own in TRANSFER_OPTIONS.values() for name in own),
    *("exists", "edited", "drivers", "drop_empty", "check"),
)
INBETWEEN = (*PATH_OPTIONS, *ArcSettings.__annotations__)

# For each job: lines that give a file of Python its ``settings``, and what it sets there.
_ACTIVE = "obj = bpy.context.object\nobj = obj.lissom_handle_of or obj"
FILES = {
    "pose": (
        [_ACTIVE, "settings = obj.lissom_pose"],
        [f"settings.{name}" for name in POSE]
        + [f"settings.options.{owner}.{name}" for owner, own in POSE_OPTIONS.items() for name in own],
    ),
    "transfer": (
        ["settings = bpy.context.scene.lissom_transfer"],
        [f"settings.{name}" for name in TRANSFER],
    ),
    "inbetween": (
        [_ACTIVE, "settings = obj.lissom_inbetween"],
        [f"settings.{name}" for name in INBETWEEN],
    ),
}


def folder(job):
    """The folder of a job's presets, below that of all presets."""
    return f"lissom/{job}"
