"""Framing: what a view has to look at to show an object where nothing covers the view."""

import numpy as np

MARGIN = 1.15  # so much wider than what is shown


def free_span(width, covering):
    """(low, high): the pixels across a view that no region at either edge, (low, high) too, covers."""
    low, high = 0, width
    for start, end in covering:
        if start + end > width:
            high = min(high, start)
        else:
            low = max(low, end)
    return (low, high) if low < high else (0, width)


def framed(points, turn, size, free, pixel, perspective=True):
    """(location (3,), distance) of a view that shows points (k, 3) within the free span, as near as it can.

    ``turn`` (3, 3) has the view's right, up and backward directions as columns, ``size`` the view's
    (width, height) in pixels, and ``pixel`` is how wide one is at a distance of 1. In perspective what is
    nearer looks larger, and may be seen outside of what holds it at its middle.
    """
    *flat, depth = (np.asarray(points) @ turn).T
    middle = (depth.min() + depth.max()) / 2
    if not perspective:
        depth = np.full_like(depth, middle)
    bounds = []
    for along, whole, (low, high) in zip(flat, size, (free, (0, size[1])), strict=True):
        centre, half = (low + high) / 2 - whole / 2, (high - low) / 2 / MARGIN
        left, right = pixel * (half - centre), pixel * (half + centre)
        # An eye at (place, height) sees a point where -left <= (along - place) / (height - depth) <= right.
        bounds.append((left, right, (left * depth - along).max(), (right * depth + along).max()))
    eye = max((least + most) / (left + right) for left, right, least, most in bounds)
    place = [(left * eye - least + most - right * eye) / 2 for left, right, least, most in bounds]
    return turn @ (*place, middle), eye - middle


def upright(towards):
    """(3, 3): right, up and backward of a view that looks ``towards`` (3,) a way and stands upright."""
    back = -np.asarray(towards, dtype=float) / np.linalg.norm(towards)
    right = np.cross((0.0, 0.0, 1.0), back)
    if np.linalg.norm(right) < 1e-3:  # from above or below: as Blender's own views
        right = np.array([1.0, 0.0, 0.0])
    right = right - back * (right @ back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back])
