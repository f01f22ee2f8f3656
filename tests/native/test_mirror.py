"""Half meshes that a mirror completes, and whole ones whose handles move left and right alike."""

import lissom
import numpy as np
import pytest
from figures import volume
from shapes import diagonal, moved, rigid, rotation

ORIGIN, X = np.zeros(3), np.array([1.0, 0, 0])
METHODS = pytest.mark.parametrize("method", lissom.POSE_METHODS)
SEEDS = pytest.mark.parametrize("seed", range(3))


def dome(seed, rows=14, around=20):
    """A bumpy half sphere on x >= 0, whose rim lies on x = 0: vertices, triangles."""
    rng = np.random.default_rng(seed)
    polar = np.repeat(np.pi / 2 * np.arange(1, rows + 1) / rows, around)
    turn = np.tile(2 * np.pi * np.arange(around) / around, rows)
    ring = np.stack([np.cos(polar), np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn)], 1)
    vertices = np.concatenate([X[None], ring]) * [1, *rng.uniform(0.7, 1.4, 2)]
    vertices *= 1 + 0.05 * np.sin(vertices @ rng.normal(size=3) * 4)[:, None]
    vertices[-around:, 0] = 0
    i = np.arange(around)
    j = (i + 1) % around
    faces = [np.stack([np.zeros_like(i), 1 + i, 1 + j], 1)]
    for row in range(rows - 1):
        a, b = 1 + row * around + i, 1 + row * around + j
        faces += [np.stack([a, a + around, b + around], 1), np.stack([a, b + around, b], 1)]
    return vertices, np.concatenate(faces)


def mirrored(points, point=ORIGIN, normal=X):
    return points - 2 * ((points - point) @ normal)[..., None] * normal


def across(matrix):
    """The motion of the other side of x = 0."""
    mirror = np.diag([-1.0, 1, 1, 1])
    return mirror @ matrix @ mirror


def completed(vertices, faces, axis=0):
    """The whole mesh, and where the image of each vertex is in it."""
    seam = vertices[:, axis] == 0
    image = np.arange(len(vertices))
    image[~seam] = len(vertices) + np.arange((~seam).sum())
    sign = np.where(np.arange(3) == axis, -1.0, 1.0)
    return (
        np.concatenate([vertices, vertices[~seam] * sign]),
        np.concatenate([faces, image[faces][:, [0, 2, 1]]]),
        image,
    )


def scene(seed):
    """A half mesh, its handles (one on the plane, one beside it) and their motions."""
    vertices, faces = dome(seed)
    rng = np.random.default_rng(seed + 100)
    low = np.flatnonzero(vertices[:, 2] < 0.6 * vertices[:, 2].min())
    tip = np.flatnonzero(vertices[:, 0] > 0.9 * vertices[:, 0].max())
    motion = rigid(rng.normal(size=3), rng.uniform(0.3, 1.0), rng.uniform(-0.4, 0.4, 3))
    return vertices, faces, [low, tip], [np.eye(4), motion]


@METHODS
@SEEDS
@pytest.mark.parametrize("keeps", [False, True])
def test_a_half_is_posed_as_the_half_of_the_whole(method, seed, keeps):
    vertices, faces, handles, (still, motion) = scene(seed)
    options = {"method": method, "preserve_volume": keeps}
    half = lissom.Pose(lissom.Mesh(vertices, faces), handles, mirror=[(ORIGIN, X)], **options)
    posed = half.solve([still, motion], max_iterations=2000, tolerance=1e-10)
    seam = vertices[:, 0] == 0
    assert not posed.report.warnings
    assert (posed.vertices[seam, 0] == 0).all()
    assert np.abs(posed.vertices[handles[1]] - moved(motion, vertices[handles[1]])).max() < 1e-14
    points, triangles, image = completed(vertices, faces)
    low = np.union1d(handles[0], image[handles[0]])
    whole = lissom.Pose(lissom.Mesh(points, triangles), [low, handles[1], image[handles[1]]], **options)
    expected = whole.solve([still, motion, across(motion)], max_iterations=2000, tolerance=1e-10).vertices
    assert np.abs(posed.vertices - expected[: len(vertices)]).max() < 1e-6
    if keeps:
        both = np.concatenate([posed.vertices, mirrored(posed.vertices)[~seam]])
        assert abs(volume(both, triangles) / volume(points, triangles) - 1) < 1e-6


def test_without_a_mirror_the_seam_comes_apart():
    vertices, faces, handles, motions = scene(0)
    posed = lissom.Pose(lissom.Mesh(vertices, faces), handles).solve(motions).vertices
    assert np.abs(posed[vertices[:, 0] == 0, 0]).max() > 0.01


@SEEDS
def test_any_plane_mirrors(seed):
    vertices, faces, handles, motions = scene(seed)
    rng = np.random.default_rng(seed)
    place = rigid(rng.normal(size=3), 2.0, rng.uniform(-5, 5, 3))
    plane = (moved(place, np.array([0, 2.0, 3.0])), place[:3, :3] @ X * 7)
    there = lissom.Pose(lissom.Mesh(moved(place, vertices), faces), handles, mirror=[plane])
    here = lissom.Pose(lissom.Mesh(vertices, faces), handles, mirror=[(ORIGIN, X)])
    back = np.linalg.inv(place)
    found = there.solve([place @ motion @ back for motion in motions]).vertices
    expected = moved(place, here.solve(motions).vertices)
    assert np.abs(found - expected).max() < 1e-6
    height = (found - plane[0]) @ (place[:3, :3] @ X)
    assert np.abs(height[vertices[:, 0] == 0]).max() < 1e-14 * diagonal(vertices) * 10


@METHODS
def test_two_and_three_planes_complete_quarters_and_eighths(method):
    steps = np.linspace(0, np.pi / 2, 9)
    a, b = (angle.ravel() for angle in np.meshgrid(steps, steps, indexing="ij"))
    part = np.stack([np.cos(a), np.sin(a) * np.cos(b), 1.2 * np.sin(a) * np.sin(b)], 1)
    part[np.abs(part) < 1e-12] = 0
    part, place = np.unique(part, axis=0, return_inverse=True)
    k = np.arange(81).reshape(9, 9)
    quads = np.stack([k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]], -1).reshape(-1, 4)
    faces = place.ravel()[np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])]
    faces = faces[[len(set(face)) == 3 for face in faces.tolist()]]
    corner = np.linalg.norm(part - part[np.abs(part - 0.6).max(1).argmin()], axis=1) < 0.2
    corner &= (part > 0).all(1)
    centre = np.flatnonzero(part[:, 2] < 0.15)
    motion = rigid((1, 2, 0.5), 0.4, (0.2, 0.1, 0.3))
    planes = [(ORIGIN, axis) for axis in np.eye(3)]
    handles = [centre, np.flatnonzero(corner)]
    points, triangles, seam = part, faces, part == 0
    for count in (2, 3):
        mesh = lissom.Mesh(points, triangles)
        pose = lissom.Pose(mesh, handles, method=method, mirror=planes[:count])
        posed = pose.solve([np.eye(4), motion], max_iterations=2000, tolerance=1e-10).vertices
        for axis in range(count):
            assert (posed[seam[:, axis], axis] == 0).all()
        # The same with one mirror less, on the mesh that is completed by hand.
        whole, sides, image = completed(points, triangles, axis=count - 1)
        both = [np.union1d(centre, image[centre]), handles[1], image[handles[1]]]
        mirror = np.diag([-1.0 if axis == count - 1 else 1.0 for axis in range(4)])
        pose = lissom.Pose(lissom.Mesh(whole, sides), both, method=method, mirror=planes[: count - 1])
        goal = [np.eye(4), motion, mirror @ motion @ mirror]
        other = pose.solve(goal, max_iterations=2000, tolerance=1e-10).vertices[: len(points)]
        assert np.abs(posed - other).max() < 1e-6


@METHODS
@SEEDS
def test_the_right_handle_follows_the_left(method, seed):
    vertices, faces, (low, tip), (still, motion) = scene(seed)
    points, triangles, image = completed(vertices, faces)
    order = np.random.default_rng(seed).permutation(len(points))
    back = np.argsort(order)
    mesh = lissom.Mesh(points[order], back[triangles])
    left, right, low = back[tip], back[image[tip]], back[np.union1d(low, image[low])]
    options = {"method": method, "symmetry": [(ORIGIN, X)]}
    alone = lissom.Pose(mesh, [low, left], **options)
    found = alone.solve([still, motion])
    assert not found.report.warnings
    whole = found.vertices[back]
    assert np.abs(whole[image] - mirrored(whole[: len(vertices)])).max() < 1e-15 * 10
    both = lissom.Pose(mesh, [right, low, left], **options)
    assert any("follow the one on the other side" in said for said in both.warnings)
    ignored = rigid((0, 1, 0), 1.0, (9, 9, 9))
    assert np.abs(both.solve([ignored, still, motion]).vertices - found.vertices).max() < 1e-6
    other = lissom.Pose(mesh, [low, right], **options).solve([still, across(motion)]).vertices
    assert np.abs(other - found.vertices).max() < 1e-6
    points = np.concatenate([points[order][low], moved(motion, points[order][left])])
    by_points = alone.solve_points(points, warm_start=False).vertices
    assert np.abs(by_points - found.vertices).max() < 1e-6


@pytest.mark.parametrize("whole", [False, True])
def test_a_handle_on_the_plane_stays_in_it(whole):
    vertices, faces, (low, _), _ = scene(1)
    top = np.flatnonzero(vertices[:, 2] > 0.6 * vertices[:, 2].max())
    option, seam, image = "mirror", vertices[:, 0] == 0, np.arange(len(vertices))
    if whole:
        vertices, faces, image = completed(vertices, faces)
        low, top, option = (*(np.union1d(h, image[h]) for h in (low, top)), "symmetry")
        seam = vertices[:, 0] == 0
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [low, top], **{option: [(ORIGIN, X)]})
    along = rigid((1, 0, 0), 0.7, (0, 0.2, 0.3))
    posed = pose.solve([np.eye(4), along]).vertices
    assert np.abs(posed[top] - moved(along, vertices[top])).max() < 1e-14
    # A shift across the plane does nothing, nor does a turn that both sides would answer in opposite ways.
    centre = vertices[seam & np.isin(np.arange(len(vertices)), top)].mean(0) * [0, 1, 1]
    for askew in (rigid(offset=(0.5, 0, 0)), rigid((0, 0, 1), 0.8), rigid((0, 1, 0), 0.5, (0.1, 0, 0))):
        about = rigid(offset=centre) @ askew @ rigid(offset=-centre)
        posed = pose.solve([np.eye(4), about], warm_start=False).vertices
        assert (posed[seam, 0] == 0).all()
        spread = np.ptp(np.linalg.norm(posed[top] - posed[top[0]], axis=1))
        assert abs(spread - np.ptp(np.linalg.norm(vertices[top] - vertices[top[0]], axis=1))) < 1e-12


@pytest.mark.parametrize("method", ["poisson", "rotation_invariant", "arap"])
def test_turns_beyond_half_a_turn_go_the_mirrored_way(method):
    vertices, faces, handles, _ = scene(2)
    angle = 1.6 * np.pi
    twist = rigid(X, angle, (0.5, 0, 0))
    turns = [ORIGIN, X * angle]
    half = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method, mirror=[(ORIGIN, X)])
    posed = half.solve([np.eye(4), twist], turns=turns).vertices
    points, triangles, image = completed(vertices, faces)
    low, tip = np.union1d(handles[0], image[handles[0]]), handles[1]
    whole = lissom.Pose(lissom.Mesh(points, triangles), [low, tip, image[tip]], method=method)
    goal = [np.eye(4), twist, across(twist)]
    expected = whole.solve(goal, turns=[*turns, X * angle]).vertices[: len(vertices)]
    assert np.abs(posed - expected).max() < 1e-6


def test_what_buckles_stays_symmetric_through_many_moves():
    angle, height = (
        g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 13) * np.pi, np.linspace(0, 6, 41))
    )
    vertices = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle) + 0.15 * np.cos(angle) ** 2, height], 1)
    vertices[np.abs(vertices[:, 0]) < 1e-12, 0] = 0
    k = np.arange(len(vertices)).reshape(41, 13)
    quads = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    points, triangles, image = completed(vertices, faces)
    # In another order rounding is another.
    order = np.random.default_rng(0).permutation(len(points))
    back = np.argsort(order)
    ends = [np.flatnonzero(vertices[:, 2] < 0.4), np.flatnonzero(vertices[:, 2] > 5.6)]
    half = lissom.Pose(lissom.Mesh(vertices, faces), ends, rotation_smoothing=0, mirror=[(ORIGIN, X)])
    both = [back[np.union1d(end, image[end])] for end in ends]
    mesh = lissom.Mesh(points[order], back[triangles])
    whole = lissom.Pose(mesh, both, rotation_smoothing=0, symmetry=[(ORIGIN, X)])
    free = lissom.Pose(mesh, both, rotation_smoothing=0)
    apart = []
    for push in np.linspace(0, 3, 101)[1:]:
        goal = [np.eye(4), rigid(offset=(0, 0, -push))]
        one, two, plain = (pose.solve(goal, max_iterations=20) for pose in (half, whole, free))
        apart.append(np.abs(two.vertices[back][: len(vertices)] - one.vertices).max())
    lean = plain.vertices[back]
    assert np.abs(lean[image] - mirrored(lean[: len(vertices)])).max() > 0.1
    # Until it snaps, at the 66th move. To which of two symmetric shapes about equally good is up to rounding.
    assert max(apart[:50]) < 1e-6
    assert two.report.energy == pytest.approx(one.report.energy, rel=0.02)


@pytest.mark.parametrize("unheld", ["rest", "follow"])
def test_loose_parts_are_as_without_a_mirror(unheld):
    vertices, faces, handles, motions = scene(0)
    n = len(vertices)
    on_plane, apart = vertices * 0.1 + [0, 0, 1.2], vertices * 0.1 + [3, 0, 0]
    points = np.concatenate([vertices, on_plane, apart])
    triangles = np.concatenate([faces + k * n for k in range(3)])
    plain, mirror = (
        lissom.Pose(lissom.Mesh(points, triangles), handles, unheld=unheld, **options)
        for options in ({}, {"mirror": [(ORIGIN, X)]})
    )
    assert plain.warnings == mirror.warnings and len(mirror.warnings) == 1
    found = mirror.solve(motions).vertices[n:].reshape(2, n, 3)
    for posed, rest in zip(found, (on_plane, apart), strict=True):
        sides = [x[faces] - x[np.roll(faces, 1, axis=1)] for x in (posed, rest)]
        assert np.allclose(*(np.linalg.norm(edges, axis=2) for edges in sides), atol=1e-9)
        assert np.array_equal(posed, rest) == (unheld == "rest")
    seam = on_plane[:, 0] == 0
    assert seam.any() and (found[0][seam, 0] == 0).all()


def test_regions_are_as_without_a_mirror():
    vertices, faces, handles, motions = scene(0)
    roi = np.flatnonzero(vertices[:, 0] > 0.4)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles[1:], roi=roi, mirror=[(ORIGIN, X)])
    rest = np.setdiff1d(np.arange(len(vertices)), roi)
    assert np.array_equal(pose.solve(motions[1:]).vertices[rest], vertices[rest])


def test_a_plane_that_nothing_lies_on_changes_nothing():
    vertices, faces, handles, motions = scene(0)
    mesh = lissom.Mesh(vertices, faces)
    plain, apart = (lissom.Pose(mesh, handles, mirror=m) for m in ([], [((-2, 0, 0), X)]))
    assert np.array_equal(plain.solve(motions).vertices, apart.solve(motions).vertices)
    assert plain.info.unknowns == apart.info.unknowns


def test_welded_seams_are_mirrored_too():
    vertices, faces, handles, motions = scene(1)
    soup, places = vertices[faces].reshape(-1, 3), faces.ravel()
    triangles = np.arange(len(soup)).reshape(-1, 3)
    own = [np.flatnonzero(np.isin(places, handle)) for handle in handles]
    mesh = lissom.Mesh(soup, triangles, weld=0.0)
    found = lissom.Pose(mesh, own, mirror=[(ORIGIN, X)]).solve(motions).vertices
    expected = (
        lissom.Pose(lissom.Mesh(vertices, faces), handles, mirror=[(ORIGIN, X)]).solve(motions).vertices
    )
    assert np.abs(found - expected[places]).max() < 1e-6
    assert (found[vertices[places, 0] == 0, 0] == 0).all()


def opened(vertices, degrees):
    """A jaw that opens about x, and with it the seam of a half mesh."""
    share = np.clip(0.6 - vertices[:, 2], 0, 1)
    turned = [rotation(X, np.radians(degrees) * s) @ v for s, v in zip(share, vertices, strict=True)]
    return np.array(turned) * np.where(vertices[:, :1] == 0, [[0, 1, 1]], [[1, 1, 1]])


PATHS = [
    {},
    {"rotation": "relative"},
    {"rotation": "shortest"},
    {"refinement": 4},
    {"stretch": "logarithmic"},
    {"preserve_volume": True},
]


@pytest.mark.parametrize("options", PATHS)
@SEEDS
def test_a_path_keeps_the_seam_on_the_plane(options, seed):
    vertices, faces = dome(seed)
    seam = vertices[:, 0] == 0
    end, half_way = opened(vertices, 60), opened(vertices, 20) * [1.1, 1, 1]
    points, triangles, image = completed(vertices, faces)
    both = [np.concatenate([x, mirrored(x)[~seam]]) for x in (vertices, end, half_way)]
    times = np.linspace(0, 1, 11)
    mesh, whole = lissom.Mesh(vertices, faces), lissom.Mesh(points, triangles)
    for stop in (False, True):
        through, through_whole = ([(0.3, x)] * stop for x in (half_way, both[2]))
        path = lissom.Inbetween(mesh, vertices, end, through=through, mirror=[(ORIGIN, X)], **options)
        shapes = path.at(times)
        assert shapes.shape == (11, len(vertices), 3)
        assert np.array_equal(shapes[0], vertices) and np.array_equal(shapes[-1], end)
        assert (shapes[:, seam, 0] == 0).all()
        expected = lissom.Inbetween(whole, *both[:2], through=through_whole, **options).at(times)
        # By itself the whole goes left and right alike but for what is chosen by rounding.
        alike = (expected[:, : len(vertices)] + mirrored(expected[:, image])) / 2
        assert np.abs(shapes - alike).max() < 1e-7
        knots = path.keyframes(count=4)
        assert len(path.at(knots.times)) == 4
    plain = lissom.Inbetween(mesh, vertices, end, **options).at(times)
    assert np.abs(plain[:, seam, 0]).max() > 1e-4


def test_a_vertex_that_leaves_the_plane_is_free_to():
    vertices, faces = dome(0)
    end = opened(vertices, 30)
    leaves = np.flatnonzero(vertices[:, 0] == 0)[3]
    end[leaves, 0] = 0.1
    path = lissom.Inbetween(lissom.Mesh(vertices, faces), vertices, end, mirror=[(ORIGIN, X)])
    half_way = path.at([0.5])[0]
    seam = (vertices[:, 0] == 0) & (end[:, 0] == 0)
    assert (half_way[seam, 0] == 0).all() and half_way[leaves, 0] > 0.01


def test_bad_planes_are_refused_by_name():
    vertices, faces, handles, _ = scene(0)
    mesh, end = lissom.Mesh(vertices, faces), opened(vertices, 30)
    makers = [
        ("mirror", lambda planes: lissom.Pose(mesh, handles, mirror=planes)),
        ("symmetry", lambda planes: lissom.Pose(mesh, handles, symmetry=planes)),
        ("mirror", lambda planes: lissom.Inbetween(mesh, vertices, end, mirror=planes)),
    ]
    bad = (
        [(ORIGIN, ORIGIN)],
        [(ORIGIN, (np.nan, 0, 0))],
        [((np.inf, 0, 0), X)],
        [(ORIGIN, X), (ORIGIN, (1, 1, 0))],
    )
    for name, make in makers:
        for planes in bad:
            with pytest.raises(lissom.InvalidValue, match=rf"^{name}: ") as error:
                make(planes)
            assert error.value.argument == name and error.value.indices == [len(planes) - 1]
        with pytest.raises(ValueError, match=rf"^{name}: "):
            make([X, X])
    with pytest.raises(lissom.InvalidValue, match=r"^symmetry: the mesh is not symmetric: .*in all\)"):
        lissom.Pose(mesh, handles, symmetry=[(ORIGIN, X)])
    for wrong in ({"start": vertices[1:]}, {"end": end * np.nan}):
        arguments = {"start": vertices, "end": end, **wrong}
        with pytest.raises(lissom.InvalidValue, match=rf"^{next(iter(wrong))}: "):
            lissom.Inbetween(mesh, mirror=[(ORIGIN, X)], **arguments)


def test_bad_handles_are_refused_as_without_a_mirror():
    vertices, faces, (low, tip), _ = scene(0)
    points, triangles, image = completed(vertices, faces)
    whole = lissom.Mesh(points, triangles)
    halves = [image[tip][::2], image[tip][1::2]]
    with pytest.raises(
        lissom.InvalidConstraint, match=r"^handles: the mirror image of handle 1 lies in handles 2 and 3"
    ):
        lissom.Pose(whole, [low, tip, *halves], symmetry=[(ORIGIN, X)])
    mesh, n = lissom.Mesh(vertices, faces), len(vertices)
    for handles, roi in (([[n]], None), ([[]], None), ([[1], [1]], None), ([[1]], [n]), ([[1]], [])):
        with pytest.raises(lissom.InvalidConstraint) as plain:
            lissom.Pose(mesh, handles, roi=roi)
        with pytest.raises(lissom.InvalidConstraint) as mirror:
            lissom.Pose(mesh, handles, roi=roi, mirror=[(ORIGIN, X)])
        assert str(plain.value) == str(mirror.value)


@METHODS
@SEEDS
def test_handles_that_turn_by_themselves_turn_as_those_of_the_whole(method, seed):
    vertices, faces, handles, (still, motion) = scene(seed)
    centre = vertices[handles[1]].mean(axis=0)
    shifted = np.eye(4)
    shifted[:3, 3] = moved(motion, centre) - centre
    half = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method, mirror=[(ORIGIN, X)])
    posed = half.solve([still, shifted], by_itself=[0, 1], max_iterations=3000, tolerance=1e-11)
    points, triangles, image = completed(vertices, faces)
    low = np.union1d(handles[0], image[handles[0]])
    whole = lissom.Pose(lissom.Mesh(points, triangles), [low, handles[1], image[handles[1]]], method=method)
    goal = [still, shifted, across(shifted)]
    expected = whole.solve(goal, by_itself=[0, 1, 2], max_iterations=3000, tolerance=1e-11)
    size = diagonal(points)
    assert (posed.vertices[vertices[:, 0] == 0, 0] == 0).all()
    assert len(posed.transforms) == 2
    assert np.abs(posed.transforms[0][0, 1:3]).max() < 1e-14
    # Clusters of triangles are not symmetric, and the whole's turns are not quite.
    assert np.abs(posed.transforms[1] - expected.transforms[1]).max() < 2e-3
    assert np.abs(posed.vertices - expected.vertices[: len(vertices)]).max() < 1e-3 * size
