"""In-betweens: exactness, symmetry, known turns, real poses, the fewest keys, several shapes, obstacles."""

from itertools import pairwise

import lissom
import numpy as np
import pytest
from faces import triangulate
from figures import volume
from shapes import diagonal, grid_faces, moved, prism, rigid, tube


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


def test_shapes_come_in_the_order_of_their_times():
    start, faces, end = twisted_tube()
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    shapes = path.at([1.0, 0.5, 0.0])
    assert shapes.shape == (3, *start.shape)
    assert shapes.dtype == np.float64
    assert np.array_equal(shapes[0], end)
    assert np.array_equal(shapes[1], path.at([0.5])[0])
    assert np.array_equal(shapes[2], start)
    assert path.at([]).shape == (0, *start.shape)


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


def test_row_03_shapes_times_and_tolerances_that_are_not_finite():
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    broken = end.copy()
    broken[[4, 7], 0] = np.nan
    with pytest.raises(lissom.InvalidValue, match=r"end: not finite \(at 4, 7; 2 in all\)"):
        lissom.Inbetween(mesh, start, broken)
    with pytest.raises(lissom.InvalidValue, match=r"start: not finite"):
        lissom.Inbetween(mesh, broken, end)
    with pytest.raises(ValueError, match=r"start: .*1439.*1440"):
        lissom.Inbetween(mesh, start[1:], end)
    path = lissom.Inbetween(mesh, start, end)
    for bad in (np.nan, np.inf, -0.1, 1.1):
        with pytest.raises(lissom.InvalidValue, match=r"times: not within 0 and 1 \(at 1; 1 in all\)"):
            path.at([0.5, bad])
    for bad in (np.nan, 0.0, -1.0):
        with pytest.raises(lissom.InvalidValue, match="tolerance"):
            path.keyframes(bad)
    for bad in (1, -1):
        with pytest.raises(lissom.InvalidValue, match="max_keys"):
            path.keyframes(0.1, max_keys=bad)


def test_row_11_seams_stay_closed():
    vertices, faces = tube(rows=20, columns=12)
    corners = faces.ravel()
    soup = lissom.Mesh(vertices[corners], np.arange(len(corners)).reshape(-1, 3), weld=0.0)
    end = moved(rigid((1, 0, 0), 0.7), vertices) + np.sin(3 * vertices[:, [1, 2, 0]]) * 0.2
    whole = lissom.Inbetween(lissom.Mesh(vertices, faces), vertices, end).at([0, 0.3, 0.7, 1])
    split = lissom.Inbetween(soup, vertices[corners], end[corners]).at([0, 0.3, 0.7, 1])
    assert np.abs(split - whole[:, corners]).max() < 1e-9


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
    monkeypatch.setenv("LISSOM_MEMORY_LIMIT", "7e3")
    with pytest.raises(lissom.OutOfMemory, match="the factor would take"):
        lissom.Inbetween(mesh, vertices, vertices * 1.1)


def test_row_06_an_end_shape_on_one_point_or_line():
    start, faces, _ = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    with pytest.raises(lissom.InvalidValue, match="end: all points coincide"):
        lissom.Inbetween(mesh, start, np.ones_like(start))
    with pytest.raises(lissom.InvalidValue, match="end: all points lie on one line"):
        lissom.Inbetween(mesh, start, start * [1, 0, 0])


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


OPTIONS = [
    {"rotation": "shortest"},
    {"rotation": "relative"},
    {"refinement": 3},
    {"stretch": "logarithmic"},
    {"rotation": "relative", "stretch": "logarithmic", "refinement": 2, "preserve_volume": True},
]


@pytest.mark.parametrize("options", OPTIONS)
def test_every_option_keeps_the_ends_and_the_way_back(options):
    start, faces, end = twisted_tube()
    mesh, t = lissom.Mesh(start, faces), np.array([0.0, 1e-9, 0.2, 0.5, 0.7, 1 - 1e-9, 1.0])
    there = lissom.Inbetween(mesh, start, end, **options).at(t)
    back = lissom.Inbetween(mesh, end, start, **options).at(1 - t)
    assert np.abs(there - back).max() < 1e-8 * diagonal(start)
    assert np.array_equal(there[0], start)
    assert np.array_equal(there[-1], end)
    assert np.abs(there[1] - start).max() < 1e-6
    assert np.abs(there[-2] - end).max() < 1e-6


# The error of the edge lengths half way, refined.
@pytest.mark.parametrize(("pose", "bound"), [(5, 0.0135), (7, 0.027)])
@pytest.mark.parametrize("rotation", ["consistent", "relative"])
def test_cat_refined(data, pose, bound, rotation):
    cat = data("cat_lion")
    start, faces = cat["cat_reference"].astype(float), cat["cat_faces"]
    end = cat["cat_poses"][pose - 1].astype(float)
    mesh = lissom.Mesh(start, faces)
    there = lissom.Inbetween(mesh, start, end, rotation, refinement=16).at([1 / 6, 0.5])
    assert edge_error(faces, start, end, there[1]) <= bound
    back = lissom.Inbetween(mesh, end, start, rotation, refinement=16).at([5 / 6, 0.5])
    assert np.abs(there - back).max() < 1e-8 * diagonal(start)


def test_logarithmic_stretch_grows_by_the_same_factor_in_equal_times():
    start, faces = tube()
    end = moved(rigid((1, 1, 0), 1.0), start * 9)
    mesh = lissom.Mesh(start, faces)
    size = {
        stretch: np.sqrt(lissom.Inbetween(mesh, start, end, stretch=stretch).at([0.5])[0].var(0).sum())
        for stretch in ("linear", "logarithmic")
    }
    own = np.sqrt(start.var(0).sum())
    assert size["linear"] == pytest.approx(5 * own, rel=1e-9)
    assert size["logarithmic"] == pytest.approx(3 * own, rel=1e-9)


def test_a_path_through_more_shapes_hits_them():
    start, faces, end = twisted_tube()
    middle = moved(rigid((0, 0, 1), 0.4), start) * 1.1
    mesh = lissom.Mesh(start, faces)
    path = lissom.Inbetween(mesh, start, end, through=[(0.3, middle)])
    legs = lissom.Inbetween(mesh, start, middle), lissom.Inbetween(mesh, middle, end)
    x = path.at([0.0, 0.15, 0.3, 0.65, 1.0])
    assert all(np.array_equal(x[k], shape) for k, shape in ((0, start), (2, middle), (4, end)))
    assert np.abs(x[1] - legs[0].at([0.5])[0]).max() < 1e-12
    assert np.abs(x[3] - legs[1].at([0.5])[0]).max() < 1e-12
    times = path.keyframes(0.1)
    assert 0.3 in times
    assert playback_error(path, times) <= 0.1
    assert len(path.keyframes(count=6)) == 6
    with pytest.warns(RuntimeWarning, match="max_keys"):
        assert len(path.keyframes(0.01, max_keys=5)) == 5
    with pytest.raises(lissom.InvalidValue, match="count: less than 3: every shape is a key"):
        path.keyframes(count=2)
    for times in ([0.5, 0.5], [0.0], [1.0], [0.6, 0.4], [np.nan]):
        with pytest.raises(lissom.InvalidValue, match="through: times that do not ascend"):
            lissom.Inbetween(mesh, start, end, through=[(t, middle) for t in times])
    with pytest.raises(lissom.InvalidValue, match=r"through\[0\]: not finite"):
        lissom.Inbetween(mesh, start, end, through=[(0.5, middle * np.nan)])
    with pytest.raises(TypeError, match="through"):
        lissom.Inbetween(mesh, start, end, through=[middle])


def test_a_blend_adds_turns_where_offsets_collapse():
    start, faces = prism(rows=80, columns=24, length=12)
    inner = slice(0, 80 * 24)

    def bent(angle):
        radius, x = 12 / angle, start[:, 0] * angle / 12
        out = radius - start[:, 1]
        return np.column_stack([out * np.sin(x), radius - out * np.cos(x), start[:, 2]])

    one, two = bent(np.pi / 2), bent(np.pi)
    blend = lissom.Blend(lissom.Mesh(start, faces), start, [one, one])
    assert np.array_equal(blend.at([0, 0]), start)
    assert np.array_equal(blend.at([1, 0]), one)
    near = blend.at([0.5, 0.5])
    assert np.abs(near - one).max() < 1e-9
    both = blend.at([1, 1])
    offset = both.mean(0) - two.mean(0)
    assert np.abs(both - offset - two)[inner].max() < 0.05 * 12
    assert edge_error(faces, two, two, both) < 0.02
    assert edge_error(faces, two, two, 2 * one - start) > 0.2
    with pytest.raises(lissom.InvalidValue, match="weights: has 1 values, there are 2 shapes"):
        blend.at([1])
    with pytest.raises(lissom.InvalidValue, match=r"weights: not finite \(at 1; 1 in all\)"):
        blend.at([1, np.nan])
    with pytest.raises(lissom.InvalidValue, match=r"shapes\[1\]: not finite"):
        lissom.Blend(lissom.Mesh(start, faces), start, [one, one * np.nan])


def fewest_by_trying(path, tolerance, steps):
    """The least number of keys on a grid of times, by all pairs of them."""
    fine = 4
    shapes = path.at(np.linspace(0, 1, fine * steps + 1))
    reach = [0] + [steps + 2] * steps
    for b in range(1, steps + 1):
        for a in range(b):
            share = np.linspace(0, 1, fine * (b - a) + 1)[:, None, None]
            line = (1 - share) * shapes[fine * a] + share * shapes[fine * b]
            if np.linalg.norm(shapes[fine * a : fine * b + 1] - line, axis=2).max() <= tolerance:
                reach[b] = min(reach[b], reach[a] + 1)
    return reach[steps] + 1


@pytest.mark.parametrize("tolerance", [0.4, 0.15, 0.05])
def test_keyframes_are_the_fewest_and_a_count_has_the_least_error(tolerance):
    start, faces, end = twisted_tube()
    end[:, 1] += np.sin(start[:, 0]) * np.linspace(0, 2, len(end))
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    times = path.keyframes(tolerance)
    assert len(times) <= fewest_by_trying(path, tolerance, 48)
    assert playback_error(path, list(times)) <= tolerance
    by_count = path.keyframes(count=len(times))
    assert len(by_count) == len(times)
    assert playback_error(path, list(by_count)) <= tolerance * 1.001
    assert playback_error(path, list(path.keyframes(count=len(times) - 1))) > tolerance
    for arguments in ({}, {"tolerance": 1.0, "count": 3}):
        with pytest.raises(TypeError, match="either tolerance or count"):
            path.keyframes(**arguments)


def lid():
    """A strip of a sphere that turns by 100 degrees about the axis of the sphere, which is x."""
    turn, across = np.meshgrid(
        np.radians(np.linspace(-10, 30, 41)), np.linspace(-1.1, 1.1, 51), indexing="ij"
    )
    ring = np.cos(across)
    start = np.stack([np.sin(across), ring * np.cos(turn), ring * np.sin(turn)], -1).reshape(-1, 3)
    return start, grid_faces(41, 51), moved(rigid((1, 0, 0), np.radians(100)), start)


def test_a_lid_stays_on_its_ball():
    start, faces, end = lid()
    assert 1 - np.linalg.norm((start + end) / 2, axis=1).min() > 0.35
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end)
    radii = np.linalg.norm(path.at(np.linspace(0, 1, 41)), axis=2)
    assert np.abs(radii - 1).max() < 0.005
    times = list(path.keyframes(0.002))
    # Chords of a circle: 1 - cos(a / 2) <= 0.002 asks for at least 14 of them over 100 degrees.
    assert len(times) == 15
    assert playback_error(path, times) <= 0.002
    assert playback_error(path, list(path.keyframes(count=14))) > 0.002


def ball(centre, radius, rows=96, columns=192):
    """A closed sphere around its axis z: rings and two poles."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rows + 2)[1:-1],
        np.linspace(0, 2 * np.pi, columns, endpoint=False),
        indexing="ij",
    )
    ring = np.sin(polar)
    points = np.stack([ring * np.cos(around), ring * np.sin(around), np.cos(polar)], -1).reshape(-1, 3)
    top, bottom, k = len(points), len(points) + 1, np.arange(columns)
    last, after = (rows - 1) * columns, (k + 1) % columns
    faces = np.concatenate(
        [
            grid_faces(rows, columns, closed=True),
            np.stack([np.full(columns, top), k, after], 1),
            np.stack([np.full(columns, bottom), last + after, last + k], 1),
        ]
    )
    return centre + radius * np.concatenate([points, [[0, 0, 1], [0, 0, -1]]]), faces


def eye_and_blink(data):
    face = data("ict_face")
    start, faces = face["neutral"].astype(float), triangulate(face["loops"], face["counts"])
    end = start + face["expressions"][list(face["expression_names"]).index("eyeBlink_L")]
    eye = start[21451:22221]
    fit = np.linalg.lstsq(np.column_stack([2 * eye, np.ones(len(eye))]), (eye**2).sum(1), rcond=None)[0]
    return start, faces, end, fit[:3], np.sqrt(fit[3] + fit[:3] @ fit[:3])


def test_a_blink_keeps_out_of_the_eyeball(data):
    start, faces, end, centre, radius = eye_and_blink(data)
    mesh, eye = lissom.Mesh(start, faces), lissom.Mesh(*ball(centre, radius))
    moves = np.any(start != end, axis=1)

    def depth(x):
        return np.maximum(0, radius - np.linalg.norm(x - centre, axis=-1))

    allowed = np.maximum(depth(start), depth(end))
    times = np.linspace(0, 1, 9)
    plain = lissom.Inbetween(mesh, start, end).at(times)
    assert (depth(plain) - allowed)[:, moves].max() > 0.01
    held = lissom.Inbetween(mesh, start, end, clearance=eye).at(times)
    # What the facets of the ball are off the sphere.
    assert (depth(held) - allowed)[:, moves].max() < 1e-3
    assert np.array_equal(held[:, ~moves], np.stack([start[~moves]] * 9))
    assert np.array_equal(held[[0, -1]], [start, end])
    # Smooth in time: no step jumps by more than a few times what the plain path does.
    steps = [np.linalg.norm(np.diff(x, axis=0), axis=2).max() for x in (plain, held)]
    assert steps[1] < 2 * steps[0]


def test_an_obstacle_must_be_closed_and_may_move():
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    with pytest.raises(lissom.InvalidValue, match="clearance: not closed"):
        lissom.Inbetween(mesh, start, end, clearance=mesh)
    with pytest.raises(lissom.InvalidValue, match="clearance_end: needs clearance"):
        lissom.Inbetween(mesh, start, end, clearance_end=start)
    with pytest.raises(TypeError, match="clearance: expected a lissom"):
        lissom.Inbetween(mesh, start, end, clearance=start)
    points, sides = ball(np.zeros(3), 0.5, 24, 48)
    # A ball that goes along under a sheet, which makes room for it at both ends.
    x, y = (p.ravel() for p in np.meshgrid(np.linspace(-2, 2, 41), np.linspace(-2, 2, 41), indexing="ij"))
    bumps = ((x - at) ** 2 + y**2 for at in (-0.8, 0.8))
    start, end = (
        np.column_stack([x, y, h * np.exp(-0.8 * r)]) for h, r in zip((1, 1.05), bumps, strict=True)
    )
    mesh, way = lissom.Mesh(start, grid_faces(41, 41)), np.array([0.8, 0, 0])
    middle = np.array([0, 0, 0.49])
    obstacle = lissom.Mesh(middle - way + points, sides)
    options = {"clearance": obstacle, "clearance_end": middle + way + points}
    plain, held = (lissom.Inbetween(mesh, start, end, **o).at([0.5])[0] for o in ({}, options))
    assert np.linalg.norm(plain - middle, axis=1).min() < 0.3
    # What the facets of the ball are off the sphere.
    assert np.linalg.norm(held - middle, axis=1).min() > 0.5 - 3e-3


def test_coarse_faces_keep_out_where_the_ends_are_clear():
    ball_points, sides = ball(np.zeros(3), 1.0, 48, 96)
    x, y = (p.ravel() for p in np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij"))
    start, end = (np.column_stack([x + shift, y, np.full(len(x), 0.75)]) for shift in (-2.4, 2.8))
    faces = grid_faces(9, 9)
    obstacle = lissom.Mesh(ball_points, sides)
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end, clearance=obstacle)
    for shape in path.at(np.linspace(0, 1, 11)):
        corners = shape[faces]
        across = np.concatenate([corners.mean(axis=1), (corners + corners[:, [1, 2, 0]]).reshape(-1, 3) / 2])
        # With vertices on the ball, 0.984.
        assert np.linalg.norm(across, axis=1).min() > 1


def test_the_surveys_twisted_bar_loses_no_volume(data):
    survey = data("survey")
    start, faces, status = survey["bar_vertices"].astype(float), survey["bar_faces"], survey["bar_status"]
    mesh = lissom.Mesh(start, faces)
    pose = lissom.Pose(
        mesh, [np.flatnonzero(status == 0), np.flatnonzero(status == 2)], method="rotation_invariant"
    )
    end = pose.solve([np.eye(4), survey["bar_transform"]]).vertices

    def lost(**options):
        path = lissom.Inbetween(mesh, start, end, **options)
        assert path.warnings == []
        times = [0.2, 0.5, 0.8]
        # The one open end lies in a plane, which the origin is moved to.
        base = start[status == 0].mean(0)
        base[2] = start[:, 2].min()
        volumes = [volume(x - base, faces) for x in path.at(times)]
        ends = volume(start - base, faces), volume(end - base, faces)
        return max(
            abs(v / ((1 - t) * ends[0] + t * ends[1]) - 1) for t, v in zip(times, volumes, strict=True)
        )

    assert lost() > 1e-4
    assert lost(preserve_volume=True) < 1e-8


def test_options_are_told_where_they_are_wrong():
    start, faces, end = twisted_tube()
    mesh = lissom.Mesh(start, faces)
    with pytest.raises(TypeError, match="'inbetween' has no option refine; it has rotation, stretch"):
        lissom.Inbetween(mesh, start, end, refine=3)
    with pytest.raises(lissom.InvalidValue, match="stretch: 'cubic' is none of linear, logarithmic"):
        lissom.Inbetween(mesh, start, end, stretch="cubic")
    with pytest.raises(lissom.InvalidValue, match="refinement: must not be negative, got -1"):
        lissom.Inbetween(mesh, start, end, refinement=-1)


def test_keyframes_are_used_as_an_array():
    start, faces, end = twisted_tube()
    keys = lissom.Inbetween(lissom.Mesh(start, faces), start, end).keyframes(count=4)
    assert isinstance(keys, lissom.Keyframes) and keys.error > 0 and keys.warnings == []
    times = np.asarray(keys)
    assert np.array_equal(keys * 24 + 1, times * 24 + 1) and np.array_equal(1 - keys, 1 - times)
    assert (keys == times).all() and (keys >= 0).all() and np.array_equal(np.diff(keys), np.diff(times))
    for write in (lambda: np.multiply(keys, 2, out=keys), lambda: np.add(1, 2, where=keys)):
        with pytest.raises(TypeError):
            write()
    assert keys.tolist() == list(keys) == [keys[0], *keys[1:]] and len(keys) == 4


def test_parts_of_an_obstacle_may_overlap():
    points, sides = ball(np.zeros(3), 1.0, 24, 48)
    x, y = (p.ravel() for p in np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21), indexing="ij"))
    start, end = (np.column_stack([x + shift, y, np.full(len(x), 0.75)]) for shift in (-2.4, 2.8))
    mesh = lissom.Mesh(start, grid_faces(21, 21))
    second = points + (0.4, 0, 0)
    both = lissom.Mesh(np.concatenate([points, second]), np.concatenate([sides, sides + len(points)]))
    plain, held = (lissom.Inbetween(mesh, start, end, **o).at([0.5])[0] for o in ({}, {"clearance": both}))

    def depth(shape):
        return max((1 - np.linalg.norm(shape - centre, axis=1)).max() for centre in ((0, 0, 0), (0.4, 0, 0)))

    assert depth(plain) > 0.2
    assert depth(held) < 0.01  # what the facets of the balls are off the spheres


@pytest.mark.parametrize("rotation", ["consistent", "relative", "shortest"])
@pytest.mark.parametrize("refinement", [0, 4, 16])
@pytest.mark.parametrize("seed", range(4))
def test_paths_are_continuous_in_time_where_triangles_fold_over(rotation, refinement, seed):
    """Noise up to the length of an edge, and neighbours that change places."""
    random = np.random.default_rng(seed)
    start, faces = tube(rows=12, columns=10)
    end = start + random.normal(size=start.shape) * random.uniform(0.02, 0.06) * diagonal(start)
    swapped = faces[random.integers(len(faces), size=3), :2]
    end[swapped] = end[swapped[:, ::-1]]
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end, rotation, refinement=refinement)
    assert any("turn over" in line for line in path.warnings)
    assert largest_step(path) < 20


def largest_step(path):
    """Over 1,000 times, in medians."""
    steps = np.linalg.norm(np.diff(path.at(np.linspace(0, 1, 1001)), axis=0), axis=2).max(1)
    return steps.max() / np.median(steps)


@pytest.mark.parametrize("rotation", ["consistent", "relative", "shortest"])
@pytest.mark.parametrize("height", [0.4, 0.7, 1.0])
def test_a_dimple_is_pushed_in_without_a_jump(rotation, height):
    around, rings = 12, 4
    angle, radius = np.meshgrid(2 * np.pi * np.arange(around) / around, np.arange(1, rings + 1) / rings)
    ring = [radius * np.cos(angle), radius * np.sin(angle), height * (1 - radius)]
    start = np.concatenate([[[0, 0, height]], np.stack(ring, -1).reshape(-1, 3)])
    k = np.arange(around)
    top = np.stack([np.zeros(around, int), 1 + k, 1 + (k + 1) % around], 1)
    faces = np.concatenate([top, 1 + grid_faces(rings, around, closed=True)[:, ::-1]])
    end = start * [1, 1, -1]
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end, rotation, refinement=16)
    assert largest_step(path) < 20
    keys = path.keyframes(0.01)
    assert keys.warnings or playback_error(path, list(keys)) <= 0.01


@pytest.mark.parametrize(
    "options", [{}, {"rotation": "relative"}, {"rotation": "shortest"}, {"refinement": 4}]
)
@pytest.mark.parametrize("degrees", [45, 60, 75, 90])
@pytest.mark.parametrize("seed", range(2))
def test_symmetric_shapes_with_folds_go_a_symmetric_way(options, degrees, seed):
    """The lower half of a ball turns about a hinge and crumples what is beside; lying anyhow."""
    random = np.random.default_rng(seed)
    start, faces = ball(np.zeros(3), 1.0, 23, 24)
    twin = np.concatenate([np.arange(23)[:, None] * 24 + (12 - np.arange(24)) % 24], 1).ravel()
    twin = np.append(twin, [len(start) - 2, len(start) - 1])
    half = faces[(start[faces].mean(1)[:, 0] > 0)]
    faces = np.concatenate([half, twin[half][:, ::-1]])
    mirror = np.array([-1, 1, 1])
    share = np.clip((0.1 - start[:, 2]) / random.uniform(0.2, 0.5), 0, 1)
    hinge = np.array([0, random.uniform(0.3, 0.6), 0])
    turns = [rigid((1, 0, 0), np.radians(degrees) * s)[:3, :3] for s in share]
    end = np.stack([turn @ (p - hinge) + hinge for turn, p in zip(turns, start, strict=True)])
    start, end = ((x + x[twin] * mirror) / 2 for x in (start, end))
    pose = rigid(random.normal(size=3), random.uniform(0, np.pi))[:3, :3]
    x, lying = (
        lissom.Inbetween(lissom.Mesh(start @ q.T, faces), start @ q.T, end @ q.T, **options).at([0.3, 0.5])
        @ q
        for q in (np.eye(3), pose)
    )
    assert np.abs(x[:, twin] * mirror - x).max() < 1e-9
    assert np.abs(lying - x).max() < 1e-9


def noisy(shape, random, size):
    return shape + random.normal(size=shape.shape) * size


@pytest.mark.parametrize("rotation", ["consistent", "relative", "shortest"])
@pytest.mark.parametrize("seed", range(4))
def test_parts_that_turn_by_half_a_turn_go_the_same_way(rotation, seed):
    """Pages that nothing holds, about a common spine, up to noise: all stay flat and pass on one side."""
    random = np.random.default_rng(seed)
    page = np.stack(
        [*np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1.5, 7)), np.zeros((7, 6))], -1
    ).reshape(-1, 3)
    pages = [page + [0.02, 0, 0.02 * k] for k in range(6)]
    faces = np.vstack([grid_faces(7, 6) + len(page) * k for k in range(6)])
    pose = rigid(random.normal(size=3), random.uniform(0, np.pi))[:3, :3]
    start = np.vstack(pages) @ pose.T
    end = noisy(np.vstack(pages) * [-1, 1, -1] @ pose.T, random, 1e-5)
    path = lissom.Inbetween(lissom.Mesh(start, faces), start, end, rotation=rotation)
    quarter = rigid((0, 1, 0), np.pi / 2)[:3, :3]
    ways = [np.vstack(pages) @ turn.T @ pose.T for turn in (quarter, quarter.T)]
    half_way = path.at([0.5])[0]
    assert min(np.abs(half_way - way).max() for way in ways) < 1e-3
    back = lissom.Inbetween(lissom.Mesh(start, faces), noisy(end, random, 1e-5), start, rotation=rotation)
    assert np.abs(back.at([0.5])[0] - half_way).max() < 1e-3
    if rotation != "shortest":
        assert any("half a turn" in line and "6 in all" in line for line in path.warnings)


@pytest.mark.parametrize("rotation", ["consistent", "relative"])
@pytest.mark.parametrize(("noise", "turned"), [(0.0, 0.0), (1e-7, 0.0), (1e-4, 0.0), (1e-5, 1.0)])
def test_wings_that_fold_over_a_body_by_half_a_turn_pass_on_the_same_side(rotation, noise, turned):
    """Both wings of one mesh, while the body rests or turns: the same way, and told."""
    random = np.random.default_rng(1)
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-1, 1, 21), np.linspace(0, 1, 8)))
    start = np.column_stack([x, y, 0.4 * (np.abs(x) - 0.4) ** 2])
    out, hinge = np.sign(x) * (np.abs(x) > 0.45), np.column_stack([np.sign(x) * 0.4, 0 * x, 0 * x])
    turns = np.array([rigid((0, 1, 0), -np.pi * side)[:3, :3] for side in out])
    folded = hinge + np.einsum("nij,nj->ni", turns, start - hinge)
    whole = rigid((0.3, 1, 0.2), turned)[:3, :3]
    end = np.where(out[:, None] != 0, folded, start) @ whole.T
    end += random.normal(size=end.shape) * noise
    pose = rigid((1, 2, 3), 0.7 * turned)[:3, :3]
    path = lissom.Inbetween(
        lissom.Mesh(start @ pose.T, grid_faces(8, 21)), start @ pose.T, end @ pose.T, rotation=rotation
    )
    half = rigid((0.3, 1, 0.2), turned / 2)[:3, :3]
    tips = (path.at([0.5])[0] @ pose @ half)[[0, 20]]
    tips -= tips.mean(0) * [1, 0, 0]
    # A body that turns about another axis meanwhile tilts what folds on it.
    assert abs(tips[0, 2] - tips[1, 2]) < (0.1 if turned else 1e-3) and abs(tips[0, 2]) > 0.25
    assert any("half a turn" in line for line in path.warnings)


@pytest.mark.parametrize("seed", range(3))
def test_a_way_does_not_depend_on_how_shapes_lie_however_crumpled(seed):
    random = np.random.default_rng(seed)
    start, faces = tube(rows=30, columns=14, length=6)
    along = (start[:, 0] - start[:, 0].min()) / np.ptp(start[:, 0])
    turns = np.array([rigid((1, 0.2, 0), 2.3 * t)[:3, :3] for t in along])
    end = np.einsum("nij,nj->ni", turns, start) + 0.12 * random.normal(size=start.shape)
    ways = []
    for pose in (np.eye(3), *(rigid(random.normal(size=3), random.uniform(1, 3))[:3, :3] for _ in range(3))):
        size, place = 10.0 ** random.uniform(-3, 3), random.normal(size=3)
        a, b = ((shape @ pose.T + place) * size for shape in (start, end))
        ways.append((lissom.Inbetween(lissom.Mesh(a, faces), a, b).at([0.3])[0] / size - place) @ pose)
    assert max(np.abs(way - ways[0]).max() for way in ways[1:]) < 1e-8


@pytest.mark.parametrize("seed", range(6))
def test_a_twist_beyond_half_a_turn_stays_on_its_axis(seed):
    random = np.random.default_rng(seed)
    start, faces = tube(rows=60, columns=20, length=6, bumps=0)
    start[:, 1:] *= random.uniform(0.1, 0.5)
    along = (start[:, 0] - start[:, 0].min()) / np.ptp(start[:, 0])
    angles = np.clip(1.1 * along - 0.05, 0, 1) * random.uniform(1.1, 3.5) * np.pi
    c, s = np.cos(angles), np.sin(angles)
    y, z = start[:, 1], start[:, 2]
    end = np.stack([start[:, 0], c * y - s * z, s * y + c * z], 1)
    end[angles == 0] = start[angles == 0]
    for x in lissom.Inbetween(lissom.Mesh(start, faces), start, end).at([0.25, 0.5, 0.75]):
        rings = np.array([x[start[:, 0] == at].mean(0) for at in np.unique(start[:, 0])])
        assert np.abs(rings[:, 1:]).max() < 0.01


def arm(random):
    """Its first half at rest, the second bent; and how far from there each vertex is."""
    start, faces = tube(rows=40, columns=16, length=6)
    bent = start[:, 0] > 3
    end = start.copy()
    along = start[bent, 0] - 3
    angle, radius = np.minimum(along, 1) * random.uniform(0.5, 2), 1 / random.uniform(0.5, 2)
    out = radius + 2 - start[bent, 1]
    end[bent, 0] = 3 + out * np.sin(angle) + np.maximum(along - 1, 0) * np.cos(angle)
    end[bent, 1] = radius + 2 - out * np.cos(angle) + np.maximum(along - 1, 0) * np.sin(angle)
    return start, faces, end


@pytest.mark.parametrize("rotation", ["consistent", "relative", "shortest"])
@pytest.mark.parametrize("noise", ["single precision", 1e-8, 1e-7, 1e-6])
@pytest.mark.parametrize("place", [0.0, 1000.0])
def test_what_is_still_to_single_precision_is_still(rotation, noise, place):
    """A bent arm, and beside it a part that stays, wherever they are: noise changes no more than its size."""
    random = np.random.default_rng(int(place))
    start, faces, end = arm(random)
    part, sides = ball(np.array([0, 8.0, 0]), 2.0, 10, 16)
    start, end = np.vstack([start, part]) + place, np.vstack([end, part]) + place
    mesh = lissom.Mesh(start, np.vstack([faces, sides + start.shape[0] - len(part)]))
    held = (start == end).all(1)
    if noise == "single precision":
        noisy_end, size = end.astype(np.float32).astype(float), np.abs(end).max() * 2e-7
    else:
        noisy_end, size = noisy(end, random, noise * diagonal(start)), 5 * noise * diagonal(start)
    times = np.array([0.0, 0.25, 0.5, 0.9, 1.0])
    clean = lissom.Inbetween(mesh, start, end, rotation=rotation).at(times)
    found = lissom.Inbetween(mesh, start, noisy_end, rotation=rotation).at(times)
    assert np.array_equal(found[0], start) and np.array_equal(found[-1], noisy_end)
    assert np.abs(found - clean).max() < 50 * size
    straight = start + times[:, None, None] * (noisy_end - start)
    assert np.abs(found - straight)[:, held].max() < 1e-12 * np.abs(start).max()


def test_a_straight_path_has_no_keys_by_rounding():
    """Shifts in single precision are off their straight line by 1e-12; more keys would follow that."""
    start, faces, _ = twisted_tube()
    start = start.astype(np.float32).astype(float)
    middle, end = ((start + shift).astype(np.float32).astype(float) for shift in ([1, 2, 3], [2, 1, 0]))
    mesh = lissom.Mesh(start, faces)
    straight = lissom.Inbetween(mesh, start, end).keyframes(count=8)
    assert list(straight) == [0.0, 1.0] and 0 < straight.error < 1e-6
    legs = lissom.Inbetween(mesh, start, end, through=[(0.4, middle)]).keyframes(count=8)
    assert list(legs) == [0.0, 0.4, 1.0]
    bent = moved(rigid((0, 0, 1), 0.8), middle)
    mixed = lissom.Inbetween(mesh, start, bent, through=[(0.4, middle)]).keyframes(count=8)
    assert list(mixed[:2]) == [0.0, 0.4] and len(mixed) == 8
