"""Scale of a transfer: motions that grow with the target, and motions that keep their own size."""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square
from shapes import moved, rigid, tube

VERTICES, FACES = tube(rows=48, columns=32, bumps=0.1)
NONE = np.zeros((0, 2), int)


def bump(vertices, size=0.2):
    """A smooth motion of one end; the other half rests."""
    along = np.clip(vertices[:, :1] - 3, 0, None) ** 2 / 9
    return vertices + size * along * np.sin(2 * vertices[:, [1, 2, 0]] + 1)


def extent(points):
    """Root mean square distance from the centre."""
    return root_mean_square(points - points.mean(0))


def carried(target, key, source=VERTICES, faces=FACES, pairs=False, **options):
    ends = lissom.Mesh(source, FACES), lissom.Mesh(target, faces)
    fit = lissom.fit_correspondence(*ends, NONE)
    return (
        lissom.Transfer(*ends, fit.pairs if pairs else fit, **options).apply(key[None]).vertices[0] - target
    )


@pytest.mark.parametrize("size", [0.5, 2.0, 30.0])
@pytest.mark.parametrize("pairs", [False, True])
def test_a_motion_keeps_its_own_size(size, pairs):
    target = size * VERTICES + [3, 1, 2]
    own = bump(VERTICES) - VERTICES
    with_target = carried(target, bump(VERTICES), pairs=pairs)
    with_source = carried(target, bump(VERTICES), pairs=pairs, scale="source")
    assert np.abs(with_target - size * own).max() < 1e-6 * size
    assert np.abs(with_source - own).max() < 1e-6
    assert not with_source[VERTICES[:, 0] < 2.8].any()


@pytest.mark.parametrize("size", [0.5, 1.0, 3.0])
def test_as_a_whole_it_turns_as_the_source_and_goes_and_grows_as_far(size):
    target = size * VERTICES
    turn = rigid((1, 2, 3), 1.5, (0.7, -0.2, 0.4))
    turned = carried(target, moved(turn, VERTICES), scale="source")
    edges = target[1:] - target[0]
    assert np.allclose(turned[1:] - turned[0] + edges, edges @ turn[:3, :3].T, atol=1e-7 * size)
    # The centre goes where that of the source does.
    way = (moved(turn, VERTICES) - VERTICES).mean(0)
    assert np.allclose(turned.mean(0), way, atol=1e-3 * diagonal(VERTICES))
    grown = carried(target, VERTICES * 1.1, scale="source")
    assert np.allclose(grown - grown.mean(0), 0.1 * (VERTICES - VERTICES.mean(0)), atol=1e-6)


def test_on_a_target_of_the_same_size_both_are_the_same():
    bent = VERTICES + 0.3 * np.sin(VERTICES[:, [2, 0, 1]])  # another shape
    target = bent * extent(VERTICES) / extent(bent)
    for key in (bump(VERTICES), moved(rigid((0, 1, 1), 0.8), VERTICES * 1.2)):
        one, other = (carried(target, key, scale=scale) for scale in ("target", "source"))
        assert np.abs(one - other).max() < 1e-9


def test_other_triangles_move_as_far():
    vertices, faces = tube(rows=65, columns=24, bumps=0.1)
    target = 2.5 * vertices
    source = lissom.Mesh(VERTICES, FACES), lissom.Mesh(target, faces)
    place = [(r, k / 8) for r in (0, 1) for k in range(8)]
    sizes = (48, 32), (65, 24)
    pairs = [[int(r * (n - 1)) * m + int(a * m) for r, a in place] for n, m in sizes]
    fit = lissom.fit_correspondence(*source, np.transpose(pairs))
    result = lissom.Transfer(*source, fit, scale="source").apply(bump(VERTICES)[None]).vertices[0] - target
    expected = bump(vertices) - vertices
    assert root_mean_square(result - expected) < 0.1 * root_mean_square(expected)
    furthest = [np.linalg.norm(d, axis=1).max() for d in (result, expected)]
    assert 0.9 < furthest[0] / furthest[1] < 1.1


def test_row_31_a_key_that_moves_nothing_moves_nothing():
    assert not carried(2 * VERTICES, VERTICES, scale="source").any()
