"""What modifiers make of a mesh, vertex by vertex, and the way back: shape keys come before modifiers.

A skin takes each vertex by an affine map of its own, ``x -> M x + t``: linear blending by one matrix, dual
quaternions (Kavan et al. 2008) by one rigid motion, since either depends on weights and bones alone. So the
rest shape and three steps of it tell the maps exactly; other modifiers are taken at first order.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

FLAT = 1e-4  # singular value of a map, of its largest, below which it cannot be inverted


@dataclass(frozen=True, eq=False)
class Skin:
    """``rest`` (n, 3) is shown at ``shown`` (n, 3); a step of a vertex by its map, ``maps`` (n, 3, 3)."""

    rest: np.ndarray = field(repr=False)
    shown: np.ndarray = field(repr=False)
    maps: np.ndarray = field(repr=False)

    @classmethod
    def of(cls, rest, look, step):
        """``look(shape)`` tells how a shape (n, 3) is shown; ``step`` is as far as one may go for it."""
        shown = look(rest)
        moved = [look(rest + step * axis) - shown for axis in np.eye(3)]
        return cls(rest, shown, np.stack(moved, axis=2) / step)

    def is_trivial(self, tolerance):
        """Whether shapes are shown as they are, within ``tolerance``."""
        still = np.abs(self.shown - self.rest).max(initial=0) <= tolerance
        return bool(still and np.abs(self.maps - np.eye(3)).max(initial=0) <= 1e-4)

    @cached_property
    def flat(self):
        """(k,) vertices whose maps cannot be inverted: there all that the key could do collapses."""
        values = np.linalg.svd(self.maps, compute_uv=False)
        return np.flatnonzero(values[:, 2] <= FLAT * np.maximum(values[:, 0], 1e-300))

    @cached_property
    def _back(self):
        """(n, 3, 3): the maps inverted, once for all poses; none where that cannot be."""
        maps = self.maps.copy()
        maps[self.flat] = np.eye(3)
        inverse = np.linalg.inv(maps)
        inverse[self.flat] = 0.0
        return inverse

    def key(self, posed):
        """(n, 3): the shape that is shown at ``posed`` (n, 3); where no shape is, the rest shape."""
        return self.rest + np.einsum("nij,nj->ni", self._back, posed - self.shown)
