"""Fit: which face of the source belongs to which face of the target."""

import hashlib
from dataclasses import dataclass, make_dataclass
from typing import NamedTuple

import bpy
import numpy as np

from .. import session
from ..bridge import checks, shape_keys
from ..bridge import markers as bridge_markers
from ..bridge.assembly import Assembly, both_sides
from ..core import faults, marker_places
from ..core.colours import LIMIT
from ..core.refused import Refused
from ..core.transfer import doubts, fit_work, told
from ..core.transfer_options import MASKS, OPTIONS, values
from . import Asked, Done


def _options(owner):
    """A base of what is asked for, with the fields that are options of ``owner``."""
    own = [(name, type(one.default), one.default) for name, one in OPTIONS[owner].items()]
    return make_dataclass(f"{owner.capitalize()}Options", own, bases=(Asked,), kw_only=True)


@dataclass(kw_only=True)
class FitAsked(_options("fit")):
    """What a fit is made of; objects by name, one a line, or "" for the scene's."""

    source: str = ""
    target: str = ""
    markers: str = ""  # the text of a marker file; "": the scene's list, or none
    filepath: str = ""  # a marker file in place of it
    source_mask: str = ""  # vertex groups that match nothing
    target_mask: str = ""


@dataclass(kw_only=True)
class TransferAsked(_options("transfer"), FitAsked):
    """What a transfer is made of."""

    @property
    def options(self):
        """Those of lissom.Transfer."""
        return values(self, "transfer")


class Memory(NamedTuple):
    """A fit with what it was made of: a digest to know it by, objects, pairs and curves for the panel.

    ``doubts`` has each doubtful marker, and what is said against it, by its points, not its row: rows change
    places, and a marker that is corrected is free of doubt. ``faults`` are the core.faults.Fault of the fit,
    the worst first.
    """

    digest: str
    source: Assembly
    target: Assembly
    pairs: list
    curves: list
    fit: object
    summary: str
    doubts: dict
    faults: list


@dataclass(kw_only=True)
class FitDone(Done):
    """``fit``: the Memory of the fit that was made or used."""

    fit: Memory

    @property
    def kept(self):
        """All but the faults of the fit, which the panel shows with their places."""
        faults = {fault.line for fault in self.fit.faults}
        return [line for line in self.warnings if line not in faults]

    @property
    def doubtful_markers(self):
        """As they are written to a file."""
        return [
            {"name": marker.name, "source": marker.source, "target": marker.target, "reason": why}
            for marker, why in self.fit.doubts.values()
        ]


def summary(report):
    """How good a fit is, in one line."""
    told = (
        f"Fit: {report['distance_mean_percent']:.2f} % off on average, "
        f"{report['unmatched_target_percent']:.1f} % of the target unmatched"
    )
    return "; ".join([told, *sure(report)])


def sure(report):
    """How sure it is that the meshes lie as they were taken to, where that is not certain: lines."""
    certainty = report["certainty"]
    return [f"{min(99, round(100 * certainty))} % sure how the meshes lie"] if certainty < 1 else []


def where(objects):
    """Objects in a report: by name, or where there are several by number."""
    return f"'{objects[0].name}'" if len(objects) == 1 else f"{len(objects)} objects"


def key_names(objects):
    """Names of the shape keys that these objects have, each once, in their order."""
    return list(dict.fromkeys(name for obj in objects for name in shape_keys.key_names(obj)))


def remembered():
    """The last fit, and both sides of it as they are now; Refused where there is none for them."""
    memory = session.fit
    if memory is None:
        raise Refused("Press Fit first")
    found = [
        [bpy.data.objects.get(part.key) for part in side.parts] for side in (memory.source, memory.target)
    ]
    if None in found[0] + found[1]:
        raise Refused("An object of the last fit is gone: press Fit again")
    source = Assembly(found[0])
    overlap = memory.target.origin is memory.source.origin
    target = Assembly(found[1], source.origin if overlap else None)
    for then, now in ((memory.source, source), (memory.target, target)):
        if not all(map(np.array_equal, then.geometry(), now.geometry())):
            raise Refused("A mesh was changed since the last fit: press Fit again")
    return memory, source, target


def _listed(scene):
    return bridge_markers.of_scene(scene), bridge_markers.curves_of_scene(scene)


class Request:
    """Both sides and the markers of what is asked, as arrays."""

    def __init__(self, context, asked):
        sources, targets = both_sides(context, asked.source, asked.target)
        self.source = Assembly(sources)
        self.target = Assembly(targets, self.source.origin if asked.overlap else None)
        self._listed = _listed(context.scene)
        given = asked.markers, asked.filepath
        self._own = not (any(given) or asked.overlap)
        if asked.overlap and any(given):
            raise Refused(
                "Meshes that overlap need no markers: give markers, or say that they overlap, not both"
            )
        self.pairs, self.curves, self.warnings = (
            ([], [], []) if asked.overlap else bridge_markers.gather(context, sources, targets, *given)
        )
        self.options = values(asked, "fit")
        for mask, side in zip(MASKS, (self.source, self.target), strict=True):
            if getattr(asked, mask):
                self.options[mask] = side.mask(getattr(asked, mask))
        if self.curves:
            self.options["curves"] = [tuple(map(list, curve.vertices)) for curve in self.curves]
        self._exact = asked.marker_tolerance == 0
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

    def fit(self):
        """For core.transfer.known_steps: the fit in memory if it is made of this, else what makes one."""
        known = session.fit and session.fit.digest == self._digest()
        return session.fit.fit if known else (self.markers, self.options)

    def require_writable(self, keys=True):
        """The target's objects; Refused where nothing can be written to one. With ``keys``: to its keys."""
        targets = self.target.find()
        for target in targets:
            checks.require_writable(target, keys)
        return targets

    def remember(self, context, fit):
        """Keeps the fit for the next transfer, and in the scene where its markers are now; its Memory."""
        ends = [marker.ends for marker in self.pairs]
        doubted = {ends[i]: (self.pairs[i], why) for i, why in doubts(fit, self._exact).items()}
        curves = [curve.texts for curve in self.curves]
        known = self._digest(), self.source, self.target, ends, curves
        session.fit = Memory(*known, fit, summary(fit.report), doubted, self._faults(fit))
        if self._own and any(self._listed) and self._listed == _listed(context.scene):
            ends = self.source.objects()[0], self.target.objects()[0]
            fitted = iter(self.pairs)
            pairs = [marker if marker.guessed else next(fitted) for marker in self._listed[0]]
            bridge_markers.put(context.scene, pairs, *ends, curves=self.curves)
        return session.fit

    def told(self, fit):
        """What there is to warn of, about the markers and the fit."""
        return [*self.warnings, *told(fit, self.pairs, self._exact, [curve.name for curve in self.curves])]

    def told_of_transfer(self, fit, warnings, what="shape keys"):
        """The same with a transfer's own warnings, and those of meshes that several objects have."""
        shared = [checks.shared_data(obj, what) for obj in self.target.objects()]
        return [*self.told(fit), *warnings, *filter(None, shared)]

    def _digest(self):
        """Equal exactly when a fit made for one request serves the other."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (*self.geometry()[0], *self.geometry()[1], self._vertices):
            digest.update(np.ascontiguousarray(array).tobytes())
        for name, option in self.options.items():
            digest.update(f"{name} ".encode())
            digest.update(option.tobytes() if isinstance(option, np.ndarray) else repr(option).encode())
        return digest.hexdigest()

    def _faults(self, fit):
        names = [marker.name for marker in self.pairs]
        sides = [
            faults.Side(*mesh, [getattr(marker, side) for marker in self.pairs], names)
            for side, mesh in zip(("source", "target"), self.geometry(), strict=True)
        ]
        diagonal = marker_places.diagonal(self.target.rest())
        masked = self.options.get("target_mask", ())
        return faults.of_fit(fit, *sides, LIMIT * diagonal, diagonal, masked)


class Fit:
    """The source pulled onto the target."""

    def __init__(self, context, asked):
        self._request = Request(context, asked)
        self.work = fit_work(*self._request.geometry(), self._request.markers, self._request.options)

    def write(self, context, fit):
        """Keeps a fit of lissom.fit_correspondence; a FitDone."""
        self._request.source.find()
        self._request.target.find()
        memory = self._request.remember(context, fit)
        grave = [fault.line for fault in memory.faults if fault.grave]
        return FitDone(summary=memory.summary, warnings=[*grave, *self._request.told(fit)], fit=memory)
