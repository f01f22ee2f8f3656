"""Keys mirrored, split and summed: identities."""

import lissom
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lissom_addon_core import sides
from lissom_addon_core.work import Work
from numpy.testing import assert_allclose, assert_array_equal


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("eyeBlinkLeft", "eyeBlinkRight"),
        ("mouthLeft", "mouthRight"),
        ("browDown_L", "browDown_R"),
        ("Brow.r", "Brow.l"),
        ("left_brow", "right_brow"),
        ("LeftEye", "RightEye"),
        ("smile_L.001", "smile_R.001"),
        ("SMILE LEFT", "SMILE RIGHT"),
    ],
)
def test_names_change_sides_in_their_own_spelling(name, other):
    assert sides.swapped(name) == other
    assert sides.swapped(other) == name


@pytest.mark.parametrize(
    "name", ["jawOpen", "Bright", "upright", "pull", "browInnerUp", "mouthRollUpper", ""]
)
def test_names_without_a_side_have_no_other(name):
    assert sides.swapped(name) is None


def test_halves_are_spelled_as_the_key_is():
    assert sides.names_of_halves("browInnerUp") == ("browInnerUpLeft", "browInnerUpRight")
    assert sides.names_of_halves("brow_up") == ("brow_up_L", "brow_up_R")
    assert sides.names_of_halves("Brow Up") == ("Brow Up.L", "Brow Up.R")
    for name in ("browInnerUp", "brow_up", "Brow Up"):
        left, right = sides.names_of_halves(name)
        assert sides.swapped(left) == right


@given(st.integers(0, 1000), st.sampled_from([0, 1, 2]), st.sampled_from([0.0, 0.1, 2.0]))
def test_left_and_right_add_up_to_the_whole(seed, axis, width):
    random = np.random.default_rng(seed)
    vertices, offsets = random.normal(size=(2, 60, 3))
    vertices[:3, axis] = 0
    share = sides.left_share(vertices, axis, width)
    left, right = sides.split(offsets, share)
    whole = offsets.astype(np.float32)
    assert np.abs((left + right) - whole).max() <= np.finfo(np.float32).eps * np.abs(whole).max()
    flipped = vertices.copy()
    flipped[:, axis] *= -1
    assert_allclose(share + sides.left_share(flipped, axis, width), 1, atol=1e-12)
    assert_array_equal(left[vertices[:, axis] < -width / 2], 0)
    assert_array_equal(right[vertices[:, axis] > width / 2], 0)


def test_the_split_has_no_step():
    x = np.zeros((1001, 3))
    x[:, 0] = np.linspace(-1, 1, 1001)
    share = sides.left_share(x, 0, 0.5)
    assert np.all(np.diff(share) >= 0)
    assert np.abs(np.diff(share, 2)).max() < 1e-4, "its slope is continuous"


def symmetric(seed=0, around=24):
    """A bumpy dome that is its own mirror image about x = 0, in shuffled order."""
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, around + 1), np.linspace(-1, 1, around + 1)), -1).reshape(
        -1, 2
    )
    z = 1 - 0.4 * grid[:, 0] ** 2 + 0.1 * np.cos(5 * grid[:, 0]) * np.sin(3 * grid[:, 1])
    vertices = np.column_stack([grid, z])
    rows = np.arange((around + 1) ** 2).reshape(around + 1, around + 1)
    a, b, c, d = (part.ravel() for part in (rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]))
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    order = np.random.default_rng(seed).permutation(len(vertices))
    return vertices[order], np.argsort(order)[triangles]


def twins(vertices, triangles, axis=0):
    return Work(sides.twins_work(vertices, triangles, axis)).wait()


def test_mirrored_twice_is_the_key_itself():
    vertices, triangles = symmetric()
    found = twins(vertices, triangles)
    assert np.nanmax(found.away) < 1e-12
    offsets = np.random.default_rng(1).normal(size=vertices.shape)
    once = sides.mirrored(offsets, found, 0)
    assert_array_equal(sides.mirrored(once, found, 0), offsets)
    opposite = np.argmin(np.linalg.norm(vertices[:, None] * [-1, 1, 1] - vertices[None], axis=2), axis=1)
    assert_array_equal(once, offsets[opposite] * [-1, 1, 1])


def test_a_mesh_without_mirrored_vertices_mirrors_by_its_surface():
    vertices, triangles = symmetric()
    moved = vertices.copy()
    moved[:, 0] += 0.02 * np.sin(7 * vertices[:, 1])
    moved[:, 2] = 1 - 0.4 * moved[:, 0] ** 2 + 0.1 * np.cos(5 * moved[:, 0]) * np.sin(3 * moved[:, 1])
    found = twins(moved, triangles)
    assert 0 < np.nanmean(found.away) < 2e-3

    def smile(at):
        return np.exp(-8 * ((at[:, 0] - 0.5) ** 2 + at[:, 1] ** 2))[:, None] * [0.2, 0.1, 0.05]

    other = smile(moved * [-1, 1, 1]) * [-1, 1, 1]
    inside = np.abs(moved[:, 0]) < 0.9
    assert np.abs(sides.mirrored(smile(moved), found, 0) - other)[inside].max() < 0.03 * 0.2


def test_what_has_nothing_opposite_stays():
    vertices, triangles = symmetric()
    vertices[:, 0] += 5
    found = twins(
        np.concatenate([vertices, vertices * [-1, 1, 1]]),
        np.concatenate([triangles, triangles[:, ::-1] + len(vertices)]),
    )
    assert np.isfinite(found.away).all()
    with pytest.raises(lissom.InvalidConstraint):
        twins(vertices, triangles)


def test_a_sum_is_linear():
    random = np.random.default_rng(0)
    a, b = random.normal(size=(2, 3, 40, 3))
    weights = random.normal(size=3)
    assert_allclose(sides.total(a + 2 * b, weights), sides.total(a, weights) + 2 * sides.total(b, weights))
    assert_allclose(sides.total(a), a[0] + a[1] + a[2])
