"""Face keys: the expressions of the face that comes along, on any head.

Where it is not sure where the face is, it makes none, and asks: the face is put beside the head, and
landmarks lie where they would be, as guesses. Those that somebody has moved, confirmed or clicked are
followed from then on.
"""

from dataclasses import dataclass

import numpy as np

from ..bridge import arcs, checks, mirrors, source_face
from ..bridge import markers as bridge_markers
from ..bridge.assembly import Assembly
from ..bridge.meshes import surface
from ..core import landmark_file, markers
from ..core.face import face_work
from ..core.face_found import Marks, Unsure
from ..core.face_parts import KINDS
from ..core.landmarks import MIDDLES
from ..core.quality import pack_faces
from ..core.refused import Refused, first
from ..core.surface import closest
from . import Asked, Done
from .corrections import Corrections
from .parts import quality_told
from .transfer_keys import destinations

# What of the core's warnings is not repeated: ears fold on heads that have none. A fold that does harm turns
# faces over in the keys, and their verdicts say so.
FOLDED = " fitted triangles face against the target"


@dataclass(kw_only=True)
class FaceAsked(Asked):
    """What face keys are made of: the head by name, eyes, teeth and lashes one a line, a set of names.

    ``kinds`` are what parts are where their shape misleads: "EYE Lamp" a line, of face_parts.KINDS.
    """

    target: str = ""
    parts: str = ""
    names: str = "ARKIT"
    exists: str = "UPDATE"
    edited: str = "KEEP"
    strength: float = 1.0
    contact: bool = True
    landmarks: str = ""  # a file of an outside detector
    kinds: str = ""


@dataclass(kw_only=True)
class FaceDone(Done):
    """``written``: the names on each object; ``left``: those that nothing makes; ``landmarks``: those to look
    at; ``kinds``: what the loose pieces of each object were taken for; ``quality``: rows of core.quality.

    ``sure``: how sure it is where the face is, 0-1; ``stopped``: that it was too little, and no key was made;
    ``guessed``: that landmarks then lie beside each other as guesses.
    """

    written: dict[str, list[str]]
    left: list[str]
    landmarks: list[str]
    kinds: dict[str, list[str]]
    quality: list[dict]
    report: dict
    sure: float
    stopped: bool = False
    guessed: bool = False


class FaceKeys:
    """Keys of a set of names on a head and what goes with it."""

    def __init__(self, context, asked):
        head = checks.mesh_object(asked.target, context)
        mirrors.refuse_half(head)
        objects = [head, *(checks.mesh_object(name, context) for name in asked.parts.splitlines() if name)]
        objects = list(dict.fromkeys(objects))
        owners = {}
        for obj in objects:
            checks.require_writable(obj)
            checks.require_own_mesh(obj, owners)
        self._asked, self._side = asked, Assembly(objects)
        rows = list(zip(self._side.split(self._side.rest()), self._side.parts, strict=True))
        head, *parts = [(vertices, part.triangles) for vertices, part in rows]
        # The whole's triangles face outward whatever the objects' scales.
        triangles = self._side.geometry()[1][: len(head[1])]
        told = _told(asked.kinds, self._side.names)
        marks = self._marks(context, objects[0], head[0])
        settings = asked.names, asked.strength, asked.contact
        self.work = face_work((head[0], triangles), parts, *settings, marks, told)

    @property
    def head(self):
        """The head's name."""
        return self._side.name

    def _marks(self, context, head, rest):
        """Marks of a file, or of the markers that somebody has set or confirmed; None without."""
        own = source_face.landmarks()
        if self._asked.landmarks:
            found = landmark_file.load(self._asked.landmarks, own)
            places = self._side.into(
                [np.array(list(found.values())), *[np.zeros((0, 3))] * (len(self._side.parts) - 1)]
            )
            return Marks(np.array([own[name] for name in found]), places)
        settings = context.scene.lissom_transfer
        if settings.target != head or not source_face.is_it(settings.source):
            return None
        pairs, _ = bridge_markers.current(context.scene, settings.source, head)
        pairs = [marker for marker in pairs if not marker.guessed]
        if not pairs:
            return None
        markers.check(pairs, len(settings.source.data.vertices), len(head.data.vertices))
        if len(pairs) < source_face.LEAST_MARKS:
            raise Refused(
                f"{len(pairs)} of the landmarks {'is' if len(pairs) == 1 else 'are'} set: "
                f"set or confirm {source_face.LEAST_MARKS} at least, "
                "as the middles of both eyes and of the mouth"
            )
        return Marks(
            np.array(
                [own.get(pair.name, pair.point("source").position(source_face.rest())) for pair in pairs]
            ),
            np.array([marker.point("target").position(rest) for marker in pairs]),
        )

    def write(self, context, found):
        """Writes a core.face.Faced; a FaceDone. What is Unsure is asked."""
        if isinstance(found, Unsure):
            return self._ask(context, found)
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
        of_fit = [line for line in found.located.fit.report["warnings"] if FOLDED not in line]
        warnings = [*corrections.warnings(), *found.warnings, *of_fit]
        warnings += filter(
            None, [told(obj) for obj in targets for told in (checks.shared_data, arcs.out_of_date)]
        )
        doubts = found.located.doubts
        if doubts:
            warnings.append(f"Landmarks to look at: {first(doubts)}")
        kinds = {part.name: kinds for part, kinds in zip(self._side.parts, found.kinds, strict=True)}
        return FaceDone(
            summary=f"{len(written[targets[0].name])} face keys on '{targets[0].name}'",
            warnings=warnings,
            written=written,
            left=found.left,
            landmarks=doubts,
            kinds=kinds,
            quality=self._remember_quality(context, found, plans[0]),
            report=dict(found.located.fit.report),
            sure=found.located.certainty,
        )

    def _ask(self, context, unsure):
        """Puts the face beside the head, and what is guessed on both; a FaceDone that has stopped."""
        head, settings = self._side.find()[0], context.scene.lissom_transfer
        own = source_face.landmarks()
        face = (
            settings.source if source_face.is_it(settings.source) else source_face.add_beside(context, head)
        )
        settings.source, settings.target, settings.show_markers = face, head, True
        places = [unsure.guesses[name] for name in unsure.guesses]
        added = []
        if places:
            on_head, _ = closest(self._side.split(self._side.rest())[0], surface(head)[1], np.array(places))
            on_face, _ = closest(
                source_face.rest(), surface(face)[1], np.array([own[name] for name in unsure.guesses])
            )
            rows = zip(unsure.guesses, on_face, on_head, strict=True)
            added = [markers.Marker.between(name, *pair)._replace(guessed=True) for name, *pair in rows]
        settings.landmarks = "FREE" if added else "FACE_3"
        bridge_markers.put(context.scene, added, face, head)
        return FaceDone(
            summary=f"No key is made: {unsure.why}",
            warnings=[],
            written={},
            left=[],
            landmarks=unsure.doubts or [marker.name for marker in added] or [mark.name for mark in MIDDLES],
            kinds={},
            quality=[],
            report={},
            sure=0.0,
            stopped=True,
            guessed=bool(added),
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
        return quality_told(context.scene.lissom_transfer)


def _told(text, objects):
    """For each object the kind that its parts were said to be of, or ""."""
    told = dict.fromkeys(objects, "")
    for line in filter(None, text.splitlines()):
        kind, _, name = line.partition(" ")
        if kind not in KINDS:
            raise Refused(f"Kinds: there is no kind '{kind}': choose of {', '.join(KINDS)}")
        if name not in told:
            raise Refused(f"Kinds: '{name}' is neither the head nor a part: choose of {', '.join(objects)}")
        told[name] = kind
    return list(told.values())
