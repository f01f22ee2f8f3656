"""The last fit as colours on both meshes, and where the next marker helps most."""

import bpy
import numpy as np
from bpy.props import BoolProperty

from .. import session
from ..bridge import checks, colours
from ..bridge import markers as bridge_markers
from ..core import markers
from ..core.colours import LIMIT, of_fit
from ..core.refused import Refused
from ..core.suggest import suggest
from ..jobs.fit import remembered
from .job import allowed, answering


class LISSOM_OT_fit_show(bpy.types.Operator):
    """Show how well the last fit lies, as colours on both meshes, or take the colours away"""

    bl_idname = "lissom.fit_show"
    bl_label = "Show Fit"
    bl_options = {"REGISTER", "UNDO"}

    show: BoolProperty(name="Show", description="Off: take the colours away", default=True)

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.fit or shown_objects() else "Press Fit first")

    @answering
    def execute(self, context):
        if not self.show:
            for obj in shown_objects():
                colours.hide(obj)
            colours.views_back()
            return
        memory, source, target = remembered()
        objects = source.objects() + target.objects()
        for obj in objects:
            reason = checks.refusal(obj, keys=False)
            if reason:
                raise Refused(reason)
        diagonal = float(np.linalg.norm(np.ptp(target.rest(), axis=0)))
        found = of_fit(memory.fit, source.geometry()[1], diagonal, LIMIT)
        for side, values in zip((source, target), found, strict=True):
            for obj, own in zip(side.objects(), side.split(values), strict=True):
                colours.show(obj, own)
        colours.views_show()


def shown_objects():
    """The mesh objects that bear the colours of a fit."""
    return [obj for obj in bpy.data.objects if obj.type == "MESH" and colours.shown(obj)]


class LISSOM_OT_marker_suggest(bpy.types.Operator):
    """Add a marker where the last fit is least certain; correct its place on the target, then fit again"""

    bl_idname = "lissom.marker_suggest"
    bl_label = "Suggest Marker"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.fit else "Press Fit first")

    @answering
    def execute(self, context):
        memory, source, target = remembered()
        known = [marker for marker in bridge_markers.of_scene(context.scene) if not marker.guessed]
        if not known:  # a first marker alone would say less than the shapes do
            raise Refused("There are no markers to add to: mark three pairs yourself first")
        if [marker.ends for marker in known] != memory.pairs:
            raise Refused("The markers were changed since the last fit: press Fit again")
        counts = len(source.parts[0].vertices), len(target.parts[0].vertices)
        # Markers lie on the first object of each side.
        vertices, triangles = source.geometry()
        marked = np.array([marker.source for marker in known])
        near = target.rest()[: counts[1]].copy()
        near[[marker.target for marker in known]] = np.inf
        found = suggest(memory.fit, (vertices, triangles), near, marked)
        if found is None or found[0] >= counts[0]:
            raise Refused("There is no vertex left that a marker would help")
        marker = markers.Marker(f"Suggested {len(known) + 1}", *found)
        markers.check([*known, marker], *counts)
        bridge_markers.append(context.scene, [marker], source.objects()[0], target.objects()[0])
        self.report({"INFO"}, "Look where the new marker lies on the target, and correct it")


classes = (LISSOM_OT_fit_show, LISSOM_OT_marker_suggest)
