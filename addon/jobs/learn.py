"""Learn from corrections: keys that were edited by hand since a transfer teach those that were not."""

from dataclasses import dataclass

import lissom
import numpy as np

from ..bridge import checks, kept, shape_keys
from ..bridge.meshes import surface
from ..bridge.written import Written
from ..core.options import default
from ..core.refused import Refused, first
from ..core.work import Work
from . import Asked, Done, learn_shown

LEAST = 5e-4  # of a key's motion: less is not told of


@dataclass(kw_only=True)
class LearnAsked(Asked):
    """What is learned from: the target by name, and which of its keys that are as they were transferred are
    right as they are, one a line. With ``preview`` nothing is written but a key to look at.
    """

    object: str = ""
    right: str = ""
    strength: float = default("learn", "strength")
    preview: bool = False


@dataclass(kw_only=True)
class LearnDone(Done):
    """``changes``: how much each key changes, over its motion; ``foretold``: of each corrected key what
    part of its correction the others foretell; ``written``: the names of the keys that were changed.
    """

    changes: dict[str, float]
    foretold: dict[str, float]
    written: list[str]


class Learn:
    """Keys of a target changed as those that the artist has corrected ask for; these stay to the bit."""

    def __init__(self, context, asked):
        self._asked = asked
        learn_shown.stop()
        obj = checks.mesh_object(asked.object, context)
        checks.require_writable(obj)
        self._name, written = obj.name, Written(obj)
        states = {name: written.state(name) for name in shape_keys.key_names(obj)}
        self._names = [name for name, state in states.items() if state in ("WRITTEN", "EDITED")]
        right = list(filter(None, asked.right.splitlines()))
        for name in right:
            shape_keys.find(obj, name)
            if name not in self._names:
                raise Refused(f"No transfer has written the key '{name}' of '{obj.name}' as the mesh is now")
        if not self._names:
            raise Refused(f"No transfer has written keys of '{obj.name}' as it is now: press Transfer first")
        self._taught = [name for name in self._names if states[name] == "EDITED" or name in right]
        if not self._taught:
            raise Refused(f"No key of '{obj.name}' was edited since it was transferred: correct some first")
        keys = obj.data.shape_keys.key_blocks
        self._locked = [n for n in self._names if keys[n].lock_shape and n not in self._taught]
        self._vertices, triangles = surface(obj)
        try:
            mesh = lissom.Mesh(self._vertices, triangles)
        except lissom.InvalidMesh as error:
            raise Refused(f"The mesh of '{obj.name}' cannot be used: {error}") from error
        shapes = self._vertices + np.array([written.transferred(name) for name in self._names])
        now = {name: kept.offsets(keys[name]) for name in self._taught}
        wanted = {self._names.index(name): self._vertices + offsets for name, offsets in now.items()}
        self.work = Work(_steps(mesh, shapes, wanted, asked.strength))

    def write(self, context, found):
        """Writes a lissom.Learned; a LearnDone."""
        obj = checks.mesh_object(self._name, None)
        checks.require_writable(obj)
        changes = dict(zip(self._names, found.changes.tolist(), strict=True))
        others = [n for n in self._names if n not in (*self._taught, *self._locked)]
        changed = [name for name in others if changes[name] > LEAST]
        shapes = dict(zip(self._names, found.vertices, strict=True))
        foretold = dict(zip(self._taught, found.foretold.tolist(), strict=True))
        self._list(context.scene.lissom_transfer, changes, foretold, others)
        if self._asked.preview:
            learn_shown.start(obj, {n: shapes[n] for n in self._listed}, context.scene.lissom_transfer)
        else:
            self._write(obj, {name: shapes[name] - self._vertices for name in others})
        taught = first(repr(name) for name in self._taught)
        warnings = [*found.warnings]
        if not changed:
            warnings.append("The corrections tell nothing of the other keys: they have too little in common")
        if self._locked:
            warnings.append(f"Locked, and left as they are: {first(repr(name) for name in self._locked)}")
        return LearnDone(
            summary=f"Learned from {taught}: {len(changed)} keys "
            f"{'would change' if self._asked.preview else 'changed'} on '{self._name}'",
            warnings=warnings,
            changes={name: changes[name] for name in others},
            foretold=foretold,
            written=[] if self._asked.preview else changed,
        )

    def _list(self, settings, changes, foretold, others):
        """The scene's list: the keys that change most first, then those that were corrected."""
        self._listed = [*sorted(others, key=changes.get, reverse=True), *self._taught]
        settings.learned.clear()
        for name in self._listed:
            row = settings.learned.add()
            row.name, row.change = name, changes[name]
            row.corrected, row.foretold = name in foretold, foretold.get(name, 0.0)

    def _write(self, obj, offsets):
        written, keys = Written(obj), obj.data.shape_keys.key_blocks
        for name, own in offsets.items():
            if name in keys and written.state(name) == "WRITTEN":  # the artist was at work too
                relative = keys[name].relative_key
                shape_keys.write(obj, name, shape_keys.shape(relative) + own, None, relative)
                written.learned(name, own)


def _steps(mesh, shapes, wanted, strength):
    return (yield lissom.start_learn(mesh, shapes, wanted, strength=strength))
