"""Where the face that comes along lies on a head: by shape alone, by the openings of eyes and mouth, or by
marks.

A person is found by shape, and who it is with the place. What is no person's shape, as a cartoon's head,
says where eyes and mouth are by its openings, if there is an eyeball behind each of two; else somebody has
to say.
"""

from typing import NamedTuple

import lissom
import numpy as np

from . import face_parts, face_rims, topology
from .face_lids import Lids
from .face_parts import Frame
from .landmarks import FACE, MIDDLES, mirrored
from .refused import Refused
from .transfer import fit_steps

CURVES = ("lid_left", "lid_right", "lips")
LEAST = 0.5  # from here on keys are made: people, also the face alone, have 0.73 and more, a cow 0.2
SURE = 0.75  # from here on nothing is said
OFF = 0.01  # of the head's diagonal: a landmark further from the head than this is to be looked at
CROOKED = 0.03  # of the head's diagonal: likewise, from the mirror image of its twin
PLAIN = 0.5  # confidence from which on a landmark is not looked at
REACH = 0.6  # of an opening's extent, from its middle: a click there is in it, or on its rim
LARGEST = 1.6  # extents of the marks: larger openings are cuts, or that of the neck
LIKELY = (1.5, 3.0)  # spreads by which people differ at most, and what nobody does
KIN = 4.0  # spreads of proportions: heads that differ by more are no people's
BESIDE = 0.1  # of the head's diagonal: no landmark is further outside of its box
SPREAD = 0.01  # of the head's diagonal, across the line that landmarks are nearest to
AGAINST = 0.3  # cosine: landmarks do not look that much against the surface around them


class Marks(NamedTuple):
    """Places that belong together: (k, 3) on the face that comes along, (k, 3) on the head."""

    source: np.ndarray
    target: np.ndarray


class Located(NamedTuple):
    """The fit; {curve: loop of the head}; how sure it is, 0-1; {landmark: how sure}; ``by`` SHAPE, RIMS or
    MARKS.
    """

    fit: object
    rims: dict
    certainty: float
    confidence: dict
    by: str

    @property
    def doubts(self):
        """Names of the landmarks to look at."""
        return [name for name, sure in self.confidence.items() if sure < PLAIN]


class Unsure(NamedTuple):
    """Why no key is made; {landmark: (3,)} where they would be, none where nothing is known; those to look
    at.
    """

    why: str
    guesses: dict
    doubts: list


def middles(face):
    """(3, 3) of the left eye's opening, the right one's and the mouth, of the face that comes along."""
    return _middles([face.neutral[face.curves[name]] for name in CURVES])


def _middles(curves):
    return np.array([(one.min(axis=0) + one.max(axis=0)) / 2 for one in curves])


def locate_steps(face, head, marks=None):
    """Located or Unsure, as steps of a Work; ``head`` is (lissom.Mesh, vertices, triangles, parts, eyeballs).

    ``face`` is of lissom.data, ``parts`` are (vertices, triangles), ``eyeballs`` (centre, radius), and
    ``marks``, Marks, are followed.
    """
    mesh, vertices, triangles, parts, balls = head
    if _looks_inward(vertices, triangles):
        raise Refused("The faces of the head look inward: use Recalculate Outside first (Mesh > Normals)")
    source = lissom.Mesh(face.neutral, face.triangles)
    located = None
    if marks is None:
        try:
            # Any way up: a hint makes an egg pass for a face.
            fit = yield from fit_steps(source, mesh, None, {"modes": face.modes})
        except lissom.InvalidConstraint:  # too little in common
            fit = None
        located = fit and _judged(face, fit, vertices, {}, "SHAPE")
        if located and located.certainty >= LEAST:
            return located
    found = yield from _openings(vertices, triangles, parts)
    if marks is None:
        own = face_rims.of_face(found, balls)
        if own is None:
            return _guessed(face_rims.of_face(found, None)) or _unsure(face, located)
        marks, by, rims = Marks(middles(face), own[0]), "RIMS", dict(zip(CURVES, own[1], strict=True))
    else:
        _require_face(marks, vertices, triangles)
        marks, by = _in_openings(marks, middles(face), found), "MARKS"
    at = Frame.of(marks.source, marks.target)
    where = at.there(middles(face))
    if by == "MARKS":
        rims = face_rims.near(found, where)
    if len(marks.source) == len(CURVES):
        marks = _with_corners(face, marks, (at.back(vertices), vertices), rims)
    names = [np.linalg.norm(face.neutral - point, axis=1).argmin() for point in marks.source]
    options = {
        "points": marks.target,
        "source_points": marks.source,
        "curves": [[face.curves[name], loop] for name, loop in rims.items()],
    }
    # What turns in behind the lips of a cartoon would lie on either lip of the face that comes along.
    behind = [one.behind for one in found if any(one.loop is loop for loop in rims.values())]
    if behind:
        options["target_mask"] = np.concatenate(behind)
    if _is_kin(face, vertices, rims, where):
        options["modes"] = face.modes
    fit = yield from fit_steps(
        source, mesh, np.column_stack([names, np.zeros(len(names), dtype=int)]), options
    )
    located = _judged(face, fit, vertices, rims, by)
    return located if located.certainty >= LEAST else _unsure(face, located)


def _with_corners(face, marks, head, rims):
    """Marks with the corners of eyes and mouth; ``head`` are its vertices in the face's frame, and (n, 3).

    By middles alone a rim is doubted where a cartoon is unlike the face around it, and not followed.
    """
    upright, vertices = head
    source, target = [marks.source], [marks.target]
    for name, loop in rims.items():
        source.append(face.neutral[Lids.of(face.neutral, face.curves[name]).corners])
        target.append(vertices[Lids.of(upright, loop).corners])
    return Marks(np.concatenate(source), np.concatenate(target))


def _require_face(marks, vertices, triangles):
    """Refuses marks that cannot be those of a face on the head."""
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    inside = np.clip(marks.target, vertices.min(axis=0), vertices.max(axis=0))
    if np.linalg.norm(marks.target - inside, axis=1).max() > BESIDE * size:
        raise Refused("The landmarks lie far beside the head: are they in the units of the scene?")
    away = marks.target - marks.target.mean(axis=0)
    if np.linalg.svd(away, compute_uv=False)[1] < SPREAD * size:
        raise Refused(
            "The landmarks lie in one place or on one line: set the middles of both eyes and of the mouth"
        )
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    around = np.linalg.norm((a + b + c) / 3 - marks.target.mean(axis=0), axis=1)
    near = around < np.linalg.norm(away, axis=1).max()
    outward = np.cross(b - a, c - a)[near].sum(axis=0)
    looks = Frame.of(marks.source, marks.target).turn @ [0, -1, 0]
    if outward @ looks < -AGAINST * np.linalg.norm(outward):
        raise Refused(
            "The landmarks look into the head: left and right, those of the head itself, are exchanged"
        )


def _looks_inward(vertices, triangles):
    """Whether a surface that is open here or there encloses what lies on the side its faces look to."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    return bool(np.einsum("ij,ij->", a - vertices.mean(axis=0), normals) < 0)


def _openings(vertices, triangles, parts):
    """The face_rims.Openings of a head, as steps of a Work; eyes and teeth hide what is behind them."""
    of_body = np.isin(triangles[:, 0], face_parts.parts(len(vertices), triangles)[0])
    body = face_rims.filled(triangles[of_body])
    whole = np.concatenate([body, triangles[~of_body]])
    linings = yield lissom.Mesh(*topology.joined([(vertices, whole), *parts])).start_linings()
    return face_rims.openings(vertices, body, np.isin(np.arange(len(body)), linings))


def _in_openings(marks, own, found):
    """Marks of which those of the middles of eyes and mouth that lie in an opening, as one sees it, are at
    its middle: there a click goes through to the eyeball, or to the back of the head, or takes the rim.
    """
    target = marks.target.copy()
    wide = np.ptp(marks.target, axis=0).max()
    small = [one for one in found if one.extent.max() < LARGEST * wide]
    for place, source in zip(target, marks.source, strict=True):
        if np.linalg.norm(own - source, axis=1).min() < 1e-6:
            off = [np.abs(one.middle - place)[[0, 2]] / one.extent[[0, 2]] for one in small]
            around = [one for one, far in zip(small, off, strict=True) if far.max() < REACH]
            if around:
                place[:] = min(around, key=lambda one: np.prod(one.extent[[0, 2]])).middle
    return Marks(marks.source, target)


def _guessed(own):
    """Unsure of openings that may be eyes and a mouth; None where there are none."""
    if own is None:
        return None
    guesses = {mark.name: place for mark, place in zip(MIDDLES, own[0], strict=True)}
    return Unsure("no eyeball tells which openings are the eyes", guesses, list(guesses))


def _unsure(face, located):
    if located is None:
        return Unsure("no face is found by shape alone; it has to stand upright and look along -Y", {}, [])
    on = located.fit.fitted_vertices[face.landmarks]
    guesses = {mark.name: place for mark, place in zip(FACE, on, strict=True)}
    return Unsure(f"where the face is, is only {100 * located.certainty:.0f} % sure", guesses, located.doubts)


def _judged(face, fit, vertices, rims, by):
    confidence = landmark_confidence(face, fit, vertices)
    report = fit.report["certainty"]
    likely = 1.0
    if len(fit.coefficients):
        spread = float(np.sqrt(np.mean(np.square(fit.coefficients))))
        likely = float(np.clip((LIKELY[1] - spread) / (LIKELY[1] - LIKELY[0]), 0, 1))
    plain = np.mean([sure >= PLAIN for sure in confidence.values()])
    certainty = 1.0 if by == "MARKS" else report * likely * min(1.0, plain / 0.8)
    return Located(fit, rims, float(certainty), confidence, by)


def landmark_confidence(face, fit, vertices):
    """{landmark: how sure it is, 0-1}: near to the head, on no fold, and where the mirror image of its twin
    is.
    """
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    on = fit.fitted_vertices[face.landmarks]
    away = np.nan_to_num(fit.distances[face.landmarks] / size, nan=1.0)
    folded = np.isin(face.landmarks, face.triangles[fit.flipped])
    back = Frame.of(fit.rest, fit.fitted_vertices).back(on)
    twins = [[mark.name for mark in FACE].index(mirrored(mark.name)) for mark in FACE]
    scale = np.linalg.norm(np.ptp(fit.rest, axis=0))
    local = back - [np.median((back + back[twins])[:, 0]) / 2, 0, 0]
    crooked = np.linalg.norm(local - local[twins] * [-1, 1, 1], axis=1) / scale
    sure = np.exp(-np.log(2) * ((away / OFF) ** 2 + (crooked / CROOKED) ** 2)) * ~folded
    return {mark.name: float(one) for mark, one in zip(FACE, sure, strict=True)}


def _proportions(face, rest):
    """Of a person: eye to mouth, width of the mouth and height of an eye, over the distance of the eyes."""
    curves = left, _, lips = [rest[face.curves[name]] for name in CURVES]
    return _ratios(_middles(curves), np.ptp(lips, axis=0)[0], np.ptp(left, axis=0)[2])


def _ratios(centres, mouth, eye):
    apart = np.linalg.norm(centres[0] - centres[1])
    down = np.linalg.norm((centres[0] + centres[1]) / 2 - centres[2])
    return np.log(np.array([down, mouth, eye]) / apart)


def _is_kin(face, vertices, rims, where):
    """Whether a head has proportions that people have; lengths that no rim tells are taken to be such."""
    mean = _proportions(face, face.neutral)
    steps = [_proportions(face, face.neutral + mode) - mean for mode in face.modes]
    spread = np.sqrt(np.square(steps).sum(axis=0))
    extents = {name: np.ptp(vertices[loop], axis=0) for name, loop in rims.items()}
    apart = np.linalg.norm(where[0] - where[1])
    mouth = extents["lips"][0] if "lips" in extents else apart * np.exp(mean[1])
    eye = extents["lid_left"][2] if "lid_left" in extents else apart * np.exp(mean[2])
    off = np.abs(_ratios(where, mouth, eye) - mean) / spread
    return bool(off.max() < KIN)
