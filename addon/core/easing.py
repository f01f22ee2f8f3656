"""Easings: how a slider runs through a path, as polynomials of degree 3 at most.

A cubic Bezier whose handles lie at thirds of its span is a cubic polynomial of time, so Blender's own curves
hold these exactly, on the whole of [0, 1] and on every part of it.
"""

from typing import NamedTuple

import numpy as np


class Easing(NamedTuple):
    """``coefficients`` of 1, t, t^2, t^3; ``inverse`` gives the t of a value. Both map [0, 1] onto itself.

    Beyond 0 and 1 the arc runs as the slider does.
    """

    label: str
    line: str
    coefficients: tuple
    inverse: object

    def value(self, times):
        """e(t)."""
        eased = np.polynomial.polynomial.polyval(times, self.coefficients)
        return np.where(np.abs(np.subtract(times, 0.5)) <= 0.5, eased, times)

    def slope(self, times):
        """e'(t)."""
        return np.polynomial.polynomial.polyval(times, np.polynomial.polynomial.polyder(self.coefficients))


EASINGS = {  # a file stores the place in this table: only append
    "LINEAR": Easing("Linear", "The arc runs as the slider does", (0, 1), lambda u: u),
    "SMOOTH": Easing(
        "Smooth",
        "The arc starts and ends slowly",
        (0, 0, 3, -2),
        lambda u: np.where(u <= 0, 0.0, np.where(u >= 1, 1.0, 0.5 + np.sin(np.arcsin(2 * u - 1) / 3))),
    ),
    "IN": Easing("Ease In", "The arc starts slowly", (0, 0, 1), lambda u: np.sqrt(u)),
    "OUT": Easing("Ease Out", "The arc ends slowly", (0, 2, -1), lambda u: 1 - np.sqrt(1 - u)),
}


class Corner(NamedTuple):
    """One point of a curve, (time, value) each: the point itself and its two Bezier handles."""

    point: tuple
    left: tuple
    right: tuple


def bezier(times, values, slopes_left, slopes_right):
    """The curve through ``values`` at ``times``, (k,) each, as corners; slopes are d value / d time.

    ``slopes_left[i]`` is that of the piece which ends at i, ``slopes_right[i]`` of the one that starts there.
    """
    thirds = np.diff(times) / 3
    before = np.append(thirds[:1], thirds)
    after = np.append(thirds, thirds[-1:])
    rows = zip(times, values, slopes_left, slopes_right, before, after, strict=True)
    return [
        Corner((float(t), float(v)), (float(t - b), float(v - b * m)), (float(t + a), float(v + a * n)))
        for t, v, m, n, b, a in rows
    ]
