"""A fit from imprecise markers, with parts that one side lacks, turned, and without markers: ICT people.

They are random sums of the identity modes; errors are relative to those of perfect correspondence, which
the same faces give, in the same run.
"""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square, triangulate

FACE, SKIN = 9409, 14062  # vertices of the face come first, then what else is skin
MOUTH = 11240, 13294  # the socket of the mouth
# Of the 68 landmarks of the iBUG scheme, those that say where what is.
FEW = {
    21: [0, 4, 8, 12, 16, 19, 21, 24, 27, 30, 33, 36, 39, 42, 45, 48, 51, 54, 57, 62, 66],
    13: [0, 8, 16, 27, 30, 36, 39, 42, 45, 48, 51, 54, 57],
}


class Head:
    """The first `count` vertices of the ICT head: rest, faces, offsets of expressions, landmarks."""

    def __init__(self, data, count=FACE):
        archive = data("ict_face")
        faces = triangulate(archive["loops"], archive["counts"])
        self.rest = archive["neutral"][:count].astype(float)
        self.faces = faces[(faces < count).all(axis=1)]
        names = [str(name) for name in archive["expression_names"]]
        wanted = [k for k, name in enumerate(names) if not name.startswith(("Pupil", "cheekRaiser"))]
        # Every fourth tells as much as all of them.
        self.offsets = archive["expressions"][wanted[::4], :count].astype(float)
        self.landmarks = archive["landmarks"][archive["landmarks"] < count]
        self.modes = data("ict_identities")["modes"][:, :count].astype(float)

    def person(self, seed):
        """(n, 3) somebody of the same faces."""
        amounts = np.random.default_rng(seed).normal(size=len(self.modes))
        return self.rest + np.tensordot(amounts, self.modes, 1)

    def errors(self, vertices, rest, offsets, where=slice(None)):
        """(k,) of the expressions that move anything there."""
        sizes = np.array([root_mean_square(offset[where]) for offset in offsets])
        off = [root_mean_square(((x - rest) - o)[where]) for x, o in zip(vertices, offsets, strict=True)]
        return (np.array(off) / np.maximum(sizes, 1e-300))[sizes > 1e-3]

    def best(self, person):
        """What perfect correspondence leaves, at the median."""
        source, target = lissom.Mesh(self.rest, self.faces), lissom.Mesh(person, self.faces)
        fit = lissom.fit_correspondence(source, target, np.zeros((0, 2), int))
        keys = lissom.Transfer(source, target, fit).apply(self.rest + self.offsets).vertices
        return np.median(self.errors(keys, person, self.offsets))


def shuffled(vertices, faces):
    """The same surface in another order: vertices, faces, new place of each old vertex and the reverse."""
    order = np.random.default_rng(1).permutation(len(vertices))
    place = np.argsort(order)
    return vertices[order], place[faces], place, order


def part(vertices, faces, kept):
    """The faces of kept vertices: vertices, faces, new place of each old vertex or -1, and the reverse."""
    faces = faces[kept[faces].all(axis=1)]
    used = np.unique(faces)
    place = np.full(len(vertices), -1)
    place[used] = np.arange(len(used))
    return vertices[used], place[faces], place, used


def clicked(points, vertices, faces, amount, seed):
    """Points off by a normal error of root mean square `amount` of the diagonal, back on the surface."""
    random = np.random.default_rng(seed)
    away = points + random.normal(size=points.shape) * amount * diagonal(vertices) / np.sqrt(3)
    dense = np.concatenate([vertices, vertices[faces].mean(axis=1)])
    return dense[[np.argmin(((dense - point) ** 2).sum(axis=1)) for point in away]]


def carried(source, target, markers, poses, points=None, **options):
    fit = lissom.fit_correspondence(source, target, markers, points, **options)
    return fit, lissom.Transfer(source, target, fit).apply(poses).vertices


@pytest.mark.parametrize(
    ("seed", "amounts"),  # 2 % of the diagonal is the breadth of a nostril
    [(1, {0.005: 1.15, 0.02: 1.3}), (2, {0.0025: 1.15, 0.01: 1.15})],
)
def test_clicks_that_are_off_cost_little(data, seed, amounts):
    head = Head(data)
    person, source = head.person(seed), lissom.Mesh(head.rest, head.faces)
    vertices, faces, place, order = shuffled(person, head.faces)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    best = head.best(person)
    for amount, most in amounts.items():
        points = clicked(person[head.landmarks], person, head.faces, amount, seed)
        fit, keys = carried(source, lissom.Mesh(vertices, faces), markers, head.rest + head.offsets, points)
        times = np.median(head.errors(keys, vertices, head.offsets[:, order])) / best
        assert times < most, f"{100 * amount} % off: {times} times the best"
        assert fit.report["flipped_triangles"] == 0


@pytest.mark.parametrize(("seed", "count", "noise"), [(2, 21, 1), (6, 13, 2), (7, 13, 1), (8, 13, 1)])
def test_few_clicks_that_are_far_off_are_not_taken_for_other_proportions(data, seed, count, noise):
    head = Head(data)
    person = head.person(seed)
    vertices, faces, place, _ = shuffled(person, head.faces)
    chosen = head.landmarks[FEW[count]]
    points = clicked(person[chosen], person, head.faces, 0.02, 1000 * noise + seed)
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    fit = lissom.fit_correspondence(source, target, np.column_stack([chosen, place[chosen]]), points)
    away = np.linalg.norm(fit.fitted_vertices - person, axis=1) / diagonal(person)
    # Where the last three were followed, 0.73 to 0.76 %.
    assert 100 * away.mean() < 0.5


@pytest.mark.parametrize(
    ("of_source", "of_target", "most"),
    [
        ("face", "skin", 1.1),
        ("skin", "face", 1.1),
        ("skin", "lower half", 1.1),
    ],
)
def test_what_only_one_side_has_pulls_and_holds_nothing(data, of_source, of_target, most):
    head = Head(data, SKIN)
    person = head.person(3)
    face = np.arange(SKIN) < FACE
    kept = {"face": face, "skin": np.full(SKIN, True), "lower half": face & (person[:, 1] < -1)}
    own, own_faces, own_place, own_order = part(head.rest, head.faces, kept[of_source])
    vertices, faces, place, order = part(person, head.faces, kept[of_target])
    vertices, faces, moved, mixed = shuffled(vertices, faces)
    both = head.landmarks[(own_place[head.landmarks] >= 0) & (place[head.landmarks] >= 0)]
    markers = np.column_stack([own_place[both], moved[place[both]]])
    poses = own + head.offsets[:, own_order]
    fit, keys = carried(lissom.Mesh(own, own_faces), lissom.Mesh(vertices, faces), markers, poses)
    vertex = order[mixed]
    on = kept[of_source][vertex] & face[vertex]
    best = Head(data).best(person[:FACE])
    times = np.median(head.errors(keys, vertices, head.offsets[:, vertex], on)) / best
    assert times < most, f"{times} times the best"
    assert fit.report["flipped_triangles"] == 0
    assert not fit.report["warnings"], "markers that are right are not blamed"


def test_a_mouth_masked_on_both_costs_the_face_nothing(data):
    head = Head(data, SKIN)
    vertices, faces, place, order = shuffled(head.rest, head.faces)
    inside = np.arange(*MOUTH)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    fit, keys = carried(
        lissom.Mesh(head.rest, head.faces),
        lissom.Mesh(vertices, faces),
        markers,
        head.rest + head.offsets,
        source_mask=inside,
        target_mask=place[inside],
    )
    errors = head.errors(keys, vertices, head.offsets[:, order], order < FACE)
    assert np.median(errors) < 0.005
    assert fit.report["flipped_triangles"] == 0


@pytest.mark.parametrize("degrees", [10, 30, 90])
def test_a_turned_target_gets_turned_keys(data, degrees):
    head = Head(data)
    angle = np.radians(degrees)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    vertices, faces, place, order = shuffled(head.person(4), head.faces)
    source = lissom.Mesh(head.rest, head.faces)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    found = []
    for by in (np.eye(3), turn):
        target = lissom.Mesh(vertices @ by.T, faces)
        _, keys = carried(source, target, markers, head.rest + head.offsets)
        found.append(np.median(head.errors(keys, vertices @ by.T, head.offsets[:, order] @ by.T)))
    assert found[1] < 1.05 * found[0]


def test_without_markers_the_shapes_tell(data):
    head = Head(data)
    source = lissom.Mesh(head.rest, head.faces)
    for seed in (1, 3, 5):  # with half the rounds the lips of the second are pulled beside the target's
        person = head.person(seed)
        vertices, faces, _, order = shuffled(person * 0.01 + 3, head.faces)
        fit, keys = carried(source, lissom.Mesh(vertices, faces), None, head.rest + head.offsets)
        assert fit.report["certainty"] > 0.9 and not fit.report["warnings"]
        errors = head.errors(keys * 100, vertices * 100, head.offsets[:, order])
        assert np.median(errors) < 1.25 * head.best(person)
    lion = data("cat_lion")
    lion = lissom.Mesh(lion["lion_reference"], lion["lion_faces"])
    with pytest.raises(lissom.InvalidConstraint, match="too little in common"):
        lissom.fit_correspondence(source, lion)


@pytest.mark.parametrize("half", ["source", "target"])
def test_half_a_head_without_markers_does_not_tilt_the_keys(data, half):
    head = Head(data, SKIN)
    person = head.person(3)
    whole, left = np.full(SKIN, True), head.rest[:, 0] > -1e-6
    kept = [left, whole] if half == "source" else [whole, left]
    own, own_faces, _, own_order = part(head.rest, head.faces, kept[0])
    vertices, faces, _, order = part(person, head.faces, kept[1])
    vertices, faces, _, mixed = shuffled(vertices, faces)
    poses = own + head.offsets[:, own_order]
    _, keys = carried(lissom.Mesh(own, own_faces), lissom.Mesh(vertices, faces), None, poses)
    vertex = order[mixed]
    errors = head.errors(keys, vertices, head.offsets[:, vertex], left[vertex] & (vertex < FACE))
    # Measured 1.59 and 1.40; 1.64 and 1.96 where keys turned by what half a face seems to be turned by, and
    # 1.53 for the second where what of the source has no counterpart told it as well.
    assert np.median(errors) < 1.6 * Head(data).best(person[:FACE])


@pytest.mark.parametrize("wrong", [[33], [48, 54]])
def test_a_wrong_marker_is_named_and_left_out(data, wrong):
    head = Head(data)
    person = head.person(5)
    vertices, faces, place, order = shuffled(person, head.faces)
    points = person[head.landmarks].copy()
    if len(wrong) == 1:  # 5 % of the diagonal off
        points[wrong[0]] += np.array([0.9, 0.4, 0.0]) * 0.05 * diagonal(person)
    else:  # left and right corner of the mouth exchanged
        points[wrong] = points[wrong[::-1]]
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    source = lissom.Mesh(head.rest, head.faces)
    fit, keys = carried(source, lissom.Mesh(vertices, faces), markers, head.rest + head.offsets, points)
    assert fit.doubtful_markers.tolist() == wrong
    for number in wrong:
        named = f"number {number} (source vertex {head.landmarks[number]})"
        assert any(named in warning for warning in fit.report["warnings"])
    assert np.median(head.errors(keys, vertices, head.offsets[:, order])) < 1.15 * head.best(person)


def test_more_rounds_do_not_make_it_worse(data):
    head = Head(data)
    person = head.person(2)
    vertices, faces, place, order = shuffled(person, head.faces)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    points = clicked(person[head.landmarks], person, head.faces, 0.01, 2)
    source = lissom.Mesh(head.rest, head.faces)
    few, many = (
        head.errors(
            carried(
                source, lissom.Mesh(vertices, faces), markers, head.rest + head.offsets, points, rounds=rounds
            )[1],
            vertices,
            head.offsets[:, order],
        )
        for rounds in (4, 16)
    )
    # Measured 1.05 and 1.0: what is left between them is noise of the clicks. By closest points it was 2.5.
    assert np.median(many) < 1.1 * np.median(few)
    assert np.percentile(many, 90) < 1.1 * np.percentile(few, 90)


def test_markers_far_outside_are_named_and_left_out(data):
    head = Head(data)
    person = head.person(1)
    vertices, faces, place, order = shuffled(person, head.faces)
    wrong = [8, 30, 36, 45, 57]
    points = person[head.landmarks].copy()
    points[wrong] += np.random.default_rng(0).normal(size=(len(wrong), 3)) * diagonal(person)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    source = lissom.Mesh(head.rest, head.faces)
    fit, keys = carried(source, lissom.Mesh(vertices, faces), markers, head.rest + head.offsets, points)
    assert fit.doubtful_markers.tolist() == wrong
    assert np.median(head.errors(keys, vertices, head.offsets[:, order])) < 1.1 * head.best(person)


@pytest.mark.parametrize("where", ["left half", "round one eye", "on one line"])
def test_markers_all_in_one_place_do(data, where):
    head = Head(data)
    person = head.person(1)
    vertices, faces, place, order = shuffled(person, head.faces)
    chosen = {
        "left half": head.landmarks[head.rest[head.landmarks, 0] > 1],
        "round one eye": head.landmarks[36:42],
        "on one line": head.landmarks[27:31],
    }[where]
    source = lissom.Mesh(head.rest, head.faces)
    markers = np.column_stack([chosen, place[chosen]])
    fit, keys = carried(source, lissom.Mesh(vertices, faces), markers, head.rest + head.offsets)
    assert np.median(head.errors(keys, vertices, head.offsets[:, order])) < 1.25 * head.best(person)
    assert fit.report["flipped_triangles"] == 0


def cartoon(head, much):
    """A head with eyes and mouth grown and the chin drawn in, by a smooth map of space."""
    rest, of = head.rest, head.rest[head.landmarks]
    eyes = [(of[36:42].mean(0), 0.09, (0.7, 0.7, 0.35)), (of[42:48].mean(0), 0.09, (0.7, 0.7, 0.35))]
    drawn = rest.copy()
    for centre, size, growth in [
        *eyes,
        (of[8], 0.15, (-0.35, -0.1, 0.0)),
        (of[48:60].mean(0), 0.08, (0.4, 0.12, 0.0)),
    ]:
        away = drawn - centre
        near = np.exp(-0.5 * (away**2).sum(axis=1) / (size * diagonal(rest)) ** 2)
        drawn = drawn + much * near[:, None] * away * np.array(growth)
    return drawn


@pytest.mark.parametrize(
    ("much", "off", "amount", "tolerance"),
    [(1, 0.4, 0, 0.01), (1.5, 0.75, 0, 0.004), (1.5, 0.75, 0.005, 0.01), (2, 1.2, 0.005, 0.01)],
)
def test_other_proportions_are_told_by_few_markers(data, much, off, amount, tolerance):
    head = Head(data)
    drawn = cartoon(head, much)
    vertices, faces, place, _ = shuffled(drawn, head.faces)
    chosen = head.landmarks[[8, 0, 16, 19, 24, 30, 36, 37, 39, 41, 42, 44, 45, 46, 48, 54, 57]]
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    markers = np.column_stack([chosen, place[chosen]])
    points = clicked(drawn[chosen], drawn, head.faces, amount, 3) if amount else None
    fit = lissom.fit_correspondence(source, target, markers, points, marker_tolerance=tolerance)
    away = np.linalg.norm(fit.fitted_vertices - drawn, axis=1) / diagonal(drawn)
    # Where the markers let go, 0.59, 1.14 and 3.3 %.
    assert 100 * away.mean() < off
    if much == 1:
        assert 100 * away.max() < 2  # 3.4 where borders are free to slide.
    assert fit.report["flipped_triangles"] == 0


def test_a_fit_beside_the_target_is_never_sure(data):
    head = Head(data)
    person = head.person(1)
    vertices, faces, place, _ = shuffled(person, head.faces)
    points = person[head.landmarks] + np.array([10.0, 0.0, 0.0]) * diagonal(person)
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    fit = lissom.fit_correspondence(source, target, markers, points)
    assert fit.report["certainty"] < 0.5
    assert any("beside the target" in warning for warning in fit.report["warnings"])
    assert any("the fit has failed" in warning for warning in fit.report["warnings"])
    with pytest.raises(lissom.InvalidConstraint, match="no source triangle is matched"):
        lissom.Transfer(source, target, fit)


@pytest.mark.parametrize("wrong", ["left and right exchanged", "shuffled", "all at one point"])
def test_markers_that_are_all_wrong_get_a_warning(data, wrong):
    head = Head(data)
    person = head.person(1)
    vertices, faces, place, _ = shuffled(person, head.faces)
    points = person[head.landmarks].copy()
    if wrong == "left and right exchanged":
        points = mirrored(points)
    elif wrong == "shuffled":
        points = points[np.random.default_rng(2).permutation(len(points))]
    else:
        points[:] = points[30]
    markers = np.column_stack([head.landmarks, place[head.landmarks]])
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    fit = lissom.fit_correspondence(source, target, markers, points)
    assert fit.report["flipped_triangles"] > 100
    assert any("face against the target" in warning for warning in fit.report["warnings"])


@pytest.mark.parametrize("wrong", ["all", "one side", "every fifth"])
@pytest.mark.parametrize("count", [68, 7, 0])
def test_faces_that_look_the_wrong_way_cost_nothing(data, wrong, count):
    head = Head(data, SKIN)
    person = head.person(3)
    vertices, faces, place, order = shuffled(person, head.faces)
    over = {
        "all": np.full(len(faces), True),
        "one side": vertices[faces].mean(axis=1)[:, 0] > 1.0,
        "every fifth": np.random.default_rng(0).random(len(faces)) < 0.2,
    }[wrong]
    turned = np.where(over[:, None], faces[:, ::-1], faces)
    landmarks = head.landmarks[:: 68 // count] if count else []
    markers = np.column_stack([landmarks, place[landmarks]]) if count else None
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, turned)
    fit, keys = carried(source, target, markers, head.rest + head.offsets)
    assert np.median(head.errors(keys, vertices, head.offsets[:, order])) < 1.1 * head.best(person)
    assert fit.report["flipped_triangles"] == 0 and fit.report["certainty"] > 0.9
    assert any("inside out" in told for told in fit.report["warnings"]) == (wrong == "all")


def mirrored(points):
    """Each of the face's landmarks at the place of the one that is its like on the other side."""
    across = points * [-1, 1, 1] + [2 * points[27:31, 0].mean(), 0, 0]
    return points[[np.argmin(((points - point) ** 2).sum(axis=1)) for point in across]]


@pytest.mark.parametrize("other", ["square", "stanford-bunny"])
def test_targets_with_nothing_in_common_are_refused_without_markers(data, other):
    if other == "square":
        x, y = (axis.ravel() for axis in np.meshgrid(np.arange(40.0), np.arange(40.0)))
        number = np.arange(1600).reshape(40, 40)
        a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
        faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        target = lissom.Mesh(np.column_stack([x, y, 0 * x]), faces)
    else:
        models = data("models")
        target = lissom.Mesh(models[f"{other}_vertices"], models[f"{other}_faces"])
    head = Head(data)
    with pytest.raises(lissom.InvalidConstraint, match="too little in common"):
        lissom.fit_correspondence(lissom.Mesh(head.rest, head.faces), target)
