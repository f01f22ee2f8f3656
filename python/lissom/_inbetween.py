"""Paths between the shapes of a mesh, and blends of them."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.lib.mixins import NDArrayOperatorsMixin

from . import _native
from ._native import Job, Mesh

if TYPE_CHECKING:
    from typing import Unpack

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._option_types import BlendOptions, PathOptions


@dataclass(frozen=True, eq=False)
class Keyframes(NDArrayOperatorsMixin):
    """Times of keys, and how well straight lines between them follow the path.

    Arithmetic, comparison and the functions of numpy take it as the array of the times.
    """

    times: NDArray[np.float64]
    """(k,) ascending from 0 to 1."""
    error: float
    """Largest distance of any vertex at any time from the path, in the mesh's own units."""
    warnings: list[str]
    """That more keys would have been needed, where they do not suffice."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        times = self.times if dtype is None else self.times.astype(dtype, copy=False)
        return times.copy() if copy else times

    def __len__(self) -> int:
        return len(self.times)

    def __iter__(self) -> Iterator[float]:
        return iter(self.times)

    def __getitem__(self, index: Any) -> Any:
        return self.times[index]

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        results = (*options.get("out", ()), options.get("where"))
        if any(isinstance(each, Keyframes) for each in results):
            return NotImplemented  # nothing is written here
        arrays = (each.times if isinstance(each, Keyframes) else each for each in inputs)
        return getattr(ufunc, method)(*arrays, **options)

    def tolist(self) -> list[float]:
        """The times as a list."""
        return [float(time) for time in self.times]


class Inbetween:
    """The as-rigid-as-possible path from one shape of a mesh to another.

    Inbetween(mesh, start, end, rotation="consistent", **options)

    mesh: a Mesh, of which only the triangles matter, not the positions.
    start, end: (n, 3) in the mesh's own units.
    rotation: how the turn of every triangle is chosen: "consistent", where neighbours turn together;
        "relative", for several turns spread over a long part; or "shortest", by at most half a turn each.
    options: those of ``lissom.options("inbetween")``.

    Rotations and stretches of the triangles are interpolated and stitched (Alexa, Cohen-Or & Levin 2000;
    Baxter, Barla & Anjyo 2008).

    Raises InvalidValue for shapes that are not finite or all of whose points lie on a line, and for options
    out of range; SolveFailed, OutOfMemory, Cancelled.
    """

    __slots__ = ("_core",)
    _core: _native.Inbetween

    def __init__(
        self,
        mesh: Mesh,
        start: ArrayLike,
        end: ArrayLike,
        rotation: str | None = None,
        **options: Unpack[PathOptions],
    ) -> None:
        self._core = _native.start_inbetween(mesh, start, end, _told(rotation, options)).result()

    @property
    def warnings(self) -> list[str]:
        """Slivers, triangles that turn over between start and end, mirrored or open components."""
        return self._core.warnings

    def start_at(self, times: ArrayLike) -> Job[NDArray[np.float64]]:
        """:meth:`at` in the background."""
        return self._core.start_at(times)

    def at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Positions (t, n, 3) at times (t,) in 0-1; exactly ``start`` at 0 and ``end`` at 1.

        Raises InvalidValue for times that are not within 0 and 1, OutOfMemory, Cancelled.
        """
        return self.start_at(times).result()

    def start_keyframes(
        self, tolerance: float | None = None, max_keys: int = 32, *, count: int | None = None
    ) -> Job[Keyframes]:
        """:meth:`keyframes` in the background."""
        return self._core.start_keyframes(tolerance, max_keys, count)._then(_keyframes)

    def keyframes(
        self, tolerance: float | None = None, max_keys: int = 32, *, count: int | None = None
    ) -> Keyframes:
        """The fewest times between which straight lines stay within ``tolerance`` of the path everywhere.

        tolerance: in the mesh's own units.
        max_keys: at most so many; where they do not suffice, the best of that many, with a RuntimeWarning.
        count: given instead of ``tolerance``, the ``count`` times with the least error; fewer where they do
            as well.

        0 and 1 and the times of ``through`` are among them. Raises TypeError unless one of tolerance and
        count is given, InvalidValue for a tolerance that is not positive and fewer than two keys,
        OutOfMemory, Cancelled.
        """
        found = self.start_keyframes(tolerance, max_keys, count=count).result()
        for warning in found.warnings:
            warnings.warn(warning, RuntimeWarning, stacklevel=2)
        return found


def start_inbetween(
    mesh: Mesh,
    start: ArrayLike,
    end: ArrayLike,
    rotation: str | None = None,
    **options: Unpack[PathOptions],
) -> Job[Inbetween]:
    """:class:`Inbetween` in the background."""
    return _native.start_inbetween(mesh, start, end, _told(rotation, options))._then(_inbetween)


class Blend:
    """Several shapes of a mesh at once, as rigidly as possible, so that those that turn the same part do
    not collapse it.

    Blend(mesh, start, shapes, **options)

    mesh: a Mesh, of which only the triangles matter, not the positions.
    start, shapes: (n, 3) and (k, n, 3) in the mesh's own units.
    options: those of ``lissom.options("blend")``.

    Rotation vectors and stretches of each triangle are combined linearly and stitched (compare Sumner,
    Zwicker, Gotsman & Popović 2005).

    Raises InvalidValue for shapes that are not finite or all of whose points lie on a line, and for options
    out of range; SolveFailed, OutOfMemory, Cancelled.
    """

    __slots__ = ("_core",)
    _core: _native.Blend

    def __init__(
        self, mesh: Mesh, start: ArrayLike, shapes: ArrayLike, **options: Unpack[BlendOptions]
    ) -> None:
        self._core = _native.start_blend(mesh, start, shapes, options).result()

    @property
    def warnings(self) -> list[str]:
        """Triangles that turn over between start and a shape."""
        return self._core.warnings

    def start_at(self, weights: ArrayLike) -> Job[NDArray[np.float64]]:
        """:meth:`at` in the background."""
        return self._core.start_at(weights)

    def at(self, weights: ArrayLike) -> NDArray[np.float64]:
        """Positions (n, 3) at weights (k,), any numbers.

        They are exactly ``start`` where all are zero, exactly a shape where its weight is one and the
        others zero.

        Raises InvalidValue for weights that are not finite or of another number, Cancelled.
        """
        return self.start_at(weights).result()


def start_blend(
    mesh: Mesh, start: ArrayLike, shapes: ArrayLike, **options: Unpack[BlendOptions]
) -> Job[Blend]:
    """:class:`Blend` in the background."""
    return _native.start_blend(mesh, start, shapes, options)._then(_blend)


def _told(rotation: str | None, options: PathOptions) -> dict[str, Any]:
    return {**options} if rotation is None else {"rotation": rotation, **options}


def _inbetween(native: _native.Inbetween) -> Inbetween:
    path = Inbetween.__new__(Inbetween)
    path._core = native
    return path


def _blend(native: _native.Blend) -> Blend:
    blend = Blend.__new__(Blend)
    blend._core = native
    return blend


def _keyframes(result: dict[str, Any]) -> Keyframes:
    return Keyframes(**result)
