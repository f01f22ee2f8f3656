"""Landmarks: paired by their names, and the missing ones guessed from a fit."""

import bpy

from ..bridge import landmarks
from ..bridge import markers as bridge_markers
from ..bridge.markers import SIDES
from ..core import markers
from ..core.refused import Refused
from ..jobs.fit import FitAsked
from ..jobs.landmarks import GuessLandmarks
from ..translations import translated
from .job import JobRunner, answering
from .transfer import FitProperties, ready


class LISSOM_OT_landmarks_pair(bpy.types.Operator):
    """Pair all landmarks that source and target both bear by the same name"""

    bl_idname = "lissom.landmarks_pair"
    bl_label = "Pair by Name"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready(cls, context)

    @answering
    def execute(self, context):
        ends = bridge_markers.pair_of_objects(context, "", "")
        known, _ = bridge_markers.current(context.scene, *ends)
        taken = {marker.name for marker in known}
        borne = [landmarks.of(obj) for obj in ends]
        shared = [name for name in borne[0] if name in borne[1] and name not in taken]
        if not shared:
            raise Refused(
                f"'{ends[0].name}' and '{ends[1].name}' bear no further landmarks of the same name: name "
                "markers in the list, and they are kept on both meshes"
            )
        added = [markers.Marker.between(name, *(side[name] for side in borne)) for name in shared]
        markers.check([*known, *added], *(len(obj.data.vertices) for obj in ends))
        bridge_markers.append(context.scene, added, *ends)
        self.report({"INFO"}, translated(f"{len(added)} landmarks paired"))


class LISSOM_OT_landmarks_guess(FitProperties, JobRunner, bpy.types.Operator):
    """Put the landmarks that the target lacks where a fit of the markers so far has them. They are grey, and
    count only once they are dragged, or confirmed in the list"""

    bl_idname = "lissom.landmarks_guess"
    bl_label = "Guess the Rest"
    bl_options = {"REGISTER", "UNDO"}

    job_class, asked_class = GuessLandmarks, FitAsked

    @classmethod
    def poll(cls, context):
        return ready(cls, context)


class LISSOM_OT_landmarks_confirm(bpy.types.Operator):
    """Take all guessed landmarks as they lie: from now on the fit follows them"""

    bl_idname = "lissom.landmarks_confirm"
    bl_label = "Confirm Guesses"
    bl_options = {"REGISTER", "UNDO"}

    @answering
    def execute(self, context):
        settings = context.scene.lissom_transfer
        guessed = [row for row in settings.markers if row.guessed]
        if not guessed:
            raise Refused("No marker is guessed")
        if settings.source is None or settings.target is None:
            raise Refused("Choose two different objects as source and target first")
        for row in guessed:
            row.guessed = False
        pairs = bridge_markers.of_scene(context.scene)
        for side in SIDES:
            landmarks.keep(getattr(settings, side), pairs, side)
        self.report({"INFO"}, translated(f"{len(guessed)} landmarks confirmed"))


classes = (LISSOM_OT_landmarks_pair, LISSOM_OT_landmarks_guess, LISSOM_OT_landmarks_confirm)
