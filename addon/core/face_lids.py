"""Lids go as far as their own eye is high, and slide over the eyeball.

At a place of the rim, the upper lid and the lower one opposite are the gap ``g`` apart at rest. On the face
that comes along a key moves the upper one by the share ``a`` of its gap towards the lower, and the lower
one by ``b`` towards the upper; a key that closes the eye has ``a + b = 1``. On the head the rims are moved
by the same shares of its own gap, whatever a transfer by gradients has made of them. Towards the corners no
lid goes beyond the middle: the skin beside a corner would have to turn over.

The skin around goes along, by a sheet that is stretched from the rim to what is still, in cylindrical
coordinates about the eyeball's axis from corner to corner: what turns about that stays in front of the ball.
"""

from typing import NamedTuple

import numpy as np

PLACES = 33  # at which two lids are compared, from corner to corner
NARROW = 0.25  # of the eye's height: shares near the corners are of no less
CLOSED = 0.85  # of the way: from here on an eye is meant to be closed
REACH = 1.0  # of the eye's height, or of half its width: so far the skin goes along
FLAT = 5  # power of the gap, over that in the middle, by which what goes beyond the middle lessens
FAR = 10.0  # widths of an eye: so far behind it is the axis where there is no eyeball
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

    @property
    def corners(self):
        """(2,) vertices."""
        return self.upper[[0, -1]]

    def gaps(self, points):
        """(p, 3) from the upper lid to the lower at places from corner to corner."""
        at = np.linspace(0, 1, PLACES)
        return _along(points, self.lower, at) - _along(points, self.upper, at)

    def opened(self, points, offsets):
        """(k, 3) how much further from the upper one the lower one's vertices are by ``offsets`` (n, 3)."""
        own = _lengths(points, self.lower)
        return offsets[self.lower] - _along(points, self.upper, own, offsets)


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


def near(upright, body, rim):
    """Of the vertices ``body`` those that the rim of an eye takes along, of (n, 3) in the face's frame."""
    wide, _, high = np.ptp(upright[rim], axis=0)
    away = np.min([np.linalg.norm(upright[body] - point, axis=1) for point in upright[rim]], axis=0)
    return away < REACH * max(high, wide / 2)


def steps(lids, vertices, offsets, shares):
    """(k, 3) steps of the rim, the upper lid's vertices and then the lower one's, by a key of these
    ``shares``, whose ``offsets`` (n, 3) they replace. What opens an eye is left: a tall one stays open.
    """
    at = np.linspace(0, 1, PLACES)
    gaps = lids.gaps(vertices)
    size = np.linalg.norm(gaps, axis=1)
    flat = (size / size.max()) ** FLAT
    upper, lower = (np.where(side > 0.5, 0.5 + (side - 0.5) * flat, side) for side in shares)
    if shares.close:
        upper, lower = (1 - lower, lower) if shares.lower.mean() > 0.5 else (upper, 1 - upper)
    found = []
    for path, share, whole, sign in (
        (lids.upper, upper, shares.upper, 1),
        (lids.lower, lower, shares.lower, -1),
    ):
        own = _lengths(vertices, path)
        step = sign * share[:, None] * gaps
        if shares.close:  # to where the other goes as well
            goal = _along(vertices, path, at) + step
            found.append(np.column_stack([np.interp(own, at, axis) for axis in goal.T]) - vertices[path])
        elif whole.mean() > OPENS:
            found.append(np.column_stack([np.interp(own, at, axis) for axis in step.T]))
        else:
            found.append(offsets[path])
    return np.concatenate(found)


class Axis(NamedTuple):
    """The line about which lids turn: through a centre, and the directions along it, to the back and up."""

    centre: np.ndarray
    along: np.ndarray
    back: np.ndarray
    up: np.ndarray
    clear: float  # so far from the centre a rim is at least, 0 without an eyeball

    @classmethod
    def of(cls, lids, vertices, back, balls):
        """Of the eye whose lids these are and the ball (centre, radius) behind it."""
        rim = vertices[np.concatenate(lids)]
        middle = (rim.min(axis=0) + rim.max(axis=0)) / 2
        along = vertices[lids.upper[-1]] - vertices[lids.upper[0]]
        width = np.linalg.norm(along)
        along = along / width
        back = back - along * (back @ along)
        back /= np.linalg.norm(back)
        up = np.cross(along, back)
        behind = [
            (radius, centre)
            for centre, radius in balls
            if np.linalg.norm((centre - middle) @ np.array([along, up]).T) < 0.6 * radius < width * 2
        ]
        if not behind:
            return cls(middle + FAR * width * back, along, back, up, 0.0)
        radius, centre = min(behind, key=lambda ball: ball[0])
        return cls(centre, along, back, up, CLEAR * radius)

    def coordinates(self, points):
        """(n, 3) along it, radians up from the front, and away from it."""
        local = points - self.centre
        ahead, up = -local @ self.back, local @ self.up
        return np.column_stack([local @ self.along, np.arctan2(up, ahead), np.hypot(up, ahead)])

    def motion(self, points, steps):
        """(n, 3) how the coordinates of points change by steps, which stay outside of the eyeball."""
        before, after = self.coordinates(points), self.coordinates(points + steps)
        least = np.minimum(self.clear, np.linalg.norm(points - self.centre, axis=1))
        after[:, 2] = np.maximum(after[:, 2], np.sqrt(np.maximum(least**2 - after[:, 0] ** 2, 0)))
        changed = after - before
        changed[:, 1] = (changed[:, 1] + np.pi) % (2 * np.pi) - np.pi
        return changed

    def moved(self, points, motion):
        """(n, 3) displacements of points whose coordinates change so."""
        along, angle, away = (self.coordinates(points) + motion).T
        front, up = away * np.cos(angle), away * np.sin(angle)
        there = np.outer(along, self.along) - np.outer(front, self.back) + np.outer(up, self.up)
        return self.centre + there - points


def outside(vertices, triangles, offsets, centre, radius, rims):
    """``offsets`` (n, 3) of a key, with what it pushes into an eyeball out of it again.

    First the vertices, then the middles of triangles and edges, which cut across the ball between them; for
    these ``rims``, vertices that meet others, do not give way.
    """
    before = np.linalg.norm(vertices - centre, axis=1)
    moved = (np.linalg.norm(offsets, axis=1) > STILL * radius) & (before < AROUND * radius)
    found = offsets.copy()
    _push(found, vertices, np.flatnonzero(moved)[:, None], centre, np.minimum(CLEAR * radius, before[moved]))
    met = found[rims]
    near = triangles[moved[triangles].any(axis=1)]
    samples = [near, near[:, [0, 1]], near[:, [1, 2]], near[:, [2, 0]]]
    for _ in range(ROUNDS):
        for corners in samples:
            rest = np.linalg.norm(vertices[corners].mean(axis=1) - centre, axis=1)
            _push(found, vertices, corners, centre, np.minimum(OUT * radius, rest))
            found[rims] = met
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
