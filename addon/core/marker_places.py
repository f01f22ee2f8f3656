"""Where markers lie: found again after an edit, and completed by symmetry."""

import re

import numpy as np

from .surface import closest

FAR = 0.02  # of the mesh's diagonal: a place this far from its surface is no longer on the mesh
SAME = 0.005  # of the diagonal: a mark this near to where the image of another is, is its counterpart
MIDDLE = 0.01  # of the diagonal: this near to the plane of symmetry a marker is its own image

_SIDE = re.compile(r"(?<![^\W\d_])(left|right|l|r)(?![^\W\d_])", re.IGNORECASE)
_OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}


def colour(number):
    """(r, g, b) of the pair of this number, from 1: neighbours differ, whatever their count."""
    hue = 6 * ((number - 1) * 0.618034 % 1)
    return tuple(min(max(abs((hue + shift) % 6 - 3) - 1, 0), 1) * 0.8 + 0.2 for shift in (0, 4, 2))


def nearest(vertices, places):
    """For each of (k, 3) places the nearest of (n, 3) vertices: (k,) indices and (k,) distances."""
    found = [np.linalg.norm(vertices - place, axis=1) for place in places]
    index = np.array([away.argmin() for away in found], dtype=np.int64)
    return index, np.array([away[i] for away, i in zip(found, index, strict=True)])


def diagonal(vertices):
    """Length of the diagonal of the box around (n, 3) vertices."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def found_again(vertices, triangles, places):
    """The points of a surface at (k, 3) places: a list of Point, None where nothing is near."""
    if not len(triangles):
        return [None] * len(places)
    points, away = closest(vertices, triangles, places)
    far = away > FAR * diagonal(vertices)
    return [None if lost else point for point, lost in zip(points, far.tolist(), strict=True)]


def mirrored(vertices, triangles, marked, axis):
    """The points at the mirror images of ``marked``, a list of Point; None where there is nothing.

    The plane goes through the origin, across ``axis`` (0, 1 or 2). A point on it is its own image.
    """
    places = np.array([point.position(vertices) for point in marked])
    middle = np.abs(places[:, axis]) < MIDDLE * diagonal(vertices)
    places[:, axis] *= -1
    images = found_again(vertices, triangles, places)
    return [own if mid else image for own, mid, image in zip(marked, middle.tolist(), images, strict=True)]


def flipped(name):
    """The name of the other side: left and right, L and R exchange, in their own case."""

    def other(match):
        word = match[0]
        new = _OTHER[word.lower()]
        return new.upper() if word.isupper() else new.capitalize() if word[0].isupper() else new

    changed = _SIDE.sub(other, name)
    return changed if changed != name else f"{name} mirrored"


def completed(pairs, images, rests):
    """The pairs that symmetry adds, and the names of those without a counterpart.

    ``pairs`` of core.markers.Marker; ``images``, two lists for source and target, are those of their points,
    as ``mirrored`` has them; ``rests`` are the vertices (n, 3) of both. A pair has a counterpart already
    where a mark is near either image.
    """
    near = [SAME * diagonal(vertices) for vertices in rests]
    marked = [
        [marker.point(side).position(rest) for marker in pairs]
        for side, rest in zip(("source", "target"), rests, strict=True)
    ]
    added, lost = [], []
    for number, marker in enumerate(pairs):
        found = [side[number] for side in images]
        places = [point and point.position(rest) for point, rest in zip(found, rests, strict=True)]
        taken = any(
            place is not None and np.linalg.norm(np.array(known) - place, axis=1).min() < reach
            for place, known, reach in zip(places, marked, near, strict=True)
        )
        if not marker.mirror or taken:
            continue
        if None in found:
            lost.append(marker.name)
            continue
        for known, place in zip(marked, places, strict=True):
            known.append(place)
        added.append(type(marker).between(flipped(marker.name), *found))
    return added, lost
