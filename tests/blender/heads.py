"""Stylised heads, as an artist would model them: edge loops round lids and lips, a rim that turns inward,
eyeballs.

    with bpy: heads.made("round") ...

One half is laid out flat, as one sees the head from the middle of its front (azimuthal equidistant),
triangulated with its loops (Delaunay), mirrored, and lifted: onto an ellipsoid with bumps, and in front of
the eyeballs. Lengths are in units of the head's radius; z is up, the face looks along -y.
"""

from typing import NamedTuple

import numpy as np
from mathutils import Vector
from mathutils.geometry import delaunay_2d_cdt

HUG = 1.06  # lids are so far from the middle of an eyeball, in its radii
LIFT = 0.35  # of an eyeball's radius: lids go over into the face within this


class Shape(NamedTuple):
    """One head. Places and extents are radians from the middle of the front: right, up."""

    eye: tuple  # middle of the left one's opening
    opening: tuple  # half its width and height
    ball: float  # radius of the eyeball
    sunk: float  # of it: how far its middle is behind the face
    mouth: float  # how far up
    lips: float  # half their width
    radii: tuple = (1.0, 1.0, 1.0)
    bumps: tuple = ()  # (right, up, extent right, extent up, height): of nose, muzzle, chin, brow, ears
    spacing: float = 0.055  # of the vertices in front
    reach: float = 2.9  # how far back it goes
    loops: int = 6  # round each opening


SHAPES = {
    # Eyes four times as high as people's over the head, and a wide mouth.
    "round": Shape(
        eye=(0.4, 0.12), opening=(0.24, 0.30), ball=0.36, sunk=0.75, mouth=-0.52, lips=0.52,
        radii=(1.0, 0.95, 1.0),
        bumps=((0, -0.2, 0.1, 0.09, 0.13), (1.45, -0.05, 0.14, 0.2, 0.14), (0, -0.8, 0.3, 0.15, 0.06)),
    ),
    # A snout with the mouth under it.
    "muzzle": Shape(
        eye=(0.38, 0.28), opening=(0.17, 0.13), ball=0.2, sunk=0.7, mouth=-0.42, lips=0.3,
        radii=(0.85, 0.95, 1.0),
        bumps=(
            (0, -0.2, 0.34, 0.26, 0.55), (0, -0.05, 0.1, 0.07, 0.1), (0.38, 0.5, 0.25, 0.08, 0.06),
            (0.8, 1.25, 0.16, 0.2, 0.3),
        ),
    ),
    # 1,200 vertices, no head behind it.
    "mask": Shape(
        eye=(0.32, 0.18), opening=(0.17, 0.1), ball=0.19, sunk=0.8, mouth=-0.48, lips=0.27,
        radii=(0.75, 0.8, 1.0), reach=1.05, spacing=0.062, loops=6,
        bumps=((0, -0.12, 0.1, 0.2, 0.16), (0, -0.85, 0.25, 0.14, 0.08), (0.32, 0.4, 0.22, 0.07, 0.05)),
    ),
    # Eyes of which half is outside of the head.
    "bulging": Shape(
        eye=(0.4, 0.38), opening=(0.2, 0.17), ball=0.3, sunk=0.1, mouth=-0.38, lips=0.42,
        radii=(0.9, 0.9, 0.95),
        bumps=((0, -0.05, 0.12, 0.1, 0.08), (0, -0.7, 0.3, 0.15, 0.08)),
    ),
}  # fmt: skip


class Head(NamedTuple):
    """``vertices`` (n, 3), ``triangles`` (m, 3) of the skin; ``eyes``, (vertices, triangles) left and right.

    ``lids`` and ``lips`` are the loops of their edges, from the outer corner over the upper lid, each once.
    ``twins`` (n,) are the vertices of the other side. ``balls`` are (middle, radius).
    """

    vertices: np.ndarray
    triangles: np.ndarray
    eyes: list
    balls: list
    lids: list
    lips: np.ndarray
    twins: np.ndarray

    @property
    def clicks(self):
        """(3, 3) the middles of the left and right eye's opening and of the mouth, as an artist clicks
        them.
        """
        return np.array([self.vertices[loop].mean(axis=0) for loop in (*self.lids, self.lips)])


def made(name):
    """The Head of a name in ``SHAPES``."""
    return made_of(SHAPES[name])


def _ellipse(middle, half, count, start=0.0, end=2 * np.pi):
    angle = np.linspace(start, end, count, endpoint=end - start < 6)
    return np.column_stack([middle[0] + half[0] * np.cos(angle), middle[1] + half[1] * np.sin(angle)])


def _flat(shape):
    """Points (n, 2) of the left half, triangles, and the numbers of those on the lid and on half the lips."""
    around = int(np.clip(2 * np.pi * max(shape.opening) / (0.45 * shape.spacing), 24, 44)) // 4 * 4
    grown = shape.ball * 1.25 - shape.opening[0]
    beside = shape.eye[0] - shape.opening[0] - 0.03  # room on the side of the nose
    widths = np.linspace(0, min(max(grown, 2.2 * shape.spacing), beside), shape.loops)
    lid = [_ellipse(shape.eye, np.add(shape.opening, width), around) for width in widths]
    half = around // 2 + 1
    lips = []
    for width in 0.028 * 1.7 ** np.arange(shape.loops) - 0.028:
        ring = _ellipse((0, shape.mouth), (shape.lips + width, 0.012 + width), half, -np.pi / 2, np.pi / 2)
        ring[[0, -1], 0] = 0
        lips.append(ring)
    rings, points, edges = [*lid, *lips], [], []
    for ring in rings:
        first = len(points)
        points += ring.tolist()
        edges += [(first + k, first + k + 1) for k in range(len(ring) - 1)]
        if len(ring) == around:
            edges.append((first + around - 1, first))
    holes = lid[0], lips[0]
    outer = [(lid[-1], shape.eye), (lips[-1], (0, shape.mouth))]

    def free(p, gap):
        for ring, middle in outer:
            extent = np.abs(ring - middle).max(axis=0) + gap
            if (((p - np.array(middle)) / extent) ** 2).sum() < 1:
                return False
        return True

    radius, step = shape.spacing, shape.spacing
    points.append((0.0, 0.0))
    while radius <= shape.reach + 1e-9:
        count = max(6, round(np.pi * min(radius, np.pi - radius + 0.4) / step))
        for angle in np.linspace(-np.pi / 2, np.pi / 2, count):
            p = np.array([radius * np.cos(angle), radius * np.sin(angle)])
            p[0] = 0.0 if abs(p[0]) < 1e-9 else p[0]
            if free(p, 0.6 * step) or radius > shape.reach - 1e-6:
                points.append(tuple(p))
        left = shape.reach - radius
        step = shape.spacing * (1 + 1.2 * max(0.0, radius - 0.9))
        if left <= 1e-9:
            break
        radius = shape.reach if left < 1.6 * step else radius + step
    points = np.array(points)
    found = delaunay_2d_cdt([Vector(p) for p in points], edges, [], 0, 1e-7)
    flat = np.array([tuple(p) for p in found[0]])
    triangles = np.array(found[2])
    place = {old: new for new, olds in enumerate(found[3]) for old in olds}
    middle = flat[triangles].mean(axis=1)
    inside = np.zeros(len(triangles), dtype=bool)
    for hole, centre in zip(holes, (shape.eye, (0, shape.mouth)), strict=True):
        extent = np.abs(hole - centre).max(axis=0)
        inside |= (((middle - centre) / extent) ** 2).sum(axis=1) < 0.995
    numbers = [place[k] for k in range(around)], [place[len(lid) * around + k] for k in range(half)]
    triangles = triangles[~inside]
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] < 0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return flat, triangles, *numbers


def made_of(shape):
    """The Head of a Shape."""
    flat, triangles, lid, lips = _flat(shape)
    flat, triangles, twins = _mirrored(flat, triangles)
    lids = [np.array(lid), twins[lid]]
    mouth = np.concatenate([lips[::-1], twins[lips[1:-1]]])  # from above the middle to the left and round
    balls = []
    for side in (1, -1):
        middle = _ground(shape, np.array([[side * shape.eye[0], shape.eye[1]]]))[0]
        out = middle / np.linalg.norm(middle)
        forward = np.array([0.35 * out[0], min(out[1], -0.5), 0.35 * out[2]])
        balls.append((middle - shape.sunk * shape.ball * forward / np.linalg.norm(forward), shape.ball))
    vertices = _ground(shape, flat)
    for centre, radius in balls:
        vertices = _over(vertices, centre, radius)
    rims = (lids[0], 1.06, 0.35 * shape.ball), (lids[1], 1.06, 0.35 * shape.ball), (mouth, 1.0, 0.12)
    for loop, wider, depth in rims:
        vertices, triangles = _turned_in(vertices, triangles, loop, wider, depth)
    first, count = len(twins), len(lid)
    own = {vertex: place for place, vertex in enumerate(mouth.tolist())}
    twins = np.concatenate(
        [
            twins,
            first + count + np.arange(count),
            first + np.arange(count),
            first + 2 * count + np.array([own[vertex] for vertex in twins[mouth]]),
        ]
    )
    return Head(vertices, triangles, [ball(*one) for one in balls], balls, lids, mouth, twins)


def _turned_in(vertices, triangles, loop, wider, depth):
    """A ring of vertices more, behind the loop, to which the rim of a lid or of the lips turns in."""
    edge = vertices[loop]
    middle = edge.mean(axis=0)
    inner = middle + wider * (edge - middle) + [0, depth, 0]
    ring, ahead = len(vertices) + np.arange(len(loop)), np.roll(np.arange(len(loop)), -1)
    quads = np.concatenate(
        [np.column_stack([loop, loop[ahead], ring[ahead]]), np.column_stack([loop, ring[ahead], ring])]
    )
    x, z = (edge - middle)[:, [0, 2]].T
    if (x * np.roll(z, -1) - z * np.roll(x, -1)).sum() < 0:  # clockwise, as one sees it
        quads = quads[:, ::-1]
    return np.concatenate([vertices, inner]), np.concatenate([triangles, quads])


# Rings of a bag behind the mouth and of a socket behind an eye: how wide, how much higher, of half the width,
# how deep, of half the width of the mouth or of the eyeball's radius.
BAG = (1.15, 0.25, 0.25), (1.2, 0.3, 0.6), (0.8, 0.2, 0.95), (0.4, 0.1, 1.1)
SOCKET = (1.2, 0.0, 0.3), (1.2, 0.0, 0.8), (0.9, 0.0, 1.3), (0.4, 0.0, 1.6)


def closed(head, mouth=True, eyes=True):
    """The Head without borders there: a bag behind the mouth, sockets behind the eyes, as most artists have
    them.
    """
    loops = [*head.lids, head.lips]
    first = len(head.vertices) - sum(map(len, loops))
    vertices, triangles = head.vertices, head.triangles
    for loop, wanted, deep in zip(loops, (eyes, eyes, mouth), (*head.balls, None), strict=True):
        ring, first = first + np.arange(len(loop)), first + len(loop)
        if not wanted:
            continue
        middle = vertices[ring].mean(axis=0)
        own = vertices[ring] - middle
        half = np.abs(own[:, 0]).max()
        bulge = np.sign(own[:, 2]) * half * np.sqrt(np.maximum(0, 1 - (own[:, 0] / half) ** 2))
        ahead = np.roll(np.arange(len(ring)), -1)
        x, z = own[:, [0, 2]].T
        turn = -1 if (x * np.roll(z, -1) - z * np.roll(x, -1)).sum() < 0 else 1
        for wide, high, back in SOCKET if deep else BAG:
            new = middle + wide * own
            new[:, 1] = middle[1] + back * (deep[1] if deep else half)
            new[:, 2] += high * bulge
            now = len(vertices) + np.arange(len(ring))
            quads = [
                np.column_stack([ring, ring[ahead], now[ahead]]),
                np.column_stack([ring, now[ahead], now]),
            ]
            vertices = np.concatenate([vertices, new])
            triangles = np.concatenate([triangles, *(quad[:, ::turn] for quad in quads)])
            ring = now
        fan = np.column_stack([ring, ring[ahead], np.full(len(ring), len(vertices))])
        vertices = np.concatenate([vertices, vertices[ring].mean(axis=0)[None]])
        triangles = np.concatenate([triangles, fan[:, ::turn]])
    new = np.arange(len(head.vertices), len(vertices))
    image = vertices[new] * [-1, 1, 1]
    away = np.linalg.norm(image[:, None] - vertices[new], axis=2)
    twins = np.concatenate([head.twins, new[away.argmin(axis=1)] if len(new) else new])
    return head._replace(vertices=vertices, triangles=triangles, twins=twins)


def painted(head):
    """Vertices and triangles of the Head without openings for its eyes, as where they are painted on it."""
    first = len(head.vertices) - sum(map(len, (*head.lids, head.lips)))
    behind = np.arange(first, first + sum(map(len, head.lids)))  # what the lids turn in to
    vertices, triangles = head.vertices, head.triangles[~np.isin(head.triangles, behind).any(axis=1)]
    for lid, other in zip(head.lids, (1, -1), strict=True):
        fan = np.column_stack([lid, np.roll(lid, -other), np.full(len(lid), len(vertices))])
        vertices = np.concatenate([vertices, vertices[lid].mean(axis=0)[None]])
        triangles = np.concatenate([triangles, fan])
    used = np.unique(triangles)
    return vertices[used], np.searchsorted(used, triangles)


def _mirrored(flat, triangles):
    """Both halves: points, triangles, and each point's twin."""
    other = np.arange(len(flat))
    off = flat[:, 0] > 1e-6
    flat = np.where(off[:, None], flat, flat * [0, 1])
    other[off] = len(flat) + np.arange(off.sum())
    both = np.concatenate([flat, flat[off] * [-1, 1]])
    twins = np.concatenate([other, np.flatnonzero(off)])
    return both, np.concatenate([triangles, other[triangles][:, ::-1]]), twins


def _ground(shape, flat):
    """Places of flat points on the ellipsoid with its bumps."""
    away = np.linalg.norm(flat, axis=1)
    turn = flat / np.maximum(away, 1e-12)[:, None]
    direction = np.column_stack([np.sin(away) * turn[:, 0], -np.cos(away), np.sin(away) * turn[:, 1]])
    points = direction * np.array(shape.radii)
    for right, up, across, high, height in shape.bumps:
        for side in (1, -1) if right else (1,):
            far = ((flat[:, 0] - side * right) / across) ** 2 + ((flat[:, 1] - up) / high) ** 2
            points += (height * np.exp(-far))[:, None] * direction
    return points


def _over(points, centre, radius):
    """Points pushed forward to lie in front of an eyeball."""
    local = points - centre
    flat = np.hypot(local[:, 0], local[:, 2])
    reach = HUG * radius
    near = flat < 1.35 * reach
    front = -np.sqrt(np.maximum(reach**2 - np.minimum(flat, 0.98 * reach) ** 2, 0))
    fade = np.clip((1.35 * reach - flat) / LIFT / radius, 0, 1)
    fade = fade**2 * (3 - 2 * fade)
    raised = np.minimum(local[:, 1], front * fade + local[:, 1] * (1 - fade))
    moved = points.copy()
    moved[:, 1] = np.where(near & (points[:, 1] < centre[1] + radius), centre[1] + raised, points[:, 1])
    return moved


def ball(centre, radius, rings=14, around=24):
    """Vertices and triangles of an eyeball whose poles look forward and back."""
    angle = np.linspace(0, np.pi, rings + 1)[1:-1]
    turn = np.arange(around) * 2 * np.pi / around
    body = np.stack(
        [
            np.outer(np.sin(angle), np.cos(turn)),
            -np.outer(np.cos(angle), np.ones(around)),
            np.outer(np.sin(angle), np.sin(turn)),
        ],
        axis=2,
    ).reshape(-1, 3)
    points = np.concatenate([[[0, -1, 0]], body, [[0, 1, 0]]])
    faces, last = [], len(points) - 1
    for k in range(around):
        nxt = (k + 1) % around
        faces.append((0, 1 + nxt, 1 + k))
        for ring in range(rings - 2):
            a, b = 1 + ring * around + k, 1 + ring * around + nxt
            faces += [(a, b, b + around), (a, b + around, a + around)]
        faces.append((last, last - around + k, last - around + nxt))
    faces = np.array(faces)
    points_of = points[faces]
    normal = np.cross(points_of[:, 1] - points_of[:, 0], points_of[:, 2] - points_of[:, 0])
    inward = (normal * points_of.mean(axis=1)).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return centre + radius * points, faces


def cap(middle, radius, rings=10, around=32):
    """Vertices and triangles of hair: of a ball what is above and behind."""
    points, faces = ball(np.array(middle), radius, 2 * rings, around)
    local = points[faces].mean(axis=1) - middle
    faces = faces[local[:, 2] > 0.4 * radius - 0.6 * local[:, 1]]
    used = np.unique(faces)
    return points[used], np.searchsorted(used, faces)


def left_open(head, jaw, both):
    """How far apart lips stay that close while the jaw is open, of what the jaw opens: by offsets (n, 3)."""
    count = len(head.lips)  # from the middle of the upper one on: across from k is half of all, less k
    across = head.lips[(count // 2 - np.arange(count)) % count]
    opened, left = (np.linalg.norm(by[across] - by[head.lips], axis=1).max() for by in (jaw, both))
    return left / opened


def seen(head, vertices, side, count=60):
    """How much of an eyeball one sees from the front, of a square round it, with the head's vertices (n, 3)
    there.
    """
    centre, radius = head.balls[side]
    steps = np.linspace(-1, 1, count) * radius
    x, z = (axis.ravel() for axis in np.meshgrid(centre[0] + steps, centre[2] + steps))
    inside = (x - centre[0]) ** 2 + (z - centre[2]) ** 2 < (0.98 * radius) ** 2
    x, z = x[inside], z[inside]
    front = centre[1] - np.sqrt(radius**2 - (x - centre[0]) ** 2 - (z - centre[2]) ** 2)
    shown = np.full(len(x), True)
    corners = vertices[head.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = (low[:, 0] < x.max()) & (high[:, 0] > x.min()) & (low[:, 2] < z.max()) & (high[:, 2] > z.min())
    for a, b, c in corners[near]:
        (ux, uz), (vx, vz) = (b - a)[[0, 2]], (c - a)[[0, 2]]
        turn = ux * vz - uz * vx
        if abs(turn) < 1e-12:
            continue
        px, pz = x - a[0], z - a[2]
        s, t = (px * vz - pz * vx) / turn, (ux * pz - uz * px) / turn
        covers = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
        y = a[1] + s * (b - a)[1] + t * (c - a)[1]
        shown &= ~(covers & (y < front))
    return float(shown.mean())
