"""Landmarks: paired by their names, and the missing ones guessed from a fit."""

import bpy
import numpy as np

from ..bridge import landmarks
from ..bridge import markers as bridge_markers
from ..bridge.markers import SIDES
from ..bridge.meshes import surface
from ..core import markers
from ..core.refused import Refused
from ..core.surface import closest
from ..core.transfer import fit_work
from .job import JobOperator, answering
from .transfer_fit import FitProperties, Request, ready


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
        self.report({"INFO"}, f"{len(added)} landmarks paired")


class LISSOM_OT_landmarks_guess(FitProperties, JobOperator, bpy.types.Operator):
    """Put the landmarks that the target lacks where a fit of the markers so far has them. They are grey, and
    count only once they are dragged, or confirmed in the list"""

    bl_idname = "lissom.landmarks_guess"
    bl_label = "Guess the Rest"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready(cls, context)

    def begin(self, context):
        self._request = request = Request(self, context)
        source, target = (side.objects()[0] for side in (request.source, request.target))
        self._ends = source.name, target.name
        marked = {marker.name for marker in bridge_markers.of_scene(context.scene) if not marker.guessed}
        names = landmarks.names(context.scene.lissom_transfer)
        borne = landmarks.of(source)
        self._missing = [name for name in names or borne if name in borne and name not in marked]
        if not self._missing:
            raise Refused(
                f"'{source.name}' bears no landmark that is not paired: mark them on the source first, by "
                "Pick with a set of landmarks, or choose a source that has them"
            )
        self._points = [borne[name] for name in self._missing]
        return fit_work(*request.geometry(), request.markers, request.options)

    def finish(self, context, fit):
        ends = [bpy.data.objects.get(name) for name in self._ends]
        if None in ends:
            raise Refused("The source or the target is gone: nothing was changed")
        surfaces = [surface(obj) for obj in ends]
        fitted = np.array([point.position(fit.fitted_vertices) for point in self._points])
        rest = self._request.target.rest()[: len(surfaces[1][0])]
        points, _ = closest(rest, surfaces[1][1], fitted)
        known, _ = bridge_markers.current(context.scene, *ends)
        kept = [marker for marker in known if not (marker.guessed and marker.name in self._missing)]
        taken = [{marker.point(side) for marker in kept} for side in SIDES]
        added = []
        for name, *pair in zip(self._missing, self._points, points, strict=True):
            if any(point in side for point, side in zip(pair, taken, strict=True)):
                continue
            for point, side in zip(pair, taken, strict=True):
                side.add(point)
            added.append(markers.Marker.between(name, *pair)._replace(guessed=True))
        bridge_markers.put(context.scene, kept, *ends)
        bridge_markers.append(context.scene, added, *ends)
        certainty = fit.report["certainty"]
        sure = f", {min(99, round(100 * certainty))} % sure how the meshes lie" if certainty < 1 else ""
        self.report({"INFO"}, f"{len(added)} landmarks guessed{sure}: drag what is off, then confirm")


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
        for row in guessed:
            row.guessed = False
        pairs = bridge_markers.of_scene(context.scene)
        for side in SIDES:
            landmarks.keep(getattr(settings, side), pairs, side)
        self.report({"INFO"}, f"{len(guessed)} landmarks confirmed")


classes = (LISSOM_OT_landmarks_pair, LISSOM_OT_landmarks_guess, LISSOM_OT_landmarks_confirm)
