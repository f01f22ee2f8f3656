"""Parts of a head: spheres found, what belongs to which jaw, and how eyes turn."""

import numpy as np
import pytest
from lissom_addon_core import face_parts
from lissom_addon_core.face_parts import Frame, Mouth

MOUTH = Mouth(np.array([0.0, -1.0, -0.5]), 0.5)


def ball(centre, radius, count=200, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return np.array(centre) + radius * points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("part", [1.0, 0.5, 0.3])
def test_a_sphere_is_found_from_a_part_of_it(part):
    points = ball((0.3, -0.8, 0.1), 0.12)
    front = points[np.argsort(points[:, 1])[: int(part * 200)]]
    centre, radius, rough = face_parts.sphere(front)
    np.testing.assert_allclose(centre, (0.3, -0.8, 0.1), atol=1e-9)
    assert abs(radius - 0.12) < 1e-9 and rough < 1e-9


def test_parts_are_told_by_shape_and_place():
    random = np.random.default_rng(1)
    box = random.uniform(-0.5, 0.5, size=(60, 3))
    assert face_parts.kind(ball((0.3, -0.7, 0.1), 0.12), MOUTH) == "EYE"
    assert (
        face_parts.kind(ball((0.3, -0.7, 0.1), 0.12) + random.normal(size=(200, 3)) * 0.002, MOUTH) == "EYE"
    )
    assert face_parts.kind(box * [0.3, 0.1, 0.05] + [0, -0.9, -0.45], MOUTH) == "UPPER"
    assert face_parts.kind(box * [0.3, 0.1, 0.05] + [0, -0.9, -0.6], MOUTH) == "LOWER"
    assert face_parts.kind(box * [0.1, 0.02, 0.03] + [0.3, -0.9, 0.15], MOUTH) == "RIDE"  # lashes
    assert face_parts.kind(box * [1.0, 1.0, 0.3] + [0, 0, 0.9], MOUTH) == "RIDE"  # hair


@pytest.mark.parametrize("seed", range(5))
def test_a_frame_takes_the_face_to_the_head_and_back(seed):
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn[:, 0] *= np.linalg.det(turn)
    rest, size, shift = random.normal(size=(40, 3)), random.uniform(0.1, 50), random.normal(size=3)
    frame = Frame.of(rest, size * rest @ turn.T + shift)
    np.testing.assert_allclose(frame.turn, turn, atol=1e-9)
    assert abs(frame.size / size - 1) < 1e-9
    np.testing.assert_allclose(frame.back(size * rest @ turn.T + shift), rest, atol=1e-9)
    np.testing.assert_allclose(frame.offsets(rest), size * rest @ turn.T, atol=1e-8 * size)


def test_eyes_look_where_their_keys_say():
    front = np.array([[0.0, -1.0, 0.0]])
    wanted = {"Up": (0, 1), "Down": (0, -1), "In": (-1, 0), "Out": (1, 0)}
    for side, sign in (("_L", 1), ("_R", -1)):
        centre = np.array([0.3 * sign, 0.0, 0.0])
        for look, (x, z) in wanted.items():
            vector = face_parts.gaze(f"eyeLook{look}{side}", centre)
            moved = front + face_parts.turned(front + centre, centre, vector)
            np.testing.assert_allclose(moved[0, [0, 2]], 0.5 * np.array([sign * x, z]), atol=1e-12)
        assert face_parts.gaze("jawOpen", centre) is None
    assert face_parts.gaze("eyeLookUp_R", np.array([0.3, 0, 0])) is None


def test_what_rides_goes_with_the_nearest_and_jaws_rigidly():
    random = np.random.default_rng(2)
    rest, offsets = random.normal(size=(300, 3)), random.normal(size=3)
    points = random.normal(size=(700, 3))
    near, weights = face_parts.bonds(points, rest)
    found = np.einsum("nk,nkd->nd", weights, np.tile(offsets, (300, 1))[near])
    np.testing.assert_allclose(found, np.tile(offsets, (700, 1)))
    assert face_parts.bonds(rest, rest)[1].max(axis=1).min() > 0.99
    moved = face_parts.turned(rest, np.array([0.0, 0, 1]), np.array([0.4, 0.1, -0.2])) + [1, 2, 3]
    own = face_parts.turned(points, np.array([0.0, 0, 1]), np.array([0.4, 0.1, -0.2])) + [1, 2, 3]
    np.testing.assert_allclose(face_parts.rigid_offsets(points, rest, moved), own, atol=1e-9)


def test_parts_are_connected_pieces_the_largest_first():
    triangles = np.array([[0, 1, 2], [1, 2, 3], [4, 5, 6], [5, 6, 7], [6, 7, 8], [9, 10, 11]])
    found = face_parts.parts(14, triangles)
    assert [part.tolist() for part in found] == [[4, 5, 6, 7, 8], [0, 1, 2, 3]]
