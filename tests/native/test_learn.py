"""Corrected keys teach the others: people with known answers, identities, and what is refused.

People are random sums of the ICT face's identity modes, to whom its expressions are transferred by 68
markers. What is right is known: the expressions by themselves, or as a face of its own has them, stronger
here and weaker there, turned and crooked, by fields that are smooth over the face.
"""

import lissom
import numpy as np
import pytest
from faces import diagonal, root_mean_square
from test_fit_forgives import Head, carried, shuffled

# Five keys as an artist would correct them first: what moves brows, lids, jaw and lips.
TAUGHT = [
    ["jawOpen", "mouthSmile_L", "mouthSmile_R", "browInnerUp_L", "browInnerUp_R"],
    ["jawOpen", "mouthPucker", "eyeBlink_L", "eyeBlink_R", "mouthFrown_L"],
]


class Person:
    """Somebody with keys as they were transferred: vertices, faces, names, offsets, and what is right."""

    def __init__(self, data, seed):
        head, archive = Head(data), data("ict_face")
        names = [str(name) for name in archive["expression_names"]]
        wanted = [k for k, name in enumerate(names) if not name.startswith(("Pupil", "cheekRaiser"))]
        self.names = [names[k] for k in wanted]
        offsets = archive["expressions"][wanted, : len(head.rest)].astype(float)
        self.vertices, self.faces, place, order = shuffled(head.person(seed), head.faces)
        self.mesh = lissom.Mesh(self.vertices, self.faces)
        markers = np.column_stack([head.landmarks, place[head.landmarks]])
        source = lissom.Mesh(head.rest, head.faces)
        _, keys = carried(source, self.mesh, markers, head.rest + offsets)
        self.made, self.plain = keys - self.vertices, offsets[:, order]

    def own(self, seed, amount):
        """(k, n, 3) the expressions as a face of its own has them."""
        fields = amount * waves(self.vertices, seed, 7)
        return np.array(
            [
                (1 + fields[:, :1]) * d + np.cross(0.5 * fields[:, 1:4], d) + 0.5 * fields[:, 4:7] * d
                for d in self.plain
            ]
        )

    def learned(self, right, taught):
        """Errors (k - 5,) of the keys that were not corrected, before and after; and the result."""
        places = [self.names.index(name) for name in taught]
        corrected = {place: self.vertices + right[place] for place in places}
        result = lissom.learn(self.mesh, self.vertices + self.made, corrected)
        others = [k for k in range(len(right)) if k not in places]
        before, after = (
            np.array([root_mean_square(keys[k] - right[k]) for k in others])
            for keys in (self.made, result.vertices - self.vertices)
        )
        return before, after, result, corrected


def waves(vertices, seed, count):
    """(n, count) fields of size 1 or so, that change over a third of the diagonal and more."""
    random = np.random.default_rng(seed)
    fields = np.zeros((len(vertices), count))
    for _ in range(8):
        ways = random.normal(size=(count, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        ways *= 2 * np.pi / (diagonal(vertices) * random.uniform(0.35, 1, count))[:, None]
        fields += np.cos(vertices @ ways.T + random.uniform(0, 2 * np.pi, count)) / 2
    return fields


PEOPLE: dict[int, Person] = {}


@pytest.fixture
def person(data, seed):
    """Made once for all tests."""
    if seed not in PEOPLE:
        PEOPLE[seed] = Person(data, seed)
    return PEOPLE[seed]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("taught", TAUGHT)
def test_five_corrected_keys_teach_the_others(person, seed, taught):
    before, after, result, corrected = person.learned(person.own(seed, 0.2), taught)
    assert after.sum() < 0.8 * before.sum()
    assert (after / before).max() < 1.05
    for place, shape in corrected.items():
        np.testing.assert_array_equal(result.vertices[place], shape, "to the bit")


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("taught", TAUGHT)
def test_where_corrections_have_nothing_in_common_little_changes(person, taught):
    before, after, _, _ = person.learned(person.plain, taught)  # what is left is what the fit is off
    assert after.sum() < 1.01 * before.sum()
    assert (after / before).max() < 1.05


def strip(n=60):
    """A flat strip of 20 n triangles and its keys: bumps at three places, one far off, four ways each."""
    x, y = (
        part.ravel() for part in np.meshgrid(np.linspace(0, 6, n + 1), np.linspace(0, 1, 11), indexing="ij")
    )
    vertices = np.column_stack([x, y, 0 * x])
    a = (np.arange(n)[:, None] * 11 + np.arange(10)).ravel()
    triangles = np.concatenate([np.column_stack([a, a + 11, a + 12]), np.column_stack([a, a + 12, a + 1])])

    def bump(at, way):
        size = np.clip(1 - ((x - at) / 0.8) ** 2, 0, None) ** 2
        return size[:, None] * np.asarray(way)

    ways = [[0, 0, 0.2], [0.1, 0, 0.2], [0.1, 0.1, 0.1], [0, -0.1, 0.2]]
    keys = np.array([bump(at, way) for at in (1.0, 1.3, 5.0) for way in ways])
    return vertices, triangles, keys


def test_what_all_corrections_say_is_learned_where_they_say_it():
    vertices, triangles, keys = strip()
    mesh = lissom.Mesh(vertices, triangles)
    wanted = 1.3 * keys
    found = lissom.learn(mesh, vertices + keys, {k: vertices + wanted[k] for k in (0, 1, 2, 3)})
    made = found.vertices - vertices
    near, far = made[4:8], made[8:]
    left = np.linalg.norm(near - wanted[4:8]) / np.linalg.norm(keys[4:8] - wanted[4:8])
    assert left < 0.25
    assert np.linalg.norm(far - keys[8:]) < 0.01 * np.linalg.norm(wanted[8:] - keys[8:])
    assert (found.foretold > 0.7).all()
    assert found.changes[:8] == pytest.approx(0.3, rel=0.25)


def test_strength_is_how_much_of_it_is_taken():
    vertices, triangles, keys = strip()
    mesh = lissom.Mesh(vertices, triangles)
    taught = {k: vertices + 1.3 * keys[k] for k in (0, 1, 2, 3)}
    whole, half, none = (
        lissom.learn(mesh, vertices + keys, taught, strength=strength).vertices - vertices - keys
        for strength in (1.0, 0.5, 0.0)
    )
    others = [k for k in range(len(keys)) if k not in taught]
    np.testing.assert_allclose(half[others], 0.5 * whole[others], atol=1e-14)
    assert not np.abs(none[others]).max() > 1e-15
    for k in taught:
        np.testing.assert_allclose(half[k], 0.3 * keys[k], atol=1e-15)


def test_what_a_key_leaves_at_rest_stays_at_rest_to_the_bit():
    vertices, triangles, keys = strip()
    taught = {k: vertices + 1.3 * keys[k] for k in (0, 1, 2, 3)}
    found = lissom.learn(lissom.Mesh(vertices, triangles), vertices + keys, taught).vertices
    still = ~keys.any(axis=2)
    for k in range(len(keys)):
        np.testing.assert_array_equal(found[k][still[k]], vertices[still[k]])


def test_it_does_not_depend_on_how_the_mesh_lies():
    vertices, triangles, keys = strip()
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    taught = {0: 1.3 * keys[0], 1: 0.9 * keys[1], 2: 1.2 * keys[2]}

    def learned(matrix, shift):
        at = vertices @ matrix.T + shift
        wanted = {k: at + offsets @ matrix.T for k, offsets in taught.items()}
        found = lissom.learn(lissom.Mesh(at, triangles), at + keys @ matrix.T, wanted).vertices
        return (found - at) @ np.linalg.inv(matrix).T

    np.testing.assert_allclose(learned(7.0 * turn, [3.0, -2.0, 9.0]), learned(np.eye(3), 0.0), atol=1e-9)


def test_a_single_correction_is_told_to_be_one():
    vertices, triangles, keys = strip()
    mesh = lissom.Mesh(vertices, triangles)
    assert "a single corrected key" in lissom.learn(mesh, vertices + keys, {0: vertices}).warnings[0]


def test_what_cannot_be_learned_from_is_refused():
    vertices, triangles, keys = strip()
    mesh, made = lissom.Mesh(vertices, triangles), vertices + keys
    with pytest.raises(lissom.InvalidConstraint, match="corrected: no key is corrected"):
        lissom.learn(mesh, made, {})
    outside = r"corrected: key out of range, there are 12 \(at 13; 1 in all\)"
    with pytest.raises(lissom.InvalidConstraint, match=outside):
        lissom.learn(mesh, made, {0: vertices, 13: vertices})
    with pytest.raises(lissom.InvalidValue, match=r"corrected\[0\]: not finite"):
        lissom.learn(mesh, made, {0: vertices * np.nan})
    with pytest.raises(lissom.InvalidValue, match="strength"):
        lissom.learn(mesh, made, {0: vertices}, strength=-1.0)
    with pytest.raises(ValueError, match="corrected: expected shape"):
        lissom.learn(mesh, made, {0: vertices[1:]})
    with pytest.raises(ValueError, match="corrected: positions of different shapes"):
        lissom.learn(mesh, made, {0: vertices[1:], 1: vertices})
    with pytest.raises(ValueError, match="vertices: expected shape"):
        lissom.learn(mesh, keys[:, 1:], {0: vertices})
