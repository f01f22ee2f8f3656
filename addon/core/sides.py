"""Keys of one side made from those of the other: names, mirrored offsets, split ones."""

import re
from typing import NamedTuple

import lissom
import numpy as np

LEFT_RIGHT = {"left": "right", "l": "r"}
LEFT_RIGHT |= {right: left for left, right in LEFT_RIGHT.items()}
# ``browDownLeft``, ``leftBrow``; ``left_brow``, ``Brow_L``, ``brow.l``, ``R-brow``; then Blender's number.
_PATTERNS = (
    re.compile(r"^(?P<before>.*[a-z0-9])(?P<side>Left|Right)(?P<after>(?:\.\d+)?)$"),
    re.compile(r"^(?P<before>)(?P<side>[lL]eft|[rR]ight)(?P<after>[A-Z].*)$"),
    re.compile(r"^(?P<before>(?:.*[._\- ])?)(?P<side>left|right|l|r)(?P<after>(?:\.\d+)?)$", re.IGNORECASE),
    re.compile(r"^(?P<before>)(?P<side>left|right|l|r)(?P<after>[._\- ].*)$", re.IGNORECASE),
)
AT_VERTEX = 1e-6  # weight of the other corners below which a twin is a vertex: rounding


class Twins(NamedTuple):
    """Where each vertex of a mesh lies mirrored: the ``corners`` (n, 3) and ``weights`` (n, 3) of the
    place on the same mesh, zeros where there is none; ``away`` (n,) how far off that place is, or NaN.
    """

    corners: np.ndarray
    weights: np.ndarray
    away: np.ndarray


def parts_of(name):
    """(before, side, after) of a name that says left or right, else None."""
    found = next(filter(None, (pattern.match(name) for pattern in _PATTERNS)), None)
    return found and found.group("before", "side", "after")


def swapped(name):
    """The name of the other side, in the same spelling; None where a name has no side."""
    parts = parts_of(name)
    if parts is None:
        return None
    before, side, after = parts
    other = LEFT_RIGHT[side.lower()]
    if side.isupper():
        other = other.upper()
    elif side[0].isupper():
        other = other.capitalize()
    return before + other + after


def names_of_halves(name):
    """The names of the left and the right half of a key, as the rest of the set spells sides.

    ``browInnerUp`` becomes ``browInnerUpLeft``, ``brow_up`` ``brow_up_L``, and ``Brow Up`` ``Brow Up.L``.
    """
    if re.search(r"[a-z0-9][A-Z]", name) and not re.search(r"[._\- ]", name):
        return name + "Left", name + "Right"
    between = "_" if "_" in name else "."
    return f"{name}{between}L", f"{name}{between}R"


def twins_work(vertices, triangles, axis):
    """Steps of a core.work.Work whose result are the Twins of a mesh about the plane ``axis`` = 0.

    By closest points of the mesh laid over its own mirror image, that face the same way (Abdrashitov et al.
    2023), so that a lip does not find the other lip.
    """
    mirrored = vertices.copy()
    mirrored[:, axis] *= -1
    mesh = lissom.Mesh(vertices, triangles)
    image = lissom.Mesh(mirrored, triangles[:, ::-1])
    fit = yield lissom.start_fit(mesh, image, overlap=True)
    triangle, weights = fit.image_triangles, fit.image_weights.copy()
    found = triangle >= 0
    corners = np.zeros((len(vertices), 3), dtype=np.int64)
    corners[found] = triangles[triangle[found]]
    weights[~found] = 0
    heaviest = weights.max(axis=1) > 1 - AT_VERTEX
    weights[heaviest] = np.eye(3)[weights[heaviest].argmax(axis=1)]
    return Twins(corners, weights, np.where(found, fit.image_distances, np.nan))


def mirrored(offsets, twins, axis):
    """(n, 3) offsets as they are on the other side; a vertex without a twin stays."""
    found = np.einsum("nc,ncd->nd", twins.weights, offsets[twins.corners])
    found[:, axis] *= -1
    return found


def left_share(vertices, axis, width):
    """(n,) in 0-1: how much of a key belongs to the left, the side of +axis.

    1 beyond half of ``width`` on the left of the plane, 0 on the right, and with continuous slope between, so
    that s(x) + s(-x) = 1.
    """
    x = vertices[:, axis]
    if width <= 0:
        return np.where(x > 0, 1.0, np.where(x < 0, 0.0, 0.5))
    t = np.clip(x / width + 0.5, 0, 1)
    return t * t * (3 - 2 * t)


def split(offsets, share):
    """Left and right (n, 3) of offsets (n, 3), by the share (n,) of the left.

    They are in single precision, as keys are, and their sum is the whole to its rounding.
    """
    whole = np.asarray(offsets, dtype=np.float32)
    left = (np.asarray(share)[:, None] * whole).astype(np.float32)
    return left.astype(np.float64), (whole - left).astype(np.float64)


def total(offsets, weights=None):
    """(n, 3): the sum of (k, n, 3) offsets, each by its weight, 1 where none are given."""
    weights = np.ones(len(offsets)) if weights is None else np.asarray(weights)
    return np.tensordot(weights, np.asarray(offsets), 1)
