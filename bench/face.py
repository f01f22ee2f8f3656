"""Face keys by one press: people whose answers are known, stylised heads, and what is no face.

    python bench/face.py [--people N] [--seeds N] [ROW ...]     in an environment with bpy and the wheel

ROW is people, heads, random or others; all of them without. People are random sums of the identity modes,
with other triangles and vertices moved on the surface, turned, scaled, whole or in part. Landmarks are in
percent of the diagonal; key errors are over those that perfect correspondence leaves, at the median of the
keys; gaps are how much further lids and lips are apart than in the answer, in percent of the diagonal.
"""

import argparse
import importlib.util
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / folder) for folder in ("native", "blender")]

import bpy  # noqa: E402
import heads  # noqa: E402
import lissom  # noqa: E402
import numpy as np  # noqa: E402
import random_heads  # noqa: E402
from faces import diagonal, root_mean_square, slid, triangulate  # noqa: E402
from lissom import data  # noqa: E402
from measured import FOLDER, load  # noqa: E402

# The extension's core by itself, as the tests load it.
_CORE = ROOT / "addon" / "core"
_spec = importlib.util.spec_from_file_location(
    "lissom_addon_core", _CORE / "__init__.py", submodule_search_locations=[str(_CORE)]
)
sys.modules["lissom_addon_core"] = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(sys.modules["lissom_addon_core"])

from lissom_addon_core.face import SOURCE, face_work  # noqa: E402
from lissom_addon_core.face_found import Unsure  # noqa: E402
from lissom_addon_core.face_lids import Lids  # noqa: E402

SKIN = ("face", "head_and_neck")
SOCKETS = ("mouth_socket", "eye_sockets")
INSIDE = ("gums_and_tongue", "teeth", "eyeball_left", "eyeball_right")
KINDS = {
    "skin": SKIN,
    "with sockets": SKIN + SOCKETS,
    "with all": SKIN + SOCKETS + INSIDE,
    "face alone": ("face",),
    "cut at the neck": SKIN,
}


def turned(random):
    """A rotation by up to 30 degrees about the vertical, and 10 about another axis."""
    angle, nod = np.radians(random.uniform([-30, -10], [30, 10]))
    c, s, d, t = np.cos(angle), np.sin(angle), np.cos(nod), np.sin(nod)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, d, -t], [0, t, d]])


def person(seed, kind):
    """Vertices, triangles, the part of the face, where its vertices are, which are on the face, offsets,
    its shape.
    """
    whole, random = data.face(), np.random.default_rng(seed)
    part = whole.only(*KINDS[kind])
    rest = part.neutral + np.tensordot(random.normal(size=len(whole.modes)), part.modes, 1)
    triangles = triangulate(part.loops, part.counts, turn=1)
    if kind == "cut at the neck":
        low = rest[:, 2] < np.percentile(rest[:, 2], 8)
        triangles = triangles[~low[triangles].any(axis=1)]
    own = [part.landmarks[part.landmarks >= 0], *part.curves.values()]
    corners, weights = slid(rest, triangles, np.concatenate(own), seed)
    used = np.unique(triangles)
    place = np.full(len(rest), -1)
    order = random.permutation(len(used))
    place[used[order]] = np.arange(len(used))

    def blend(values):
        return np.einsum("nk,nkd->nd", weights, values[corners])[used[order]]

    turn = turned(random) * random.uniform(0.01, 3)
    offsets = np.array([blend(offset) @ turn.T for offset in part.expressions])
    on_face = np.isin(used[order], part.regions["face"])
    return blend(rest) @ turn.T, place[triangles], part, place, on_face, offsets, rest


def best(rest):
    """Error of the keys at the median, of perfect correspondence: the face alone, of the same triangles."""
    face = data.face().only("face")
    source, target = (lissom.Mesh(points, face.triangles) for points in (face.neutral, rest))
    fit = lissom.fit_correspondence(source, target, np.zeros((0, 2), int))
    keys = lissom.Transfer(source, target, fit).apply(face.neutral + face.expressions).vertices
    return np.median(errors(keys - rest, face.expressions))


def errors(found, known):
    sizes = np.array([root_mean_square(offset) for offset in known])
    off = np.array([root_mean_square(one - other) for one, other in zip(found, known, strict=True)])
    return (off / np.maximum(sizes, 1e-300))[sizes > 1e-3 * sizes.max()]


def gap(vertices, offsets, known, loop):
    """How much further apart the two sides of a loop are than known, in percent of the diagonal."""
    sides = Lids.of(vertices, loop)
    wide = [np.linalg.norm(sides.gaps(vertices + one), axis=1).mean() for one in (offsets, known)]
    return 100 * (wide[0] - wide[1]) / diagonal(vertices)


def people_row(told):
    print("| person | | vertices | sure | landmarks | keys over perfect | blink | lips | seconds |")
    print("|---:|---|---:|---:|---:|---:|---:|---:|---:|")
    rows = []
    for seed in range(told.people):
        kind = list(KINDS)[seed % len(KINDS)]
        vertices, triangles, part, place, on_face, known, rest = person(seed, kind)
        start = time.perf_counter()
        found = face_work((vertices, triangles), [], "ICT").wait()
        seconds = time.perf_counter() - start
        if isinstance(found, Unsure):
            print(f"| {seed} | {kind} | {len(vertices)} | none: {found.why} | | | | | {seconds:.1f} |")
            continue
        fit, face = found.located.fit, data.face().only(*SOURCE)
        there = part.landmarks >= 0
        marks = vertices[place[part.landmarks[there]]]
        off = np.linalg.norm(fit.fitted_vertices[face.landmarks[there]] - marks, axis=1).mean()
        error = np.median(errors(found.offsets[:, on_face], known[:, on_face]))
        least = best(rest[np.sort(part.regions["face"])])
        index = {name: k for k, name in enumerate(found.names)}

        def key(*names, of, index=index):
            return sum(of[index[name]] for name in names)

        loops = {name: place[loop] for name, loop in part.curves.items()}
        blinks = [
            gap(
                vertices,
                *(key(f"eyeBlink_{side[0].upper()}", of=of) for of in (found.offsets, known)),
                loops[f"lid_{side}"],
            )
            for side in ("left", "right")
        ]
        lips = gap(
            vertices, *(key("jawOpen", "mouthClose", of=of) for of in (found.offsets, known)), loops["lips"]
        )
        row = 100 * off / diagonal(vertices), error / least, max(blinks), lips, seconds
        rows.append(row)
        cells = f"{row[0]:.2f} % | {row[1]:.2f} | {row[2]:.3f} % | {row[3]:.3f} % | {seconds:.1f}"
        print(f"| {seed} | {kind} | {len(vertices)} | {found.located.certainty:.2f} | {cells} |", flush=True)
    if rows:
        middle, worst = np.median(rows, axis=0), np.max(rows, axis=0)
        for name, one in (("median", middle), ("worst", worst)):
            print(
                f"| {name} | | | | {one[0]:.2f} % | {one[1]:.2f} | {one[2]:.3f} % | {one[3]:.3f} % "
                f"| {one[4]:.1f} |"
            )


def heads_row(_):
    print(
        "| head | vertices | found by | eye seen | mouth | width | lips closed | smile | longest edge "
        "| mirror | verdicts | seconds |"
    )
    print("|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---|---:|")
    whole = {name: heads.made(name) for name in heads.SHAPES}
    whole |= {f"{name}, closed behind": heads.closed(head) for name, head in whole.items()}
    for name, head in whole.items():
        start = time.perf_counter()
        found = face_work((head.vertices, head.triangles), head.eyes, "ARKIT").wait()
        seconds = time.perf_counter() - start
        if isinstance(found, Unsure):
            print(f"| {name} | {len(head.vertices)} | none: {found.why} |" + " |" * 9)
            continue
        key = dict(zip(found.names, found.offsets, strict=True))
        both = head.vertices + key["eyeBlinkLeft"] + key["eyeBlinkRight"]
        open_eye = max(
            heads.seen(head, both, side) / heads.seen(head, head.vertices, side) for side in (0, 1)
        )
        # A key for a jaw that is open.
        shapes = key | {"mouthClose": key["jawOpen"] + key["mouthClose"]}
        left_open = heads.left_open(head, key["jawOpen"], shapes["mouthClose"])
        before, after = (np.ptp((head.vertices + by)[head.lips], axis=0) for by in (0, key["jawOpen"]))
        x = head.vertices[head.lips, 0]
        corners = head.lips[[x.argmin(), x.argmax()]]
        smile = (key["mouthSmileLeft"] + key["mouthSmileRight"])[corners, 2].min() / before[0]
        ends = np.concatenate(
            [head.triangles[:, [0, 1]], head.triangles[:, [1, 2]], head.triangles[:, [2, 0]]]
        )
        rest = np.linalg.norm(np.diff(head.vertices[ends], axis=1)[:, 0], axis=1)
        long = max(
            (np.linalg.norm(np.diff((head.vertices + by)[ends], axis=1)[:, 0], axis=1) / rest).max()
            for by in shapes.values()
        )
        crooked = max(
            np.abs(key[one + "Left"][head.twins] * [-1, 1, 1] - key[one + "Right"]).max()
            / np.abs(key[one + "Left"]).max()
            for one in (
                other.removesuffix("Left")
                for other in found.names
                if other.endswith("Left") and other[:-4] + "Right" in key
            )
            if one not in ("jaw", "mouth")
        )
        print(
            f"| {name} | {len(head.vertices)} | {found.located.by.lower()}, no click "
            f"| {100 * open_eye:.1f} % "
            f"| {after[2] / before[2]:.1f} times | {after[0] / before[0]:.2f} "
            f"| to {100 * left_open:.0f} % | {100 * smile:.0f} % "
            f"| {long:.1f} times | {100 * crooked:.0f} % | {verdicts(found)} | {seconds:.1f} |",
            flush=True,
        )


def random_row(told):
    print("| seed | head | vertices | sure | verdicts | broken | seconds |")
    print("|---:|---|---:|---:|---|---|---:|")
    kept = 0
    for seed in range(told.first, told.first + told.seeds):
        drawn = random_heads.drawn(seed)
        start = time.perf_counter()
        found = face_work((drawn.vertices, drawn.triangles), drawn.parts, "ARKIT").wait()
        seconds = time.perf_counter() - start
        row = f"| {seed} | {drawn.told} | {len(drawn.vertices)} |"
        if isinstance(found, Unsure):
            print(f"{row} none: {found.why} | | | {seconds:.1f} |", flush=True)
            continue
        broken = random_heads.broken(drawn, dict(zip(found.names, found.offsets, strict=True)))
        kept += not broken
        told_of = f"{found.located.certainty:.2f} | {verdicts(found)} | {'; '.join(broken)}"
        print(f"{row} {told_of} | {seconds:.1f} |", flush=True)
    print(f"| | {kept} of {told.seeds} as promised | | | | | |")


def verdicts(found):
    return ", ".join(f"{found.quality.verdict.count(one)} {one}" for one in ("good", "look", "bad"))


def solids():
    """name -> vertices, triangles, of what is no face."""
    angle, turn = np.meshgrid(np.linspace(0, np.pi, 40)[1:-1], np.arange(64) * 2 * np.pi / 64, indexing="ij")
    ball = np.stack(
        [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=2
    ).reshape(-1, 3)
    rows = len(angle)
    a = (np.arange(rows - 1)[:, None] * 64 + np.arange(64)).ravel()
    b = (np.arange(rows - 1)[:, None] * 64 + (np.arange(64) + 1) % 64).ravel()
    faces = np.concatenate([np.column_stack([a, a + 64, b]), np.column_stack([b, a + 64, b + 64])])
    narrower = np.column_stack([1 - 0.15 * ball[:, 2], 1 - 0.15 * ball[:, 2], np.ones(len(ball))])
    yield "egg", ball * [1, 1.1, 1.4] * narrower, faces
    yield "cube", ball / np.abs(ball).max(axis=1, keepdims=True), faces
    width = np.interp(ball[:, 2], [-1, -0.8, -0.5, -0.2, 0.2, 0.6, 1], [1.2, 1.3, 0.5, 0.75, 0.9, 0.7, 0.05])
    round_ = ball[:, :2] / np.linalg.norm(ball[:, :2], axis=1, keepdims=True)
    yield "bust without features", np.column_stack([round_ * width[:, None], 1.8 * ball[:, 2]]), faces
    finger = np.exp(-(((np.degrees(np.arctan2(ball[:, 2], ball[:, 0])) % 60 - 30) / 12) ** 2))
    yield "hand", ball * [0.9, 0.3, 1.0] * (1 + 0.8 * finger * (ball[:, 2] > -0.2))[:, None], faces
    for file, name in (("cat_lion", "cat"), ("models", "spot")):
        if (FOLDER / f"{file}.npz").is_file():
            archive = load(file)
            vertices = archive["cat_reference" if name == "cat" else "spot_vertices"].astype(float)
            yield name, vertices, archive[f"{name}_faces"]


def others_row(_):
    print("| no face | vertices | keys | sure |")
    print("|---|---:|---|---:|")
    for name, vertices, triangles in solids():
        found = face_work((vertices, triangles), [], "ICT").wait()
        told = (
            f"none: {found.why} | " if isinstance(found, Unsure) else f"made | {found.located.certainty:.2f}"
        )
        print(f"| {name} | {len(vertices)} | {told} |", flush=True)


ROWS = {"people": people_row, "heads": heads_row, "random": random_row, "others": others_row}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", choices=[[], *ROWS], metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--people", type=int, default=20)
    parser.add_argument("--seeds", type=int, default=20, help="random heads")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed")
    told = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for row in told.rows or ROWS:
        ROWS[row](told)


if __name__ == "__main__":
    main()
