"""Data that comes along: a face with expressions, to carry over to any other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Face", "face"]

_PACKED = Path(__file__).with_name("face.npz")
_known: list[Face] = []


@dataclass(frozen=True, eq=False)
class Face:
    """The light ICT FaceKit face (R. Li et al., Learning Formation of Physically-Based Face Attributes).

    Lengths are centimetres, in Blender's axes: z is up, the face looks along -y, its own left is at
    positive x.
    Offsets add: ``neutral + np.tensordot(c, modes, 1) + expression`` is another person with that expression.
    MIT licence, copyright (c) 2020 USC Institute for Creative Technologies.

    Left out of the original are four expressions that ARKit does not have (``PupilDilate``,
    ``cheekRaiser``), the irises, lashes, lacrimal fluid and eye shading shells, and the texture coordinates.
    """

    neutral: NDArray[np.float64]
    """(22991, 3) the neutral face, to half a micrometre."""
    expressions: NDArray[np.float64]
    """(53, 22991, 3) offsets of the expressions from it, to 2.5 micrometres."""
    expression_names: tuple[str, ...]
    """Their names: ARKit's with ``_L`` and ``_R`` for sides, without the tongue's."""
    modes: NDArray[np.float64]
    """(37, 22991, 3) principal components of other people's offsets, each times its standard deviation, to 25
    micrometres: a sum of them by normal random numbers is a random person."""
    loops: NDArray[np.int32]
    """(91836,) the vertices of all polygons in turn."""
    counts: NDArray[np.int32]
    """(23096,) how many each polygon has, 3 or 4."""
    landmarks: NDArray[np.int32]
    """(68,) vertices of the Multi-PIE landmarks: jaw line, brows, nose, eyes, lips."""
    regions: dict[str, NDArray[np.int32]]
    """Vertices by name. The first eight are the parts, and have every vertex once: face, head_and_neck,
    mouth_socket, eye_sockets, gums_and_tongue, teeth, eyeball_left, eyeball_right. The others are of these:
    lids, brows, lips, upper and lower teeth, tongue."""
    curves: dict[str, NDArray[np.int32]]
    """Vertices along edges: the loops lid_left, lid_right and lips, each ending with its first."""

    @cached_property
    def triangles(self) -> NDArray[np.int32]:
        """(m, 3) the polygons in triangles, each a fan from its first corner, in their order."""
        starts = np.cumsum(self.counts) - self.counts
        first = np.repeat(starts, self.counts - 2)
        fan = np.arange(len(first)) - np.repeat(
            np.cumsum(self.counts - 2) - (self.counts - 2), self.counts - 2
        )
        triangles: NDArray[np.int32] = self.loops[np.stack([first, first + fan + 1, first + fan + 2], axis=1)]
        return triangles

    def only(self, *regions: str) -> Face:
        """The face without what is in none of these; landmarks that are not in them become -1.

        Polygons stay whose corners all do, regions and curves of which all or a part does.
        """
        kept = np.zeros(len(self.neutral), dtype=bool)
        for name in regions:
            kept[self.regions[name]] = True
        number = np.where(kept, np.cumsum(kept) - 1, -1).astype(np.int32)
        polygons = np.minimum.reduceat(kept[self.loops], np.cumsum(self.counts) - self.counts)
        named = {name: number[of[kept[of]]] for name, of in self.regions.items() if kept[of].any()}
        return Face(
            neutral=self.neutral[kept],
            expressions=self.expressions[:, kept],
            expression_names=self.expression_names,
            modes=self.modes[:, kept],
            loops=number[self.loops[np.repeat(polygons, self.counts)]],
            counts=self.counts[polygons],
            landmarks=number[self.landmarks],
            regions=named,
            curves={name: number[of] for name, of in self.curves.items() if kept[of].all()},
        )


def face() -> Face:
    """The face that comes along; its arrays are read once, and are not to be written to."""
    if not _known:
        _known.append(_read())
    return _known[0]


def _read() -> Face:
    with np.load(_PACKED) as packed:
        neutral, expressions, modes = (
            _positions(packed[name], step)
            for name, step in zip(("neutral", "expressions", "modes"), packed["steps"], strict=True)
        )
        made = Face(
            neutral=neutral,
            expressions=expressions,
            expression_names=tuple(packed["expression_names"].tolist()),
            modes=modes,
            loops=packed["loops"],
            counts=packed["counts"].astype(np.int32),
            landmarks=packed["landmarks"],
            regions=_lists(packed, "region"),
            curves=_lists(packed, "curve"),
        )
    arrays = (value for value in vars(made).values() if isinstance(value, np.ndarray))
    for array in (*arrays, *made.regions.values(), *made.curves.values()):
        array.flags.writeable = False
    return made


def _positions(differences: NDArray[Any], step: float) -> NDArray[np.float64]:
    """(..., n, 3) of (..., 3, n) integers, each less the one before; of axes with y up and z forward."""
    x, y, z = np.moveaxis(np.cumsum(differences, axis=-1, dtype=np.int32), -2, 0)
    return np.stack([x, -z, y], axis=-1) * step


def _lists(packed: Any, name: str) -> dict[str, NDArray[np.int32]]:
    parts = np.split(packed[f"{name}_vertices"], packed[f"{name}_starts"][1:-1])
    return dict(zip(packed[f"{name}_names"].tolist(), parts, strict=True))
