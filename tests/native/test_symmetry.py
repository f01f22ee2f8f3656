"""A source and a target that are the same left and right: so are the keys."""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square
from shapes import grid_faces, tube

MIRROR = np.array([-1, 1, 1])


class Head:
    """Rings around z, bumpy but the same on both sides of x = 0; open at the top and at the neck."""

    def __init__(self, rings, around, seed, mirrored=True):
        down, turn = np.meshgrid(np.linspace(0.15, 0.85, rings), np.arange(around) / around, indexing="ij")
        self.rings, self.around = rings, around
        down, turn = np.pi * down.ravel(), 2 * np.pi * turn.ravel()
        ball = np.stack([np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down)], axis=1)
        random = np.random.default_rng(seed)
        places, heights = random.normal(size=(12, 3)), random.uniform(-0.15, 0.25, 12)
        places[0], heights[0] = [0, 1, 0], 0.5  # the nose, which tells front from back
        self.rest = ball * (1 + bumps(ball, places, heights) + bumps(ball * MIRROR, places, heights))[:, None]
        row, column = np.divmod(np.arange(rings * around), around)
        self.twin = row * around + (around // 2 - column) % around
        self.rest = (self.rest + self.rest[self.twin] * MIRROR) / 2  # to the last bit
        self.faces = grid_faces(rings, around, closed=True)[:, ::-1]
        if mirrored:  # one diagonal of each quad on this side, its mirror image on the other
            half = self.faces[self.rest[self.faces].mean(axis=1)[:, 0] > 0]
            self.faces = np.concatenate([half, self.twin[half][:, ::-1]])

    def marked(self, count=8):
        ring = np.linspace(0, self.rings - 1, 5).astype(int)
        return (ring[:, None] * self.around + np.arange(count) * self.around // count).ravel()

    def crooked(self, left, right):
        """How far the key of one side is from the mirror image of that of the other, of the diagonal."""
        off = (left - self.rest)[self.twin] * MIRROR - (right - self.rest)
        return np.abs(off).max() / diagonal(self.rest)


def bumps(points, places, heights):
    places = places / np.linalg.norm(places, axis=1, keepdims=True)
    return (heights * np.exp(-6 * ((points[:, None] - places) ** 2).sum(-1))).sum(1)


def keys_of(head, seed):
    """(4, n, 3): keys of the left, their mirror images, and one of both sides."""
    random = np.random.default_rng(seed)
    places = np.array([[0.7, 0.6, 0.2], [0.3, 0.9, -0.4]]) + random.normal(size=(2, 3)) * 0.1
    ways = random.normal(size=(2, 1, 3)) * 0.2
    left = np.stack([bumps(head.rest, place[None], np.ones(1)) for place in places])[..., None] * ways
    right = left[:, head.twin] * MIRROR
    return head.rest + np.concatenate([left, right, left[:1] + right[:1]])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0, 0.01])
def test_left_and_right_are_mirror_images(seed, noise):
    source, target = Head(25, 48, seed), Head(33, 64, seed + 100)
    markers = np.column_stack([source.marked(), target.marked()])
    random = np.random.default_rng(seed)
    points = target.rest[markers[:, 1]]
    points = points + random.normal(size=points.shape) * noise * diagonal(target.rest) / np.sqrt(3)
    ends = lissom.Mesh(source.rest, source.faces), lissom.Mesh(target.rest, target.faces)
    fit = lissom.fit_correspondence(*ends, markers, points if noise else None)
    poses = keys_of(source, seed)
    for options in ({}, {"frames": "local"}, {"scale": "source"}, {"weighting": "pairs"}):
        found = lissom.Transfer(*ends, fit, **options).apply(poses).vertices
        assert root_mean_square(found - target.rest) > 0.005
        crooked = [
            target.crooked(*found[[0, 2]]),
            target.crooked(*found[[1, 3]]),
            target.crooked(*found[[4, 4]]),
        ]
        assert max(crooked) < 1e-6, (options, crooked)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("which", ["source", "target"])
def test_with_quads_that_are_cut_otherwise_nearly(seed, which):
    source = Head(25, 48, seed, mirrored=which != "source")
    target = Head(33, 64, seed + 100, mirrored=which != "target")
    ends = lissom.Mesh(source.rest, source.faces), lissom.Mesh(target.rest, target.faces)
    fit = lissom.fit_correspondence(*ends, np.column_stack([source.marked(), target.marked()]))
    found = lissom.Transfer(*ends, fit).apply(keys_of(source, seed)).vertices
    crooked = max(target.crooked(*found[[k, k + 2]]) for k in (0, 1))
    print(f"{which} cut otherwise: {crooked:.1e}")
    # The cut of the source's quads does not count, since keys are read at its vertices; the target's does.
    assert crooked < (1e-6 if which == "source" else 5e-4)


def test_a_mesh_of_many_planes_is_not_mirrored_against_its_markers():
    vertices, faces = tube(rows=40, columns=32, bumps=0)
    finer, others = tube(rows=49, columns=48, bumps=0)
    # Marked with an eighth of a turn: the planes of both are not each other's.
    rows = [(r, k) for r in (0, 0.25, 0.5, 0.75, 1) for k in range(8)]
    markers = [[int(r * 39) * 32 + 4 * k, int(r * 48) * 48 + 6 * ((k + 1) % 8)] for r, k in rows]
    ends = lissom.Mesh(vertices, faces), lissom.Mesh(finer, others)
    fit = lissom.fit_correspondence(*ends, markers)
    at = lambda points, angle: np.exp(  # noqa: E731
        -6 * ((points - [3, np.cos(angle), np.sin(angle)]) ** 2).sum(1)
    )
    pose = vertices + 0.3 * at(vertices, 0)[:, None] * [1, 0, 0]
    moved = (lissom.Transfer(*ends, fit).apply([pose]).vertices[0] - finer)[:, 0]
    assert moved[np.argmax(at(finer, np.pi / 4))] > 0.25
    assert abs(moved[np.argmax(at(finer, -np.pi / 4))]) < 0.05
