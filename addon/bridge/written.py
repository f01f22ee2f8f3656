"""What transfers have written to shape keys, by which one tells what the artist has changed since.

``Key.lissom_written`` has a row for each key: its offsets from its relative key, in single precision and
compressed, the hash of the faces, and some vertices of the Basis, by which one tells that the object's
transforms were applied since: what was written turns and scales along. They lie on the block of the shape keys, so that they are saved,
undone, copied and removed along with these. Shape keys bear no mark of their own: one that was renamed is
known again by its shape.
"""

import numpy as np

from ..core import corrections, space
from . import shape_keys
from .meshes import signature

PROBES = 32  # vertices of the Basis that tell whether transforms were applied


class Written:
    """What is remembered of the shape keys of a mesh object, by the names that they have now."""

    def __init__(self, obj):
        self._obj, self._rows = obj, {}  # a key's name -> its row's
        self._topology = signature(obj.data)
        rows = self._keys.lissom_written if self._keys else ()
        there = set(self._keys.key_blocks.keys()) if rows else set()
        self._rows = {row.name: row.name for row in rows if row.name in there}
        lost = [row for row in rows if row.name not in there and row.topology == self._topology]
        others = there - self._rows.keys() - {self._keys.reference_key.name} if lost else set()
        for row in lost:
            offsets = self._turned(row, row.offsets)
            found = {name: corrections.alike(self._offsets(name), offsets) for name in sorted(others)}
            found = {name: away for name, away in found.items() if away is not None}
            if found:
                name = min(found, key=found.get)
                others.remove(name)
                self._rows[name] = row.name

    @property
    def _keys(self):
        return self._obj.data.shape_keys

    def _row(self, name):
        return self._keys.lissom_written[self._rows[name]]

    def _offsets(self, name):
        key = self._keys.key_blocks[name]
        return shape_keys.shape(key) - shape_keys.shape(key.relative_key)

    def _turned(self, row, packed):
        """(n, 3): what a row has packed, in the coordinates that the mesh has now."""
        before = corrections.unpack(row.probes)
        change = space.linear_change(before, shape_keys.probes(self._obj.data, PROBES))
        return corrections.unpack(packed) @ change.T

    def _pack(self, row, offsets, transferred=None):
        """Keeps (n, 3) arrays in the coordinates that the mesh has now."""
        row.offsets = corrections.pack(offsets)
        row.transferred = b"" if transferred is None else corrections.pack(transferred)
        row.probes = corrections.pack(shape_keys.probes(self._obj.data, PROBES))

    def state(self, name):
        """One of "FOREIGN": no transfer has written the key; "WRITTEN": it is as it was written; "EDITED"
        since; "UNKNOWN": the mesh was remodelled since.
        """
        if name not in self._rows:
            return "FOREIGN"
        if not self.knows(name):
            return "UNKNOWN"
        largest = np.abs(shape_keys.shape(self._keys.key_blocks[name])).max(initial=0.0)
        edited = corrections.differs(self._offsets(name), self.written(name), largest)
        return "EDITED" if edited else "WRITTEN"

    def knows(self, name):
        """Whether a transfer has written the key, on the mesh as it is now."""
        return name in self._rows and self._row(name).topology == self._topology

    def strength(self, name):
        """How many times as strong as transferred the artist wants a key."""
        return self._row(name).strength if name in self._rows else 1.0

    def strengthen(self, name, strength):
        """Makes a key so many times as strong as it was transferred; what the artist has added stays."""
        row, correction = self._row(name), self.correction(name)
        times = strength / row.strength
        offsets = times * self.written(name)
        transferred = times * self.transferred(name) if row.transferred else None
        key = self._keys.key_blocks[name]
        base = shape_keys.shape(key.relative_key)
        shape_keys.write(self._obj, name, base + offsets + correction, None, key.relative_key)
        row.strength = strength
        self._pack(row, offsets, transferred)

    def written(self, name):
        """(n, 3) offsets of a key as they were written."""
        row = self._row(name)
        return self._turned(row, row.offsets)

    def transferred(self, name):
        """(n, 3) offsets of a key as they were transferred, before anything was learned."""
        row = self._row(name)
        return self._turned(row, row.transferred or row.offsets)

    def learned(self, name, offsets):
        """Keeps what has just been learned of a key, (n, 3), and what it was learned from."""
        self._pack(self._row(name), offsets, self.transferred(name))

    def correction(self, name):
        """(n, 3): what the artist has added to a key since."""
        return self._offsets(name) - self.written(name)

    def remember(self, name, offsets=None):
        """Keeps what has just been written to a key: offsets (n, 3), by default those that it has."""
        if name not in self._rows:
            self._keys.lissom_written.add().name = name
            self._rows[name] = name
        row = self._row(name)
        row.topology = self._topology
        self._pack(row, self._offsets(name) if offsets is None else offsets)

    def tidy(self):
        """Rows take the names that their keys have now; those whose keys are gone go too."""
        rows = self._keys.lissom_written if self._keys else ()
        now = {row: name for name, row in self._rows.items()}
        for place in reversed(range(len(rows))):
            if rows[place].name in now:
                rows[place].name = now[rows[place].name]
            else:
                rows.remove(place)
        self._rows = {name: name for name in self._rows}
