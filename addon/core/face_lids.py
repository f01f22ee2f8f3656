"""Lids go as far as their own eye is high, and slide over the eyeball.

At a place of the rim, the upper lid and the lower one opposite are the gap ``g`` apart at rest. On the face
that comes along a key moves the upper one by the share ``a`` of its gap towards the lower, and the lower
one by ``b`` towards the upper; a key that closes the eye has ``a + b = 1``. On the head the rims are moved
by the same shares of its own gap, whatever a transfer by gradients has made of them, and the skin around
goes along, less and less with the distance.
"""

from typing import NamedTuple

import numpy as np

PLACES = 33  # at which two lids are compared, from corner to corner
NARROW = 0.25  # of the eye's height: shares near the corners are of no less
CLOSED = 0.85  # of the way: from here on an eye is meant to be closed
SPREAD = 0.75, 0.5  # of the eye's height: so far the skin goes along, above and below
OPENS = 0.05  # of the gap: what moves a lid less towards the other, or away from it, is left
CLEAR = 1.06  # radii of the eyeball: what was outside stays as far from its middle
OUT = 1.02  # radii: likewise for what lies between vertices
ROUNDS = 6
AROUND = 2.0  # radii of the eyeball: what is further from its middle has nothing to do with it
LEAST = 1e-3  # centimetres of the face that comes along: a lid that moves less stays
STILL = 1e-4  # of the eyeball's radius: less is no motion


class Lids(NamedTuple):
    """The rim of an eye as its upper and its lower lid, both from the corner with the smaller x to the
    other.
    """

    upper: np.ndarray
    lower: np.ndarray

    @classmethod
    def of(cls, points, loop):
        """Of vertices (n, 3) and a loop of them that ends with its first; x is to the side, z up."""
        ring = loop[:-1]
        x = points[ring][:, 0]
        start, end = int(x.argmin()), int(x.argmax())
        one = np.roll(ring, -start)[: (end - start) % len(ring) + 1]
        other = np.roll(ring, -end)[: (start - end) % len(ring) + 1][::-1]
        if points[one][:, 2].mean() < points[other][:, 2].mean():
            one, other = other, one
        return cls(one, other)

    def gaps(self, points):
        """(p, 3) from the upper lid to the lower at places from corner to corner."""
        at = np.linspace(0, 1, PLACES)
        return _along(points, self.lower, at) - _along(points, self.upper, at)


def _lengths(points, path):
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points[path], axis=0), axis=1))])
    return along / along[-1]


def _along(points, path, at, values=None):
    """``values`` (n, d) at shares of the length of a path, by default the points themselves."""
    own = (points if values is None else values)[path]
    length = _lengths(points, path)
    return np.column_stack([np.interp(at, length, column) for column in own.T])


class Shares(NamedTuple):
    """How far a key moves both lids at each place, (p,), as shares of the gap there."""

    upper: np.ndarray
    lower: np.ndarray

    @classmethod
    def of(cls, lids, rest, offsets):
        """Of a key's ``offsets`` (n, 3)."""
        at = np.linspace(0, 1, PLACES)
        gaps = lids.gaps(rest)
        size = np.linalg.norm(gaps, axis=1)
        way = gaps.sum(axis=0) / np.linalg.norm(gaps.sum(axis=0))
        floor = np.maximum(size, NARROW * size.max())
        upper, lower = (_along(rest, path, at, offsets) @ way / floor for path in lids)
        lower = -lower
        middle = size > 0.5 * size.max()
        whole = upper[middle] + lower[middle]
        if whole.mean() > CLOSED:  # the ends too are to meet, and nothing is to pass
            share = np.clip(np.median(upper[middle] / whole), 0, 1)
            return cls(np.full(PLACES, share), np.full(PLACES, 1 - share))
        return cls(*(np.clip(side, side[middle].min(), side[middle].max()) for side in (upper, lower)))

    @property
    def close(self):
        """Whether the eye is closed."""
        return bool(np.allclose(self.upper + self.lower, 1))


def corrected(lids, vertices, upright, offsets, shares):
    """``offsets`` (n, 3) of a key on the head with lids that close moved by their ``shares``.

    ``upright`` (n, 3) are the vertices in the face's frame. What opens an eye is left: a tall one stays open.
    """
    at = np.linspace(0, 1, PLACES)
    gaps = lids.gaps(vertices)
    size = np.linalg.norm(gaps, axis=1)
    way = gaps.sum(axis=0) / np.linalg.norm(gaps.sum(axis=0))
    floor = np.maximum(size, NARROW * size.max())
    high = np.linalg.norm(lids.gaps(upright), axis=1).max()
    found = offsets.copy()
    sides = [_along(vertices, path, at) for path in lids]
    for path, share, sign, spread in (
        (lids.upper, shares.upper, 1, SPREAD[0]),
        (lids.lower, shares.lower, -1, SPREAD[1]),
    ):
        own = _lengths(vertices, path)
        if shares.close:
            goal = sides[0] + shares.upper[:, None] * (sides[1] - sides[0])
            step = np.column_stack([np.interp(own, at, axis) for axis in goal.T]) - vertices[path]
        elif share.mean() > OPENS:
            step = np.outer(sign * np.interp(own, at, share * floor), way)
        else:
            continue
        _lead(found, upright, path, lids, step, sign, spread * high)
    return found


def _lead(offsets, upright, path, lids, step, sign, reach):
    """Has the skin go with the steps (k, 3) of one lid, the upper one with ``sign`` 1, in place of its
    ``offsets``: that above it at the same place from corner to corner, the less the further away, so that
    all of it stretches alike.
    """
    places = upright[path]
    order = np.argsort(places[:, 0])
    x, height = places[order, 0], places[order, 2]
    middle = np.interp(upright[:, 0], *upright[lids.upper[[0, -1]]][:, [0, 2]].T)
    off = sign * (upright[:, 2] - np.interp(upright[:, 0], x, height))
    deep = np.abs(upright[:, 1] - np.interp(upright[:, 0], x, places[order, 1]))
    theirs = (upright[:, 0] > x[0]) & (upright[:, 0] < x[-1]) & (sign * (upright[:, 2] - middle) > 0)
    away = np.hypot(np.maximum(off, 0), np.maximum(deep - reach / 2, 0))
    fade = np.where(theirs, np.clip(1 - away / reach, 0, 1), 0)[:, None]
    along = np.column_stack([np.interp(upright[:, 0], x, axis[order]) for axis in step.T])
    offsets *= 1 - fade
    offsets += fade * along
    offsets[path] = step


def outside(vertices, triangles, offsets, centre, radius):
    """``offsets`` (n, 3) of a key, with what it pushes into an eyeball out of it again.

    First the vertices, then the middles of triangles and edges, which cut across the ball between them.
    """
    before = np.linalg.norm(vertices - centre, axis=1)
    moved = (np.linalg.norm(offsets, axis=1) > STILL * radius) & (before < AROUND * radius)
    found = offsets.copy()
    _push(found, vertices, np.flatnonzero(moved)[:, None], centre, np.minimum(CLEAR * radius, before[moved]))
    near = triangles[moved[triangles].any(axis=1)]
    samples = [near, near[:, [0, 1]], near[:, [1, 2]], near[:, [2, 0]]]
    for _ in range(ROUNDS):
        for corners in samples:
            rest = np.linalg.norm(vertices[corners].mean(axis=1) - centre, axis=1)
            _push(found, vertices, corners, centre, np.minimum(OUT * radius, rest))
    found[~moved] = offsets[~moved]
    return found


def _push(offsets, vertices, corners, centre, least):
    """Moves vertices until the middles of these (m, c) are ``least`` (m,) away from a centre."""
    local = (vertices + offsets)[corners].mean(axis=1) - centre
    away = np.linalg.norm(local, axis=1)
    short = away < least
    steps = (local * (least / np.maximum(away, 1e-12) - 1)[:, None])[short]
    sums, counts = np.zeros_like(offsets), np.zeros(len(offsets))
    for column in corners[short].T:
        np.add.at(sums, column, steps)
        np.add.at(counts, column, 1)
    offsets += sums / np.maximum(counts, 1)[:, None]
