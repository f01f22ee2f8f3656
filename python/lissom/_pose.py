"""Pose a mesh by handles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._native import Job, Mesh
from ._report import Report

if TYPE_CHECKING:
    from typing import Unpack

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._option_types import PoseOptions, SolveOptions


@dataclass(frozen=True, eq=False)
class PoseReport(Report):
    """What a solve did."""

    iterations: int
    """Iterations done; 1 for methods that do not iterate, 0 where there was nothing to solve."""
    energy: float | None
    """Energy at the end, of iterative methods, for the mesh scaled to a diagonal of 1."""
    converged: bool
    """Whether ``tolerance`` was reached within ``max_iterations``."""
    seconds: float
    """Time of the solve."""
    warnings: list[str]
    """What is doubtful about the mesh, the handles, the system and the result."""


@dataclass(frozen=True, eq=False)
class PoseInfo(Report):
    """What binding a pose made, all systems of its method together."""

    unknowns: int
    """Unknowns of the systems."""
    factor_nonzeros: int
    """Values kept in the factors, zeros that fill up blocks included."""
    factor_bytes: int
    """Bytes of the factors, indices included: what a solve reads twice."""
    bind_seconds: float
    """Time of binding."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A posed mesh."""

    vertices: NDArray[np.float64]
    """(n, 3) positions in the mesh's own units."""
    transforms: NDArray[np.float64]
    """(h, 4, 4) the handles' matrices, of those that turn by themselves with the turn found; (0, 4, 4) of a
    pose by points."""
    report: PoseReport
    """What the solve did."""


class Pose:
    """A mesh with handles, ready to be posed again and again.

    Pose(mesh, handles, roi=None, method="arap", handle_weights=None, **options)

    mesh: a Mesh.
    handles: list of (k,) vertex index arrays, one per handle.
    roi: (k,) indices of the vertices that may move; None for all. Vertices outside it stay at rest;
        components without a handle, and vertices in no face, do as the option `unheld` says.
    method: one of POSE_METHODS.
    handle_weights: list of one (k,) array per handle, or None, of how much each of its vertices belongs to
        it, above 0 and at most 1.
    options: those of ``lissom.options("pose")`` and of ``lissom.options("pose." + method)``;
        docs/options.md lists them.

    Binding factors the method's systems; solving is then quick. Each method's source stands in its file of
    the core; "arap" is Sorkine & Alexa 2007 with the cells of Chao et al. 2010.

    Raises InvalidConstraint for no or empty handles, a vertex in two handles, indices out of range and an
    empty region; InvalidValue for an unknown method or an option out of range; TypeError for an option that
    the method does not have, or of another type; SolveFailed where a system cannot be factored even with a
    little added to its diagonal; OutOfMemory where its factor does not fit in what the machine has left, or
    in the environment variable LISSOM_MEMORY_LIMIT, in bytes; Cancelled.
    """

    __slots__ = ("_core",)
    _core: _native.Pose

    def __init__(
        self,
        mesh: Mesh,
        handles: Sequence[ArrayLike],
        roi: ArrayLike | None = None,
        method: str = "arap",
        handle_weights: Sequence[ArrayLike | None] | None = None,
        **options: Unpack[PoseOptions],
    ) -> None:
        self._core = _native.start_pose(mesh, handles, roi, method, handle_weights, options).result()

    @property
    def info(self) -> PoseInfo:
        """What binding made: the size of the systems and the time it took."""
        return PoseInfo(*self._core.info)

    @property
    def warnings(self) -> list[str]:
        """What is doubtful about the mesh, the handles, the region and the system."""
        return self._core.warnings

    def start_solve(
        self,
        transforms: ArrayLike,
        *,
        turns: ArrayLike | None = None,
        by_itself: ArrayLike | None = None,
        **options: Unpack[SolveOptions],
    ) -> Job[Posed]:
        """:meth:`solve` in the background."""
        return self._core.start_solve(transforms, turns, by_itself, options)._then(_posed)

    def solve(
        self,
        transforms: ArrayLike,
        *,
        turns: ArrayLike | None = None,
        by_itself: ArrayLike | None = None,
        **options: Unpack[SolveOptions],
    ) -> Posed:
        """Poses by one affine matrix per handle.

        transforms: (h, 4, 4), rest to posed in the mesh's own units, acting on column vectors.
        turns: (h, 3) rotation vectors (axis times angle, radians) that say by how many whole turns each
            handle rotates; a matrix alone says at most half a turn.
        by_itself: numbers of the handles that are moved and not turned: each turns about the mean of its
            vertices as suits where all handles go, for "arap" by the least energy, else so that the turns,
            spread over the surface, lead there (thesis of S. Zhou 2008, 3.4.2). The search goes on from the
            last solve's turn; in the first one, and without ``warm_start``, from that of the matrix.
            ``Posed.transforms`` tells what was found. All others turn as given.
        options: those of ``lissom.options("pose.solve")``; all but ``warm_start`` for iterative methods.

        Raises InvalidConstraint for a wrong number of matrices, for ones that are not affine, for values that
        are not finite and for numbers that are no handle's; InvalidValue for an option out of range;
        SolveFailed on overflow; OutOfMemory; Cancelled.
        """
        return self.start_solve(transforms, turns=turns, by_itself=by_itself, **options).result()

    def start_solve_points(self, targets: ArrayLike, **options: Unpack[SolveOptions]) -> Job[Posed]:
        """:meth:`solve_points` in the background."""
        return self._core.start_solve_points(targets, options)._then(_posed)

    def solve_points(self, targets: ArrayLike, **options: Unpack[SolveOptions]) -> Posed:
        """Poses by points: targets (k, 3) in the mesh's own units, one row per handle vertex, handles in
        order.

        Each handle's rotation is estimated from its own vertices. Options and errors are those of
        :meth:`solve`.
        """
        return self.start_solve_points(targets, **options).result()


def start_pose(
    mesh: Mesh,
    handles: Sequence[ArrayLike],
    roi: ArrayLike | None = None,
    method: str = "arap",
    handle_weights: Sequence[ArrayLike | None] | None = None,
    **options: Unpack[PoseOptions],
) -> Job[Pose]:
    """:class:`Pose` in the background."""
    return _native.start_pose(mesh, handles, roi, method, handle_weights, options)._then(_pose)


def _pose(native: _native.Pose) -> Pose:
    pose = Pose.__new__(Pose)
    pose._core = native
    return pose


def _posed(result: tuple[Any, ...]) -> Posed:
    vertices, transforms, report = result
    return Posed(vertices, transforms, PoseReport(**report))
