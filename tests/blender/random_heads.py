"""Random stylised heads, and what Face Keys promises of each.

    drawn = random_heads.drawn(seed);  random_heads.broken(drawn, {key: offsets})

A head is one of ``heads.SHAPES`` with other proportions, open or closed behind eyes and mouth, with or
without a neck, ears and hair that are stuck on it, eyeballs in its own mesh or as parts, turned by up to 25
degrees, somewhere, at any size.
"""

from typing import NamedTuple

import heads
import numpy as np


class Drawn(NamedTuple):
    """What Face Keys is given, as it stands in its scene, and the Head, its first vertices, as modelled.

    A place there is ``scale turn x + shift``. ``told`` says what was drawn.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    parts: list
    head: heads.Head
    scale: float
    turn: np.ndarray
    shift: np.ndarray
    told: str

    def there(self, points):
        """(n, 3) places in the scene of (n, 3) as modelled."""
        return self.scale * points @ self.turn.T + self.shift

    def back(self, offsets):
        """(n, 3) offsets of the head's own vertices, as it was modelled."""
        return offsets[: len(self.head.vertices)] @ self.turn / self.scale


def drawn(seed):
    """The Drawn of a number."""
    random = np.random.default_rng(seed)
    name = str(random.choice(list(heads.SHAPES)))
    head, told = heads.made_of(_shape(heads.SHAPES[name], random)), [name]
    mouth, eyes, balls, neck, hair, ears = (random.random(6) < 0.5).tolist()
    if mouth or eyes:
        head = heads.closed(head, mouth, eyes)
        told += ["mouth bag"] * mouth + ["sockets"] * eyes
    if neck and name != "mask":
        head = _with_neck(head)
        told.append("neck")
    pieces = [(head.vertices, head.triangles)]
    if hair and name != "mask":
        pieces.append(heads.cap((0, 0.15, 0.1), 1.05))
        told.append("hair")
    if ears:
        wide = np.abs(head.vertices[:, 0]).max()
        size = random.uniform(0.1, 0.25)
        pieces += [heads.ball(np.array([side * wide, 0.1, 0.5]), size) for side in (1, -1)]
        told.append("ears")
    if balls:
        pieces += head.eyes
        told.append("eyeballs in the mesh")
    first = np.cumsum([0, *(len(points) for points, _ in pieces)])
    triangles = np.concatenate([start + faces for start, (_, faces) in zip(first, pieces, strict=False)])
    angle = np.radians(random.uniform(-25, 25))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    scale = 10 ** random.uniform(-2, 2)
    told += [f"turned by {np.degrees(angle):.0f} degrees", f"of size {scale:.2g}"]
    found = Drawn(
        np.concatenate([points for points, _ in pieces]),
        triangles,
        [],
        head,
        scale,
        turn,
        scale * random.normal(size=3),
        ", ".join(told),
    )
    parts = [] if balls else [(found.there(points), faces) for points, faces in head.eyes]
    return found._replace(vertices=found.there(found.vertices), parts=parts)


def _shape(shape, random):
    """A Shape of the same sort."""

    def near(values, much):
        return tuple(np.multiply(values, random.uniform(1 - much, 1 + much, np.shape(values))).tolist())

    opening = near(shape.opening, 0.2)
    # No eyeball is beside its lids.
    aside, up = np.multiply(shape.eye, random.uniform([0.9, 0.85], [1.05, 1.0])).tolist()
    bumps = [(*bump[:4], bump[4] * random.uniform(0.6, 1.4)) for bump in shape.bumps]
    return shape._replace(
        eye=(max(aside, opening[0] + 0.12), up),
        opening=opening,
        ball=shape.ball * min(1.0, max(opening) / max(shape.opening)),
        sunk=shape.sunk * random.uniform(0.9, 1.1),
        mouth=min(shape.mouth * random.uniform(0.9, 1.1), up - opening[1] - 0.25),
        lips=shape.lips * random.uniform(0.75, 1.25),
        radii=near(shape.radii, 0.12),
        bumps=tuple(bumps),
        spacing=shape.spacing * random.uniform(0.9, 1.2),
    )


def _with_neck(head):
    """The Head with a neck that goes down from its border at the back."""
    ends = np.sort(np.concatenate([head.triangles[:, k] for k in ([0, 1], [1, 2], [2, 0])]), axis=1)
    edges, times = np.unique(ends, axis=0, return_counts=True)
    border = edges[times == 1]
    border = border[(head.vertices[border][:, :, 1] > 0.3).all(axis=1)]
    directed = np.concatenate([head.triangles[:, k] for k in ([0, 1], [1, 2], [2, 0])])
    border = directed[
        (directed[:, None] == np.concatenate([border, border[:, ::-1]])).all(axis=2).any(axis=1)
    ]
    vertices, triangles, twins = head.vertices, head.triangles, head.twins
    for back, down in ((0.15, 0.3), (0.05, 0.5)):
        ring, place = np.unique(border, return_inverse=True)
        place, first = place.reshape(-1, 2), len(vertices)
        new = vertices[ring] + [0, back, -down]
        now = first + place
        triangles = np.concatenate(
            [
                triangles,
                np.column_stack([border[:, 1], border[:, 0], now[:, 0]]),
                np.column_stack([border[:, 1], now[:, 0], now[:, 1]]),
            ]
        )
        vertices = np.concatenate([vertices, new])
        twins = np.concatenate([twins, first + np.searchsorted(ring, twins[ring])])
        border = now
    return head._replace(vertices=vertices, triangles=triangles, twins=twins)


def broken(drawn, keys):
    """Texts of what is not as promised, of {name: offsets (n, 3)} of ARKit's keys."""
    head, found = drawn.head, []
    rest, key = head.vertices, {name: drawn.back(offsets) for name, offsets in keys.items()}

    def promise(kept, text):
        if not kept:
            found.append(text)

    blink = rest + key["eyeBlinkLeft"] + key["eyeBlinkRight"]
    for side in (0, 1):
        share = heads.seen(head, blink, side) / heads.seen(head, rest, side)
        promise(share <= 0.02, f"{100 * share:.1f} % of eye {side} is seen in a blink")
    before, after = (np.ptp((rest + by)[head.lips], axis=0) for by in (0, key["jawOpen"]))
    promise(after[2] >= 2 * before[2], f"jawOpen makes the mouth {after[2] / before[2]:.1f} times as high")
    promise(abs(after[0] / before[0] - 1) < 0.2, f"and {after[0] / before[0]:.2f} times as wide")
    below = len(head.lips) // 2  # the middle of the lower lip; the first is that of the upper
    share = key["jawOpen"][head.lips[0], 2] / key["jawOpen"][head.lips[below], 2]
    promise(share < 0.5, f"the upper lip goes {100 * share:.0f} % of the way of the lower in jawOpen")
    together = key["jawOpen"] + key["mouthClose"]
    left = heads.left_open(head, key["jawOpen"], together)
    promise(left < 0.1, f"mouthClose leaves {100 * left:.0f} %")
    corners = head.lips[[rest[head.lips, 0].argmin(), rest[head.lips, 0].argmax()]]
    smile = (key["mouthSmileLeft"] + key["mouthSmileRight"])[corners, 2].min() / before[0]
    promise(smile >= 0.08, f"a smile raises the corners by {100 * smile:.1f} %")
    ends = np.concatenate([head.triangles[:, k] for k in ([0, 1], [1, 2], [2, 0])])
    length = np.linalg.norm(np.diff(rest[ends], axis=1)[:, 0], axis=1)
    for name, by in (key | {"mouthClose": together}).items():
        long = (np.linalg.norm(np.diff((rest + by)[ends], axis=1)[:, 0], axis=1) / length).max()
        promise(long <= 3, f"{name} makes an edge {long:.1f} times as long")
        other = key.get(name.removesuffix("Left") + "Right")
        if name.endswith("Left") and name not in ("jawLeft", "mouthLeft"):
            off = np.abs(by[head.twins] * [-1, 1, 1] - other).max() / np.abs(by).max()
            promise(off < 0.01, f"{name} and its counterpart differ by {100 * off:.0f} %")
    return found
