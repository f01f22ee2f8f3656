"""Fit: which face of the source belongs to which face of the target."""

import hashlib
from typing import NamedTuple

import bpy
import numpy as np
from bpy.props import StringProperty

from .. import session
from ..bridge import checks, shape_keys
from ..bridge import markers as bridge_markers
from ..bridge.assembly import Assembly, both_sides
from ..core import marks
from ..core.colours import LIMIT
from ..core.refused import Refused
from ..core.region import weakest, words
from ..core.transfer import doubts, fit_work, told
from ..properties.transfer import (
    closest_property,
    contact_property,
    marker_tolerance_property,
    mask_property,
    match_distance_property,
    overlap_property,
    scale_property,
    unmatched_property,
)
from .job import JobOperator, allowed
from .transfer_markers import SOURCE, TARGET

MARKERS = {
    "name": "Markers",
    "description": "Marker pairs as the text of a marker file; empty: the scene's list, and where that is "
    "empty too, the shapes alone",
    "options": {"SKIP_SAVE"},
}
MARKER_FILE = {
    "name": "Marker File",
    "description": "Marker file to use in place of the scene's list",
    "subtype": "FILE_PATH",
    "options": {"SKIP_SAVE"},
}


class FitProperties:
    """Mixin: what a fit is made of."""

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    markers: StringProperty(**MARKERS)
    filepath: StringProperty(**MARKER_FILE)
    overlap: overlap_property()
    marker_tolerance: marker_tolerance_property()
    match_distance: match_distance_property()
    closest: closest_property()
    source_mask: mask_property("Source")
    target_mask: mask_property("Target")


class TransferProperties(FitProperties):
    """Mixin: what a transfer is made of."""

    unmatched: unmatched_property()
    scale: scale_property()
    contact: contact_property()

    def transfer_options(self):
        """Those of lissom.Transfer."""
        return {"unmatched": self.unmatched, "scale": self.scale, "contact": self.contact}

    def warn(self, request, fit, warnings, targets):
        """Reports what a transfer has to say that is done."""
        warnings = [*request.told(fit), *warnings]
        for warning in filter(None, [*warnings, *map(checks.shared_data, targets)]):
            self.report({"WARNING"}, warning)


def where(objects):
    """Objects in a report: by name, or where there are several by number."""
    return f"'{objects[0].name}'" if len(objects) == 1 else f"{len(objects)} objects"


class Memory(NamedTuple):
    """A fit with what it was made of: a digest to know it by, objects, pairs and curves for the panel.

    ``doubts`` has each doubtful marker, and what is said against it, by its points, not its row: rows change
    places, and a marker that is corrected is free of doubt. ``weak`` says which region is off most, or
    nothing.
    """

    digest: str
    source: Assembly
    target: Assembly
    pairs: list
    curves: list
    fit: object
    summary: str
    doubts: dict
    weak: str


def summary(report):
    """How good a fit is, in one line."""
    certainty = report["certainty"]
    sure = f", {min(99, round(100 * certainty))} % sure how the meshes lie" if certainty < 1 else ""
    return (
        f"Fit: {report['distance_mean_percent']:.2f} % off on average, "
        f"{report['unmatched_target_percent']:.1f} % of the target unmatched{sure}"
    )


def _listed(scene):
    return bridge_markers.of_scene(scene), bridge_markers.curves_of_scene(scene)


class Request:
    """Both sides and the markers of an operator, as arrays."""

    def __init__(self, operator, context):
        sources, targets = both_sides(context, operator.source, operator.target)
        self.source = Assembly(sources)
        self.target = Assembly(targets, self.source.origin if operator.overlap else None)
        self._listed = _listed(context.scene)
        given = operator.markers, operator.filepath
        self._own = not (any(given) or operator.overlap)
        if operator.overlap and any(given):
            raise Refused(
                "Meshes that overlap need no markers: give markers, or say that they overlap, not both"
            )
        self.pairs, self.curves, self.warnings = (
            ([], [], []) if operator.overlap else bridge_markers.gather(context, sources, targets, *given)
        )
        self.options = {
            name: getattr(operator, name)
            for name in ("overlap", "marker_tolerance", "match_distance", "closest")
        }
        for side in ("source", "target"):
            group = getattr(operator, f"{side}_mask")
            if group:
                self.options[f"{side}_mask"] = getattr(self, side).mask(group)
        if self.curves:
            self.options["curves"] = [tuple(map(list, curve.vertices)) for curve in self.curves]
        self._exact = operator.marker_tolerance == 0
        ends = [(marker.source, marker.target) for marker in self.pairs]
        self._vertices = np.array(ends, dtype=np.int64)
        self.markers = self._vertices if self.pairs else None
        for name, side in (("source_points", "source"), ("points", "target")):
            points = [marker.point(side) for marker in self.pairs]
            if not all(point.is_vertex for point in points):
                rest = getattr(self, side).rest()  # the main object's vertices come first
                self.options[name] = np.array([point.position(rest) for point in points])

    def geometry(self):
        """(vertices, triangles) of source and target in solve space."""
        return [self.source.geometry(), self.target.geometry()]

    def digest(self):
        """Equal exactly when a fit made for one request serves the other."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (*self.geometry()[0], *self.geometry()[1], self._vertices):
            digest.update(np.ascontiguousarray(array).tobytes())
        for name, option in self.options.items():
            digest.update(f"{name} ".encode())
            digest.update(option.tobytes() if isinstance(option, np.ndarray) else repr(option).encode())
        return digest.hexdigest()

    def known_fit(self):
        """The fit in memory, if it was made of just this."""
        return session.fit.fit if session.fit and session.fit.digest == self.digest() else None

    def _weak(self, fit):
        vertices, triangles = self.source.geometry()
        diagonal = marks.diagonal(self.target.rest())
        found = weakest(fit, triangles, LIMIT * diagonal)
        if found is None:
            return ""
        worst = found[fit.distances[found].argmax()]
        marked = [marker.source for marker in self.pairs]
        place = words(vertices[worst], vertices, marked, [marker.name for marker in self.pairs])
        off = 100 * fit.distances[worst] / diagonal
        return f"Least sure {place} of the source, up to {off:.1f} % off: look there"

    def told(self, fit):
        """What there is to warn of, about the markers and the fit."""
        return [*self.warnings, *told(fit, self.pairs, self._exact, [curve.name for curve in self.curves])]

    def remember(self, context, fit):
        """Keeps the fit for the next transfer, and in the scene where its markers are now."""
        ends = [marker.ends for marker in self.pairs]
        doubted = {ends[i]: (self.pairs[i], why) for i, why in doubts(fit, self._exact).items()}
        curves = [curve.texts for curve in self.curves]
        known = self.digest(), self.source, self.target, ends, curves
        session.fit = Memory(*known, fit, summary(fit.report), doubted, self._weak(fit))
        if self._own and any(self._listed) and self._listed == _listed(context.scene):
            ends = self.source.objects()[0], self.target.objects()[0]
            fitted = iter(self.pairs)
            pairs = [marker if marker.guessed else next(fitted) for marker in self._listed[0]]
            bridge_markers.put(context.scene, pairs, *ends, curves=self.curves)


def ready(operator_class, context, keys=False, writes=False):
    """poll(): what the panel still misses, said on its buttons; scripts' calls are checked as they run."""
    settings = getattr(context, "lissom_transfer", None)
    reason = ""
    if settings is not None:
        try:
            sources, targets = both_sides(context, "", "")
        except Refused:
            return allowed(operator_class, "Choose two different objects as source and target first")
        if keys and not key_names(sources):
            reason = f"'{sources[0].name}' has no shape keys to carry over"
        elif keys and settings.which == "SELECTED" and not len(settings.chosen):
            reason = "Tick the shape keys to carry over first"
        elif keys or writes:
            reason = next(filter(None, map(checks.refusal, targets)), "")
    return allowed(operator_class, reason)


def key_names(objects):
    """Names of the shape keys that these objects have, each once, in their order."""
    return list(dict.fromkeys(name for obj in objects for name in shape_keys.key_names(obj)))


class LISSOM_OT_transfer_fit(FitProperties, JobOperator, bpy.types.Operator):
    """Pull the source onto the target, by markers or else by shape, and find which faces belong together"""

    bl_idname = "lissom.transfer_fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready(cls, context)

    def begin(self, context):
        self._request = Request(self, context)
        return fit_work(*self._request.geometry(), self._request.markers, self._request.options)

    def finish(self, context, fit):
        self._request.source.find()
        self._request.target.find()
        self._request.remember(context, fit)
        for warning in self._request.told(fit):
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, summary(fit.report))


classes = (LISSOM_OT_transfer_fit,)
