"""Where markers lie: found again after an edit, and completed by symmetry."""

import re

import numpy as np

FAR = 0.02  # of the mesh's diagonal: a place this far from every vertex is no longer on the mesh
MIDDLE = 0.01  # of the diagonal: this near to the plane of symmetry a marker is its own image

_SIDE = re.compile(r"(?<![^\W\d_])(left|right|l|r)(?![^\W\d_])", re.IGNORECASE)
_OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}


def colour(number):
    """(r, g, b) of the marker at this place of the list: neighbours differ, whatever their count."""
    hue = 6 * (number * 0.618034 % 1)
    return tuple(min(max(abs((hue + shift) % 6 - 3) - 1, 0), 1) * 0.8 + 0.2 for shift in (0, 4, 2))


def nearest(vertices, places):
    """For each of (k, 3) places the nearest of (n, 3) vertices: (k,) indices and (k,) distances."""
    found = [np.linalg.norm(vertices - place, axis=1) for place in places]
    index = np.array([away.argmin() for away in found], dtype=np.int64)
    return index, np.array([away[i] for away, i in zip(found, index, strict=True)])


def diagonal(vertices):
    """Length of the diagonal of the box around (n, 3) vertices."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def mirrored(vertices, marked, axis):
    """The vertices nearest to the mirror images of ``marked`` (k,): (k,) indices, -1 where there are none.

    The plane goes through the origin, across ``axis`` (0, 1 or 2). A vertex on it is its own image.
    """
    size = diagonal(vertices)
    places = vertices[marked].copy()
    middle = np.abs(places[:, axis]) < MIDDLE * size
    places[:, axis] *= -1
    found, away = nearest(vertices, places)
    found[away > FAR * size] = -1
    return np.where(middle, marked, found)


def flipped(name):
    """The name of the other side: left and right, L and R exchange, in their own case."""

    def other(match):
        word = match[0]
        new = _OTHER[word.lower()]
        return new.upper() if word.isupper() else new.capitalize() if word[0].isupper() else new

    changed = _SIDE.sub(other, name)
    return changed if changed != name else f"{name} mirrored"


def completed(pairs, sources, targets):
    """The pairs that symmetry adds, and the names of those without a counterpart.

    ``pairs`` of core.markers.Marker; ``sources`` and ``targets`` are the images of their vertices, as
    ``mirrored`` has them. A pair has a counterpart already where either image is marked.
    """
    taken = [{marker.source for marker in pairs}, {marker.target for marker in pairs}]
    added, lost = [], []
    for marker, source, target in zip(pairs, sources, targets, strict=True):
        if not marker.mirror or source in taken[0] or target in taken[1]:
            continue
        if source < 0 or target < 0:
            lost.append(marker.name)
            continue
        taken[0].add(source)
        taken[1].add(target)
        added.append(type(marker)(flipped(marker.name), source, target))
    return added, lost
