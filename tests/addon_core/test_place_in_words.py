"""Regions of a mesh, and their words."""

import numpy as np
import pytest
from lissom_addon_core.place_in_words import largest_piece, words

SIDE = 21
GRID = np.stack(np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE)), axis=-1).reshape(-1, 2)
PLANE = np.insert(GRID, 1, 0, axis=1)  # seen from the front: x and z
CORNER = np.arange(SIDE * (SIDE - 1)).reshape(-1, SIDE)[:, :-1].ravel()
FACES = np.concatenate([CORNER[:, None] + [0, 1, SIDE + 1], CORNER[:, None] + [0, SIDE + 1, SIDE]])


def around(x, z, radius):
    """The faces whose corners all lie around a place."""
    near = np.linalg.norm(GRID - (x, z), axis=1) < radius
    return FACES[near[FACES].all(axis=1)]


def test_the_largest_piece_counts():
    both = np.concatenate([around(-0.6, -0.6, 0.2), around(0.7, 0.7, 0.31)])
    found = largest_piece(both, len(GRID))
    assert np.allclose(PLANE[found].mean(axis=0), [0.7, 0, 0.7], atol=0.06)
    assert set(found) == set(around(0.7, 0.7, 0.31).ravel())
    assert largest_piece(FACES[:0], len(GRID)) is None


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
