"""Pack the part of the ICT FaceKit face that comes along into python/lissom/data/face.npz.

    LISSOM_DATA=/folder/with/the/archives python tools/pack_ict_data.py

It reads ict_face.npz and ict_identities.npz of that folder. Needed only to change the selection: the packed
file is kept in the repository. `lissom.data` says what is in it, and unpacks it.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "native"))
from faces import loop_through, neighbours, rings_from_border, triangulate  # noqa: E402
from measured import load  # noqa: E402

# Name, vertices, polygons: ranges of FaceKit's own mesh, from the tables of its README. Left out are the
# irises, the lacrimal fluid, the shells that blend and shade the eyes, and the lashes: its shaders need them.
PARTS = [
    ("face", (0, 9409), (0, 9230)),
    ("head_and_neck", (9409, 11248), (9230, 11144)),
    ("mouth_socket", (11248, 13294), (11144, 13226)),
    ("eye_sockets", (13294, 14062), (13226, 14034)),
    ("gums_and_tongue", (14062, 17039), (14034, 17006)),
    ("teeth", (17039, 21451), (17006, 21496)),
    ("eyeball_left", (21451, 22221), (21496, 22296)),
    ("eyeball_right", (23021, 23791), (23094, 23894)),
]

# The 53 that are ARKit's, tongue apart, where brows and cheeks have two sides; left out are these.
NOT_STANDARD = ("PupilDilate_L", "PupilDilate_R", "cheekRaiser_L", "cheekRaiser_R")

# One step of the stored integers in centimetres. Half of it is how far rounding moves a coordinate at most:
# of the neutral face one part in a million of the head's diagonal, of a mode one in twenty thousand.
NEUTRAL_STEP = 1e-4
EXPRESSION_STEP = 5e-4
MODE_STEP = 5e-3

# Rings of edges from the border of the face, inside the lids and lips, to where one sees it end.
LID_RINGS = 2
LIP_RINGS = 8

MOVED = 0.3  # of the largest motion in a blink: what moves so far is lid
BROW_REACH = 0.7  # centimetres from the line through the brow's landmarks
TONGUE_REACH = 0.6  # centimetres from the teeth: what is nearer is gum


def regions(neutral, moves, landmarks, curves, beside, starts):
    """{name: vertices} of what is no part of its own; ``moves`` tells an expression's offsets by its name."""
    face, found = np.arange(starts[1]), {}
    for side, letter, brow in (("left", "L", range(22, 27)), ("right", "R", range(17, 22))):
        blink = moves(f"eyeBlink_{letter}")[face]
        size = np.linalg.norm(blink, axis=1)
        lid = size > MOVED * size.max()
        found[f"upper_lid_{side}"] = np.flatnonzero(lid & (blink[:, 1] < 0))
        lower = moves(f"eyeSquint_{letter}")[face]
        size = np.linalg.norm(lower, axis=1)
        rim = neutral[curves[f"lid_{side}"][:-1]]
        near = _distance(neutral[face], np.concatenate([rim, rim[:1]])) < BROW_REACH
        found[f"lower_lid_{side}"] = np.flatnonzero(near & (lower[:, 1] > MOVED * size.max()))
        found[f"brow_{side}"] = np.flatnonzero(
            _distance(neutral[face], neutral[landmarks[list(brow)]]) < BROW_REACH
        )
    outer = neutral[landmarks[[*range(48, 60), 48]]]
    inside, edge = set(curves["lips"].tolist()), curves["lips"].tolist()
    reach = _distance(outer, neutral[curves["lips"]]).max()
    near = _distance(neutral[face], neutral[curves["lips"]]) < reach
    while edge := [v for v in {b for a in edge for b in beside[a]} - inside if near[v]]:
        inside.update(edge)
    lips = np.array(sorted(inside))
    jaw_moves = np.linalg.norm(moves("jawOpen"), axis=1)
    below = jaw_moves[lips] > 0.5 * jaw_moves[lips].max()
    found["upper_lip"], found["lower_lip"] = lips[~below], lips[below]
    teeth, gums = np.arange(starts[5], starts[6]), np.arange(starts[4], starts[5])
    down = jaw_moves > 0.1 * jaw_moves[teeth].max()  # the hindmost of the lower ones move least
    found["upper_teeth"], found["lower_teeth"] = teeth[~down[teeth]], teeth[down[teeth]]
    away = np.array([np.linalg.norm(neutral[teeth] - p, axis=1).min() for p in neutral[gums]])
    found["tongue"] = gums[down[gums] & (away > TONGUE_REACH)]
    return found


def _distance(points, line):
    """From each of (n, 3) points to a polyline (k, 3)."""
    a, b = line[:-1], line[1:] - line[:-1]
    along = np.einsum("nkj,kj->nk", points[:, None] - a, b) / np.maximum((b * b).sum(1), 1e-12)
    nearest = a + np.clip(along, 0, 1)[..., None] * b
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(1)


def differences(offsets, step):
    """(k, n, 3) as (k, 3, n) integers, each less the one before: neighbours go alike, which packs well."""
    rounded = np.rint(np.asarray(offsets, dtype=np.float64) / step).astype(np.int32)
    found = np.diff(np.swapaxes(rounded, 1, 2), axis=2, prepend=0)
    return found.astype(np.int16 if np.abs(found).max() < 2**15 else np.int32)


def flat(name, lists):
    """Lists of vertices by name as three arrays."""
    return {
        f"{name}_names": np.array(list(lists)),
        f"{name}_starts": np.cumsum([0, *map(len, lists.values())]).astype(np.int32),
        f"{name}_vertices": np.concatenate(list(lists.values())).astype(np.int32),
    }


def main():
    face, identities = load("ict_face"), load("ict_identities")

    vertices = np.concatenate([np.arange(*span) for _, span, _ in PARTS])
    polygons = np.concatenate([np.arange(*span) for _, _, span in PARTS])
    renumbered = np.full(len(face["neutral"]), -1, dtype=np.int32)
    renumbered[vertices] = np.arange(len(vertices), dtype=np.int32)

    corners = np.concatenate([[0], np.cumsum(face["counts"])])
    loops = np.concatenate([renumbered[face["loops"][corners[p] : corners[p + 1]]] for p in polygons])
    assert loops.min() == 0, "a kept polygon uses a vertex that is left out"
    counts = face["counts"][polygons]

    standard = ~np.isin(face["expression_names"], NOT_STANDARD)
    names = face["expression_names"][standard]
    expressions = face["expressions"][standard][:, vertices].astype(np.float64)
    neutral, landmarks = face["neutral"][vertices].astype(np.float64), renumbered[face["landmarks"]]

    starts = np.cumsum([0] + [stop - start for _, (start, stop), _ in PARTS])
    skin = triangulate(loops, counts.astype(int))
    skin = skin[(skin < starts[1]).all(axis=1)]
    beside = neighbours(loops, counts.astype(int), starts[1])
    lids = [loop_through(ring, beside) for ring in rings_from_border(skin, beside, LID_RINGS)[:2]]
    lids.sort(key=lambda loop: -neutral[loop, 0].mean())  # the subject's left is at positive x
    lips = loop_through(rings_from_border(skin, beside, LIP_RINGS)[2], beside)
    curves = dict(zip(("lid_left", "lid_right", "lips"), map(np.array, (*lids, lips)), strict=True))

    def moves(name):
        return expressions[list(names).index(name)]

    parts = {name: np.arange(*span) for (name, _, _), span in zip(PARTS, pairwise(starts), strict=True)}
    named = parts | regions(neutral, moves, landmarks, curves, beside, starts)
    packed = ROOT / "python" / "lissom" / "data" / "face.npz"
    np.savez_compressed(
        packed,
        steps=np.array([NEUTRAL_STEP, EXPRESSION_STEP, MODE_STEP]),
        neutral=differences(neutral[None], NEUTRAL_STEP)[0],
        expressions=differences(expressions, EXPRESSION_STEP),
        expression_names=names,
        modes=differences(identities["modes"][:, vertices], MODE_STEP),
        loops=loops,
        counts=counts,
        landmarks=landmarks,
        **flat("region", named),
        **flat("curve", curves),
    )
    print(
        f"{packed.relative_to(ROOT)}: {len(vertices)} vertices, {len(polygons)} polygons, "
        f"{len(names)} expressions, {len(identities['modes'])} modes, {packed.stat().st_size / 1e6:.2f} MB"
    )
    for name, of in {**named, **curves}.items():
        print(f"  {name}: {len(of)}")


if __name__ == "__main__":
    main()
