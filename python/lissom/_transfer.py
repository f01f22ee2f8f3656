"""Carry the shapes of one mesh over to another."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _native
from ._native import Job, Mesh
from ._report import Report

if TYPE_CHECKING:
    from typing import Unpack

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._option_types import FitOptions, TransferOptions


@dataclass(frozen=True, eq=False)
class FitReport(Report):
    """What a fit says about itself. Distances are those of fitted vertices to the target."""

    distance_mean: float
    """Their mean, in the target's units."""
    distance_max: float
    """Their largest, in the target's units."""
    distance_mean_percent: float
    """Their mean, in percent of the target's diagonal."""
    distance_max_percent: float
    """Their largest, in percent of the target's diagonal."""
    flipped_triangles: int
    """Fitted triangles that face against the target where they lie."""
    distorted_triangles: int
    """Fitted triangles three times as long as the usual one, or a third as wide."""
    unmatched_source_triangles: int
    """Source triangles without a match."""
    unmatched_target_triangles: int
    """Target triangles without a match."""
    unmatched_source_percent: float
    """Their share of the source's area, in percent."""
    unmatched_target_percent: float
    """Their share of the target's area, in percent."""
    certainty: float
    """How sure it is that the meshes lie on each other as laid, 0-1; 1 by markers or ``overlap``, less where
    little of either has a counterpart on the other."""
    rounds: int
    """Rounds of closest points done."""
    seconds: float
    """Time of the fit."""
    warnings: list[str]
    """What is doubtful."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A source pulled onto a target: what belongs together, and how good it is where."""

    pairs: NDArray[np.int64]
    """(p, 2) of source and target triangle, many to many."""
    image_triangles: NDArray[np.int64]
    """(n_target,) the source triangle that each target vertex lies on, -1 where none."""
    image_weights: NDArray[np.float64]
    """(n_target, 3) where on it, by barycentric coordinates."""
    fitted_vertices: NDArray[np.float64]
    """(n_source, 3) the source's vertices on the target, in the target's units."""
    rest: NDArray[np.float64]
    """(n_source, 3) the source at rest as the person that the target looks like has it, in the source's
    units: its own vertices without ``modes``. Shapes whose offsets are everybody's are best carried over from
    there: ``Transfer(Mesh(fit.rest, triangles), target, fit).apply(fit.rest + offsets)``."""
    coefficients: NDArray[np.float64]
    """(k,) how much of each of the ``modes`` that is; empty without."""
    distances: NDArray[np.float64]
    """(n_source,) from the fitted vertices to the target, in its units, NaN where nothing faces them."""
    image_distances: NDArray[np.float64]
    """(n_target,) from the target's vertices to their images, in its units, NaN where there is none."""
    distortion: NDArray[np.float64]
    """(m_source,) how much longer or narrower than the usual one each fitted triangle is, at least 1."""
    flipped: NDArray[np.int64]
    """(f,) the source triangles that face against the target."""
    marker_distances: NDArray[np.float64]
    """(k,) from each marker's place on the fitted source to where it was marked, in the target's units."""
    doubtful_markers: NDArray[np.int64]
    """(d,) the markers, by number, that lie where the others do not put them and were left out."""
    doubtful_percents: NDArray[np.float64]
    """(d,) how far each of these is from there, in percent of the target's diagonal."""
    doubtful_warnings: list[str]
    """What the warnings say of each of these."""
    curve_distances: NDArray[np.float64]
    """(c,) mean distance of each curve on the fitted source from its like, in the target's units."""
    doubtful_curves: NDArray[np.int64]
    """(d,) the curves, by number, that lie where the others do not put them and were left out."""
    doubtful_curve_percents: NDArray[np.float64]
    """(d,) how far each of these is from there, in percent of the target's diagonal."""
    unmet_curves: NDArray[np.int64]
    """(u,) the curves, by number, that were followed and not met."""
    unmet_curve_percents: NDArray[np.float64]
    """(u,) how far each of these is from its like, in percent of the target's diagonal."""
    reordered_curves: NDArray[np.int64]
    """The curves, by number, on which the markers come in another order than on the target."""
    curve_warnings: list[str]
    """What the warnings say of these three, in this order."""
    report: FitReport
    """How well it went."""
    _core: _native.Fit = field(init=False, repr=False)

    def next_marker(
        self, markers: ArrayLike, *, source_mask: ArrayLike = (), target_mask: ArrayLike = ()
    ) -> tuple[int, int] | None:
        """Where one more marker helps most: a source vertex, and the target vertex to correct by eye.

        That is where the fit has distorted the source most, far from ``markers`` (k, 2), among the components
        that bear some; None where every vertex has one. Vertices of the masks are none that are proposed.
        Raises InvalidConstraint for indices out of range.
        """
        fitted = self.fitted_vertices, self.distances, self.distortion
        found = self._core.next_marker(fitted, markers, (source_mask, target_mask))
        return None if found is None else (int(found[0]), int(found[1]))


def start_fit(
    source: Mesh,
    target: Mesh,
    markers: ArrayLike | None = None,
    points: ArrayLike | None = None,
    **options: Unpack[FitOptions],
) -> Job[Fit]:
    """:func:`fit_correspondence` in the background."""
    told: dict[str, Any] = {**options, "points": points}
    return _native.start_fit(source, target, markers, told)._then(_fit)


def fit_correspondence(
    source: Mesh,
    target: Mesh,
    markers: ArrayLike | None = None,
    points: ArrayLike | None = None,
    **options: Unpack[FitOptions],
) -> Fit:
    """Pulls ``source`` onto ``target`` and matches their triangles (Sumner & Popović 2004).

    markers: (k, 2), vertex of the source, vertex of the target that belongs to it; None finds out by the
        shapes alone how the meshes lie on each other, and says how sure that is (``report["certainty"]``).
        Meshes of the same triangles need none: without any, each vertex belongs to its like. Markers may be
        off by ``marker_tolerance``; one that lies where the others do not put it is named and left out.
    points: (k, 3), where on the target the markers' source vertices belong, in its units, where that is not
        at its vertices.
    options: those of ``lissom.options("fit")``. ``curves`` among them is a list of (source vertices, target
        vertices), each along edges of its mesh: rims of lids, lips. One that ends with its first vertex is a
        loop. The two are matched by length between the markers that lie on both, and between the ends of
        paths; which way round they go and where loops begin is found out. With three of them no marker is
        needed. With ``overlap=True`` nothing is pulled: the meshes lie on each other as they are, as clothes
        lie on a body (Abdrashitov et al. 2023).

    Raises InvalidConstraint for an empty list of markers, indices out of range, vertices marked twice,
    curves whose vertices no edges join or that come twice, meshes with too little in common to do without
    markers, and meshes that are to overlap but do not, or have markers or curves besides; InvalidValue for an
    option out of range; SolveFailed; OutOfMemory; Cancelled.
    """
    return start_fit(source, target, markers, points, **options).result()


@dataclass(frozen=True, eq=False)
class TransferReport(Report):
    """How long a transfer took."""

    seconds: float
    """All of it."""
    solve_seconds: float
    """Of these, back-substitution."""


@dataclass(frozen=True, eq=False)
class Transferred:
    """Shapes carried over."""

    vertices: NDArray[np.float64]
    """(k, n_target, 3) in the target's units."""
    report: TransferReport
    """How long it took."""


@dataclass(frozen=True, eq=False)
class Quality(Report):
    """What there is to say about each of k shapes that were carried over."""

    verdict: list[str]
    """Of each: "good"; "look", where it may be right; "bad", where it is not."""
    reasons: list[list[str]]
    """Of each why, in words, the worst first: "12 triangles turned over"; empty where it is good."""
    faces: list[NDArray[np.int64]]
    """Of each the target triangles to look at: turned over, torn, or beside a gap; none where it is good."""
    flipped_triangles: NDArray[np.int64]
    """(k,) target triangles turned over: they face against where the source's turn them."""
    torn_triangles: NDArray[np.int64]
    """(k,) target triangles with an edge 2.5 times as long as the source's shape asks for."""
    contacts: NDArray[np.int64]
    """(k,) target vertices whose images meet another surface."""
    contact_gap: NDArray[np.float64]
    """(k,) how much wider than on the source their mean distance is, in percent of the target's diagonal."""
    closing: NDArray[np.float64]
    """(k,) what part of the way they come together; 1 where there are none."""
    amplitude: NDArray[np.float64]
    """(k,) motion over that of the source, scaled as the transfer does; 1 where nothing is seen to move."""
    crooked: NDArray[np.float64]
    """(k,) difference of left and right over the motion, where both meshes and the source's shape are
    symmetric about a plane across an axis; 0 elsewhere."""
    covered: NDArray[np.float64]
    """(k,) what part of the source's motion has a counterpart on the target; 1 where nothing is seen to
    move."""
    motion: NDArray[np.float64]
    """(k,) largest displacement, in percent of the target's diagonal."""
    residual: NDArray[np.float64]
    """(k,) how far from the gradients asked for the result is, relative to them; no part of the verdict."""


class Transfer:
    """A prepared transfer from one mesh to another; factored once, for any number of shapes.

    Transfer(source, target, fit, **options)

    source, target: Meshes.
    fit: a Fit, or (p, 2) pairs of source and target triangle. A Fit made for meshes of other faces is
        refused.
    options: those of ``lissom.options("transfer")``.

    The target's triangles take the gradients of the source's that they are matched with, and are stitched
    (Sumner & Popović 2004).

    Raises InvalidConstraint for no pairs or indices out of range, InvalidValue for an option out of range,
    SolveFailed, OutOfMemory, Cancelled.
    """

    __slots__ = ("_core",)
    _core: _native.Transfer

    def __init__(
        self, source: Mesh, target: Mesh, fit: Fit | ArrayLike, **options: Unpack[TransferOptions]
    ) -> None:
        self._core = _native.start_transfer(source, target, _matches(fit), options).result()

    @property
    def warnings(self) -> list[str]:
        """What is doubtful about the matches."""
        return self._core.warnings

    def start_apply(self, poses: ArrayLike) -> Job[Transferred]:
        """:meth:`apply` in the background."""
        return self._core.start_apply(poses)._then(_transferred)

    def apply(self, poses: ArrayLike) -> Transferred:
        """Carries poses (k, n_source, 3), in the source's units, over.

        Raises InvalidValue for values that are not finite, SolveFailed on overflow, OutOfMemory, Cancelled.
        """
        return self.start_apply(poses).result()

    def start_quality(self, poses: ArrayLike, vertices: ArrayLike, led: ArrayLike = ()) -> Job[Quality]:
        """:meth:`quality` in the background."""
        return self._core.start_quality(poses, vertices, led)._then(_quality)

    def quality(self, poses: ArrayLike, vertices: ArrayLike, led: ArrayLike = ()) -> Quality:
        """What there is to say about ``vertices`` (k, n_target, 3), which `apply` has made of ``poses`` (k,
        n_source, 3): a verdict on each, with reasons.

        led: (l,) indices of vertices of which somebody else has decided since how far they go: they count as
            having gone as far as was asked for.

        Raises InvalidValue for values that are not finite or another number of poses, InvalidConstraint for
        led vertices out of range, Cancelled.
        """
        return self.start_quality(poses, vertices, led).result()

    def start_attributes(self, values: ArrayLike) -> Job[NDArray[np.float64]]:
        """:meth:`attributes` in the background."""
        return self._core.start_attributes(values)

    def attributes(self, values: ArrayLike) -> NDArray[np.float64]:
        """Carries ``values`` (n_source, k) of vertices, such as skin weights, over: (n_target, k).

        Each target vertex takes what is where it lies on the source. Vertices that lie nowhere take the
        harmonic extension of those around them by the uniform Laplacian (Taubin 1995), components of which
        none does the values of the nearest vertex that does. Results are convex combinations of the source's
        values: weights that add up to 1 still do.

        Raises InvalidValue for values that are not finite, InvalidConstraint for a transfer made of pairs
        alone, SolveFailed, OutOfMemory, Cancelled; ValueError for another shape.
        """
        return self.start_attributes(values).result()

    def start_corner_attributes(
        self, values: ArrayLike, faces: ArrayLike | None = None
    ) -> Job[NDArray[np.float64]]:
        """:meth:`corner_attributes` in the background."""
        return self._core.start_corner_attributes(values, faces)

    def corner_attributes(self, values: ArrayLike, faces: ArrayLike | None = None) -> NDArray[np.float64]:
        """Carries ``values`` (m_source, 3, k) of triangles' corners, such as UV maps, over: (m_target, 3, k).

        A seam is an edge whose two sides have other values. Each target triangle takes all of its corners
        from the side of seams that its centre lies on; corners beyond a seam take what is nearest to them on
        this side.

        faces: (m_target,), which face each target triangle is part of, as the triangles of a quad are; those
            of one face take the same side. None: each is a face of its own.

        Raises as :meth:`attributes`; InvalidConstraint also for another number of faces.
        """
        return self.start_corner_attributes(values, faces).result()


def start_transfer(
    source: Mesh, target: Mesh, fit: Fit | ArrayLike, **options: Unpack[TransferOptions]
) -> Job[Transfer]:
    """:class:`Transfer` in the background."""
    return _native.start_transfer(source, target, _matches(fit), options)._then(_transfer)


def _matches(fit: Fit | ArrayLike) -> _native.Fit | ArrayLike:
    return fit._core if isinstance(fit, Fit) else fit


def _transfer(native: _native.Transfer) -> Transfer:
    transfer = Transfer.__new__(Transfer)
    transfer._core = native
    return transfer


def _fit(result: tuple[Any, ...]) -> Fit:
    native, arrays, report = result
    fit = Fit(**arrays, report=FitReport(**report))
    object.__setattr__(fit, "_core", native)  # no argument: nobody else has one
    return fit


def _transferred(result: tuple[Any, ...]) -> Transferred:
    vertices, *seconds = result
    return Transferred(vertices, TransferReport(*seconds))


def _quality(result: dict[str, Any]) -> Quality:
    return Quality(**result)
