"""Corrections are the artist's: which keys a transfer leaves as they are, and what it carries over."""

from dataclasses import dataclass, field

from .. import session
from ..bridge import shape_keys
from ..bridge.kept import offsets
from ..bridge.written import Written
from ..core import corrections
from ..core.refused import Refused, first


@dataclass
class Found:
    """Keys by object: those that are ``locked``, ``edited`` since a transfer wrote them, of which that is
    ``unknown``, since the mesh was remodelled, and ``foreign``, which no transfer wrote.
    """

    locked: dict[str, list[str]] = field(default_factory=dict)
    edited: dict[str, list[str]] = field(default_factory=dict)
    unknown: dict[str, list[str]] = field(default_factory=dict)
    foreign: dict[str, list[str]] = field(default_factory=dict)

    @property
    def names(self):
        """All of them."""
        return {name for by in vars(self).values() for names in by.values() for name in names}

    def add(self, why, obj, name):
        """``why`` is the name of a field."""
        names = getattr(self, why).setdefault(obj.name, [])
        if name not in names:
            names.append(name)


def is_edited(obj, name):
    """Whether a key was edited since a transfer wrote it; remembered until some mesh changes."""
    known = session.edited.setdefault(obj.session_uid, {})
    if name not in known:
        written = Written(obj)  # looks at the whole mesh: once for all keys
        known |= {one: written.state(one) == "EDITED" for one in [name, *shape_keys.key_names(obj)]}
    return known[name]


class Corrections:
    """What becomes of keys that are there: ``edited`` is "KEEP", "CARRY" or "OVERWRITE"."""

    def __init__(self, edited):
        self._choice, self.found = edited, Found()

    def leave(self, targets, plans):
        """The plans {name on the source: on the object} without the keys that are left as they are."""
        kept = []
        for obj, plan in zip(targets, plans, strict=True):
            blocks = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
            written = Written(obj)
            kept.append({old: new for old, new in plan.items() if self._writes(obj, blocks, written, new)})
        return kept

    def _writes(self, obj, blocks, written, name):
        if name not in blocks:
            return True
        if blocks[name].lock_shape:
            self.found.add("locked", obj, name)
            return False
        state = written.state(name)
        if state == "EDITED":
            self.found.add("edited", obj, name)
            return self._choice != "KEEP"
        if state == "UNKNOWN":
            self.found.add("unknown", obj, name)
            return self._choice == "OVERWRITE"
        if state == "FOREIGN" and offsets(blocks[name]).any():
            self.found.add("foreign", obj, name)
        return True

    def writer(self, obj, triangles):
        """A Writer for one object of the target; ``triangles`` (m, 3) are its own."""
        return Writer(obj, triangles, self._choice)

    def require_any(self, plans):
        """Refused where nothing is left to write."""
        if not any(plans):
            raise Refused("Nothing to write. " + ". ".join(self.warnings()))

    def warnings(self):
        """What there is to say of what was left, and of what was not."""
        edited = {
            "KEEP": "Edited by hand since the last transfer, and kept",
            "CARRY": "Edited by hand since the last transfer, and carried over",
            "OVERWRITE": "Edited by hand since the last transfer, and overwritten",
        }
        unknown = "The mesh was remodelled since the last transfer, so that edits by hand are not known"
        said = {
            "locked": "Locked, and left as they are",
            "edited": edited[self._choice],
            "unknown": unknown
            + ("; overwritten" if self._choice == "OVERWRITE" else "; kept, choose Overwrite to write them"),
            "foreign": "Not made by a transfer, and overwritten, as If Exists says",
        }
        found = {why: getattr(self.found, why) for why in said}
        return [
            f"{said[why]}: {first(dict.fromkeys(repr(name) for names in by.values() for name in names))}"
            for why, by in found.items()
            if by
        ]


class Writer:
    """Writes the keys of one object as strong as is wanted, carries its corrections over and remembers."""

    def __init__(self, obj, triangles, edited):
        self._obj, self._triangles, self._carries = obj, triangles, edited == "CARRY"
        self._written = Written(obj)
        self._written.tidy()

    def write(self, name, base, offsets, settings=None, relative=None):
        """A key of offsets (n, 3) from the shape ``base`` (n, 3); else as bridge.shape_keys.write."""
        offsets = self._written.strength(name) * offsets
        carries = self._carries and self._written.state(name) == "EDITED"
        correction = 0.0
        if carries:
            ends = base + self._written.written(name), base + offsets
            correction = corrections.turned(self._written.correction(name), *ends, self._triangles)
        shape_keys.write(self._obj, name, base + offsets + correction, settings, relative)
        self._written.remember(name, offsets if carries else None)
