"""Landmarks that the target lacks, guessed from a fit."""

from dataclasses import dataclass

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
from . import Done
from .fit import Request, sure


@dataclass(kw_only=True)
class GuessDone(Done):
    """``guessed``: names of the markers that were added."""

    guessed: list[str]


class GuessLandmarks:
    """Landmarks of the source put where a fit of the markers so far has them on the target."""

    def __init__(self, context, asked):
        self._request = request = Request(context, asked)
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
        self.work = fit_work(*request.geometry(), request.markers, request.options)

    def write(self, context, fit):
        """Puts the markers where a fit has them, as guesses; a GuessDone."""
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
        told = [f"{len(added)} landmarks guessed: drag what is off, then confirm", *sure(fit.report)]
        return GuessDone(summary="; ".join(told), warnings=[], guessed=[marker.name for marker in added])
