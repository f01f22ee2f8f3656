"""Parts ride on what they sit on: random parts on random bends, heads and twists."""

import lissom
import numpy as np
import pytest
import shapes

ROTATIONS = ("consistent", "relative", "shortest")
TIMES = (0.1, 0.35, 0.5, 0.8)


def ball(radius, rows=5, columns=8):
    """A closed sphere: vertices, triangles."""
    polar, around = np.meshgrid(
        np.linspace(0.3, np.pi - 0.3, rows), np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij"
    )
    rings = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1)
    vertices = np.vstack([rings.reshape(-1, 3), [(0, 0, 1), (0, 0, -1)]])
    k, n = np.arange(columns), rows * columns
    up = np.stack([(k + 1) % columns, k, np.full(columns, n)], 1)
    down = np.stack([k, (k + 1) % columns, np.full(columns, n + 1)], 1) + (n - columns, n - columns, 0)
    return radius * vertices, np.concatenate([shapes.grid_faces(rows, columns, closed=True), up, down])


def bent(points, angle, low=3.0, high=9.0):
    """Bent about z between two places along x; below the first as it was."""
    p = np.atleast_2d(points)
    r = (high - low) / angle
    s = np.clip((p[:, 0] - low) / (high - low), 0, 1) * angle
    beyond = np.minimum(p[:, 0] - low, 0) + np.maximum(p[:, 0] - high, 0)
    x = low + (r - p[:, 1]) * np.sin(s) + beyond * np.cos(s)
    y = r - (r - p[:, 1]) * np.cos(s) + beyond * np.sin(s)
    return np.column_stack([x, y, p[:, 2]]).reshape(np.shape(points))


def on_a_bent_tube(random, angle, count=6):
    """(start, end, faces, the tube's vertices, [(part's vertices, its radius)]): balls on a tube that bends.

    Each ball goes with the place below it, turns by itself by up to 60 degrees, and is shifted by a tenth of
    its radius.
    """
    tube, faces = shapes.tube(rows=100, columns=32, length=12.0, bumps=0.0)
    a, b, all_faces, parts = [tube], [bent(tube, angle)], [faces], []
    for _ in range(count):
        radius = random.uniform(0.08, 0.3)
        points, own_faces = ball(radius)
        around, along = random.uniform(0, 2 * np.pi), random.uniform(0.5, 11.5)
        height = 1 + 0.5 * radius
        base = np.array([along, height * np.cos(around), height * np.sin(around)])
        step = 1e-5 * np.eye(3)
        u, _, vt = np.linalg.svd((bent(base + step, angle) - bent(base - step, angle)).T)
        own = shapes.rotation(random.normal(size=3), random.uniform(0, np.pi / 3))
        shift = random.normal(size=3)
        shift *= 0.1 * radius / np.linalg.norm(shift)
        first = sum(map(len, a))
        a.append(points + base)
        b.append(points @ (u @ vt @ own).T + bent(base, angle) + shift)
        all_faces.append(own_faces + first)
        parts.append((np.arange(first, first + len(points)), radius))
    return np.vstack(a), np.vstack(b), np.vstack(all_faces), len(tube), parts


def strays(x, a, b, t, part, host):
    """How far the distances of a part's centre to the host around it are from between those at both ends."""
    near = np.argsort(np.linalg.norm(a[:host] - a[part].mean(0), axis=1))[:8]
    gaps = lambda p: np.linalg.norm(p[part].mean(0) - p[near], axis=1)  # noqa: E731
    return np.abs(gaps(x) - (1 - t) * gaps(a) - t * gaps(b)).max()


@pytest.mark.parametrize("rotation", ROTATIONS)
@pytest.mark.parametrize("degrees", [40, 90, 150])
def test_balls_on_a_tube_that_bends_keep_their_place(rotation, degrees):
    random = np.random.default_rng(degrees)
    for _ in range(3):
        a, b, faces, host, parts = on_a_bent_tube(random, np.radians(degrees))
        path = lissom.Inbetween(lissom.Mesh(a, faces), a, b, rotation=rotation)
        for t, x in zip(TIMES, path.at(TIMES), strict=True):
            for part, radius in parts:
                assert strays(x, a, b, t, part, host) < 0.03 * radius, (t, radius)


@pytest.mark.parametrize("rotation", ROTATIONS)
def test_eyes_stay_in_a_head_that_turns_whatever_they_look_at(rotation):
    random = np.random.default_rng(1)
    head, head_faces = ball(1.0, 20, 30)
    eye, eye_faces = ball(0.2)
    iris, iris_faces = ball(0.08)
    for _ in range(10):
        centre = random.normal(size=3)
        centre *= 0.95 / np.linalg.norm(centre)
        gaze = shapes.rotation(random.normal(size=3), random.uniform(0, 1.5))
        axis, angle = random.normal(size=3), random.uniform(0.3, 2.5)
        turn = shapes.rotation(axis, angle)
        a = np.vstack([head, eye + centre, iris + centre + (0, 0, 0.18)])
        looking = np.vstack([eye, iris + (0, 0, 0.18)]) @ gaze.T + centre
        b = np.vstack([head, looking]) @ turn.T
        faces = np.vstack([head_faces, eye_faces + len(head), iris_faces + len(head) + len(eye)])
        path = lissom.Inbetween(lissom.Mesh(a, faces), a, b, rotation=rotation)
        for t, x in zip(TIMES, path.at(TIMES), strict=True):
            now = shapes.rotation(axis, t * angle)
            eye_at, iris_at = np.split(x[len(head) :] @ now - centre, [len(eye)])
            assert np.abs(eye_at.mean(0)).max() < 1e-9, "the eye has left its socket"
            assert abs(np.linalg.norm(iris_at.mean(0)) - 0.18) < 0.01, "the iris has left its eye"


@pytest.mark.parametrize("rotation", ["consistent", "relative"])
def test_parts_turn_as_often_as_what_they_sit_on(rotation):
    tube, tube_faces = shapes.tube(rows=200, columns=24, length=12.0, bumps=0.0)
    points, own = ball(0.2)
    twist = 7.0  # at the far end, beyond a whole turn

    def twisted(x, share):
        out = x.copy()
        for part in [slice(0, len(tube)), *(slice(n, n + len(points)) for n in firsts)]:
            along = x[part, 0] if part.start == 0 else np.full(len(points), x[part, 0].mean())
            s = share * twist * np.clip((along - 1) / 10, 0, 1)
            y, z = x[part, 1], x[part, 2]
            out[part, 1], out[part, 2] = np.cos(s) * y - np.sin(s) * z, np.sin(s) * y + np.cos(s) * z
        return out

    firsts = [len(tube) + k * len(points) for k in range(4)]
    places = [(x, 1.1, 0.0) for x in (2.0, 5.0, 9.0, 11.5)]
    a = np.vstack([tube, *(points + place for place in places)])
    faces = np.vstack([tube_faces, *(own + first for first in firsts)])
    path = lissom.Inbetween(lissom.Mesh(a, faces), a, twisted(a, 1.0), rotation=rotation)
    for t, x in zip(TIMES, path.at(TIMES), strict=True):
        off = np.linalg.norm(x - twisted(a, t), axis=1)
        assert off[len(tube) :].max() < 1.2 * off[: len(tube)].max() + 0.02


def test_the_way_is_continuous_hits_its_ends_and_is_the_same_backward():
    a, b, faces, _host, _parts = on_a_bent_tube(np.random.default_rng(5), 2.0)
    mesh = lissom.Mesh(a, faces)
    times = np.linspace(0, 1, 201)
    way = lissom.Inbetween(mesh, a, b).at(times)
    assert np.array_equal(way[0], a)
    assert np.array_equal(way[-1], b)
    assert np.allclose(lissom.Inbetween(mesh, b, a).at(1 - times), way, rtol=0, atol=1e-12)
    steps = np.linalg.norm(np.diff(way, axis=0), axis=2).max(1)
    assert steps.max() < 3 * np.median(steps)


def test_a_door_swings_on_its_hinges_and_a_ball_that_flies_goes_its_own_way():
    house, house_faces = ball(3.0, 12, 16)
    x, z = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1.6, 6))
    door, door_faces = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], 1), shapes.grid_faces(6, 6)
    hinge = np.array([3.05, 0, 0])
    faces = np.vstack([house_faces, door_faces + len(house)])
    a = np.vstack([house, door + hinge])
    for angle in (0.3, 0.8, 1.5, 2.5):
        b = np.vstack([house, door @ shapes.rotation((0, 0, 1), angle).T + hinge])
        half = np.vstack([house, door @ shapes.rotation((0, 0, 1), angle / 2).T + hinge])
        assert np.abs(lissom.Inbetween(lissom.Mesh(a, faces), a, b).at([0.5])[0] - half).max() < 1e-9
    # A head turns while what sat on it flies far away: that keeps no place, and goes straight.
    far = np.vstack([house @ shapes.rotation((0, 0, 1), 1.0).T, door + hinge + (20, 5, 0)])
    x = lissom.Inbetween(lissom.Mesh(a, faces), a, far).at([0.5])[0]
    assert np.abs(x[len(house) :] - (door + hinge + (10, 2.5, 0))).max() < 1e-9


@pytest.mark.parametrize("rotation", ROTATIONS)
def test_vertices_in_no_face_follow_the_nearest_surface(rotation):
    random = np.random.default_rng(2)
    head, faces = ball(1.0, 20, 30)
    for _ in range(5):
        direction = random.normal(size=(12, 3))
        hair = direction / np.linalg.norm(direction, axis=1)[:, None] * random.uniform(1.0, 2.0, (12, 1))
        axis, angle, offset = random.normal(size=3), random.uniform(0.3, 2.8), random.normal(size=3)
        a = np.vstack([head, hair])
        b = a @ shapes.rotation(axis, angle).T + offset
        x = lissom.Inbetween(lissom.Mesh(a, faces), a, b, rotation=rotation).at(TIMES)
        # Rigid against the head in between, as at the ends.
        for now in x:
            seen = np.linalg.norm(now[len(head) :, None] - now[None, : len(head)], axis=2)
            rest = np.linalg.norm(hair[:, None] - head[None], axis=2)
            assert np.abs(seen - rest).max() < 1e-9
    # One in the same place at both ends stays there.
    b[-1] = a[-1]
    assert np.array_equal(lissom.Inbetween(lissom.Mesh(a, faces), a, b).at([0.4])[0][-1], a[-1])


def test_a_blend_takes_what_rides_along():
    head, head_faces = ball(1.0, 20, 30)
    eye, eye_faces = ball(0.2)
    a = np.vstack([head, eye + (0, 0, 0.95), [(0, 0, 1.5)]])
    faces = np.vstack([head_faces, eye_faces + len(head)])
    turned = a @ shapes.rotation((1, 0, 0), 1.6).T
    nodding = lissom.Blend(lissom.Mesh(a, faces), a, [turned])
    for weight in (0.25, 0.5, 1.3):
        expected = a @ shapes.rotation((1, 0, 0), 1.6 * weight).T
        assert np.abs(nodding.at([weight]) - expected - (nodding.at([weight]) - expected)[0]).max() < 1e-9


@pytest.mark.parametrize("reverse", [False, True])
def test_a_part_keeps_its_seat_where_another_place_touches_it_at_one_end(reverse):
    """A tube bent by half a turn: a ball and a hair on the inside lie nearer to its other half then."""
    tube, faces = shapes.tube(rows=100, columns=32, length=12.0, bumps=0.0)
    points, own_faces = ball(0.2)
    angle, low, high = np.pi, 4.0, 8.0  # the halves are 0.55 apart in the end
    base = np.array([10.0, 1.1, 0.0])
    hair = base + [0.5, 0.3, 0.0]
    a = np.vstack([tube, points + base, hair])
    b = bent(a, angle, low, high)
    a, b = (b, a) if reverse else (a, b)
    mesh = lissom.Mesh(a, np.vstack([faces, own_faces + len(tube)]))
    path = lissom.Inbetween(mesh, a, b)
    rigid = np.flatnonzero(np.abs(tube[:, 0] - 10.0) < 1.0)
    for x in path.at([0.25, 0.5, 0.75]):
        from_ = np.vstack([tube, points + base, hair])
        u, _, vt = np.linalg.svd((from_[rigid] - from_[rigid].mean(0)).T @ (x[rigid] - x[rigid].mean(0)))
        carried = lambda p: (p - from_[rigid].mean(0)) @ u @ vt + x[rigid].mean(0)  # noqa: B023, E731
        assert np.abs(carried(base) - x[len(tube) : -1].mean(0)).max() < 0.02
        assert np.abs(carried(hair) - x[-1]).max() < 0.02
