"""The rims of lids and lips, found on a mesh itself: loops of edges round the openings of eyes and mouth.

An opening is a border of the mesh. Behind the edge of a lid, artists turn its skin inward, so that the
border is not what one sees: of it and the loops beside it the rim is the one that leaves the smallest
opening from the front, and of those that leave much the same the one in front.
"""

from typing import NamedTuple

import numpy as np

from . import topology

BEHIND = 4  # loops from the border to the rim at most
LEAST = 8  # vertices of a rim
NEAR = 0.6  # of the distance of the eyes: an opening further from where it should be is another
MOST = 1.6  # of the distance of the eyes: a rim that is wider is that of the neck or of a cut
ALIKE = 0.02  # of the square of its width: openings that differ by less are the same from the front
LEVEL = 0.25  # of the distance of the eyes: one eye is no higher than the other, nor further back


class Opening(NamedTuple):
    """A border of the mesh: the loop of its rim, ending with its first, its middle, and its extent (3,);
    ``behind``, the vertices between the rim and the border.
    """

    loop: np.ndarray
    middle: np.ndarray
    extent: np.ndarray
    behind: np.ndarray


def openings(vertices, triangles):
    """The Openings of a mesh that looks along -y, the shortest border first."""
    edges, times = topology.edges(triangles)
    beside = {}
    for a, b in edges.tolist():
        beside.setdefault(a, set()).add(b)
        beside.setdefault(b, set()).add(a)
    border = {}
    for a, b in edges[times == 1].tolist():
        border.setdefault(a, set()).add(b)
        border.setdefault(b, set()).add(a)
    found, left = [], set(border)
    while left:
        ring, grown = set(), {left.pop()}
        while grown:
            ring |= grown
            grown = {v for b in grown for v in border[b]} - ring
        left -= ring
        rim, behind = _rim(vertices, ring, beside)
        if rim is not None:
            points = vertices[rim]
            middle = (points.min(axis=0) + points.max(axis=0)) / 2
            found.append(Opening(rim, middle, np.ptp(points, axis=0), behind))
    return sorted(found, key=lambda opening: len(opening.loop))


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
    """The loop of edges that these vertices form, ending with its first, or None."""
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
    """(3, 3) middles of the left eye, the right eye and the mouth, by the Openings and the eyeballs alone,
    or None.

    The eyes are two openings of a size, at a height and with an eyeball (centre, radius) behind each; the
    mouth is the only opening below the eyes and between them.
    """
    eyes = [
        (one, ball)
        for one in found
        for ball in balls
        if np.linalg.norm((one.middle - ball[0])[[0, 2]]) < 0.6 * ball[1] and one.extent[0] < 2.4 * ball[1]
    ]
    if len(eyes) != 2 or eyes[0][0] is eyes[1][0] or eyes[0][1] is eyes[1][1]:
        return None
    (left, _), (right, _) = sorted(eyes, key=lambda eye: -eye[0].middle[0])
    apart = np.linalg.norm(left.middle - right.middle)
    off = np.abs(left.middle - right.middle)[1:]
    if off.max() > LEVEL * apart or not np.allclose(left.extent, right.extent, atol=0.15 * apart):
        return None
    between = (left.middle + right.middle) / 2
    below = [
        one
        for one in found
        if abs(one.middle[0] - between[0]) < 0.2 * apart
        and between[2] - 2.5 * apart < one.middle[2] < between[2] - 0.3 * apart
        and one.extent[0] < MOST * apart * 1.5
        and one.extent[2] < one.extent[0]
        and abs(one.middle[1] - between[1]) < 1.5 * apart
    ]
    return np.array([left.middle, right.middle, below[0].middle]) if len(below) == 1 else None
