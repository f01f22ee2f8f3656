"""Attributes: weights, colours and UV maps carried over through the images of a fit."""

import lissom
import numpy as np
import pytest
from dense import neighbours
from shapes import tube

ROWS, COLUMNS = 41, 32
CUT, HALF = 5 / 32, 0.45  # where the map of the tube has its seams
VERTICES, FACES = tube(rows=ROWS, columns=COLUMNS)
VALUES = np.column_stack([np.sin(3 * VERTICES), np.ones(len(VERTICES)), VERTICES[:, 0]])
NONE = np.zeros((0, 2), int)


def unrolled():
    """(m, 3, 2): a UV map of the tube, cut along one line, and around it, where it is shifted."""
    row, column = FACES // COLUMNS, (FACES % COLUMNS - round(CUT * COLUMNS)) % COLUMNS
    last = np.ptp(column, axis=1, keepdims=True) > 1
    across = np.where(last & (column == 0), COLUMNS, column) / COLUMNS
    along = row / (ROWS - 1)
    return np.stack([across, along + 3 * (along.max(1, keepdims=True) > HALF + 1e-9)], axis=2)


def transfer(rows=ROWS, columns=COLUMNS, vertices=None, faces=None, **masks):
    """From the tube onto another; where that has the same faces, without markers."""
    made = tube(rows=rows, columns=columns) if vertices is None else (vertices, faces)
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(*made)
    pairs = NONE
    if len(made[1]) != len(FACES):
        place = [(r, k / 8) for r in (0, 0.25, 0.5, 0.75, 1) for k in range(8)]
        sizes = (ROWS, COLUMNS), (rows, columns)
        pairs = np.transpose([[int(r * (n - 1)) * m + int(a * m) for r, a in place] for n, m in sizes])
    fit = lissom.fit_correspondence(source, target, pairs, **masks)
    return lissom.Transfer(source, target, fit), fit


def test_a_mesh_gives_itself_its_own_values():
    there, _ = transfer()
    assert np.array_equal(there.attributes(VALUES), VALUES)
    uv = unrolled()
    assert np.array_equal(there.corner_attributes(uv), uv)
    assert there.attributes(VALUES[:, :0]).shape == (len(VERTICES), 0)
    job = there.start_attributes(VALUES[:, :1])
    assert np.array_equal(job.result(), VALUES[:, :1]) and job.done


def test_other_triangles_take_what_is_where_they_lie():
    there, fit = transfer(rows=57, columns=48)
    by_hand = np.einsum("nk,nkc->nc", fit.image_weights, VALUES[FACES[fit.image_triangles]])
    found = there.attributes(VALUES)
    assert (fit.image_triangles >= 0).all() and np.allclose(found, by_hand, atol=1e-14)
    assert (found[:, 3] == 1).all(), "to the last bit"
    assert (found.min(0) >= VALUES.min(0)).all() and (found.max(0) <= VALUES.max(0)).all()
    assert np.abs(found[:, 4] - tube(rows=57, columns=48)[0][:, 0]).max() < 0.05


def test_what_lies_nowhere_is_the_mean_of_what_is_around_it():
    vertices, faces = tube(rows=57, columns=48)
    masked = np.flatnonzero((vertices[:, 0] > 2) & (vertices[:, 1] > 0) & (vertices[:, 0] < 4))
    there, fit = transfer(rows=57, columns=48, target_mask=masked)
    assert (fit.image_triangles[masked] < 0).all()
    found = there.attributes(VALUES)
    rings = neighbours(faces, len(vertices))
    free = np.flatnonzero(fit.image_triangles < 0)
    dense = np.eye(len(vertices))
    for v in free:
        dense[v] = 0
        dense[v, v], dense[v, rings[v]] = len(rings[v]), -1
    given = found.copy()
    given[free] = 0
    assert np.allclose(found, np.linalg.solve(dense, given), atol=1e-9)
    assert (found[:, 3] == 1).all()


def test_row_30_a_part_that_nothing_matches_takes_from_the_nearest():
    ball, sides = tube(rows=4, columns=6, length=0.2)
    vertices = np.concatenate([VERTICES, 0.1 * ball + [3, 0, 1.5]])
    faces = np.concatenate([FACES, sides + len(VERTICES)])
    part = np.arange(len(VERTICES), len(vertices))
    source, target = lissom.Mesh(VERTICES, FACES), lissom.Mesh(vertices, faces)
    marked = np.arange(0, len(VERTICES), 20)
    fit = lissom.fit_correspondence(source, target, np.column_stack([marked] * 2), target_mask=part)
    there = lissom.Transfer(source, target, fit)
    found = there.attributes(VALUES)
    distance = np.linalg.norm(vertices[part][:, None] - VERTICES, axis=2)
    assert np.array_equal(found[part], found[distance.argmin(1)])
    corners = there.corner_attributes(unrolled())
    assert np.isfinite(corners).all()


@pytest.mark.parametrize(("rows", "columns"), [(57, 48), (21, 24), (81, 96)])
def test_no_triangle_spans_a_seam(rows, columns):
    vertices, faces = tube(rows=rows, columns=columns)
    there, _ = transfer(rows=rows, columns=columns)
    uv = unrolled()
    found = there.corner_attributes(uv)
    low, high = found.min(1), found.max(1)
    # A triangle is as large in the map as on the tube, and shorter at a seam; over one it would be larger.
    angle = 1.5 * np.array([1 / columns, 1 / (rows - 1)]) + 0.01
    assert (high - low <= angle).all()
    assert uv.min() <= found.min() and found.max() <= uv.max()
    # What is not at a seam is where it lies.
    turn = np.arctan2(vertices[:, 2], vertices[:, 1]) / (2 * np.pi)
    at = np.column_stack([(turn - CUT) % 1, vertices[:, 0] / 6])[faces]
    near = 1.5 / np.array([columns, rows - 1])
    away = (at[..., 1].max(1) < HALF - near[1]) | (at[..., 1].min(1) > HALF + near[1])
    inside = away & (at[..., 0].min(1) > near[0]) & (at[..., 0].max(1) < 1 - near[0])
    assert inside.mean() > 0.6
    expected = at + np.where(at[:, :, 1:].mean(1, keepdims=True) > HALF, [0, 3], 0)
    assert np.abs(found - expected)[inside].max() < 0.01


def test_the_triangles_of_a_face_take_one_side():
    rows, columns = 29, 24
    faces = len(tube(rows=rows, columns=columns)[1])
    quads = np.arange(faces) % (faces // 2)
    there, _ = transfer(rows=rows, columns=columns)
    uv = unrolled()
    found = there.corner_attributes(uv, quads)
    first, second = found[: faces // 2], found[faces // 2 :]
    # Both triangles of a quad have two corners in common: its first, and that across.
    assert np.array_equal(first[:, [0, 2]], second[:, [0, 1]])
    both = np.concatenate([first, second], axis=1)
    assert (np.ptp(both, axis=1) <= 1.5 * np.array([1 / columns, 1 / (rows - 1)]) + 0.01).all()


def test_corners_of_flat_colours_are_flat():
    colours = np.repeat(np.random.default_rng(2).random((len(FACES), 1, 4)), 3, axis=1)
    there, _ = transfer(rows=57, columns=48)
    found = there.corner_attributes(colours)
    assert np.array_equal(found, np.repeat(found[:, :1], 3, axis=1))
    assert (found[:, 0, None] == colours[None, :, 0]).all(2).any(1).all()


def test_rows_03_and_43_values_that_cannot_be_used():
    there, _ = transfer()
    with pytest.raises(ValueError, match=r"values: expected shape \(1312, n\), got \(1311, 5\)"):
        there.attributes(VALUES[1:])
    with pytest.raises(ValueError, match=r"values: expected shape \(1312, n\)"):
        there.attributes(VALUES[:, 0])
    with pytest.raises(TypeError, match="values: expected floating point numbers"):
        there.attributes(VALUES > 0)
    with pytest.raises(lissom.InvalidValue, match=r"values: not finite \(at 7; 1 in all\)"):
        there.attributes(np.where(np.arange(len(VERTICES))[:, None] == 7, np.nan, VALUES))
    uv = unrolled()
    with pytest.raises(ValueError, match="values: expected shape"):
        there.corner_attributes(uv[:, :2])
    with pytest.raises(lissom.InvalidValue, match=r"values: not finite \(at 3; 1 in all\)"):
        there.corner_attributes(np.where(np.arange(len(FACES))[:, None, None] == 3, np.inf, uv))
    with pytest.raises(lissom.InvalidConstraint, match="faces: 5 for"):
        there.corner_attributes(uv, np.arange(5))
    mesh = lissom.Mesh(VERTICES, FACES)
    alone = lissom.Transfer(mesh, mesh, [[0, 0]])
    with pytest.raises(lissom.InvalidConstraint, match="need a fit"):
        alone.attributes(VALUES)


def test_row_40_cancelled():
    there, _ = transfer()
    job = there.start_corner_attributes(unrolled())
    job.cancel()
    with pytest.raises(lissom.Cancelled):
        job.result()
