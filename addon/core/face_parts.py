"""Eyes, teeth, tongue and lashes of a head: told by shape and place, and moved as a face's keys move them.

All of it in the face's own frame: x to its left, y to its back, z up. A Frame says where that is.
"""

from typing import NamedTuple

import lissom
import numpy as np

from .brush import rigid

KINDS = ("EYE", "UPPER", "LOWER", "RIDE")
ROUND = 0.08  # of the radius: root mean square distance from a sphere of what is an eyeball
GAZE = np.radians(30)  # as far as the gaze keys turn an eye
LOOKS = {"Up": (-1, 0, 0), "Down": (1, 0, 0), "Left": (0, 0, 1), "Right": (0, 0, -1)}  # axes of the turns
NEIGHBOURS = 4  # that what rides goes with


class Frame(NamedTuple):
    """The similarity that takes the face that comes along to a head: ``x -> size turn x + shift``."""

    turn: np.ndarray
    size: float
    shift: np.ndarray

    @classmethod
    def of(cls, rest, fitted):
        """The nearest to taking (n, 3) to (n, 3)."""
        motion = rigid(rest, fitted)
        turn, centre = motion[:3, :3], rest.mean(axis=0)
        spread = ((rest - centre) ** 2).sum()
        size = float((((rest - centre) @ turn.T) * (fitted - fitted.mean(axis=0))).sum() / spread)
        return cls(turn, size, fitted.mean(axis=0) - size * turn @ centre)

    def there(self, points):
        """(n, 3) of the face on the head."""
        return self.size * points @ self.turn.T + self.shift

    def back(self, points):
        """(n, 3) of the head in the face's frame."""
        return (points - self.shift) @ self.turn / self.size

    def offsets(self, offsets):
        """(n, 3) displacements of the face on the head."""
        return self.size * offsets @ self.turn.T


class Mouth(NamedTuple):
    """Where the mouth of the face is: middle of the slit (3,), and its width."""

    middle: np.ndarray
    width: float


def sphere(points):
    """(centre (3,), radius, root mean square distance over the radius) of the sphere nearest to points.

    Least squares in |p|^2 = 2 p.c + d (Coope 1993).
    """
    middle = points.mean(axis=0)
    local = points - middle
    rows = np.c_[2 * local, np.ones(len(points))]
    solution, *_ = np.linalg.lstsq(rows, (local**2).sum(axis=1), rcond=None)
    centre = solution[:3]
    radius = float(np.sqrt(max(solution[3] + centre @ centre, 0.0)))
    away = np.linalg.norm(local - centre, axis=1) - radius
    return centre + middle, radius, float(np.sqrt((away**2).mean()) / max(radius, 1e-300))


def kind(points, mouth):
    """What a part (n, 3) in the face's frame is, by shape and by where it is against the mouth."""
    _, radius, rough = sphere(points)
    height = points[:, 2].mean() - mouth.middle[2]
    if len(points) >= 12 and rough < ROUND and height > 0.4 * mouth.width and radius < mouth.width:
        return "EYE"
    off = points.mean(axis=0) - mouth.middle
    inside = (
        abs(off[0]) < 0.6 * mouth.width and abs(off[2]) < 0.6 * mouth.width and off[1] > -0.1 * mouth.width
    )
    if inside:
        return "UPPER" if off[2] > 0 else "LOWER"
    return "RIDE"


def balls(points, pieces, told=""):
    """(centre (3,), radius) of those of ``pieces``, lists of ``points`` (n, 3), that are eyeballs by shape.

    Where they were ``told`` to be of a kind, all of them are, or none.
    """
    found = [sphere(points[piece]) for piece in pieces if len(piece) >= 12 and told in ("", "EYE")]
    return [(centre, radius) for centre, radius, rough in found if told or rough < ROUND]


def parts(count, triangles, least=4):
    """Lists of vertices, each of one connected piece, the largest first; tiny ones are left out."""
    label = lissom.components(count, triangles)
    used = np.unique(triangles)
    found = [used[label[used] == number] for number in np.unique(label[used])]
    return sorted((one for one in found if len(one) >= least), key=len, reverse=True)


def gaze(name, centre):
    """The turn of an eye at ``centre`` in the face's frame by the key of a name: a rotation vector, or None.

    "eyeLookIn" is toward the nose: to the right for the left eye, which is at x above 0.
    """
    head, side = name[:-2], name[-2:]
    if not head.startswith("eyeLook") or side != ("_L" if centre[0] > 0 else "_R"):
        return None
    look = head.removeprefix("eyeLook")
    if look in ("In", "Out"):
        look = "Right" if (look == "In") == (side == "_L") else "Left"
    axis = LOOKS.get(look)
    return None if axis is None else GAZE * np.array(axis, dtype=np.float64)


def turned(points, centre, vector):
    """(n, 3) displacements of points that turn about a centre by a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    axis, local = vector / max(angle, 1e-300), points - centre
    across = np.cross(axis, local)
    return np.sin(angle) * across + (1 - np.cos(angle)) * np.cross(axis, across)


def bonds(points, rest):
    """(n, k) of the nearest of some vertices (m, 3) to (n, 3) points, and (n, k) what each counts.

    By the inverse of the squared distance.
    """
    nearest, weights = [], []
    for some in np.array_split(points, max(1, len(points) // 512)):
        away = ((some[:, None] - rest[None]) ** 2).sum(axis=2)
        near = np.argpartition(away, min(NEIGHBOURS, len(rest) - 1), axis=1)[:, :NEIGHBOURS]
        counts = 1.0 / (np.take_along_axis(away, near, axis=1) + 1e-12)
        nearest.append(near)
        weights.append(counts / counts.sum(axis=1, keepdims=True))
    return np.concatenate(nearest), np.concatenate(weights)


def rigid_offsets(points, rest, offsets):
    """(n, 3) displacements of points that go rigidly with what moves from rest (m, 3) by offsets (m, 3)."""
    motion = rigid(rest, rest + offsets)
    return points @ motion[:3, :3].T + motion[:3, 3] - points
