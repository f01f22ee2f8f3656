"""The face that comes along carried over to any head, without a marker, and the parts that go with it."""

from typing import NamedTuple

import lissom
import numpy as np
from lissom import data, names

from . import face_parts
from .face_parts import Frame, Mouth
from .landmarks import FACE
from .refused import Refused
from .transfer import fit_steps
from .work import Work

SKIN = ("face", "head_and_neck")
LEAST_CERTAIN = 0.5  # below it no key is made
SURE = 0.75  # from here on nothing is said: people have more
OFF = 0.01  # of the head's diagonal: a landmark further from the head than this is to be looked at
CORNERS = [48, 54]  # of the mouth


class Faced(NamedTuple):
    """What was found: names of the keys; their offsets (k, n, 3) on the head, and on each part; ``left``, the
    names that nothing makes; ``kinds`` of the loose pieces of each object; ``doubts``, landmarks by name.
    """

    fit: object
    names: list
    offsets: np.ndarray
    parts: list
    left: list
    kinds: list
    doubts: list
    quality: dict
    warnings: list


def face_work(head, parts, kind, strength=1.0, contact=True):
    """Work whose result is a Faced; ``head`` and ``parts`` are (vertices, triangles) in one solve space.

    ``kind`` is one of ``lissom.names.SETS``; keys are ``strength`` times as strong, and with ``contact`` lids
    and lips meet where they do on the face that comes along.
    """

    def steps():
        try:
            target = lissom.Mesh(*head)
        except lissom.InvalidMesh as error:
            raise Refused(f"The mesh of the head cannot be used: {error}") from error
        face = data.face().only(*SKIN)
        fit = yield from fit_steps(
            lissom.Mesh(face.neutral, face.triangles),
            target,
            None,
            {"modes": face.modes},  # any way up: a hint makes an egg pass for a face
        )
        certainty = fit.report["certainty"]
        doubts = _doubts(face, fit, head[0])
        if certainty < LEAST_CERTAIN:
            raise Refused(
                f"No face is found for sure, {100 * certainty:.0f} %: turn the head upright, looking along "
                "-Y, or choose Add > Mesh > Source Face, mark the corners of eyes and mouth by Pick, and "
                "press Transfer"
            )
        made, offsets, left = names.combined(kind, face.expression_names, face.expressions)
        # Offsets are everybody's: from the person that the head looks like they have that person's gradients.
        person = lissom.Mesh(fit.rest, face.triangles)
        transfer = yield lissom.start_transfer(person, target, fit, contact=contact)
        shapes = fit.rest + strength * offsets
        found = (yield transfer.start_apply(shapes)).vertices
        quality = yield transfer.start_quality(shapes, found)
        moved = found - head[0]
        loose = face_parts.parts(len(head[0]), head[1])[1:]
        body = np.setdiff1d(np.arange(len(head[0])), np.concatenate([*loose, np.zeros(0, dtype=int)]))
        known = _Known(face, fit, kind, strength, head[0][body], moved[:, body])
        own, whats = known.move(head[0], loose, ride=False)  # what rides the transfer has carried over
        for what, piece in zip(whats, loose, strict=True):
            if what != "RIDE":
                moved[:, piece] = own[:, piece]
        told, kinds = [], [whats]
        for vertices, triangles in parts:
            offsets_of, whats = known.move(vertices, face_parts.parts(len(vertices), triangles))
            told.append(offsets_of)
            kinds.append(whats)
        warnings = list(transfer.warnings)
        if certainty < SURE:
            warnings.append(f"Only {100 * certainty:.0f} % sure where the face is: look at every key")
        return Faced(fit, made, moved, told, left, kinds, doubts, quality, warnings)

    return Work(steps())


def _doubts(face, fit, vertices):
    """Names of the landmarks that lie off the head, or on triangles that are turned over."""
    limit = OFF * np.linalg.norm(np.ptp(vertices, axis=0))
    away = fit.distances[face.landmarks]
    folded = np.isin(face.landmarks, face.triangles[fit.flipped])
    return [FACE[i].name for i in np.flatnonzero(~(away < limit) | folded)]


class _Known:
    """How a face moves, for what goes with it."""

    def __init__(self, face, fit, kind, strength, head, moved):
        """``head`` (n, 3) are the vertices of the head itself, ``moved`` (k, n, 3) their offsets by key."""
        self._whole, self._kind, self._strength = data.face(), kind, strength
        self._frame = Frame.of(fit.rest, fit.fitted_vertices)
        self._head, self._moved = head, moved
        corners = fit.rest[face.landmarks[CORNERS]]
        self._mouth = Mouth(corners.mean(axis=0), float(np.linalg.norm(corners[1] - corners[0])))

    def move(self, vertices, pieces, ride=True):
        """Offsets (k, n, 3) of ``vertices`` (n, 3), and the kind of each of ``pieces``, lists of them.

        Without ``ride`` those that ride have none.
        """
        offsets, kinds = np.zeros((len(self._moved), *vertices.shape)), []
        local = self._frame.back(vertices)
        for piece in pieces:
            kinds.append(face_parts.kind(local[piece], self._mouth))
            if kinds[-1] == "RIDE" and ride:
                near, weights = face_parts.bonds(vertices[piece], self._head)
                for row, moved in zip(offsets, self._moved, strict=True):
                    row[piece] = np.einsum("nk,nkd->nd", weights, moved[near])
            elif kinds[-1] in ("EYE", "LOWER"):
                offsets[:, piece] = self._rigid(kinds[-1], local[piece])
        return offsets, kinds

    def _rigid(self, kind, points):
        """Offsets (k, n, 3) of points (n, 3) in the face's frame, which turn as an eye or go with the jaw."""
        whole, jaw = self._whole, self._whole.regions["lower_teeth"]
        if kind == "EYE":
            ict = [_turns(name, points) for name in whole.expression_names]
        else:
            still = whole.neutral[jaw]
            ict = [face_parts.rigid_offsets(points, still, moved[jaw]) for moved in whole.expressions]
        _, keys, _ = names.combined(self._kind, whole.expression_names, np.array(ict))
        return self._strength * self._frame.offsets(keys)


def _turns(name, points):
    centre, _, _ = face_parts.sphere(points)
    vector = face_parts.gaze(name, centre)
    return np.zeros_like(points) if vector is None else face_parts.turned(points, centre, vector)
