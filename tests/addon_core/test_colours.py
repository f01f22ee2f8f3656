"""Colours of a fit."""

from types import SimpleNamespace

import numpy as np
from lissom_addon_core.colours import BAD, DOUBTFUL, GOOD, UNMATCHED, WRONG, of_fit

TRIANGLES = np.array([[0, 1, 2], [2, 3, 4]])


def test_every_state_has_its_colour():
    fit = SimpleNamespace(
        distances=np.array([0, 0.05, 0.1, 7, np.nan]),
        image_distances=np.array([np.nan, 0.0]),
        flipped=[1],
        distortion=np.ones(2),
    )
    source, target = of_fit(fit, TRIANGLES, diagonal=10.0, limit=0.01)
    assert np.allclose(source[:2, :3], [GOOD, DOUBTFUL])
    assert np.allclose(source[2:, :3], WRONG)
    assert np.allclose(target[:, :3], [UNMATCHED, GOOD])
    assert (source[:, 3] == 1).all() and source.dtype == np.float32
    fit.flipped = np.zeros(0, int)
    source, _ = of_fit(fit, TRIANGLES, diagonal=10.0, limit=0.01)
    assert np.allclose(source[2:, :3], [BAD, BAD, UNMATCHED])
    fit.distortion[1] = 9.0
    source, _ = of_fit(fit, TRIANGLES, diagonal=10.0, limit=0.01)
    assert np.allclose(source[2:, :3], WRONG)
