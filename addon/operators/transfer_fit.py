"""Fit: which face of the source belongs to which face of the target."""

import hashlib
from typing import NamedTuple

import bpy
import numpy as np
from bpy.props import StringProperty

from .. import session
from ..bridge import checks, groups, meshes, shape_keys
from ..bridge import markers as bridge_markers
from ..core import space
from ..core.transfer import fit_work
from ..properties.transfer import mask_property, match_distance_property
from .job import JobOperator, allowed
from .transfer_markers import SOURCE, TARGET

MARKERS = {
    "name": "Markers",
    "description": "Marker pairs as the text of a marker file; empty: the scene's list",
    "options": {"SKIP_SAVE"},
}
MARKER_FILE = {
    "name": "Marker File",
    "description": "Marker file to use in place of the scene's list",
    "subtype": "FILE_PATH",
    "options": {"SKIP_SAVE"},
}


class Memory(NamedTuple):
    """A fit with what it was made of: the digest for certainty, names and pairs for the panel."""

    digest: str
    source: str
    target: str
    pairs: list
    fit: object
    summary: str


def summary(report):
    """How good a fit is, in one line."""
    return (
        f"Fit: {report['distance_mean_percent']:.2f} % off on average, "
        f"{report['unmatched_target_percent']:.1f} % of the target unmatched"
    )


class Request:
    """Both meshes and the markers of an operator, as arrays."""

    def __init__(self, operator, context):
        source, target = bridge_markers.pair_of_objects(context, operator.source, operator.target)
        self.source, self.target = (
            meshes.Snapshot.of(obj, space.linear_part(obj.matrix_world, obj.name)) for obj in (source, target)
        )
        self.pairs, self.warnings = bridge_markers.gather(
            context, source, target, operator.markers, operator.filepath
        )
        self.options = {"match_distance": operator.match_distance}
        for name, obj in (("source_mask", source), ("target_mask", target)):
            group = getattr(operator, name)
            if group:
                self.options[name] = groups.mask(obj, group)
        markers = [(marker.source, marker.target) for marker in self.pairs]
        self.markers = np.array(markers, dtype=np.int64).reshape(-1, 2)

    def geometry(self):
        """(vertices, triangles) of source and target in solve space."""
        return [self.source.geometry(), self.target.geometry()]

    def digest(self):
        """Equal exactly when a fit made for one request serves the other."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (*self.geometry()[0], *self.geometry()[1], self.markers):
            digest.update(np.ascontiguousarray(array).tobytes())
        for name, option in self.options.items():
            digest.update(f"{name} ".encode())
            digest.update(option.tobytes() if isinstance(option, np.ndarray) else repr(option).encode())
        return digest.hexdigest()

    def known_fit(self):
        """The fit in memory, if it was made of just this."""
        return session.fit.fit if session.fit and session.fit.digest == self.digest() else None

    def remember(self, fit):
        """Keeps the fit for the next transfer."""
        session.fit = Memory(
            self.digest(), self.source.name, self.target.name, self.pairs, fit, summary(fit.report)
        )


def ready(operator_class, context, keys=False):
    """poll(): what the panel still misses, said on its buttons; scripts' calls are checked as they run."""
    settings = getattr(context, "lissom_transfer", None)
    reason = ""
    if settings is not None:
        source, target = settings.source, settings.target
        if source is None or target is None or source == target:
            reason = "Choose two different objects as source and target first"
        elif not len(settings.markers) and not bridge_markers.needless(source, target):
            reason = "Add marker pairs first: at least three, ten or more for a face"
        elif keys and not shape_keys.key_names(source):
            reason = f"'{source.name}' has no shape keys to carry over"
        elif keys and settings.which == "SELECTED" and not len(settings.chosen):
            reason = "Tick the shape keys to carry over first"
        elif keys:
            reason = checks.refusal(target)
    return allowed(operator_class, reason)


class LISSOM_OT_transfer_fit(JobOperator, bpy.types.Operator):
    """Pull the source onto the target by the markers, and find which faces belong together"""

    bl_idname = "lissom.transfer_fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    source: StringProperty(**SOURCE)
    target: StringProperty(**TARGET)
    markers: StringProperty(**MARKERS)
    filepath: StringProperty(**MARKER_FILE)
    match_distance: match_distance_property()
    source_mask: mask_property("Source")
    target_mask: mask_property("Target")

    @classmethod
    def poll(cls, context):
        return ready(cls, context)

    def begin(self, context):
        self._request = Request(self, context)
        return fit_work(*self._request.geometry(), self._request.markers, self._request.options)

    def finish(self, context, fit):
        self._request.source.find()
        self._request.target.find()
        self._request.remember(fit)
        for warning in [*self._request.warnings, *fit.report["warnings"]]:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, summary(fit.report))


classes = (LISSOM_OT_transfer_fit,)
