"""A bound mesh: handles and region by name, checked, and the native pose that follows the handles."""

from typing import NamedTuple

import lissom
import numpy as np
from lissom import nearest_rotations, rotation_vectors

from . import stays
from .mirrors import NONE
from .refused import Refused, first
from .topology import joined
from .turns import UNTURNED
from .work import Work

# Empties keep their place in single precision: below this part of the mesh's extent a handle stands still.
STILL = 2e-6

# A handle that has turned this far since the last solve is not where that left the mesh.
TURNED = np.pi / 2

# So many vertices tell whether the rest shape has moved, and how.
PROBES = 8

# A method takes two small steps in a row for convergence: with fewer in one go it would never find any.
FEWEST_ITERATIONS = 4


def check_groups(groups, handles, roi):
    """Refused where a vertex group is missing, empty or overlaps another handle (rows 19, 23, 25).

    ``groups`` maps names to sorted vertex indices, ``handles`` is a list of names, ``roi`` a name or "".
    """
    if not handles:
        raise Refused("There is no handle: add a vertex group as a handle, then bind")
    missing = [name for name in [*handles, *([roi] if roi else [])] if name not in groups]
    if missing:
        raise Refused(
            f"Vertex group {first(repr(name) for name in missing)} is missing: it was renamed or removed. "
            "Choose it anew in the list of handles or as region, then bind"
        )
    for name in handles:
        if not len(groups[name]):
            raise Refused(f"Vertex group '{name}' holds no vertices: assign some, then bind")
    if roi and not len(groups[roi]):
        raise Refused(
            f"The region's vertex group '{roi}' holds no vertices: assign some, or clear the region"
        )
    for number, name in enumerate(handles):
        for other in handles[:number]:
            shared = np.intersect1d(groups[name], groups[other])
            if len(shared):
                raise Refused(
                    f"Handles '{other}' and '{name}' share vertices {first(shared)}: "
                    "take them out of one of the two vertex groups"
                )


class Company(NamedTuple):
    """Further meshes under the same handles, each (vertices (n, 3), triangles (m, 3)) in solve space.

    Those that ride are parts of the mesh that is posed: loose ones follow the nearest surface rigidly. Drapes
    lie on it as clothes do, and go with it by the transfer of a fit that takes both as they are.
    """

    rides: tuple = ()
    drapes: tuple = ()


ALONE = Company()


def bind_work(
    vertices, triangles, corners, handles, weights, roi, asked, mirrors=NONE, company=ALONE, adrift=False
):
    """Work whose result is the BoundPose of a mesh.

    ``vertices`` (n, 3) in solve space, ``corners`` (c,) the vertices of the faces in turn; ``handles`` and
    ``weights`` are lists of arrays (k,), ``roi`` one of indices or None, ``asked`` a pose_options.Asked.
    ``mirrors`` are those of the object; indices beyond its vertices are those of what rides on it. Where the
    handles are all dragged, ``adrift``, core.stays says what holds the mesh.
    """

    def steps():
        all_vertices, all_triangles = joined([(vertices, triangles), *company.rides])
        mesh = lissom.Mesh(all_vertices, all_triangles, weld=0.0 if asked.weld else None)
        region, known = roi, asked
        if adrift:
            region, reach = stays.moving(mesh, handles, asked.stays, asked.reach)
            known = asked._replace(reach=reach)
        pose = yield lissom.start_pose(
            mesh,
            handles,
            roi=region,
            method=asked.method,
            handle_weights=weights if asked.use_weights else None,
            **asked.options,
            **mirrors.pose(all_vertices),
        )
        drapes = []
        for cloth in company.drapes:
            source, target = lissom.Mesh(vertices, triangles), lissom.Mesh(*cloth)
            fit = yield lissom.start_fit(source, target, None, overlap=True)
            if not len(fit.pairs):
                raise Refused("A cloth lies nowhere on the mesh: let it go along as a rigid part")
            drapes.append((yield lissom.start_transfer(source, target, fit)))
        return BoundPose(pose, vertices, corners, len(handles), known, mirrors, company, drapes)

    return Work(steps())


class Motion(NamedTuple):
    """Where the handles are: matrices (h, 4, 4), rest -> posed in solve space; turns (h, 3) or None; the
    numbers of those that turn by themselves."""

    transforms: np.ndarray
    turns: np.ndarray | None = None
    by_itself: tuple[int, ...] = ()


def steady(motions):
    """The same row of motions, in which a handle turns by itself only if it is never turned as given.

    A handle that rests may stand still or turn by itself, as it does in the other motions.
    """
    turned = {h for motion in motions for h in _turned(motion)}
    return [
        motion._replace(by_itself=tuple(h for h in motion.by_itself if h not in turned)) for motion in motions
    ]


def _turned(motion):
    """The handles that a motion turns as given."""
    vectors = rotation_vectors(nearest_rotations(motion.transforms[:, :3, :3]))
    told = vectors if motion.turns is None else motion.turns
    return np.flatnonzero(np.linalg.norm(told, axis=1) > UNTURNED)


def _same(one, other):
    """Whether two Companies are of the same meshes."""
    pairs = zip((*one.rides, *one.drapes), (*other.rides, *other.drapes), strict=False)
    return [len(part) for part in one] == [len(part) for part in other] and all(
        np.array_equal(a, b) for mesh, like in pairs for a, b in zip(mesh, like, strict=True)
    )


class BoundPose:
    """The native pose of one bound mesh, with what it was made from, to tell whether it still holds."""

    def __init__(self, pose, vertices, corners, handles, asked, mirrors, company=ALONE, drapes=()):
        """``pose`` is a lissom.Pose of so many ``handles``, ``drapes`` a lissom.Transfer for each of
        ``company.drapes``; the rest as ``bind_work`` has it."""
        self.pose = pose
        self.vertices = vertices
        self.corners = corners
        self.asked = asked
        self.mirrors = mirrors
        self.company = company
        self._drapes = drapes
        self.warnings = pose.warnings
        self.extent = np.linalg.norm(np.ptp(vertices, axis=0))
        self._handles = handles
        self._seconds = None  # of one iteration, in the last solve
        self.doubts = []  # what the last solve says besides, that it stopped early apart
        self.breaks = 0  # counts how often something else than a solve was shown
        self.put_to_rest()

    def put_to_rest(self):
        """The mesh is shown at rest, all handles stand where they were bound."""
        self._motion = Motion(np.tile(np.eye(4), (self._handles, 1, 1)))
        self._converged = True
        self._warm = False
        self.breaks += 1

    def forget(self):
        """What is shown is not the last solve: the next occasion solves, and from the rest shape."""
        self._motion = None
        self._warm = False
        self.breaks += 1

    def beyond_half_a_turn(self):
        """(h,) bool: the handles that had turned so far, all told, at the last solve."""
        if self._motion is None or self._motion.turns is None:
            return np.zeros(self._handles, dtype=bool)
        return np.linalg.norm(self._motion.turns, axis=1) > np.pi

    def fits(self, vertices, corners, handles, asked, mirrors, company=ALONE):
        """True while meshes, the number of handles, mirrors, method and options are those it was made for."""
        return (
            handles == self._handles
            and asked == self.asked
            and mirrors == self.mirrors
            and _same(company, self.company)
            and np.array_equal(corners, self.corners)
            and np.array_equal(vertices, self.vertices)
        )

    def is_due(self, motion):
        """True where a solve would change what is shown: a handle moved, or the last solve stopped early."""
        return not self._converged or self._moved(motion)

    def _moved(self, motion):
        """True where the handles are not where the last solve left them."""
        if self._motion is None or self._jumps(motion):
            return True
        change = np.abs(motion.transforms - self._motion.transforms)
        return change[:, :3, :3].max() > STILL or change[:, :3, 3].max() > STILL * self.extent

    def _jumps(self, motion):
        """True where a handle's turns are others than those the last solve went through."""
        if motion.by_itself != self._motion.by_itself:
            return True
        if motion.turns is None and self._motion.turns is None:
            return False
        none = np.zeros((self._handles, 3))
        before, now = (none if m.turns is None else m.turns for m in (self._motion, motion))
        # From half a turn on they are told: what is not told is less.
        least = TURNED if motion.turns is not None and self._motion.turns is not None else np.pi + TURNED
        return np.linalg.norm(now - before, axis=1).max() > least

    def _arguments(self, motion, options):
        warm = self._warm and not self._jumps(motion)
        by_itself = list(motion.by_itself)
        return {"turns": motion.turns, "by_itself": by_itself, "warm_start": warm, **options}

    def work(self, motion, **options):
        """One solve as Work: (n, 3) in solve space and the report; ``options`` of lissom.Pose.solve."""

        def steps():
            return (yield from self.steps(motion, **options))

        return Work(steps())

    def steps(self, motion, **options):
        """The same as a part of longer work."""
        job = self.pose.start_solve(motion.transforms, **self._arguments(motion, options))
        return self._note(motion, (yield job))

    def _note(self, motion, result):
        self._motion = motion
        self._converged = result.report["converged"]
        # After those of the pose, and the one of a solve that stopped early.
        known = len(self.warnings) + (not self._converged)
        self.doubts = result.report["warnings"][known:]
        self._seconds = result.report["seconds"] / max(1, result.report["iterations"])
        self._warm = True
        if not self._drapes:
            return result.vertices, result.report
        body = result.vertices[None, : len(self.vertices)]
        dressed = [drape.apply(body).vertices[0] for drape in self._drapes]
        return np.concatenate([result.vertices, *dressed]), result.report

    def iterations_within(self, seconds, motion):
        """About how many iterations fit into ``seconds``, judged by the last solve: at rest never too few to
        converge, while the handles move at least one."""
        fewest = 1 if self._moved(motion) else FEWEST_ITERATIONS
        return max(fewest, int(seconds / self._seconds) if self._seconds else 0)

    @property
    def converged(self):
        """Whether the last solve went to the end."""
        return self._converged
