"""Framing: what a view has to look at to show an object where nothing covers the view."""

import numpy as np

MARGIN = 1.15  # so much wider than the object


def free_span(width, covering):
    """(low, high): the pixels across a view that no region at either edge, (low, high) too, covers."""
    low, high = 0, width
    for start, end in covering:
        if start + end > width:
            high = min(high, start)
        else:
            low = max(low, end)
    return (low, high) if low < high else (0, width)


def framed(corners, turn, size, free, pixel):
    """(location (3,), factor of the distance) that show a box of corners (k, 3) within the free span.

    ``turn`` (3, 3) has the view's right, up and backward directions as columns, ``size`` the view's
    (width, height) in pixels, and ``pixel`` is how wide one is at the present distance.
    """
    flat = np.asarray(corners) @ turn
    low, high = flat.min(axis=0), flat.max(axis=0)
    room = free[1] - free[0], size[1]
    factor = MARGIN * max(np.divide((high - low)[:2], room)) / pixel
    aside = (sum(free) - size[0]) / 2 * pixel * factor
    return turn @ ((low + high) / 2 - (aside, 0, 0)), factor


def upright(towards):
    """(3, 3): right, up and backward of a view that looks ``towards`` (3,) a way and stands upright."""
    back = -np.asarray(towards, dtype=float) / np.linalg.norm(towards)
    right = np.cross((0.0, 0.0, 1.0), back)
    if np.linalg.norm(right) < 1e-3:  # from above or below: as Blender's own views
        right = np.array([1.0, 0.0, 0.0])
    right = right - back * (right @ back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back])
