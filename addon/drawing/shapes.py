"""Flat shapes in pixels of a view; blending is the caller's."""

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

_TURN = np.linspace(0, 2 * np.pi, 25)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN), 0 * _TURN], axis=1)


def ring(spot, inner, outer, rgba):
    """What lies between two circles; a disc where the inner one has no radius."""
    circles = [np.array([*spot, 0.0]) + radius * _CIRCLE for radius in (inner, outer)]
    _draw("TRI_STRIP", np.stack(circles, axis=1).reshape(-1, 3), rgba)


def line(spots, rgba):
    """A path through (k, 2) spots."""
    _draw("LINE_STRIP", np.c_[spots, np.zeros(len(spots))], rgba)


def box(low, high, rgba):
    """A filled rectangle."""
    (left, bottom), (right, top) = low, high
    corners = [(left, bottom, 0), (right, bottom, 0), (left, top, 0), (right, top, 0)]
    _draw("TRI_STRIP", np.array(corners, dtype=float), rgba)


def _draw(kind, spots, rgba):
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, kind, {"pos": spots.astype(np.float32)})
    shader.uniform_float("color", rgba)
    batch.draw(shader)
