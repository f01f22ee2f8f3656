"""Hat functions: the piecewise linear basis on a list of knots.

The i-th hat is 1 at knot i, 0 at every other knot and linear between; beyond the first and the last knot
it keeps its value. At any t the hats add up to 1, so keys weighted by them play a polygon through the keys.
"""

import numpy as np

from .easing import bezier

NEAREST = 1e-4  # what Blender's curves and the names of keys can tell apart, several times over


def uniform_knots(count):
    """Knots of ``count`` in-betweens and both ends, (count + 2,): 0, 1/(count+1), ..., 1."""
    return np.linspace(0.0, 1.0, count + 2)


def spread(knots, fixed):
    """``fixed``, 0, 1, and of ``knots`` those farther than ``NEAREST`` from all before; in rising order."""
    kept = np.union1d(fixed, [0.0, 1.0])
    for knot in knots:
        if np.abs(kept - knot).min() > NEAREST:
            kept = np.append(kept, knot)
    return np.sort(kept)


def beyond(knots, shapes, least, most):
    """Knots and shapes with one more before 0 and behind 1, where ``least`` and ``most`` reach so far.

    The path goes on there as straight as it left.
    """
    knots, shapes = list(knots), list(shapes)
    if least < -NEAREST:
        shapes.insert(0, shapes[0] + (shapes[1] - shapes[0]) * least / knots[1])
        knots.insert(0, least)
    if most > 1 + NEAREST:
        shapes.append(shapes[-1] + (shapes[-1] - shapes[-2]) * (most - 1) / (1 - knots[-2]))
        knots.append(most)
    return np.array(knots), shapes


def corners(knots, index, easing):
    """Hat ``index`` of an eased slider t, h_i(e(t)), as corners of a Bezier curve: at most three."""
    around = np.arange(max(index - 1, 0), min(index + 2, len(knots)))
    near = np.asarray(knots, dtype=np.float64)[around]
    inside = np.clip(near, 0.0, 1.0)
    times = np.where(near == inside, easing.inverse(inside), near)
    values = (around == index) * 1.0
    slopes = np.diff(values) / np.diff(near)  # of the hat itself, piece by piece
    eased = easing.slope(np.clip(times, 0.0, 1.0))
    past = (near[:-1] < 0) | (near[1:] > 1)  # pieces on which the arc runs as the slider does
    starts, ends = (slopes * np.where(past, 1.0, at) for at in (eased[:-1], eased[1:]))
    return bezier(times, values, np.append(starts[:1], ends), np.append(starts, ends[-1:]))


def weights(knots, times):
    """The values of all hats, (t,) times -> (t, k); each row adds up to 1."""
    knots = np.asarray(knots, dtype=np.float64)
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    return np.stack([np.interp(times, knots, row) for row in np.eye(len(knots))], axis=1)
