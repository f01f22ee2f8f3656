"""Meshes of images: the outline and area of what is drawn, angles, and poses and paths that stay flat."""

import drawings
import lissom
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import moved, rigid

SMOOTH = {
    "ring": drawings.ring(),
    "photo": np.ones((40, 60)),
    **{name: drawings.letter(name) for name in drawings.LETTERS},
    **{f"islands {seed}": drawings.islands(seed) for seed in range(6)},
}
ROUGH = {
    **{f"noise {seed}": drawings.noise(seed) for seed in range(4)},
    **{f"lines {seed}": drawings.lines(seed) for seed in range(4)},
}
ALL = SMOOTH | ROUGH
ANGLE = 25.0  # that the documentation states
TIP = 60.0


def areas(vertices, triangles):
    """(..., m) signed areas in the plane, of positions (..., n, 3)."""
    a, b, c = (vertices[..., triangles[:, k], :2] for k in range(3))
    first, second = b - a, c - a
    return 0.5 * (first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def angles(vertices, triangles):
    """(m, 3) degrees."""
    corners = vertices[triangles]
    to = [np.roll(corners, -k, 1) - corners for k in (1, 2)]
    lengths = [np.linalg.norm(edge, axis=2) for edge in to]
    return np.degrees(np.arccos(np.clip((to[0] * to[1]).sum(2) / lengths[0] / lengths[1], -1, 1)))


def outline(triangles):
    """(k, 2) edges of one triangle only, in its direction."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    known = {tuple(edge) for edge in edges.tolist()}
    return edges[[(b, a) not in known for a, b in edges.tolist()]]


def loops(edges):
    """Number of closed rings that edges make, each point having as many in as out."""
    group = {point: point for point in np.unique(edges).tolist()}

    def root(point):
        while group[point] != point:
            group[point] = group[group[point]]
            point = group[point]
        return point

    for a, b in edges.tolist():
        group[root(a)] = root(b)
    return len({root(point) for point in group})


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("edge", [0.0, 3.0, 12.0])
def test_triangles_are_good_wherever_the_outline_lets_them(name, edge):
    vertices, triangles, uv = lissom.image_mesh(ALL[name], edge=edge)
    height, width = ALL[name].shape
    assert (vertices[:, 2] == 0).all() and (areas(vertices, triangles) > 0).all()
    assert np.allclose(uv * (width, height), vertices[:, :2]) and uv.min() >= 0 and uv.max() <= 1
    assert np.array_equal(np.unique(triangles), np.arange(len(vertices)))
    edges = outline(triangles)
    assert (np.bincount(edges[:, 0]) == np.bincount(edges[:, 1], minlength=edges[:, 0].max() + 1)).all()
    found = angles(vertices, triangles)
    inner = np.zeros(len(vertices))
    np.add.at(inner, triangles.ravel(), found.ravel())
    tips = np.flatnonzero(inner[np.unique(edges)] < TIP)
    assert name.startswith("noise") or not len(tips)
    assert found.min() >= ANGLE or len(tips)


@pytest.mark.parametrize("name", SMOOTH)
def test_area_and_outline_are_those_of_the_drawing(name):
    alpha = SMOOTH[name]
    height, width = alpha.shape
    made = lissom.image_mesh(alpha, edge=4.0)
    vertices, triangles, _ = made
    assert areas(vertices, triangles).sum() == pytest.approx(alpha.sum(), rel=0.015, abs=2)
    # Alpha a little inside and outside of the middles of the outline's edges, as the image says.
    edges = outline(triangles)
    along = vertices[edges[:, 1], :2] - vertices[edges[:, 0], :2]
    normal = np.stack([-along[:, 1], along[:, 0]], 1) / np.linalg.norm(along, axis=1, keepdims=True)
    middles = (vertices[edges[:, 0], :2] + vertices[edges[:, 1], :2]) / 2

    def at(places):
        x, y = places[:, 0] - 0.5, height - places[:, 1] - 0.5
        i, j = np.floor(x).astype(int), np.floor(y).astype(int)
        u, v = x - i, y - j

        def value(right, down):
            return alpha[np.clip(j + down, 0, height - 1), np.clip(i + right, 0, width - 1)]

        mixed = (1 - v) * ((1 - u) * value(0, 0) + u * value(1, 0))
        mixed += v * ((1 - u) * value(0, 1) + u * value(1, 1))
        outside = (x < -0.5) | (y < -0.5) | (x > width - 0.5) | (y > height - 0.5)
        return np.where(outside, 0.0, mixed)

    assert (at(middles + 0.5 * normal) >= 0.5).mean() > 0.99
    assert (at(middles - 0.5 * normal) < 0.5).mean() > 0.99


def test_a_disc_is_round_to_a_quarter_of_a_pixel():
    x, y = drawings.centres(130, 100)
    alpha = drawings.inked(drawings.disc(x, y, (62.3, 48.9), 40.7))
    vertices, triangles, _ = lissom.image_mesh(alpha)
    rim = vertices[np.unique(outline(triangles)), :2]
    assert np.abs(np.hypot(*(rim - (62.3, 48.9)).T) - 40.7).max() < 0.3


def test_edges_are_as_long_as_wanted():
    for edge in (3.0, 6.0, 12.0):
        vertices, triangles, _ = lissom.image_mesh(np.ones((120, 160)), edge=edge)
        sides = vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]
        lengths = np.linalg.norm(sides, axis=2)
        assert np.median(lengths) == pytest.approx(edge, rel=0.1) and lengths.max() < 2.2 * edge
        assert lengths.min() > 0.3 * edge


def test_islands_and_holes_are_kept():
    x, y = drawings.centres(200, 100)
    rings = [np.abs(drawings.disc(x, y, (50, 50), 25)) - 12, np.abs(drawings.disc(x, y, (140, 50), 30)) - 5]
    alpha = drawings.inked(np.minimum(np.minimum(*rings), drawings.disc(x, y, (140, 50), 12)))
    vertices, triangles, _ = lissom.image_mesh(alpha)
    assert loops(outline(triangles)) == 5
    assert lissom.Mesh(vertices, triangles).components == 3


def test_diagonal_lines_a_pixel_wide_hang_together():
    alpha = np.eye(30)
    made = lissom.image_mesh(alpha)
    assert lissom.Mesh(made.vertices, made.triangles).components == 1 and not made.warnings


def test_rows_are_from_the_top_and_border_is_met_at_right_angles():
    alpha = np.zeros((10, 20))
    alpha[:3] = 1.0
    vertices, _, uv = lissom.image_mesh(alpha)
    assert np.allclose([vertices.min(0), vertices.max(0)], [(0, 7, 0), (20, 10, 0)], atol=1e-9)
    assert np.allclose([uv.min(0), uv.max(0)], [(0, 0.7), (1, 1)])


@given(st.integers(0, 2**31), st.integers(1, 9), st.integers(1, 9), st.sampled_from([0.2, 0.5, 1.0]))
def test_any_small_image_gives_a_mesh_or_says_why_not(seed, width, height, threshold):
    random = np.random.default_rng(seed)
    alpha = np.round(random.random((height, width)) * random.integers(1, 5)) / 4
    try:
        vertices, triangles, _ = lissom.image_mesh(alpha, threshold=threshold, smallest=0.0)
    except lissom.InvalidValue as error:
        assert error.argument == "alpha" and (alpha < threshold).all()
    else:
        assert (alpha >= threshold).any() and (areas(vertices, triangles) > 0).all()


def test_specks_are_left_out_and_told():
    alpha = np.zeros((30, 30))
    alpha[5:25, 5:25] = 1
    alpha[2, 2] = alpha[28, 3] = 1
    made = lissom.image_mesh(alpha)
    assert made.warnings == ["2 specks and holes of less than 2 square pixels left out"]
    assert lissom.Mesh(made.vertices, made.triangles).components == 1
    every = lissom.image_mesh(alpha, smallest=0)
    assert not every.warnings and lissom.Mesh(every.vertices, every.triangles).components == 3


@pytest.mark.parametrize(
    "alpha, options, message",
    [
        (np.zeros((4, 5)), {}, "no pixel is as opaque as the threshold; the most opaque has 0.000"),
        (np.zeros((0, 5)), {}, "the image has no pixels"),
        (np.eye(3), {"smallest": 100.0}, "nothing opaque is as large as 100 square pixels"),
    ],
)
def test_images_that_show_nothing_are_refused(alpha, options, message):
    with pytest.raises(lissom.InvalidValue, match=f"^alpha: {message}") as error:
        lissom.image_mesh(alpha, **options)
    assert error.value.argument == "alpha"


@pytest.mark.parametrize("bad", [np.nan, np.inf, -0.1, 255.0])
def test_row_03_alpha_beyond_0_and_1_is_refused_with_its_places(bad):
    alpha = drawings.ring()
    alpha[2, 3] = alpha[7, 1] = bad
    with pytest.raises(lissom.InvalidValue, match=r"^alpha: ") as error:
        lissom.image_mesh(alpha)
    assert error.value.indices == [2 * alpha.shape[1] + 3, 7 * alpha.shape[1] + 1] and error.value.count == 2


def test_row_43_other_arrays():
    alpha = drawings.ring()
    known = lissom.image_mesh(alpha.astype(np.float32))
    for same in (np.asfortranarray(alpha.astype(np.float32)), alpha.astype(np.float32).astype(">f4")):
        assert np.array_equal(lissom.image_mesh(same).vertices, known.vertices)
    for shape in ((6,), (3, 4, 4)):
        with pytest.raises(ValueError, match=r"^alpha: expected shape \(n, m\)"):
            lissom.image_mesh(np.ones(shape))
    with pytest.raises(TypeError, match=r"^alpha: "):
        lissom.image_mesh(np.ones((4, 4), dtype=object))


def test_row_39_more_triangles_than_fit_are_refused():
    with pytest.raises(lissom.OutOfMemory, match=r"^the triangles would take"):
        lissom.image_mesh(np.ones((100, 100)), edge=1e-4)


# --- posed in the plane -------------------------------------------------------------------------------


def figure(seed: int):
    """A drawing with limbs, its mesh, and pins at its ends: alpha, ImageMesh, pins, their centres."""
    random = np.random.default_rng(seed)
    x, y = drawings.centres(220, 160)
    body = np.array([(60.0, 80.0), (160.0, 80.0)])
    ends = np.array([(25, 130), (25, 30), (195, 130), (195, 30)]) + random.uniform(-12, 12, (4, 2))
    limbs = [body, *([body[k // 2], end] for k, end in enumerate(ends))]
    alpha = drawings.inked(
        np.min([drawings.stroke(x, y, points, random.uniform(18, 26)) for points in limbs], 0)
    )
    made = lissom.image_mesh(alpha, edge=5.0)
    centres = np.array([(110.0, 80.0), *ends])
    pins = [np.flatnonzero(np.linalg.norm(made.vertices[:, :2] - c, axis=1) < 8) for c in centres]
    return made, pins, centres


def swung(centre, pivot, angle):
    """The motion of a pin that turns about a pivot."""
    back, there = (rigid(offset=(*(sign * np.asarray(pivot)), 0)) for sign in (-1, 1))
    return there @ rigid((0, 0, 1), angle) @ back


def motions(seed, centres):
    """The middle stays, and every limb swings about its joint."""
    random = np.random.default_rng(seed)
    pivots = [centres[0], (60, 80), (60, 80), (160, 80), (160, 80)]
    turns = [0.0, *random.uniform(-0.8, 0.8, 4)]
    return np.array([swung(c, p, a) for c, p, a in zip(centres, pivots, turns, strict=True)])


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_every_method_stays_in_the_plane_exactly(method):
    for seed in range(3):
        made, pins, centres = figure(seed)
        matrices = motions(seed, centres)
        pose = lissom.Pose(lissom.Mesh(made.vertices, made.triangles), pins, method=method)
        posed = pose.solve(matrices).vertices
        assert (posed[:, 2] == 0).all()
        assert np.abs(posed[pins[1]] - moved(matrices[1], made.vertices[pins[1]])).max() < 1e-9


@pytest.mark.parametrize("rotation", ["consistent", "relative"])
@pytest.mark.parametrize("refinement", [0, 4])
def test_no_triangle_of_a_path_is_flipped_and_all_lies_in_the_plane(rotation, refinement):
    for seed in range(6):
        made, pins, centres = figure(seed)
        mesh = lissom.Mesh(made.vertices, made.triangles)
        posed = lissom.Pose(mesh, pins).solve(motions(seed, centres)).vertices
        path = lissom.Inbetween(mesh, made.vertices, posed, rotation=rotation, refinement=refinement)
        shapes = path.at(np.linspace(0, 1, 50))
        assert (shapes[..., 2] == 0).all()
        assert (areas(shapes, made.triangles) > 0).all()
