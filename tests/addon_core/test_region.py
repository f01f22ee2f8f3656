"""Where a fit is off, in words."""

from types import SimpleNamespace

import numpy as np
import pytest
from lissom_addon_core.region import weakest, words

SIDE = 21
GRID = np.stack(np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE)), axis=-1).reshape(-1, 2)
PLANE = np.insert(GRID, 1, 0, axis=1)  # seen from the front: x and z
CORNER = np.arange(SIDE * (SIDE - 1)).reshape(-1, SIDE)[:, :-1].ravel()
FACES = np.concatenate([CORNER[:, None] + [0, 1, SIDE + 1], CORNER[:, None] + [0, SIDE + 1, SIDE]])


def fit_off_at(*spots):
    """A fit that is off around each (x, z, radius)."""
    off = [np.zeros(len(GRID), bool)]
    off += [np.linalg.norm(GRID - (x, z), axis=1) < radius for x, z, radius in spots]
    return SimpleNamespace(distances=np.where(np.any(off, axis=0), 0.3, 0.01))


@pytest.mark.parametrize("limit", [0.1, 0.2])
def test_the_largest_region_counts(limit):
    fit = fit_off_at((0.7, 0.7, 0.31), (-0.6, -0.6, 0.2))
    found = weakest(fit, FACES, limit)
    assert np.allclose(PLANE[found].mean(axis=0), [0.7, 0, 0.7], atol=0.06)
    fit.distances[found] = np.nan
    assert np.allclose(PLANE[weakest(fit, FACES, limit)].mean(axis=0), [-0.6, 0, -0.6], atol=0.06)
    assert weakest(fit_off_at(), FACES, limit) is None
    assert weakest(fit, FACES, 1.0) is None


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((0.9, 0, 0.9), "at the top left"),
        ((-0.9, 0, 0), "at the right"),
        ((0, 0, -0.8), "at the bottom"),
        ((0.1, 0, 0.1), "in the middle"),
    ],
)
def test_a_region_is_called_by_its_sides_or_by_a_marker(place, said):
    box = np.concatenate([PLANE, [[0, -1, 0], [0, 1, 0]]])
    assert words(np.array(place), box, [], []) == said
    corner = len(PLANE) - 1
    near = words(np.array(place), box, [corner, 0], ["left ear", "chin"])
    assert near == ("near 'left ear'" if said == "at the top left" else said)
