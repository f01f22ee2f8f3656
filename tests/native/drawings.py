"""Drawings as alpha, (h, w) with the top row first, from the distances of pixels to what is drawn."""

from itertools import pairwise

import numpy as np


def centres(width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) x and y of the pixels' centres, y up from the lower edge."""
    return np.meshgrid(np.arange(width) + 0.5, height - (np.arange(height) + 0.5))


def inked(distance: np.ndarray) -> np.ndarray:
    """Alpha of what has negative distance, smooth over the pixels at its edge."""
    return np.clip(0.5 - distance, 0.0, 1.0)


def disc(x, y, centre, radius):
    return np.hypot(x - centre[0], y - centre[1]) - radius


def stroke(x, y, points, width):
    """Distance to a pen's line of this width along points."""
    points = np.asarray(points, float)
    nearest = np.full(np.shape(x), np.inf)
    for a, b in pairwise(points):
        along = b - a
        part = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / (along @ along), 0, 1)
        nearest = np.minimum(nearest, np.hypot(x - a[0] - part * along[0], y - a[1] - part * along[1]))
    return nearest - width / 2


def ring(width=160, height=120, outer=50.0, inner=30.0):
    x, y = centres(width, height)
    middle = width / 2, height / 2
    return inked(np.maximum(disc(x, y, middle, outer), -disc(x, y, middle, inner)))


# Strokes in a square of side 1.
LETTERS = {
    "A": [[(0.1, 0.05), (0.5, 0.95), (0.9, 0.05)], [(0.28, 0.4), (0.72, 0.4)]],
    "E": [[(0.85, 0.1), (0.15, 0.1), (0.15, 0.9), (0.85, 0.9)], [(0.15, 0.5), (0.7, 0.5)]],
    "R": [[(0.15, 0.05), (0.15, 0.9), (0.7, 0.9), (0.8, 0.7), (0.7, 0.5), (0.15, 0.5)],
          [(0.5, 0.5), (0.85, 0.05)]],
    "S": [[(0.8, 0.8), (0.6, 0.92), (0.3, 0.85), (0.25, 0.65), (0.7, 0.4),
           (0.75, 0.2), (0.4, 0.08), (0.2, 0.2)]],
    "X": [[(0.1, 0.1), (0.9, 0.9)], [(0.1, 0.9), (0.9, 0.1)]],
}  # fmt: skip


def letter(name: str, size=90, pen=11.0):
    x, y = centres(size, size)
    strokes = [size * np.array(points) for points in LETTERS[name]]
    return inked(np.min([stroke(x, y, points, pen) for points in strokes], axis=0))


def islands(seed: int, width=150, height=110, count=9):
    """Discs, some of which overlap, lie in the holes of others or are cut by the border."""
    random = np.random.default_rng(seed)
    x, y = centres(width, height)
    distance = np.full(x.shape, np.inf)
    for _ in range(count):
        centre, radius = random.uniform((0, 0), (width, height)), random.uniform(4, 28)
        one = disc(x, y, centre, radius)
        if random.random() < 0.5:
            one = np.maximum(one, -disc(x, y, centre, 0.6 * radius))
        distance = np.minimum(distance, one)
    return inked(distance)


def noise(seed: int, width=60, height=45):
    return np.random.default_rng(seed).random((height, width))


def lines(seed: int, size=64, count=5):
    """Lines a pixel wide as a pencil without smoothing leaves them."""
    random = np.random.default_rng(seed)
    alpha = np.zeros((size, size))
    for _ in range(count):
        a, b = random.integers(0, size, (2, 2))
        steps = np.abs(b - a).max() + 1
        along = np.rint(np.linspace(a, b, steps)).astype(int)
        alpha[along[:, 1], along[:, 0]] = 1.0
    return alpha
