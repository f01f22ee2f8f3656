"""Picking: what a view shows where, which mark or rim is under the mouse, and the half of a pair in hand."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .surface import Point

MARK_REACH, RIM_REACH = 12, 8  # pixels: so near to a mark or a rim the mouse is on it, ...
BESIDE_RIM = 0.5  # ... to a rim by this part of it where the mouse is on the surface


class Mark(NamedTuple):
    """One mark: its pair's place in the list, -1 where it is begun, and number; its side and point."""

    index: int
    number: int
    side: str
    point: Point


@dataclass
class Picking:
    """The half of a pair that is picked so far, and the ring around what a click would grab.

    ``ring`` is (number of a region, (x, y) in it), or None. ``wanted`` is the name of the landmark that
    is asked for, or "", and ``skipped`` has those that are not.
    """

    side: str | None = None
    point: Point | None = None
    ring: tuple | None = None
    wanted: str = ""
    skipped: set = field(default_factory=set)

    def take(self, side, point):
        """Takes a click: {side: point} of the pair that it makes whole, or None. Again on a side it moves."""
        if self.side in (None, side):
            self.side, self.point = side, point
            return None
        pair = {self.side: self.point, side: point}
        self.drop()
        return pair

    def drop(self):
        """Forgets the half that was begun."""
        self.side = self.point = None


class View(NamedTuple):
    """A region of a 3D view: from the world to clip coordinates (4, 4), and its (width, height) in pixels."""

    matrix: np.ndarray
    size: tuple[int, int]

    def project(self, places):
        """(k, 2) pixels of (k, 3) places, not numbers behind the eye, and (k,) depths to weigh them by."""
        clip = np.c_[places, np.ones(len(places))] @ self.matrix.T
        depth = np.where(clip[:, 3] > 1e-9, clip[:, 3], np.nan)
        return (clip[:, :2] / depth[:, None] + 1) / 2 * self.size, depth

    def rays(self, spots):
        """(k, 3) origins, where the view begins, and (k, 3) unit directions of the rays at (k, 2) pixels."""
        flat = np.asarray(spots, dtype=np.float64) / self.size * 2 - 1
        ends = [
            np.c_[flat, np.full(len(flat), depth), np.ones(len(flat))] @ np.linalg.inv(self.matrix).T
            for depth in (-1.0, 1.0)
        ]
        near, far = (end[:, :3] / end[:, 3:] for end in ends)
        return near, (far - near) / np.linalg.norm(far - near, axis=1, keepdims=True)


def grabbed(spots, hidden, mouse):
    """Which of the marks within reach, at (k, 2), a click at the mouse takes, or None where there are none.

    The nearest, and one that is seen before those that are ``hidden`` (k,).
    """
    away = np.linalg.norm(np.reshape(spots, (-1, 2)) - mouse, axis=1)
    return min(range(len(away)), key=lambda number: (hidden[number], away[number]), default=None)


def near_edges(view, ends, mouse, reach):
    """The edges, ends (r, 2, 3) in the world, within ``reach`` of the mouse: [(edge, share)], nearest first.

    The share is how far along the edge its point is that is nearest on the screen.
    """
    pixels, depths = (part.reshape(len(ends), 2, -1) for part in view.project(np.reshape(ends, (-1, 3))))
    start, way = pixels[:, 0], pixels[:, 1] - pixels[:, 0]
    lengths = np.einsum("ex,ex->e", way, way)
    along = np.einsum("ex,ex->e", mouse - start, way) / np.where(lengths > 0, lengths, 1)
    along = np.clip(along, 0, 1)
    away = np.linalg.norm(start + along[:, None] * way - mouse, axis=1)
    near = np.flatnonzero(away <= reach)  # what is behind the eye is not a number
    # Halves on the screen are not halves in the world.
    toward = along[near] / depths[near, 1, 0]
    shares = toward / (toward + (1 - along[near]) / depths[near, 0, 0])
    order = np.argsort(away[near], kind="stable")
    return [(int(near[i]), float(shares[i])) for i in order]
