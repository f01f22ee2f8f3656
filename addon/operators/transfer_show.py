"""The last fit as colours on both meshes, and where the next marker helps most."""

import bpy
import numpy as np
from bpy.props import BoolProperty, IntProperty

from .. import session
from ..bridge import checks, views
from ..bridge import markers as bridge_markers
from ..bridge.meshes import select_vertices
from ..core import markers
from ..core.refused import Refused
from ..jobs.fit import remembered
from ..jobs.fit_shown import coloured, hide, show
from ..translations import translated
from .job import allowed, answering


class LISSOM_OT_fit_show(bpy.types.Operator):
    """Show how well the last fit lies, as colours on both meshes, or take the colours away"""

    bl_idname = "lissom.fit_show"
    bl_label = "Show Fit"
    bl_options = {"REGISTER", "UNDO"}

    show: BoolProperty(name="Show", description="Off: take the colours away", default=True)

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.fit or coloured() else "Press Fit first")

    @answering
    def execute(self, context):
        (show if self.show else hide)(context)


class LISSOM_OT_fit_place(bpy.types.Operator):
    """Look at the place: it is selected, the view turns to it, and the fit is shown as colors"""

    bl_idname = "lissom.fit_place"
    bl_label = "Show Place"
    bl_options = {"REGISTER", "UNDO"}

    place: IntProperty(name="Place", description="Number of the fault in the panel", min=0)

    @classmethod
    def poll(cls, context):
        return allowed(cls, "" if session.fit else "Press Fit first")

    @answering
    def execute(self, context):
        memory, source, target = remembered()
        if self.place >= len(memory.faults):
            raise Refused(f"There is no fault {self.place}: the fit has {len(memory.faults)}")
        fault = memory.faults[self.place]
        side = source if fault.side == "source" else target
        places, towards = side.seen(fault.vertices)
        inside = np.zeros(len(side.rest()), dtype=bool)
        inside[fault.vertices] = True
        for obj, own in zip(side.objects(), side.split(inside), strict=True):
            checks.require_writable(obj, keys=False)
            select_vertices(obj, np.flatnonzero(own))
        views.show_places(context, side.objects(), places, side.rest(), towards)
        show(context)
        self.report({"INFO"}, translated(fault.line))


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
        beyond = [
            np.arange(count, len(side.rest())) for count, side in zip(counts, (source, target), strict=True)
        ]
        pairs = [(marker.source, marker.target) for marker in known]
        found = memory.fit.next_marker(pairs, source_mask=beyond[0], target_mask=beyond[1])
        if found is None:
            raise Refused("There is no vertex left that a marker would help")
        marker = markers.Marker(f"Suggested {len(known) + 1}", *found)
        markers.check([*known, marker], *counts)
        bridge_markers.append(context.scene, [marker], source.objects()[0], target.objects()[0])
        self.report({"INFO"}, translated("Look where the new marker lies on the target, and correct it"))


classes = (LISSOM_OT_fit_show, LISSOM_OT_fit_place, LISSOM_OT_marker_suggest)
