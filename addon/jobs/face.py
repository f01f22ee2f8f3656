"""Face keys: the expressions of the face that comes along, on any head."""

from dataclasses import dataclass

import numpy as np

from ..bridge import checks
from ..bridge.assembly import Assembly
from ..core.face import face_work
from ..core.quality import as_dicts, pack_faces
from ..core.refused import first
from . import Asked, Done
from .corrections import Corrections
from .transfer_keys import destinations


@dataclass(kw_only=True)
class FaceAsked(Asked):
    """What face keys are made of: the head by name, eyes, teeth and lashes one a line, a set of names."""

    target: str = ""
    parts: str = ""
    names: str = "ARKIT"
    exists: str = "UPDATE"
    edited: str = "KEEP"
    strength: float = 1.0
    contact: bool = True


@dataclass(kw_only=True)
class FaceDone(Done):
    """``written``: the names on each object; ``left``: those that nothing makes; ``landmarks``: those to look
    at; ``kinds``: what the loose pieces of each object were taken for; ``quality``: rows of core.quality.
    """

    written: dict[str, list[str]]
    left: list[str]
    landmarks: list[str]
    kinds: dict[str, list[str]]
    quality: list[dict]
    report: dict


class FaceKeys:
    """Keys of a set of names on a head and what goes with it."""

    def __init__(self, context, asked):
        head = checks.mesh_object(asked.target, context)
        objects = [head, *(checks.mesh_object(name, context) for name in asked.parts.splitlines() if name)]
        objects = list(dict.fromkeys(objects))
        for obj in objects:
            checks.require_writable(obj)
        self._asked, self._side = asked, Assembly(objects)
        rows = list(zip(self._side.split(self._side.rest()), self._side.parts, strict=True))
        head, *parts = [(vertices, part.triangles) for vertices, part in rows]
        # The whole's triangles face outward whatever the objects' scales.
        triangles = self._side.geometry()[1][: len(head[1])]
        self.work = face_work((head[0], triangles), parts, asked.names, asked.strength, asked.contact)

    def write(self, context, found):
        """Writes a core.face.Faced; a FaceDone."""
        targets = self._side.find()
        for obj in targets:
            checks.require_writable(obj)
        corrections = Corrections(self._asked.edited)
        plans = corrections.leave(targets, destinations(targets, found.names, self._asked.exists))
        corrections.require_any(plans)
        written = {}
        rows = zip(targets, self._side.parts, plans, strict=True)
        for place, (obj, part, plan) in enumerate(rows):
            offsets = found.parts[place - 1] if place else found.offsets
            writer, written[obj.name] = corrections.writer(obj, part.triangles), []
            for name, moved in zip(found.names, offsets, strict=True):
                if name in plan and (place == 0 or moved.any()):
                    writer.write(plan[name], part.vertices, self._back(place, moved))
                    written[obj.name].append(plan[name])
        warnings = [*corrections.warnings(), *found.warnings, *found.fit.report["warnings"]]
        if found.doubts:
            warnings.append(f"Landmarks to look at: {first(found.doubts)}")
        if found.left:
            warnings.append(f"Left out, for want of what they are made of: {first(found.left)}")
        kinds = {part.name: kinds for part, kinds in zip(self._side.parts, found.kinds, strict=True)}
        return FaceDone(
            summary=f"{len(written[targets[0].name])} face keys on '{targets[0].name}'",
            warnings=warnings,
            written=written,
            left=found.left,
            landmarks=found.doubts,
            kinds=kinds,
            quality=self._remember_quality(context, found, plans[0]),
            report=dict(found.fit.report),
        )

    def _back(self, place, moved):
        whole = np.zeros((sum(len(part.vertices) for part in self._side.parts), 3))
        self._side.split(whole)[place][:] = moved
        return self._side.back(whole)[place]

    def _remember_quality(self, context, found, plan):
        rows = context.scene.lissom_transfer.quality
        rows.clear()
        for place, name in enumerate(found.names):
            if name in plan:
                row = rows.add()
                row.name = plan[name]
                for field, values in found.quality.items():
                    value = values[place]
                    if field == "reasons":
                        value = "\n".join(value)
                    elif field == "faces":
                        value = pack_faces({self._side.name: self._side.polygons(value)[0]})
                    setattr(row, field, value.item() if isinstance(value, np.generic) else value)
        return as_dicts(rows)
