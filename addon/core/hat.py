"""Hat functions: the piecewise linear basis on a list of knots.

The i-th hat is 1 at knot i, 0 at every other knot and linear between; beyond the first and the last knot
it keeps its value. At any t the hats add up to 1, so keys weighted by them play a polygon through the keys.
"""

import numpy as np


def uniform_knots(count):
    """Knots of ``count`` in-betweens and both ends, (count + 2,): 0, 1/(count+1), ..., 1."""
    return np.linspace(0.0, 1.0, count + 2)


def points(knots, index):
    """The corners of hat ``index`` as (time, value) pairs: at most three, in rising time."""
    return [
        (float(knots[i]), 1.0 if i == index else 0.0)
        for i in range(max(index - 1, 0), min(index + 2, len(knots)))
    ]


def weights(knots, times):
    """The values of all hats, (t,) times -> (t, k); each row adds up to 1."""
    knots = np.asarray(knots, dtype=np.float64)
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    return np.stack([np.interp(times, knots, row) for row in np.eye(len(knots))], axis=1)
