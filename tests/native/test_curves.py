"""Curves as markers: edge paths and loops of both meshes that belong together."""

import lissom
import numpy as np
import pytest
from faces import diagonal, loop_through, neighbours, rings_from_border, triangulate
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import grid_faces
from test_fit_forgives import Head, carried, shuffled

FACE = 9409
# Landmarks that an artist would click: jaw, brows, nose, corners of eyes and mouth, lips.
CLICKED = [8, 4, 12, 0, 16, 17, 21, 22, 26, 27, 30, 33, 36, 39, 42, 45, 48, 54, 51, 57, 2]


class Cartoon:
    """The ICT face, and one drawn of it by a smooth map: eyes `tall` as high, the mouth `wide` as wide."""

    def __init__(self, data, tall, wide=1.0):
        archive = data("ict_face")
        faces = triangulate(archive["loops"], archive["counts"])
        faces = faces[(faces < FACE).all(axis=1)]
        self.rest = archive["neutral"][:FACE].astype(float)
        beside = neighbours(archive["loops"], archive["counts"], FACE)
        self.eyes = [loop_through(ring, beside) for ring in rings_from_border(faces, beside, 2)[:2]]
        self.mouth = loop_through(rings_from_border(faces, beside, 8)[2], beside)
        names = archive["expression_names"].tolist()
        offsets = archive["expressions"][:, :FACE].astype(float)
        self.blink = self.rest + sum(offsets[names.index(f"eyeBlink_{side}")] for side in "LR")
        self.drawn = self.draw(tall, wide)
        order = np.random.default_rng(1).permutation(FACE)
        self.place = np.argsort(order)  # of each vertex on the target, whose order tells nothing
        self.source = lissom.Mesh(self.rest, faces)
        self.target = lissom.Mesh(self.drawn[order], self.place[faces])
        marked = archive["landmarks"][CLICKED]
        self.markers = np.column_stack([marked, self.place[marked]])

    def draw(self, tall, wide):
        x, y, _ = self.rest.T
        drawn = self.rest.copy()
        for ring in self.eyes:
            middle = self.rest[ring].mean(axis=0)
            beside = np.exp(-(((x - middle[0]) / 2) ** 2))
            drawn[:, 1] += (tall - 1) * 0.8 * np.tanh((y - middle[1]) / 0.8) * beside
        level = np.exp(-(((y - self.rest[self.mouth][:, 1].mean()) / 3) ** 2))
        drawn[:, 0] += (wide - 1) * 2.5 * np.tanh(x / 2.5) * level
        return drawn

    def curves(self, which=("eyes", "mouth")):
        loops = (self.eyes if "eyes" in which else []) + ([self.mouth] if "mouth" in which else [])
        return [(loop, self.place[loop]) for loop in loops]

    def off(self, fit, vertices):
        """How far these are from where they belong at the mean, in percent of the diagonal."""
        away = np.linalg.norm((fit.fitted_vertices - self.drawn)[vertices], axis=1)
        return 100 * away.mean() / diagonal(self.drawn)

    def closed(self, shape, rest):
        """What is left of the distance between places of a rim that meet, at the median."""
        left = []
        for ring in self.eyes:
            ends = [np.linalg.norm(x[ring[1:], None] - x[None, ring[1:]], axis=2) for x in (shape, rest)]
            left.append(ends[0] / np.where(ends[1] > 0, ends[1], 1e-300))
            np.fill_diagonal(left[-1], np.inf)
        return np.median(np.concatenate([one.min(axis=1) for one in left]))

    def transferred_blink(self, fit, **options):
        shape = lissom.Transfer(self.source, self.target, fit, **options).apply([self.blink]).vertices[0]
        return self.closed(shape[self.place], self.drawn)


@pytest.fixture
def cartoon(data):
    return Cartoon(data, tall=3.0, wide=1.5)


@pytest.mark.parametrize("markers", ["markers", None])
def test_rims_of_a_cartoon_come_right_by_curves(cartoon, markers):
    marked = cartoon.markers if markers else None
    fits = [
        lissom.fit_correspondence(cartoon.source, cartoon.target, marked, curves=curves)
        for curves in ([], cartoon.curves())
    ]
    for rim in (cartoon.eyes[0], cartoon.eyes[1], cartoon.mouth):
        without, by = (cartoon.off(fit, rim) for fit in fits)
        print(f"{without:.3f} % without curves, {by:.3f} % by them")
        # By exact markers the shapes follow already, and lengths along a rim are not exact.
        assert by < (0.3 if markers else 0.5 * without)
    assert cartoon.off(fits[1], slice(None)) < cartoon.off(fits[0], slice(None))
    assert fits[1].report["flipped_triangles"] == 0 and not fits[1].report["warnings"]
    assert (fits[1].curve_distances < 5e-4 * diagonal(cartoon.drawn)).all()
    left = [cartoon.transferred_blink(fit, contact=True) for fit in fits]
    source = cartoon.closed(cartoon.blink, cartoon.rest)
    assert left[1] < 1.1 * source
    assert markers or left[0] > 1.1 * source


def test_where_a_loop_begins_and_which_way_it_goes_makes_no_difference(cartoon):
    fits = []
    for shift, way in ((0, 1), (5, 1), (40, -1)):
        turned = []
        for source, target in cartoon.curves():
            ring = np.roll(target[:-1], shift)[::way]
            turned.append((source, [*ring, ring[0]]))
        fits.append(lissom.fit_correspondence(cartoon.source, cartoon.target, cartoon.markers, curves=turned))
    for fit in fits[1:]:
        off = np.linalg.norm(fit.fitted_vertices - fits[0].fitted_vertices, axis=1)
        assert off.max() < 0.002 * diagonal(cartoon.drawn)


def test_exact_markers_and_curves(cartoon):
    fit = lissom.fit_correspondence(
        cartoon.source, cartoon.target, cartoon.markers, curves=cartoon.curves(), marker_tolerance=0.0
    )
    assert fit.marker_distances.max() < 1e-9
    assert (fit.curve_distances < 5e-4 * diagonal(cartoon.drawn)).all()


def test_a_curve_on_the_other_eye_is_named_and_left_out(cartoon):
    left, right, mouth = cartoon.curves()
    swapped = [(left[0], right[1]), mouth]
    fits = [
        lissom.fit_correspondence(cartoon.source, cartoon.target, cartoon.markers, curves=curves)
        for curves in (swapped, [mouth])
    ]
    assert fits[0].doubtful_curves.tolist() == [0] and fits[0].doubtful_markers.tolist() == []
    assert fits[0].doubtful_curve_percents[0] > 3 and not len(fits[0].unmet_curves)
    (told,) = fits[0].curve_warnings
    assert told.startswith("curves: number 0 is ") and told in fits[0].report["warnings"]
    for part in (cartoon.eyes[0], cartoon.mouth, slice(None)):
        assert cartoon.off(fits[0], part) < 1.05 * cartoon.off(fits[1], part)


@pytest.mark.parametrize(
    ("pairs", "wrong"),
    [
        ([(0, 1), (1, 0), (2, 2)], [0, 1]),
        ([(0, 1), (1, 0)], [0, 1]),
        ([(0, 0), (2, 1)], [1]),
        ([(0, 0), (1, 1), (2, 2), (2, 0)], [3]),
    ],
)
def test_without_markers_the_shapes_tell_which_curve_is_elsewhere(data, pairs, wrong):
    cartoon = Cartoon(data, tall=1.3, wide=1.1)
    right = cartoon.curves()
    curves = [(right[source][0], right[target][1]) for source, target in pairs]
    fits = [
        lissom.fit_correspondence(cartoon.source, cartoon.target, None, curves=curves)
        for curves in (curves, [curve for number, curve in enumerate(curves) if number not in wrong])
    ]
    assert fits[0].doubtful_curves.tolist() == wrong and not len(fits[0].unmet_curves)
    assert fits[0].report["flipped_triangles"] == 0
    assert cartoon.off(fits[0], slice(None)) < 1.05 * cartoon.off(fits[1], slice(None))


def sheet(size):
    """A hilly square of size x size vertices, number row * size + column."""
    y, x = np.divmod(np.arange(size * size), size) / np.array(size - 1.0)
    return np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(4 * y + 0.5)], 1), grid_faces(size, size)


def bump(seed):
    """A random smooth map near the identity."""
    random = np.random.default_rng(seed)
    waves, turns = random.normal(size=(2, 3, 3)) * [[[1.5]], [[3.0]]]
    sizes = random.normal(size=(3, 3)) * 0.05
    return lambda p: (
        p
        + sum(
            size * np.sin((p @ wave)[:, None] + turn)
            for wave, turn, size in zip(waves, turns, sizes, strict=True)
        )
    )


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.integers(3, 9), st.booleans(), st.booleans(), st.data())
def test_random_paths_and_loops_are_met(seed, size, closed, backwards, draw):
    """Around a square of cells, or along three sides of it; the target is mapped, and in another order."""
    vertices, faces = sheet(14)
    c, r = draw.draw(st.integers(1, 12 - size)), draw.draw(st.integers(1, 12 - size))
    sides = [
        *((c + i, r) for i in range(size)),
        *((c + size, r + i) for i in range(size)),
        *((c + size - i, r + size) for i in range(size)),
        *((c, r + size - i) for i in range(size if closed else 1)),
    ]
    path = np.array([14 * row + column for column, row in sides])
    mapped = bump(seed)(vertices) * 3 + [1, 2, 3]
    order = np.random.default_rng(seed).permutation(len(vertices))
    place = np.argsort(order)
    source, target = lissom.Mesh(vertices, faces), lissom.Mesh(mapped[order], place[faces])
    other = path[:: -1 if backwards else 1]
    if closed:
        other = np.roll(other, draw.draw(st.integers(0, len(path) - 1)))
        path, other = np.append(path, path[0]), np.append(other, other[0])
    corners = [0, 13, 14 * 13, 14 * 14 - 1]
    fit = lissom.fit_correspondence(
        source, target, np.column_stack([corners, place[corners]]), curves=[(path, place[other])]
    )
    assert not (len(fit.doubtful_curves) or len(fit.unmet_curves) or len(fit.reordered_curves))
    assert fit.curve_warnings == []
    assert fit.curve_distances[0] < 0.003 * diagonal(mapped)
    off = np.linalg.norm(fit.fitted_vertices[path] - mapped[path], axis=1)
    assert off.max() < 0.06 * diagonal(mapped), "nowhere near the other end"


def test_markers_on_a_path_divide_it():
    """Two halves of unlike proportions: the marker between them says where one ends."""
    vertices, faces = sheet(15)
    path = np.arange(7 * 15, 8 * 15)
    mapped = vertices.copy()
    mapped[:, 0] += 0.1 * np.sin(np.pi * vertices[:, 0])
    source, target = lissom.Mesh(vertices, faces), lissom.Mesh(mapped, faces[::-1])
    ends = [[0, 0], [14, 14], [210, 210], [224, 224]]
    off = []
    for markers in (ends, [*ends, [path[7], path[7]]]):
        fit = lissom.fit_correspondence(source, target, markers, curves=[(path, path)])
        off.append(np.linalg.norm((fit.fitted_vertices - mapped)[path], axis=1).mean() / diagonal(mapped))
    assert off[1] < 0.5 * off[0]


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        (([], [0, 1]), r"curves\[1\]: 0 source vertices"),
        (([0, 1], [3]), r"curves\[1\]: 1 target vertices"),
        (
            ([0, 1, 36], [0, 1]),
            r"curves\[1\]: source vertex out of range, the mesh has 36.*\(at 2; 1 in all",
        ),
        (
            ([0, 1], [0, 1, 99]),
            r"curves\[1\]: target vertex out of range, the mesh has 36.*\(at 2; 1 in all",
        ),
        (([0, 1, -1], [0, 1]), r"curves\[1\].*\(at 2; 1 in all\)"),
        (([0, 2, 3, 5], [0, 1]), r"curves\[1\]: no edge joins the source vertex.*\(at 1, 3; 2 in all\)"),
        (([0, 1, 2, 1], [0, 1]), r"curves\[1\]: source vertex comes twice.*\(at 3; 1 in all\)"),
        (([0, 1, 0], [0, 1]), r"curves\[1\]: source vertex comes twice.*\(at 2; 1 in all\)"),
        (([0, 1, 7, 6, 0], [0, 1, 2]), r"curves\[1\]: the source's is a loop, the target's a path"),
        (([0, 1], [0, 1, 7, 6, 0]), r"curves\[1\]: the target's is a loop, the source's a path"),
    ],
)
def test_what_is_no_curve_is_refused_with_the_numbers(curve, message):
    mesh = lissom.Mesh(*sheet(6))
    with pytest.raises(lissom.InvalidConstraint, match=message):
        lissom.fit_correspondence(mesh, mesh, [[0, 0], [5, 5], [30, 30]], curves=[([0, 1], [0, 1]), curve])


@pytest.mark.parametrize("curves", [3, [3], [([0, 1],)], [([0, 1], [0, 1], [0, 1])], [([0.5], [0, 1])]])
def test_what_is_not_even_vertices_is_a_type_error(curves):
    mesh = lissom.Mesh(*sheet(6))
    with pytest.raises(TypeError, match="curves"):
        lissom.fit_correspondence(mesh, mesh, [[0, 0], [5, 5], [30, 30]], curves=curves)


def relief(seed, size=33):
    """A square of size x size vertices with random hills, and the same mapped, in another order."""
    random = np.random.default_rng(seed)
    y, x = np.divmod(np.arange(size * size), size) / np.array((size - 1) / 2.0) - 1
    middles, widths, heights = (
        random.uniform(low, high, (9, k)) for low, high, k in ((-0.8, 0.8, 2), (0.15, 0.3, 1), (-0.3, 0.4, 1))
    )
    away = ((np.stack([x, y], 1)[:, None] - middles) ** 2).sum(-1)
    z = 0.6 * np.cos(x) * np.cos(y) + (heights.T * np.exp(-away / widths.T**2)).sum(1)
    rest = np.stack([x, y, z], 1)
    mapped = bump(seed + 1)(rest / 3) * 3
    order = random.permutation(len(rest))
    place = np.argsort(order)
    return rest, mapped, grid_faces(size, size), order, place


@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_by_few_markers_curves_that_are_cut_short_or_beside_are_named_and_left_out(seed, markers):
    rest, mapped, faces, order, place = relief(seed)
    source, target = lissom.Mesh(rest, faces), lissom.Mesh(mapped[order], place[faces])
    path = 33 * 12 + np.arange(8, 25)
    wrong = {"cut short": path[:-4], "beside": path + 33 * 5}
    corners = np.array([70, 1000, 900])
    marked = np.column_stack([corners, place[corners]]) if markers else None

    def fitted(*others):
        curves = [(path, place[other]) for other in others]
        fit = lissom.fit_correspondence(source, target, marked, curves=curves)
        return fit, np.linalg.norm(fit.fitted_vertices - mapped, axis=1).mean() / diagonal(mapped)

    _, without = fitted()
    right, by_right = fitted(path)
    # By curves the source keeps to where it lies, without any it slides: either may be nearer.
    assert not right.report["warnings"] and by_right < 1.2 * without
    for other in wrong.values():
        fit, off = fitted(other)
        assert fit.doubtful_curves.tolist() == [0] and fit.doubtful_curve_percents[0] > 1
        assert fit.curve_warnings == fit.report["warnings"] and "left out" in fit.curve_warnings[0]
        # Where its middle lies has been asked for how the meshes lie.
        assert off < 1.4 * without


def test_curves_do_not_make_keys_turn_along_by_the_shapes(data):
    """A mouth alone tells no turn: by it keys of this person were turned by 8 degrees."""
    head = Head(data)
    vertices, faces, place, order = shuffled(head.person(3), head.faces)
    mouth = Cartoon(data, 1.0).mouth
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    errors = []
    for curves in ([], [(mouth, place[mouth])]):
        _, keys = carried(source, target, None, head.rest + head.offsets, curves=curves)
        errors.append(np.median(head.errors(keys, vertices, head.offsets[:, order])))
    assert errors[1] < 1.1 * errors[0]
