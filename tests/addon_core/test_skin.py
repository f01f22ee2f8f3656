"""The way back through a skin: exact for affine maps of each vertex, still where nothing can be inverted."""

import numpy as np
import pytest
from lissom_addon_core.skin import Skin


def skinned(random, count, flat=()):
    """A rest shape, and the look of shapes by random maps and shifts of each vertex."""
    rest, shift = random.normal(size=(2, count, 3))
    maps = np.eye(3) + 0.5 * random.normal(size=(count, 3, 3))
    maps[list(flat), :, 2] = maps[list(flat), :, 1]
    return rest, maps, lambda shape: np.einsum("nij,nj->ni", maps, shape) + shift


@pytest.mark.parametrize("step", [1e-3, 1.0, 1e3])
def test_the_key_is_shown_as_posed(step):
    random = np.random.default_rng(3)
    rest, maps, look = skinned(random, 500)
    skin = Skin.of(rest, look, step)
    np.testing.assert_allclose(skin.maps, maps, atol=1e-9 * max(step, 1 / step) ** 0.5)
    posed = random.normal(size=rest.shape)
    kept = np.setdiff1d(np.arange(500), skin.flat)
    np.testing.assert_allclose(look(skin.key(posed))[kept], posed[kept], atol=1e-6)
    assert len(kept) > 480


def test_what_is_collapsed_is_told_and_rests():
    random = np.random.default_rng(4)
    rest, _, look = skinned(random, 50, flat=(3, 17))
    skin = Skin.of(rest, look, 1.0)
    assert {3, 17} <= set(skin.flat.tolist())
    key = skin.key(random.normal(size=rest.shape))
    assert np.isfinite(key).all() and np.array_equal(key[[3, 17]], rest[[3, 17]])


def test_no_motion_is_exactly_the_rest_shape_and_no_skin_is_trivial():
    random = np.random.default_rng(5)
    rest, _, look = skinned(random, 50)
    skin = Skin.of(rest, look, 1.0)
    assert np.array_equal(skin.key(skin.shown), rest)
    assert not skin.is_trivial(1e-6)
    assert Skin.of(rest, lambda shape: shape.copy(), 1.0).is_trivial(1e-6)
    assert not Skin.of(rest, lambda shape: shape + 0.01, 1.0).is_trivial(1e-6)
