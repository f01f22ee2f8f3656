"""What nobody holds follows the nearest held surface rigidly: random parts, every method."""

import lissom
import numpy as np
import pytest
import shapes
from test_parts_ride import ball

RANDOM = np.random.default_rng(4)


def scene(random, count=8):
    """(vertices, faces, handles, the tube's vertices, the parts' vertices): balls and hairs on a tube."""
    tube, faces = shapes.tube(rows=40, columns=16, bumps=0.0)
    points, faces, parts = [tube], [faces], []
    for _ in range(count):
        radius = random.uniform(0.05, 0.3)
        vertices, own = ball(radius)
        around, along = random.uniform(0, 2 * np.pi), random.uniform(0.2, 5.8)
        height = 1 + random.uniform(0.5, 2) * radius
        first = sum(map(len, points))
        points.append(vertices + (along, height * np.cos(around), height * np.sin(around)))
        faces.append(own + first)
        parts.append(np.arange(first, first + len(vertices)))
    return np.vstack(points), np.vstack(faces), list(shapes.ends(tube)), len(tube), parts


def distances(x, part, host):
    """Of a part's vertices to each other, and of its centre to the 6 nearest of the host at rest."""
    return np.linalg.norm(x[part][:, None] - x[part][None], axis=2), np.linalg.norm(
        x[part].mean(0) - x[host], axis=1
    )


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_parts_follow_rigidly_and_keep_their_place(method):
    for _ in range(2):
        vertices, faces, handles, host, parts = scene(RANDOM)
        pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
        turn = shapes.rigid((0, 1, 0), 0.5, (0.3, 0.2, -0.1))
        x = pose.solve([np.eye(4), turn]).vertices
        for part in parts:
            near = np.argsort(np.linalg.norm(vertices[:host] - vertices[part].mean(0), axis=1))[:6]
            (inner, gap), (inner_before, gap_before) = (distances(p, part, near) for p in (x, vertices))
            assert np.abs(inner - inner_before).max() < 1e-9, "rigid"
            # The patch itself stretches where the method lets it.
            stretch = np.linalg.norm(x[near][:, None] - x[near][None], axis=2) - np.linalg.norm(
                vertices[near][:, None] - vertices[near][None], axis=2
            )
            assert np.abs(gap - gap_before).max() < 0.05 + 2 * np.abs(stretch).max()


def test_what_moves_rigidly_takes_everything_along_exactly():
    vertices, faces, _, _host, parts = scene(RANDOM)
    vertices = np.vstack([vertices, RANDOM.normal(size=(5, 3)) * 2])  # loose vertices, as of hairs
    motion = shapes.rigid((1, 2, 3), 2.0, (5, 0, 1))
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [np.arange(10)])
    assert np.abs(pose.solve([motion]).vertices - shapes.moved(motion, vertices)).max() < 1e-9
    assert any("follow the nearest surface" in w and f"{len(parts)} in all" in w for w in pose.warnings)


def test_where_nothing_moves_parts_stay_to_the_last_bit_and_so_they_do_by_option():
    vertices, faces, handles, host, _parts = scene(RANDOM)
    mesh = lissom.Mesh(vertices, faces)
    assert np.array_equal(lissom.Pose(mesh, handles).solve([np.eye(4)] * 2).vertices, vertices)
    turn = shapes.rigid((0, 1, 0), 0.5, (0.3, 0.2, -0.1))
    pose = lissom.Pose(mesh, handles, unheld="rest")
    x = pose.solve([np.eye(4), turn]).vertices
    assert np.array_equal(x[host:], vertices[host:])
    assert any("without a handle stay at rest" in w for w in pose.warnings)
    assert np.array_equal(x[:host], lissom.Pose(mesh, handles).solve([np.eye(4), turn]).vertices[:host])


def test_parts_outside_the_region_stay_and_those_beside_what_is_at_rest_too():
    vertices, faces, handles, host, _parts = scene(RANDOM)
    mesh = lissom.Mesh(vertices, faces)
    turn = shapes.rigid((0, 1, 0), 0.5, (0.3, 0.2, -0.1))
    x = lissom.Pose(mesh, handles, roi=np.arange(host)).solve([np.eye(4), turn]).vertices
    assert np.array_equal(x[host:], vertices[host:])
    # A second tube outside the region: a ball on it rests, though its own vertices may move.
    other, other_faces = shapes.tube(rows=10, columns=8)
    points, own = ball(0.2)
    both = np.vstack([vertices, other + (0, 0, 9), points + (3, 0, 7.8)])
    start = len(vertices)
    more = np.vstack([faces, other_faces + start, own + start + len(other)])
    roi = np.r_[np.arange(start), np.arange(start + len(other), len(both))]
    x = lissom.Pose(lissom.Mesh(both, more), handles, roi=roi).solve([np.eye(4), turn]).vertices
    assert np.array_equal(x[start:], both[start:])


def test_a_part_with_a_handle_of_its_own_goes_where_that_takes_it():
    vertices, faces, handles, _host, parts = scene(RANDOM)
    own = shapes.rigid((0, 0, 1), 1.0, (0, 0, 3))
    pose = lissom.Pose(lissom.Mesh(vertices, faces), [*handles, parts[0]])
    x = pose.solve([np.eye(4), np.eye(4), own]).vertices
    assert np.abs(x[parts[0]] - shapes.moved(own, vertices[parts[0]])).max() < 1e-12


def test_edge_distances_are_the_shortest_ways_along_edges():
    vertices, faces, _, host, _parts = scene(RANDOM, 2)
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.vstack([edges, edges[:, ::-1]])
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    sources = [3, 200]
    expected = np.full(len(vertices), np.inf)
    expected[sources] = 0
    for _ in range(len(vertices)):
        before = expected.copy()
        np.minimum.at(expected, edges[:, 1], expected[edges[:, 0]] + lengths)
        if np.array_equal(before, expected):
            break
    found = lissom.Mesh(vertices, faces).edge_distances(sources)
    assert np.isinf(found[host:]).all()
    assert np.allclose(found[:host], expected[:host], rtol=1e-12)
    with pytest.raises(lissom.InvalidConstraint, match="out of range"):
        lissom.Mesh(vertices, faces).edge_distances([len(vertices)])
    with pytest.raises(lissom.InvalidConstraint, match="there is none"):
        lissom.Mesh(vertices, faces).edge_distances([])
