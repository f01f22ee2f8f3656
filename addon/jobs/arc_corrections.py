"""Corrections are the artist's: what was changed by hand of an arc's keys since Bake wrote them."""

import numpy as np

from ..bridge import kept, shape_keys
from ..core import corrections, hat
from ..core.refused import first


class ArcCorrections:
    """Those of an arc that another takes the place of; between its keys they go straight, as it is played."""

    def __init__(self, obj, arc, ends):
        """``arc`` is the one before, or None; ``ends``: names of the keys that the next lies between."""
        self._found, self._knots, self._same = {}, [0.0], True
        if arc is None:
            return
        self._same, mesh = (arc.start, arc.end) == ends, obj.data
        self._before = arc.end
        blocks = mesh.shape_keys.key_blocks
        there = [(row, kept.kept(row, mesh)) for row in arc.keys if row.name in blocks and row.offsets]
        there = [(row, written) for row, written in there if len(written) == len(mesh.vertices)]
        self._knots = np.union1d([0.0], [row.time for row, _ in there])
        for row, written in there:
            key = blocks[row.name]
            if kept.is_edited(key, written):
                place = int(np.searchsorted(self._knots, row.time))
                base = shape_keys.shape(key.relative_key)
                self._found[place] = row.name, kept.offsets(key) - written, base + written

    def at(self, time, shape, triangles):
        """(n, 3), or 0, to add to the new shape (n, 3) at a time, turned as the surface is."""
        if not self._same:
            return 0.0
        shares = hat.weights(self._knots, time)[0]
        return sum(
            shares[place] * corrections.turned(correction, before, shape, triangles)
            for place, (_, correction, before) in self._found.items()
            if shares[place]
        )

    def warnings(self):
        """What becomes of them."""
        if not self._found:
            return []
        names = first(repr(name) for name, *_ in self._found.values())
        if self._same:
            return [f"In-betweens corrected by hand are carried over: {names}"]
        return [f"In-betweens corrected by hand are gone with the arc to '{self._before}': {names}"]
