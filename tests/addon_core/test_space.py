"""The space that meshes are solved in: of the scene's lengths, whatever an object's scale."""

import numpy as np
import pytest
from lissom_addon_core import space
from lissom_addon_core.refused import Refused
from numpy.testing import assert_allclose, assert_array_equal

MATRIX = np.array([[0.0, -2.0, 0.3, 5.0], [1.5, 0.0, 0.0, -7.0], [0.0, 0.1, -0.7, 100.0], [0, 0, 0, 1]])


def test_into_and_back_are_inverse():
    points = np.random.default_rng(0).normal(size=(4, 7, 3))
    linear = space.linear_part(MATRIX, "Cube")
    assert_allclose(space.back(linear, space.into(linear, points)), points, atol=1e-14)


def test_lengths_in_solve_space_are_those_of_the_scene():
    linear = space.linear_part(MATRIX, "Cube")
    a, b = np.random.default_rng(1).normal(size=(2, 3))
    world = [MATRIX[:3, :3] @ p + MATRIX[:3, 3] for p in (a, b)]
    assert np.linalg.norm(space.into(linear, a) - space.into(linear, b)) == pytest.approx(
        np.linalg.norm(world[0] - world[1])
    )


@pytest.mark.parametrize("scale", [(1, 1, 0), (0, 0, 0), (1, 1e-9, 1)])
def test_row_36_a_singular_scale_is_refused(scale):
    with pytest.raises(Refused, match="'Cube' is zero along an axis"):
        space.linear_part(np.diag([*scale, 1.0]), "Cube")


@pytest.mark.parametrize("entry", [(0, 0), (1, 2), (2, 3)])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_row_36_a_matrix_that_is_not_finite_is_refused(entry, value):
    matrix = MATRIX.copy()
    matrix[entry] = value
    with pytest.raises(Refused, match="'Cube' is not a finite number"):
        space.linear_part(matrix, "Cube")


@pytest.mark.parametrize("scale", [(1, 2, 3), (-1, 2, 3), (-1, -2, 3), (-1, -1, -1)])
def test_row_36_faces_look_outward_under_any_mirror(scale):
    corners = np.vstack([np.zeros(3), np.eye(3)])
    triangles = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])  # of a tetrahedron, all outward
    linear = np.diag(scale).astype(float)
    a, b, c = np.moveaxis(space.into(linear, corners)[space.outward(linear, triangles)], 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(abs(np.prod(scale)) / 6)


def test_row_36_a_mirrored_scale_is_applied():
    linear = space.linear_part(np.diag([-1.0, 2, 3, 1]), "Cube")
    assert_allclose(space.into(linear, np.ones(3)), [-1, 2, 3])


def test_a_handle_moves_its_points_as_it_does_in_the_scene():
    rng = np.random.default_rng(2)
    rest, posed = (np.vstack([rng.normal(size=(3, 4)), [0, 0, 0, 1]]) for _ in range(2))
    point = rng.normal(size=3)
    linear = space.linear_part(MATRIX, "Cube")
    moved = (posed @ np.linalg.inv(rest) @ [*point, 1])[:3]  # in the coordinates of the object
    (transform,) = space.handle_transforms(linear, rest[None], posed[None])
    assert_allclose((transform @ [*space.into(linear, point), 1])[:3], space.into(linear, moved), atol=1e-12)


def test_row_4_what_single_precision_cannot_hold_is_refused():
    assert_allclose(space.back(np.eye(3), np.full((2, 3), 3.4e38)), 3.4e38)
    with pytest.raises(Refused, match="beyond the largest coordinate"):
        space.back(0.5 * np.eye(3), np.full((2, 3), 3.4e38))


def test_what_moves_with_the_first_object_does_not_move():
    part = MATRIX @ np.diag([1, 2, 3, 1.0])
    part[:3, 3] = [1, 2, 3]
    turned = np.array([[0.0, 0, 1, 4], [0, 2, 0, 5], [-1, 0, 0, 6], [0, 0, 0, 1]])
    moved = [np.asarray(turned @ matrix, dtype=np.float32).astype(float) for matrix in (MATRIX, part)]
    assert space.part_motion(MATRIX, part, *moved) is None
    assert space.part_motion(MATRIX, part, MATRIX, moved[1]) is not None


def test_the_motion_of_a_part_is_that_in_the_first_objects_coordinates():
    part, now = np.eye(4), np.array([[0.0, -1, 0, 4], [1, 0, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]])
    first = MATRIX @ np.diag([1, 2, 1, 1.0])
    point = np.array([0.3, 0.2, 0.1, 1])
    motion = space.part_motion(MATRIX, part, first, now)
    in_solve_space = point[:3] - MATRIX[:3, 3]
    seen = MATRIX[:3, :3] @ (np.linalg.inv(first) @ now @ point)[:3]
    assert_allclose(motion[:3, :3] @ in_solve_space + motion[:3, 3], seen, atol=1e-12)


def test_what_stays_where_it_is_in_the_scene_was_applied():
    draw = np.random.default_rng(4)
    for _ in range(20):
        before, change = np.eye(4), np.eye(4)
        before[:3], change[:3] = draw.normal(size=(2, 3, 4))
        points = draw.normal(size=(8, 3)).astype(np.float32)
        now = np.float32(points @ change[:3, :3].T + change[:3, 3])
        world = before @ np.linalg.inv(change)
        assert_allclose(space.applied(before, world, points, now), change, atol=1e-9)
        assert space.applied(before, before, points, now) is None  # an edit of the mesh
        assert space.applied(before, world, points, points) is None  # the object alone moved
        now[3] += 0.01
        assert space.applied(before, world, points, now) is None
        assert space.applied(before, np.zeros((4, 4)), points, now) is None


def test_handles_are_affine_whatever_rounding_blender_left_in_their_matrices():
    draw = np.random.default_rng(6)
    rest, posed = draw.normal(size=(2, 5, 4, 4))
    rest[:, 3] = posed[:, 3] = 0, 0, 0, 1
    exact = space.handle_transforms(MATRIX[:3, :3], rest, posed)
    posed[:, 3] += 6e-8 * draw.normal(size=(5, 4))
    found = space.handle_transforms(MATRIX[:3, :3], rest, posed)
    assert (found[:, 3] == [0, 0, 0, 1]).all()
    assert_allclose(found, exact, atol=1e-4)


@pytest.mark.parametrize("flat", [False, True])
def test_transforms_that_were_applied_are_told_by_vertices_alone(flat):
    draw = np.random.default_rng(5)
    for _ in range(20):
        points = draw.normal(size=(32, 3)) * (1, 1, 0 if flat else 1)
        turn = np.linalg.qr(draw.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn)) * draw.uniform(0.01, 100)
        change = turn if flat else turn @ np.diag(draw.uniform(0.3, 3, 3) * draw.choice([-1, 1], 3))
        points = np.float64(np.float32(points + draw.normal(size=3)))
        now = np.float64(np.float32(points @ change.T + draw.normal(size=3)))
        found = space.linear_change(points, now)
        assert_allclose(found, change, atol=1e-5 * np.abs(change).max())
        sculpted = now + (np.arange(32) == 3)[:, None] * 0.1 * np.ptp(now)
        assert_array_equal(space.linear_change(points, sculpted), np.eye(3))
        assert_array_equal(space.linear_change(points, points + 3.0), np.eye(3))


def test_vertices_in_a_line_or_in_one_place_tell_of_no_change():
    for points in (np.outer(np.arange(9.0), (1, 2, 3)), np.ones((9, 3)), np.zeros((0, 3))):
        assert_array_equal(space.linear_change(points, 2 * points), np.eye(3))
