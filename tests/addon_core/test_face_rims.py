"""The face is told by openings and eyeballs, whichever way it looks and whatever it wears."""

import numpy as np
import pytest
from lissom_addon_core import face_rims
from lissom_addon_core.face_rims import Opening

EYES = {1: np.array([0.4, -0.9, 0.2]), -1: np.array([-0.4, -0.9, 0.2])}
MOUTH = np.array([0.0, -0.95, -0.4])


def ring(middle, wide, high, count=24):
    angle = np.linspace(0, 2 * np.pi, count + 1)
    points = middle + np.column_stack([wide * np.cos(angle), 0 * angle, high * np.sin(angle)])
    return Opening(np.arange(count + 1), points, np.zeros(0, dtype=int))


def face(degrees, **more):
    """Openings, balls, and the three middles, of a head turned about the vertical."""
    turn = np.radians(degrees)
    turn = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    found = [ring(eye, 0.15, 0.2) for eye in EYES.values()] + [ring(MOUTH, 0.3, 0.02)]
    found += [ring(MOUTH + [0, -0.1, 0.2], 0.06, 0.03), *more.get("rings", [])]
    balls = [(eye + [0, 0.2, 0], 0.25) for eye in EYES.values()] + more.get("balls", [])
    middles = np.array([*EYES.values(), MOUTH]) @ turn.T
    return [one.seen_from(turn) for one in found], [(turn @ c, r) for c, r in balls], middles


@pytest.mark.parametrize("degrees", [0, 12, 25, -30])
def test_a_face_is_found_as_it_looks_and_a_cap_of_hair_is_no_eye(degrees):
    found, balls, middles = face(degrees)
    found = [one._replace(loop=one.loop + 100 * place) for place, one in enumerate(found)]
    at, loops = face_rims.of_face(found, balls)
    np.testing.assert_allclose(at, middles, atol=1e-9)
    assert [loop[0] for loop in loops] == [0, 100, 200]
    hair = [(np.array([0, 0.1, 0.1]), 1.1)]
    found, balls, middles = face(degrees, balls=hair, rings=[ring(np.array([0, 1.0, 0]), 0.9, 0.9)])
    np.testing.assert_allclose(face_rims.of_face(found, balls)[0], middles, atol=1e-9)


def test_without_eyeballs_eyes_are_a_guess_and_nostrils_are_not_it():
    found, _, middles = face(12)
    assert face_rims.of_face(found, []) is None
    nostrils = [ring(MOUTH + [side * 0.08, -0.1, 0.2], 0.05, 0.03) for side in (1, -1)]
    found, _, middles = face(12, rings=nostrils)
    np.testing.assert_allclose(face_rims.of_face(found, None)[0], middles, atol=1e-9)


def test_who_looks_away_or_has_four_eyes_is_not_guessed():
    found, balls, _ = face(50)
    assert face_rims.of_face(found, balls) is None
    higher = [eye + [0, 0, 0.6] for eye in EYES.values()]
    rings, more = [ring(eye, 0.15, 0.2) for eye in higher], [(eye, 0.25) for eye in higher]
    found, balls, _ = face(0, rings=rings, balls=more)
    assert face_rims.of_face(found, balls) is None


def test_the_border_of_a_neck_is_no_mouth():
    angle = np.linspace(0, 2 * np.pi, 25)
    neck = np.column_stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), 0.02 * np.cos(angle) - 0.9])
    neck = Opening(np.arange(25), neck, np.zeros(0, dtype=int))
    found, balls, middles = face(0, rings=[neck])
    np.testing.assert_allclose(face_rims.of_face(found, balls)[0], middles, atol=1e-9)
    assert face_rims.of_face([found[0], found[1], neck], balls) is None


def plate(height):
    """Vertices and triangles of a square with a cone in its middle; how far from it each vertex is."""
    steps = np.linspace(-1, 1, 21)
    x, z = np.meshgrid(steps, steps, indexing="ij")
    away = np.hypot(x, z)
    y = -height * np.clip(0.5 - away, 0, None)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    return np.stack([x, y, z], axis=2).reshape(-1, 3), triangles, away.ravel()


@pytest.mark.parametrize(("height", "count"), [(-0.5, 1), (0.5, 0), (0.0, 0)])
def test_what_lies_behind_a_nose_that_is_stuck_on_is_no_pocket(height, count):
    vertices, triangles, away = plate(height)
    hidden = (away[triangles] < 0.51).all(axis=1)
    found = face_rims.openings(vertices, triangles, hidden)
    assert len([one for one in found if one.extent[0] < 1.5]) == count


@pytest.mark.parametrize("seen", [True, False])
def test_a_rim_does_not_go_round_a_triangle_that_one_sees_or_not(seen):
    """Of the lining one sees a triangle that has two corners on the rim, or of the skin one does not."""
    vertices, triangles, _ = plate(-0.5)
    hidden = (np.abs(vertices[triangles][:, :, [0, 2]]).max(axis=2) < 0.51).all(axis=1)

    def rim():
        return next(one for one in face_rims.openings(vertices, triangles, hidden) if one.extent[0] < 1.5)

    known = rim().loop
    for ends in zip(known[2:-5:5], known[3:-4:5], strict=True):
        hidden[np.isin(triangles, ends).sum(axis=1) == 2] = not seen
    assert set(rim().loop) == set(known)
