"""Keys that were corrected teach the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._report import Report

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Unpack

    from numpy.typing import ArrayLike, NDArray

    from ._native import Job, Mesh
    from ._option_types import LearnOptions


@dataclass(frozen=True, eq=False)
class Learned(Report):
    """Keys as corrected ones ask for."""

    vertices: NDArray[np.float64]
    """(k, n, 3) in the mesh's units; corrected keys are as given, to the bit."""
    changes: NDArray[np.float64]
    """(k,) how much each key changes: root mean square of what is added over that of its motion; of corrected
    keys, what the correction is."""
    foretold: NDArray[np.float64]
    """Of each corrected key, in the order given, what part of its correction the others foretell, at most 1;
    0 or less where they tell nothing of it."""
    seconds: float
    """Time of it."""
    warnings: list[str]
    """What is doubtful."""


def start_learn(
    mesh: Mesh,
    vertices: ArrayLike,
    corrected: Mapping[int, ArrayLike],
    **options: Unpack[LearnOptions],
) -> Job[Learned]:
    """:func:`learn` in the background."""
    places = np.fromiter(corrected, dtype=np.int64, count=len(corrected))
    poses = [np.asarray(pose) for pose in corrected.values()]
    shapes = {pose.shape for pose in poses}
    if len(shapes) > 1:
        raise ValueError(f"corrected: positions of different shapes, {sorted(map(str, shapes))}")
    wanted = np.array(poses)
    return _native.start_learn(mesh, vertices, places, wanted, options)._then(_learned)


def learn(
    mesh: Mesh,
    vertices: ArrayLike,
    corrected: Mapping[int, ArrayLike],
    **options: Unpack[LearnOptions],
) -> Learned:
    """Carries what was corrected of some keys over to the others (after Li, Weise & Pauly 2010).

    mesh: the mesh at rest.
    vertices: (k, n, 3), all keys as they were transferred to it (``Transfer.apply``).
    corrected: of some, by their place among these, the (n, 3) positions that they were corrected to. A key
        that is right as it is tells as much: give it as it is.
    options: those of ``lissom.options("learn")``.

    Places of the mesh learn how to answer to motions, each from the corrected keys that move it, and every
    other key changes as far as it moves the same places in the same way. Each corrected key is foretold by
    the others to find out how much of it to believe: corrections that have nothing in common change nothing.
    What a key leaves at rest stays at rest.

    Raises InvalidConstraint for no corrected keys and for places out of range, InvalidValue for positions
    that are not finite and options out of range, SolveFailed, OutOfMemory, Cancelled; ValueError for other
    shapes.
    """
    return start_learn(mesh, vertices, corrected, **options).result()


def _learned(result: dict[str, Any]) -> Learned:
    return Learned(**result)
