"""In-betweens: exactness, symmetry, known turns, real poses, the fewest keys."""

from itertools import pairwise

import lissom
import numpy as np
import pytest
from shapes import diagonal, grid_faces, moved, rigid, soup, tube


def edges(faces):
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(sides, axis=0)


def edge_error(faces, start, end, x):
    """Root mean square relative deviation of the edge lengths from the mean of both ends."""
    i, j = edges(faces).T
    a, b, now = (np.linalg.norm(p[i] - p[j], axis=1) for p in (start, end, x))
    return np.sqrt(np.mean((2 * now / (a + b) - 1) ** 2))


def twisted_tube():
    """A slender tube twisted by a turn and a half; its first ring stays."""
    vertices, faces = tube(rows=60, columns=24, length=40, bumps=0)
    end = vertices.copy()
    for k, x in enumerate(np.unique(vertices[:, 0])):
        ring = vertices[:, 0] == x
        end[ring] = moved(rigid((1, 0, 0), 3 * np.pi * k / 59), end[ring])
    return vertices, faces, end


def test_both_ends_are_exact():
    start, faces, end = twisted_tube()
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    shapes = path.at([0.0, 0.5, 1.0])
    assert shapes.shape == (3, *start.shape)
    assert shapes.dtype == np.float64
    assert np.array_equal(shapes[0], start)
    assert np.array_equal(shapes[2], end)
    assert np.array_equal(shapes[:, :24], np.stack([start[:24]] * 3))


@pytest.mark.parametrize("rotation", ["consistent", "shortest"])
def test_the_way_back_is_the_same_path(rotation):
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    there = lissom.Inbetween(mesh, start, end, rotation=rotation).at([0.2, 0.5, 0.7])
    back = lissom.Inbetween(mesh, end, start, rotation=rotation).at([0.8, 0.5, 0.3])
    assert np.abs(there - back).max() < 1e-8 * diagonal(start)


def test_a_rigid_motion_is_interpolated_as_that_rotation():
    start, faces = tube()
    axis, angle = (1, 2, -1), np.radians(170)
    end = moved(rigid(axis, angle, (3, 0, 1)), start)
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    for t, x in zip([0.25, 0.5, 0.8], path.at([0.25, 0.5, 0.8]), strict=True):
        centre = (1 - t) * start.mean(0) + t * end.mean(0)
        known = moved(rigid(axis, t * angle, centre), start - start.mean(0))
        assert np.abs(x - known).max() < 1e-8 * diagonal(start)
        assert edge_error(faces, start, end, x) < 1e-8


def test_a_turn_and_a_half_comes_out_whole():
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    x = lissom.Inbetween(mesh, start, end).at([0.5])[0]
    last = moved(rigid((1, 0, 0), 1.5 * np.pi), start[-24:])
    y, z = (x[-24:] - x[-24:].mean(0))[:, 1:].T
    u, v = (last - last.mean(0))[:, 1:].T
    off = np.degrees(np.arctan2((u * z - v * y).sum(), (u * y + v * z).sum()))
    assert abs(off) < 2
    shortest = lissom.Inbetween(mesh, start, end, rotation="shortest").at([0.5])[0]
    assert edge_error(faces, start, end, x) < 0.2 * edge_error(faces, start, end, shortest)


def test_a_flat_sheet_stays_flat_even_where_it_turns_over():
    rows, columns = np.meshgrid(np.arange(12.0), np.arange(8.0), indexing="ij")
    start = np.stack([rows, columns, 0 * rows], -1).reshape(-1, 3)
    faces = grid_faces(12, 8)
    end = moved(rigid((0, 0, 1), np.radians(150)), start)
    end[43] += 1.8 * (end[44] - end[43])
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    assert any("turn over" in line for line in path.warnings)
    assert np.abs(path.at([0.3, 0.6])[:, :, 2]).max() < 1e-12


# Pose, counted from the reference as 0: the error of straight-line blending, and the bound.
@pytest.mark.parametrize(("pose", "straight", "bound"), [(5, 0.230, 0.03), (7, 0.416, 0.07)])
def test_cat(data, pose, straight, bound):
    cat = data("cat_lion")
    start, faces, end = (
        cat["cat_reference"].astype(float),
        cat["cat_faces"],
        cat["cat_poses"][pose - 1].astype(float),
    )
    assert edge_error(faces, start, end, (start + end) / 2) == pytest.approx(straight, abs=5e-4)
    x = lissom.Inbetween(lissom.Mesh(start, faces), start, end).at([0.5])[0]
    assert edge_error(faces, start, end, x) <= bound


def playback_error(path, times):
    """The largest distance of straight-line playback between `times` from the path."""
    keys = path.at(times)
    worst = 0.0
    for k, (a, b) in enumerate(pairwise(times)):
        probes = a + (b - a) * np.linspace(0.02, 0.98, 25)
        share = ((probes - a) / (b - a))[:, None, None]
        line = (1 - share) * keys[k] + share * keys[k + 1]
        worst = max(worst, np.linalg.norm(path.at(probes) - line, axis=2).max())
    return worst


def test_keyframes_keep_within_tolerance_and_none_can_be_spared():
    start, faces, end = twisted_tube()
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    tolerance = 0.05
    times = list(path.keyframes(tolerance))
    assert times[0] == 0
    assert times[-1] == 1
    assert playback_error(path, times) <= tolerance
    for spared in range(1, len(times) - 1):
        assert playback_error(path, times[:spared] + times[spared + 1 :]) > tolerance
    with pytest.warns(RuntimeWarning, match="max_keys"):
        assert len(path.keyframes(tolerance, max_keys=len(times) - 1)) == len(times) - 1


def test_row_03_shapes_times_and_tolerances_that_are_not_finite():
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    broken = end.copy()
    broken[[4, 7], 0] = np.nan
    with pytest.raises(lissom.InvalidValue, match=r"end: not finite \(at 4, 7; 2 in all\)"):
        lissom.Inbetween(mesh, start, broken)
    with pytest.raises(lissom.InvalidValue, match=r"start: not finite"):
        lissom.Inbetween(mesh, broken, end)
    path = lissom.Inbetween(mesh, start, end)
    for bad in (np.nan, np.inf, -0.1, 1.1):
        with pytest.raises(lissom.InvalidValue, match=r"times: not within 0 and 1 \(at 1; 1 in all\)"):
            path.at([0.5, bad])
    for bad in (np.nan, 0.0, -1.0):
        with pytest.raises(lissom.InvalidValue, match="tolerance"):
            path.keyframes(bad)
    with pytest.raises(lissom.InvalidValue, match="max_keys"):
        path.keyframes(0.1, max_keys=1)


def test_row_11_seams_stay_closed():
    vertices, faces = tube(rows=20, columns=12)
    corners = faces.ravel()
    soup = lissom.Mesh(vertices[corners], np.arange(len(corners)).reshape(-1, 3), weld=0.0)
    end = moved(rigid((1, 0, 0), 0.7), vertices) + np.sin(3 * vertices[:, [1, 2, 0]]) * 0.2
    whole = lissom.Inbetween(lissom.Mesh(vertices, faces), vertices, end).at([0, 0.3, 0.7, 1])
    split = lissom.Inbetween(soup, vertices[corners], end[corners]).at([0, 0.3, 0.7, 1])
    assert np.abs(split - whole[:, corners]).max() < 1e-9


def test_row_38_soups_of_random_triangles_never_fail():
    for seed in range(300):
        start, faces = soup(seed)
        end = start[::-1] + 0.1 * np.random.default_rng(seed).normal(size=start.shape)
        mesh = lissom.Mesh(start, faces)
        for shapes in ((start, end), (start, start * (1, 1, -1)), (end, start)):
            for rotation in ("consistent", "shortest"):
                assert np.isfinite(lissom.Inbetween(mesh, *shapes, rotation).at([0.3, 0.5])).all(), seed


def test_row_39_more_times_than_fit(monkeypatch):
    vertices, faces = tube(rows=20, columns=12)
    mesh = lissom.Mesh(vertices, faces)
    path = lissom.Inbetween(mesh, vertices, vertices * 1.1)
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e6")
    with pytest.raises(lissom.OutOfMemory, match=r"the in-betweens would take 11\.5 MB") as caught:
        path.at(np.full(1000, 0.5))
    assert (caught.value.needed, caught.value.available) == (2 * 24 * len(vertices) * 1000, 10**6)
    assert path.at([0.5]).shape == (1, len(vertices), 3)
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e5")
    with pytest.raises(lissom.OutOfMemory, match="the sampled path would take"):
        path.keyframes(1e-9)
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "1e3")
    with pytest.raises(lissom.OutOfMemory, match="the factor would take"):
        lissom.Inbetween(mesh, vertices, vertices * 1.1)


def test_row_06_an_end_shape_on_one_point_or_line():
    start, faces, _ = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    with pytest.raises(lissom.InvalidValue, match="end: all points coincide"):
        lissom.Inbetween(mesh, start, np.ones_like(start))
    with pytest.raises(lissom.InvalidValue, match="end: all points lie on one line"):
        lissom.Inbetween(mesh, start, start * [1, 0, 0])


def test_row_07_slivers_and_collapsed_triangles_stay_finite():
    start, faces, end = twisted_tube()
    end[200] = end[201]
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    assert any(line.startswith("end: ") and "slivers" in line for line in path.warnings)
    x = path.at([0.5, 1 - 1e-9])
    assert np.isfinite(x).all()
    assert np.abs(x[1] - end).max() < 1e-5


def test_rows_31_and_37_identical_shapes():
    start, faces, _ = twisted_tube()
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, start)
    assert path.warnings == []
    assert np.array_equal(path.at([0.3])[0], start)
    assert list(path.keyframes(1e-6)) == [0, 1]


def test_rotation_must_be_one_of_those_offered():
    start, faces, end = twisted_tube()
    with pytest.raises((ValueError, lissom.InvalidValue), match="rotation"):
        lissom.Inbetween(lissom.Mesh(start, faces), start, end, rotation="sideways")


@pytest.mark.parametrize("mirror", [(-1, 1, 1), (-1, -1, -1)])
def test_a_mirror_image_is_noticed(mirror):
    vertices, faces = tube(rows=30, columns=20)
    mesh = lissom.Mesh(vertices, faces)
    assert any(
        "mirror image" in line for line in lissom.Inbetween(mesh, vertices, vertices * mirror).warnings
    )
    turned = moved(rigid((1, 1, 0), 3.0), vertices)
    assert lissom.Inbetween(mesh, vertices, turned).warnings == []


def test_a_path_and_its_shapes_as_jobs():
    vertices, faces = tube(rows=30, columns=20)
    mesh, turned = lissom.Mesh(vertices, faces), moved(rigid((1, 1, 0), 2.0), vertices)
    path = lissom.start_inbetween(mesh, vertices, turned, rotation="shortest").result()
    assert np.array_equal(path.start([0.3]).result(), path.at([0.3]))
    with pytest.raises(lissom.InvalidValue, match="rotation: 'widest' is none of"):
        lissom.start_inbetween(mesh, vertices, turned, rotation="widest")
    with pytest.raises(lissom.InvalidValue, match="max_keys: must not be negative, got -1"):
        path.keyframes(0.1, max_keys=-1)
