"""Contact: what comes together on the source comes together on a target that is further apart."""

import lissom
import numpy as np
import pytest
from faces import root_mean_square, triangulate

LENGTH, COLUMNS = 20.0, 21


def lips(opening, around):
    """A thick C, drawn out along x, whose ends face each other across `opening` (radians).

    Returns vertices, faces and for each vertex its angle from the middle of the opening, in -pi to pi.
    """
    half = opening / 2
    outer = np.linspace(half, 2 * np.pi - half, around)
    rim = np.linspace(1.0, 0.7, 5)[1:-1]
    angles = np.concatenate([outer, np.full(3, outer[-1]), outer[::-1], np.full(3, outer[0])])
    radii = np.concatenate([np.ones(around), rim, np.full(around, 0.7), rim[::-1]])
    points = len(angles)
    x = np.linspace(0, LENGTH, COLUMNS)
    vertices = np.array(
        [(at, r * np.sin(a), r * np.cos(a)) for at in x for a, r in zip(angles, radii, strict=True)]
    )
    faces = []
    for c in range(COLUMNS - 1):
        for p in range(points):
            q = (p + 1) % points
            a, b, d, e = c * points + p, c * points + q, (c + 1) * points + q, (c + 1) * points + p
            faces += [(a, b, d), (a, d, e)]
    return vertices, np.array(faces), np.tile(np.where(angles > np.pi, angles - 2 * np.pi, angles), COLUMNS)


def closed(vertices, angle, by):
    """Both halves turned towards the opening, the more the nearer they are to it."""
    turn = -np.sign(angle) * by * (1 - np.abs(angle) / np.pi)
    y, z = vertices[:, 1], vertices[:, 2]
    turned = np.column_stack([np.sin(turn) * z + np.cos(turn) * y, np.cos(turn) * z - np.sin(turn) * y])
    return np.column_stack([vertices[:, 0], turned])


SOURCE, FACES, ANGLE = lips(0.5, 60)
TARGET, OTHER, OTHER_ANGLE = lips(0.8, 47)
CLOSED = closed(SOURCE, ANGLE, 0.25 / (1 - 0.25 / np.pi) * 0.98)


def fitted():
    """Marked along both rims and the back, at both ends and in between."""
    pairs = []
    for column in (0, 5, 10, 15, 20):
        rows, others = (column * (len(v) // COLUMNS) for v in (SOURCE, TARGET))
        for place, other in ((0, 0), (59, 46), (30, 23), (63, 50), (122, 96), (15, 12), (45, 35)):
            pairs.append((rows + place, others + other))
    source, target = lissom.Mesh(SOURCE, FACES), lissom.Mesh(TARGET, OTHER)
    return source, target, lissom.fit_correspondence(source, target, pairs)


def gap(vertices):
    """Mean distance between the two rims."""
    row = vertices.reshape(COLUMNS, -1, 3)
    first = np.concatenate([row[:, :1], row[:, :-4:-1], row[:, -4:-3]], axis=1)
    around = (row.shape[1] - 6) // 2
    last = row[:, around - 1 : around + 4]
    return np.linalg.norm(first - last, axis=2).mean()


def test_rims_that_meet_on_the_source_meet_on_a_target_that_is_further_apart():
    source, target, fit = fitted()
    left = {}
    for contact in (False, True):
        transfer = lissom.Transfer(source, target, fit, contact=contact)
        result = transfer.apply([CLOSED]).vertices
        quality = transfer.quality([CLOSED], result)
        assert quality["contacts"][0] > 50
        left[contact] = gap(result[0]), quality["contact_gap"][0]
    assert gap(CLOSED) < 0.03 * gap(SOURCE)
    assert left[False][0] > 0.2 * gap(TARGET), "nothing to show"
    assert left[True][0] < 0.2 * left[False][0]
    assert left[True][1] < 0.2 * left[False][1]


@pytest.mark.parametrize("part", [0.25, 0.5, 0.75])
def test_openings_close_by_the_same_part_of_their_own_height(part):
    """By the gradients alone the wider opening closes by as much as the narrower one, which is less of it."""
    source, target, fit = fitted()
    key = SOURCE + part * (CLOSED - SOURCE)
    wanted = 1 - gap(key) / gap(SOURCE)
    closes = {}
    for contact in (False, True):
        transfer = lissom.Transfer(source, target, fit, contact=contact)
        result = transfer.apply([key]).vertices
        closes[contact] = 1 - gap(result[0]) / gap(TARGET)
        assert abs(transfer.quality([key], result).closing[0] * wanted - closes[contact]) < 0.1
    assert closes[False] < 0.85 * wanted, "nothing to show"
    assert abs(closes[True] - wanted) < 0.06


def test_keys_that_bring_nothing_together_stay_as_they_are():
    source, target, fit = fitted()
    wider = closed(SOURCE, ANGLE, -0.2)
    results = [
        lissom.Transfer(source, target, fit, contact=contact).apply([wider, SOURCE]).vertices
        for contact in (False, True)
    ]
    assert np.array_equal(*results)
    assert np.array_equal(results[1][1], TARGET)


@pytest.mark.parametrize("contact", [False, True])
def test_what_does_not_move_stays_put_exactly(contact):
    source, target, fit = fitted()
    ends = SOURCE[:, :1] > LENGTH / 2
    key = np.where(ends, CLOSED, SOURCE)
    result = lissom.Transfer(source, target, fit, contact=contact).apply([key]).vertices[0]
    behind = TARGET[:, 0] < 0.4 * LENGTH
    assert np.array_equal(result[behind], TARGET[behind])
    assert not np.array_equal(result, TARGET)


def ball(centre, radius, rings=12, around=20):
    """A closed sphere."""
    polar, turn = np.meshgrid(
        np.linspace(0, np.pi, rings + 1)[1:-1], np.arange(around) * 2 * np.pi / around, indexing="ij"
    )
    points = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    points = np.concatenate([points.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    top, bottom = len(points) - 2, len(points) - 1
    faces = []
    for a in range(around):
        b = (a + 1) % around
        faces.append((top, a, b))
        for r in range(rings - 2):
            p, q = r * around, (r + 1) * around
            faces += [(p + a, q + a, q + b), (p + a, q + b, p + b)]
        last = (rings - 2) * around
        faces.append((last + a, bottom, last + b))
    return centre + radius * points, np.array(faces)


def test_what_closes_goes_around_a_solid_part_of_the_target():
    centre, radius = np.array([LENGTH / 2, 0.0, 0.9]), 0.2
    points, faces = ball(centre, radius)
    vertices = np.concatenate([TARGET, points])
    own = np.arange(len(TARGET), len(vertices))
    target = lissom.Mesh(vertices, np.concatenate([OTHER, faces + len(TARGET)]))
    source = fitted()[0]
    pairs = [
        (column * (len(SOURCE) // COLUMNS) + a, column * (len(TARGET) // COLUMNS) + b)
        for column in (0, 5, 10, 15, 20)
        for a, b in ((0, 0), (59, 46), (30, 23), (63, 50), (122, 96), (15, 12), (45, 35))
    ]
    fit = lissom.fit_correspondence(source, target, pairs, target_mask=own)
    deepest = {}
    for contact in (False, True):
        transfer = lissom.Transfer(source, target, fit, contact=contact, unmatched="rest")
        result = transfer.apply([CLOSED]).vertices[0]
        assert np.array_equal(result[own], points)
        deepest[contact] = radius - np.linalg.norm(result[: len(TARGET)] - centre, axis=1).min()
    assert np.linalg.norm(TARGET - centre, axis=1).min() > radius
    assert deepest[False] > 0.3 * radius, "nothing to show"
    assert deepest[True] < 0.1 * radius


def test_contact_does_no_harm_where_the_answer_is_known(data):
    """Eyes as high as this person's size makes them close by the gradients: nothing changes, to the bit."""
    archive = data("ict_face")
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    faces = triangulate(archive["loops"], archive["counts"])
    names = archive["expression_names"].tolist()
    wanted = ("eyeBlink_L", "eyeLookDown_R", "eyeSquint_L", "jawOpen", "mouthClose", "mouthRollUpper")
    offsets = archive["expressions"][[names.index(name) for name in wanted]].astype(float)
    known = neutral + archive["identities"][1]
    source, target = lissom.Mesh(neutral, faces), lissom.Mesh(known, faces[::-1])
    fit = lissom.fit_correspondence(source, target, np.column_stack([landmarks, landmarks]))
    without, with_it = (
        lissom.Transfer(source, target, fit, contact=contact).apply(neutral + offsets).vertices
        for contact in (False, True)
    )
    assert np.array_equal(without, with_it)
    error = [
        root_mean_square((shape - known - offset)[:9409]) / root_mean_square(offset[:9409])
        for shape, offset in zip(with_it, offsets, strict=True)
    ]
    assert max(error) < 0.05
