"""What was edited of a key, and the same change on another surface."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lissom_addon_core import corrections
from numpy.testing import assert_allclose, assert_array_equal

SEEDS = st.integers(0, 2**32 - 1)


def sheet(size=6):
    """A grid of triangles in the plane, and its vertices."""
    across = np.arange(size)
    vertices = np.stack([*np.meshgrid(across, across), np.zeros((size, size))], axis=-1).reshape(-1, 3)
    corner = np.arange(size * size).reshape(size, size)
    a, b, c, d = (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1])
    quads = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
    return vertices.astype(float), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def rotation(random):
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return turn * np.linalg.det(turn)


@given(SEEDS)
def test_packed_offsets_come_back(seed):
    random = np.random.default_rng(seed)
    offsets = random.normal(size=(50, 3)).astype(np.float32) * (random.random((50, 1)) < 0.3)
    assert_array_equal(corrections.unpack(corrections.pack(offsets)), offsets)


@given(SEEDS)
def test_rounding_is_no_edit_and_a_hundred_thousandth_is(seed):
    """A key is stored in single precision, and moved along with its Basis."""
    random = np.random.default_rng(seed)
    largest = 10.0 ** random.integers(-3, 4)
    basis = (random.uniform(-1, 1, (80, 3)) * largest).astype(np.float32)
    key = (basis + random.normal(size=(80, 3)) * largest / 50).astype(np.float32)
    written = key.astype(float) - basis
    moved = (random.uniform(-0.5, 0.5, (80, 3)) * largest).astype(np.float32)
    largest_after = np.abs(key + moved).max()
    again = (key + moved).astype(float) - (basis + moved).astype(float)
    assert not corrections.differs(again, written, largest_after)
    again[random.integers(80)] += 1e-5 * largest
    assert corrections.differs(again, written, largest)


@given(SEEDS)
def test_a_key_is_known_again_by_its_shape(seed):
    random = np.random.default_rng(seed)
    written = random.normal(size=(80, 3))
    assert corrections.alike(written, written) == 0
    assert corrections.alike(written + 0.1 * random.normal(size=(80, 3)), written) < 0.2
    assert corrections.alike(np.zeros((80, 3)), written) is None
    assert corrections.alike(random.normal(size=(80, 3)), written) is None
    assert corrections.alike(written, np.zeros((80, 3))) is None


@given(SEEDS)
def test_a_correction_turns_with_a_surface_that_turns(seed):
    random = np.random.default_rng(seed)
    vertices, triangles = sheet()
    vertices[:, 2] = 0.3 * random.normal(size=len(vertices))
    correction = random.normal(size=vertices.shape) * (random.random((len(vertices), 1)) < 0.4)
    turn = rotation(random)
    after = vertices @ turn.T + random.normal(size=3)
    found = corrections.turned(correction, vertices, after, triangles)
    assert_allclose(found, correction @ turn.T, atol=1e-12)
    assert_array_equal(found[~correction.any(axis=1)], 0)


def test_where_the_surface_is_flat_or_nothing_changed_it_stays_a_rotation():
    vertices, triangles = sheet()
    correction = np.ones_like(vertices)
    assert_allclose(corrections.turned(correction, vertices, vertices, triangles), correction, atol=1e-12)
    collapsed = corrections.turned(correction, vertices, np.zeros_like(vertices), triangles)
    assert_allclose(np.linalg.norm(collapsed, axis=1), np.sqrt(3))


@pytest.mark.parametrize("triangles", [np.zeros((0, 3), dtype=int), np.array([[0, 1, 2]])])
def test_vertices_of_no_face_keep_their_correction_as_it_is(triangles):
    correction = np.ones((4, 3))
    shape = np.eye(4, 3)
    assert_allclose(corrections.turned(correction, shape, shape, triangles)[3], 1.0)
