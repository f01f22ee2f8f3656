"""What was written to shape keys, by which one tells what the artist has changed since.

``Key.lissom_written`` has a row for each key: its offsets from its relative key, as ``kept`` keeps them, and
the hash of the edges. They lie on the block of the shape keys, so that they are saved, undone, copied and
removed along with these. Shape keys bear no mark of their own: one that was renamed is known again by its
shape.
"""

from ..core import corrections
from . import shape_keys
from .kept import is_edited, keep, kept, offsets
from .meshes import edge_signature


class Written:
    """What is remembered of the shape keys of a mesh object, by the names that they have now."""

    def __init__(self, obj, kind="lissom_written"):
        """``kind``: "lissom_written" of transfers, or "lissom_made" of what was made of a mesh's own keys."""
        self._obj, self._kind, self._rows = obj, kind, {}  # a key's name -> its row's
        self._topology = edge_signature(obj.data)  # transforms that are applied may flip faces
        rows = self._all
        there = set(self._keys.key_blocks.keys()) if rows else set()
        self._rows = {row.name: row.name for row in rows if row.name in there}
        lost = [row for row in rows if row.name not in there and row.topology == self._topology]
        others = there - self._rows.keys() - {self._keys.reference_key.name} if lost else set()
        for row in lost:
            before = kept(row, obj.data)
            found = {name: corrections.alike(self._offsets(name), before) for name in sorted(others)}
            found = {name: away for name, away in found.items() if away is not None}
            if found:
                name = min(found, key=found.get)
                others.remove(name)
                self._rows[name] = row.name

    @property
    def _keys(self):
        return self._obj.data.shape_keys

    @property
    def _all(self):
        return getattr(self._keys, self._kind) if self._keys else ()

    def _row(self, name):
        return self._all[self._rows[name]]

    def _offsets(self, name):
        return offsets(self._keys.key_blocks[name])

    def state(self, name):
        """One of "FOREIGN": no transfer has written the key; "WRITTEN": it is as it was written; "EDITED"
        since; "UNKNOWN": the mesh was remodelled since.
        """
        if name not in self._rows:
            return "FOREIGN"
        if not self.knows(name):
            return "UNKNOWN"
        edited = is_edited(self._keys.key_blocks[name], self.written(name))
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
        wanted, transferred = times * self.written(name), times * self.transferred(name)
        key = self._keys.key_blocks[name]
        base = shape_keys.shape(key.relative_key)
        shape_keys.write(self._obj, name, base + wanted + correction, None, key.relative_key)
        row.strength = strength
        keep(row, self._obj.data, wanted)
        if row.transferred:
            row.transferred = corrections.pack(transferred)

    def written(self, name):
        """(n, 3) offsets of a key as they were written."""
        return kept(self._row(name), self._obj.data)

    def transferred(self, name):
        """(n, 3) offsets of a key as they were transferred, before anything was learned."""
        row = self._row(name)
        return kept(row, self._obj.data, row.transferred or row.offsets)

    def learned(self, name, wanted):
        """Keeps what has just been learned of a key, (n, 3), and what it was learned from."""
        row = self._row(name)
        row.transferred = corrections.pack(self.transferred(name))
        keep(row, self._obj.data, wanted)

    def correction(self, name):
        """(n, 3): what the artist has added to a key since."""
        return self._offsets(name) - self.written(name)

    def remember(self, name, wanted=None):
        """Keeps what has just been written to a key: offsets (n, 3), by default those that it has."""
        if name not in self._rows:
            self._all.add().name = name
            self._rows[name] = name
        row = self._row(name)
        row.topology, row.transferred = self._topology, b""
        keep(row, self._obj.data, self._offsets(name) if wanted is None else wanted)

    def tidy(self):
        """Rows take the names that their keys have now; those whose keys are gone go too."""
        rows = self._all
        now = {row: name for name, row in self._rows.items()}
        for place in reversed(range(len(rows))):
            if rows[place].name in now:
                rows[place].name = now[rows[place].name]
            else:
                rows.remove(place)
        self._rows = {name: name for name in self._rows}
