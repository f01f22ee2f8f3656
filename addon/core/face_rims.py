"""The rims of lids and lips, found on a mesh itself: loops of edges round the openings of eyes and mouth.

An opening is a border of the mesh, or of what one sees of it, where a bag or a socket closes it behind.
Behind the edge of a lid, artists turn its skin inward, so that the border is not what one sees: of it and
the loops beside it the rim is the one that leaves the smallest opening from the front, and of those that
leave much the same the one in front.
"""

from itertools import permutations
from typing import NamedTuple

import lissom
import numpy as np

from . import topology

BEHIND = 4  # loops from the border to the rim at most
LEAST = 8  # vertices of a rim
NEAR = 0.6  # of the distance of the eyes: an opening further from where it should be is another
MOST = 1.6  # of the distance of the eyes: a rim that is wider is that of the neck or of a cut
ALIKE = 0.02  # of the square of its width: openings that differ by less are the same from the front
LEVEL = 0.25  # of the distance of the eyes: one eye is no higher than the other
CORNERS = 0.9  # of the distance of the eyes: those of a mouth are no further behind them
SLIT = 0.3  # of its lining's area: a pocket whose opening has less is behind a slit
SHALLOW = 0.05  # of the root of its opening's area: so deep is the middle of what lines a pocket
TURNED = np.tan(np.radians(35))  # sideways over ahead: a head looks along -y within this


class Opening(NamedTuple):
    """A border of the mesh: the loop of its rim, ending with its first, and ``points`` (k, 3) along it;
    ``behind``, the vertices between the rim and the border, and of the lining from there on.
    """

    loop: np.ndarray
    points: np.ndarray
    behind: np.ndarray

    @property
    def middle(self):
        """(3,)."""
        return (self.points.min(axis=0) + self.points.max(axis=0)) / 2

    @property
    def extent(self):
        """(3,)."""
        return np.ptp(self.points, axis=0)

    def seen_from(self, turn):
        """The same in the axes that are the rows of ``turn`` (3, 3)."""
        return self._replace(points=self.points @ turn.T)


def filled(triangles):
    """``triangles`` and those that close its gaps: borders that are too short for a rim."""
    fans = [
        np.column_stack([np.full(len(loop) - 3, loop[0]), loop[1:-2], loop[2:-1]])
        for loop in _loops(triangles)
        if len(loop) <= LEAST
    ]
    return np.concatenate([triangles, *fans])


def openings(vertices, triangles, lines):
    """The Openings of a mesh that looks along -y, the shortest border first.

    ``lines`` (m,) tells of the triangles whether they line a pocket: what one sees ends where these begin.
    """
    lines = lines & ~_sticks_out(vertices, triangles, lines)
    pockets = lissom.components(len(vertices), triangles[lines])
    for loop in _loops(triangles):
        pockets[np.isin(pockets, np.setdiff1d(pockets[loop], -1))] = -1
    seen = triangles[~(lines & (pockets[triangles] >= 0).all(axis=1))]
    beside, among = (_neighbours(topology.edges(some)[0]) for some in (seen, triangles))
    found = []
    for loop in _loops(seen):
        pocket = np.setdiff1d(pockets[loop], -1)
        if len(pocket):
            rim, behind = _without_teeth(vertices, loop, among), loop[:0]
        else:
            rim, behind = _rim(vertices, set(loop.tolist()), beside)
        if rim is not None and len(rim) > LEAST:
            behind = np.setdiff1d(np.union1d(behind, np.flatnonzero(np.isin(pockets, pocket))), rim)
            found.append(Opening(rim, vertices[rim], behind))
    return sorted(found, key=lambda opening: len(opening.loop))


def _without_teeth(vertices, loop, beside):
    """A loop that does not go round single triangles, which one sees behind a rim, or not before it."""
    path = loop[:-1]
    while len(path) > LEAST:
        before, after = np.roll(path, 1), np.roll(path, -1)
        first, second, straight = (
            np.linalg.norm(vertices[one] - vertices[other], axis=1)
            for one, other in ((before, path), (path, after), (before, after))
        )
        joined = [b in beside[a] for a, b in zip(before.tolist(), after.tolist(), strict=True)]
        detour = np.where(joined, first + second - straight, -1)
        if detour.max() < 0:
            break
        path = np.delete(path, detour.argmax())
    return np.append(path, path[0])


def _sticks_out(vertices, triangles, lines):
    """(m,) whether triangles line what is no pocket: the skin that a nose or brows stuck on it hide."""
    own, rest = triangles[lines], np.unique(triangles[~lines])
    corners = vertices[own]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    sizes = np.linalg.norm(areas, axis=1)
    label = lissom.components(len(vertices), own)
    found = np.zeros(len(triangles), dtype=bool)
    place = np.flatnonzero(lines)
    for number in np.unique(label[own[:, 0]]):
        these = label[own[:, 0]] == number
        border = np.intersect1d(own[these], rest)
        way = areas[these].sum(axis=0)  # out through the opening, as large as it is
        across = np.linalg.norm(way)
        if len(border) and across > SLIT * sizes[these].sum():
            middle = np.average(corners[these].mean(axis=1), axis=0, weights=sizes[these])
            deep = (vertices[border].mean(axis=0) - middle) @ way / across
            found[place[these]] = deep < SHALLOW * np.sqrt(across)
    return found


def _neighbours(edges):
    """{vertex: the set of those that edges (k, 2) join it to}."""
    found = {}
    for a, b in edges.tolist():
        found.setdefault(a, set()).add(b)
        found.setdefault(b, set()).add(a)
    return found


def _loops(triangles):
    """The loops at which a surface ends, each ending with its first vertex; two that touch at one are two."""
    edges, times = topology.edges(triangles)
    left, found = _neighbours(edges[times == 1]), []
    while left:
        path = [min(left)]
        while path and path[-1] in left:
            v = path[-1]
            ahead = min(left[v])
            for one, other in ((v, ahead), (ahead, v)):
                left[one].remove(other)
                if not left[one]:
                    del left[one]
            if ahead in path:
                start = path.index(ahead)
                found.append(np.array([*path[start:], ahead]))
                del path[start + 1 :]
            else:
                path.append(ahead)
    return found


def _rim(vertices, ring, beside):
    """The rim of a border, in order, and what is behind it; None where nothing near it is a loop."""
    seen, loops = set(ring), []
    for _ in range(BEHIND):
        loop = _ordered(ring, beside)
        if loop is not None and len(loop) > LEAST:
            loops.append((_area(vertices[loop][:, [0, 2]]), loop, seen - ring))
        ring = {v for b in ring for v in beside[b]} - seen
        seen |= ring
        if not ring:
            break
    if not loops:
        return None, None
    smallest, loop, _ = min(loops, key=lambda one: one[0])
    alike = smallest + ALIKE * np.ptp(vertices[loop][:, 0]) ** 2
    *_, loop, behind = min(
        (one for one in loops if one[0] <= alike), key=lambda one: vertices[one[1]][:, 1].mean()
    )
    return loop, np.array(sorted(behind), dtype=np.int64)


def _ordered(ring, beside):
    """The loop that these vertices form by the edges ``beside``, ending with its first, or None."""
    if any(len(beside[v] & ring) != 2 for v in ring):
        return None
    path = [min(ring)]
    path.append(min(beside[path[0]] & ring))
    while path[-1] != path[0]:
        path.append(next(v for v in beside[path[-1]] & ring if v != path[-2]))
    return np.array(path) if len(path) == len(ring) + 1 else None


def _area(points):
    x, y = points.T
    return abs(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2


def near(found, middles):
    """{curve of the face that comes along: loop} of the Openings nearest to where it is, (3, 3) ``middles``
    of the left eye, the right eye and the mouth; both lids or none.
    """
    apart = np.linalg.norm(middles[0] - middles[1])
    own = {}
    for name, middle in zip(("lid_left", "lid_right", "lips"), middles, strict=True):
        close = [one for one in found if one.extent[0] < MOST * apart and one.extent[2] < MOST * apart]
        close.sort(key=lambda one: np.linalg.norm(one.middle - middle))
        if close and np.linalg.norm(close[0].middle - middle) < NEAR * apart:
            own[name] = close[0].loop
    if own.keys() != {*own.keys(), "lid_left", "lid_right"} or own["lid_left"] is own["lid_right"]:
        own = {name: loop for name, loop in own.items() if name == "lips"}
    if "lips" in own and any(own["lips"] is own.get(name) for name in ("lid_left", "lid_right")):
        del own["lips"]
    return own


def of_face(found, balls):
    """(3, 3) middles of the left eye, the right eye and the mouth, and the loops of their rims, by the
    Openings and the eyeballs alone, or None.

    The eyes are the only two openings of a size, at a height and with an eyeball (centre, radius) behind each
    that have a mouth: the widest opening below and between them, where nostrils are too. Where ``balls`` are
    None they may as well be nostrils: the pair furthest apart is a guess.
    """
    faces = []
    for left, right in permutations(found, 2):
        line = left.middle - right.middle
        if line[0] <= 0 or abs(line[1]) > TURNED * line[0]:
            continue
        aside = line * [1, 1, 0] / np.hypot(*line[:2])
        turn = np.array([aside, [-aside[1], aside[0], 0], [0, 0, 1]])  # as the head looks
        eyes = [one.seen_from(turn) for one in (left, right)]
        if _are_alike(*eyes) and (balls is None or _have_balls(eyes, [(turn @ c, r) for c, r in balls])):
            mouth = _mouth(*eyes, [one.seen_from(turn) for one in found])
            if mouth is not None:
                middles = np.array([left.middle, right.middle, turn.T @ mouth.middle])
                faces.append((middles, [left.loop, right.loop, mouth.loop]))
    if balls is None and faces:
        return max(faces, key=lambda face: np.linalg.norm(face[0][0] - face[0][1]))
    return faces[0] if len(faces) == 1 else None


def _are_alike(left, right):
    apart = np.linalg.norm(left.middle - right.middle)
    alike = np.allclose(left.extent[[0, 2]], right.extent[[0, 2]], atol=0.15 * apart)
    return alike and abs(left.middle[2] - right.middle[2]) <= LEVEL * apart


def _have_balls(eyes, balls):
    own = [
        [
            (radius, number)
            for number, (centre, radius) in enumerate(balls)
            if np.linalg.norm((eye.middle - centre)[[0, 2]]) < 0.6 * radius and eye.extent[0] < 2.4 * radius
        ]
        for eye in eyes
    ]
    # A cap of hair is a ball behind both.
    return all(own) and min(own[0]) != min(own[1])


def _mouth(left, right, found):
    """The Opening of the mouth below two eyes, or None; that of a neck is further back."""
    between, apart = (left.middle + right.middle) / 2, np.linalg.norm(left.middle - right.middle)
    off = [(one, (one.middle - between) / apart) for one in found]
    below = [
        one
        for one, (aside, back, up) in off
        if abs(aside) < 0.2
        and -2.5 < up < -0.3
        and one.extent[0] < MOST * apart * 1.5
        and one.extent[2] < one.extent[0]
        and back > -1.5
        and one.points[:, 1].max() < between[1] + CORNERS * apart
    ]
    return max(below, key=lambda one: one.extent[0], default=None)
