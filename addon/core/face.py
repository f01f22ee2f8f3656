"""The face that comes along carried over to any head, without a marker, and the parts that go with it."""

from typing import NamedTuple

import lissom
import numpy as np
from lissom import data, names

from . import face_lids, face_parts, face_twins
from .face_found import CURVES, SURE, Unsure, locate_steps
from .face_lids import Lids, Shares
from .face_parts import Frame, Mouth
from .refused import Refused
from .work import Work

# With what lies behind lids and lips: a head's own would else be matched with these, and hold them.
SOURCE = ("face", "head_and_neck", "mouth_socket", "eye_sockets")
CORNERS = [48, 54]  # of the mouth
LONGEST = 2.9  # times their length edges of a head that is no person's get at most: 3 is a spike
BENDS = 0.002  # over its stretch, of the skin round an eye: both weigh alike over 4 % of the head
ROUNDS = 5  # in which lids come in front of the eyeballs, and what that has stretched is shared


class Faced(NamedTuple):
    """What was found: names of the keys; their offsets (k, n, 3) on the head, and on each part; ``left``, the
    names that nothing makes; ``kinds`` of the loose pieces of each object.
    """

    located: object
    names: list
    offsets: np.ndarray
    parts: list
    left: list
    kinds: list
    quality: dict
    warnings: list


def face_work(head, parts, kind, strength=1.0, contact=True, marks=None, told=()):
    """Work whose result is a Faced or an Unsure; ``head`` and ``parts`` are (vertices, triangles) in one
    solve space.

    ``kind`` is one of ``lissom.names.SETS``; keys are ``strength`` times as strong, and with ``contact``
    lids and lips meet where they do on the face that comes along. ``marks`` (face_found.Marks) are
    followed; ``told`` has for the head and each part a kind of ``face_parts.KINDS`` that its loose pieces
    are of, or "".
    """

    def steps():
        try:
            target = lissom.Mesh(*head)
        except lissom.InvalidMesh as error:
            raise Refused(f"The mesh of the head cannot be used: {error}") from error
        face = data.face().only(*SOURCE)
        kinds_told = told or [""] * (1 + len(parts))
        connected = face_parts.parts(len(head[0]), head[1])
        loose = connected[1:]
        pieces = [(head[0], loose, kinds_told[0])]
        pieces += [
            (vertices, face_parts.parts(len(vertices), triangles), given)
            for (vertices, triangles), given in zip(parts, kinds_told[1:], strict=True)
        ]
        balls = [ball for piece in pieces for ball in face_parts.balls(*piece)]
        located = yield from locate_steps(face, (target, *head, parts, balls), marks)
        if isinstance(located, Unsure):
            return located
        fit = located.fit
        made, offsets, left = names.combined(kind, face.expression_names, face.expressions)
        offsets = strength * _with_the_jaw(made, offsets)
        # Offsets are everybody's: from the person that the head looks like they have that person's gradients.
        person = lissom.Mesh(fit.rest, face.triangles)
        transfer = yield lissom.start_transfer(person, target, fit, contact=contact)
        shapes = fit.rest + offsets
        found = (yield transfer.start_apply(shapes)).vertices
        led = []
        if located.rims:
            skin = connected[0]
            moved, led = yield from _by_lids(
                face, located, (target, *head, skin), balls, (offsets, found - head[0])
            )
            yield from _lips_closed(located, (target, *head, skin), dict(zip(made, moved, strict=True)))
            moved = yield from _untorn(target, located, head, moved, balls)
            found = head[0] + _alike(made, located, (*head, skin), moved)
            found = yield target.start_limit_stretch(found, LONGEST)
        quality = yield transfer.start_quality(shapes, found, led)
        moved = _with_the_jaw(made, found - head[0], -1)
        body = np.setdiff1d(np.arange(len(head[0])), np.concatenate([*loose, np.zeros(0, dtype=int)]))
        known = _Known(face, fit, kind, strength, head[0][body], moved[:, body])
        # A person's lashes have been carried over by the lids that they are on; a cartoon's are no match.
        ride = bool(located.rims)
        own, whats = known.move(head[0], loose, kinds_told[0], ride)
        for what, piece in zip(whats, loose, strict=True):
            if what != "RIDE" or ride:
                moved[:, piece] = own[:, piece]
        done, kinds = [], [whats]
        for vertices, own_pieces, given in pieces[1:]:
            offsets_of, whats = known.move(vertices, own_pieces, given)
            done.append(offsets_of)
            kinds.append(whats)
        warnings = list(transfer.warnings)
        if located.certainty < SURE:
            warnings.append(f"Only {100 * located.certainty:.0f} % sure where the face is: look at every key")
        return Faced(located, made, moved, done, left, kinds, quality, warnings)

    return Work(steps())


def _with_the_jaw(made, offsets, sign=1):
    """``offsets`` (k, n, 3) of keys of these names with jawOpen's, or less these, in mouthClose.

    That key is one of its own by name alone: it says where lips are that close while the jaw is open. What
    the two make together is carried over, closed, limited and judged.
    """
    found = offsets.copy()
    if {"jawOpen", "mouthClose"} <= set(made):
        found[made.index("mouthClose")] += sign * offsets[made.index("jawOpen")]
    return found


def _by_lids(face, located, head, balls, keys):
    """(k, n, 3) with lids that go as far as these eyes are high, and the vertices that these lead, as steps
    of a Work; ``head`` is (lissom.Mesh, vertices, triangles, vertices of its skin), ``keys`` are offsets
    (k, m, 3) on the face and what was made of them (k, n, 3).
    """
    (target, vertices, _, skin), (offsets, moved) = head, keys
    found, led, frame = moved.copy(), [], Frame.of(located.fit.rest, located.fit.fitted_vertices)
    upright = frame.back(vertices)
    for name, other in (CURVES[:2], CURVES[1::-1]):
        if name not in located.rims:
            continue
        # On the face that the offsets are of: the eyes of a person with larger ones would stay open by them.
        source = Lids.of(face.neutral, face.curves[name])
        lids = Lids.of(upright, located.rims[name])
        rim, place = np.unique(np.concatenate(lids), return_index=True)
        still = np.concatenate([located.rims[one] for one in (other, "lips") if one in located.rims])
        around = np.setdiff1d(skin[face_lids.near(upright, skin, rim)], np.setdiff1d(still, rim))
        pose = yield _start_sheet(target, rim, around)
        led += [rim, around]
        axis = face_lids.Axis.of(lids, vertices, frame.turn[:, 1], balls)
        # A handle's places are lengths, whatever they stand for.
        unit = np.array([1.0, np.linalg.norm(np.ptp(vertices[rim], axis=0)), 1.0])
        goal = vertices[rim] + [unit[1], 0, 0]
        share = ((yield pose.start_solve_points(goal)).vertices - vertices)[:, :1] / unit[1]
        for row, offset in zip(found, offsets, strict=True):
            if np.abs(offset[face.curves[name]]).max() <= face_lids.LEAST:
                continue
            shares = Shares.of(source, face.neutral, offset)
            steps = face_lids.steps(lids, vertices, row, shares)[place]
            goal = vertices[rim] + unit * axis.motion(vertices[rim], steps)
            motion = (yield pose.start_solve_points(goal)).vertices - vertices
            row *= 1 - share
            row[around] += axis.moved(vertices[around], motion[around] / unit)
    return found, np.unique(np.concatenate(led)) if led else led


def _start_sheet(target, rim, around):
    """A job of the pose by which the skin ``around`` goes along with a rim."""
    # Bending keeps the ring beside the rim from taking all of the stretch.
    free = np.union1d(around, rim)
    return lissom.start_pose(target, [rim], free, "thin_shell", k_b=BENDS, unheld="rest")


def _lips_closed(located, head, keys):
    """Changes mouthClose of ``keys``, {name: offsets (n, 3)}, so that lips are as far apart as at rest, as
    steps of a Work; ``head`` as in ``_by_lids``.

    By gradients alone the jaw opens them more or less than mouthClose closes. The lower lip follows.
    """
    if "lips" not in located.rims or "mouthClose" not in keys:
        return
    target, vertices, _, skin = head
    upright = Frame.of(located.fit.rest, located.fit.fitted_vertices).back(vertices)
    lips = Lids.of(upright, located.rims["lips"])
    rim = np.unique(np.concatenate(lips))
    still = [located.rims[name] for name in CURVES[:2] if name in located.rims]
    around = np.setdiff1d(skin[face_lids.near(upright, skin, rim)], np.concatenate([[], *still]))
    goal = vertices.copy()
    goal[lips.lower] -= lips.opened(vertices, keys["mouthClose"])
    pose = yield _start_sheet(target, rim, around)
    motion = (yield pose.start_solve_points(goal[rim])).vertices - vertices
    keys["mouthClose"][around] += motion[around]


def _untorn(target, located, head, offsets, balls):
    """(k, n, 3) in front of the eyeballs, with no long edge but those of the rims of the eyes, which stay, as
    steps of a Work.

    A cartoon's few edges at the corners of eyes and mouth take what people's many loops there share.
    """
    vertices, triangles = head
    rims = [located.rims[name] for name in CURVES[:2] if name in located.rims]
    held = np.unique(np.concatenate([np.zeros(0, dtype=int), *rims]))
    found, left = offsets.copy(), np.arange(len(offsets))
    for _ in range(ROUNDS):
        for row in left:
            for centre, radius in balls:
                found[row] = face_lids.outside(vertices, triangles, found[row], centre, radius, held)
        shapes = vertices + found[left]
        limited = yield target.start_limit_stretch(shapes, LONGEST, held)
        changed = (limited != shapes).any(axis=(1, 2))
        left = left[changed]
        found[left] = limited[changed] - vertices
        if not len(left):
            break
    return found


def _alike(made, located, head, moved):
    """(k, n, 3) with the same left and right, if the head is symmetric, whatever it wears."""
    vertices, triangles, skin = head
    pairs = ("lid_left", "lid_right"), ("lips", "lips")
    sides = next(pair for pair in pairs if pair[0] in located.rims)
    plane = face_twins.Plane.of_rims(*(vertices[located.rims[name][:-1]] for name in sides))
    body = triangles[np.isin(triangles[:, 0], skin)]
    other = plane and face_twins.twins(vertices, body, plane)
    return moved if other is None else face_twins.alike(made, moved, other, plane, body)


class _Known:
    """How a face moves, for what goes with it."""

    def __init__(self, face, fit, kind, strength, head, moved):
        """``head`` (n, 3) are the vertices of the head itself, ``moved`` (k, n, 3) their offsets by key."""
        self._whole, self._kind, self._strength = data.face(), kind, strength
        self._frame = Frame.of(fit.rest, fit.fitted_vertices)
        self._head, self._moved = head, moved
        corners = fit.rest[face.landmarks[CORNERS]]
        self._mouth = Mouth(corners.mean(axis=0), float(np.linalg.norm(corners[1] - corners[0])))

    def move(self, vertices, pieces, told="", ride=True):
        """Offsets (k, n, 3) of ``vertices`` (n, 3), and the kind of each of ``pieces``, lists of them.

        ``told`` is the kind of all of them, where somebody has said so. Without ``ride`` those that ride have
        none.
        """
        offsets, kinds = np.zeros((len(self._moved), *vertices.shape)), []
        local = self._frame.back(vertices)
        for piece in pieces:
            kinds.append(told or face_parts.kind(local[piece], self._mouth))
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
