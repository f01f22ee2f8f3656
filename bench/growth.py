"""How time and memory grow with every size of the input: nothing faster than its power of 1.5.

    python bench/growth.py [--out build/bench] [pose.arap fit ...]

Each case runs in a process of its own, since the most memory that one has taken does not fall again; making
the input is part of that memory and not of the time. Seconds are the processor's, on which other work tells
least. The power is that between the two largest sizes, where what is constant counts least.
"""

import argparse
import json
import math
import resource
import subprocess
import sys
import time
from pathlib import Path

import lissom
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/native"))
from shapes import ends, moved, rigid, tube

MOST = 1.5
"""The power of the size that neither time nor memory may exceed."""
PATIENCE = 600
"""Seconds after which a case is given up."""

SIZES = [5_000, 20_000, 80_000, 320_000, 1_280_000]
MOTIONS = [np.eye(4), rigid((0, 0, 1), 0.5)]


def tube_of(count):
    """An open tube of about so many vertices, four times as many along as around."""
    columns = max(int(math.sqrt(count / 4)), 3)
    return tube(rows=count // columns, columns=columns)


def cards(count):
    """Loose cards of two triangles that stand on a tube, as hair does, and the tube: vertices, triangles."""
    skin, faces = tube_of(5_000)
    rng = np.random.default_rng(0)
    roots = skin[rng.integers(0, len(skin), count)] * (1, 1.02, 1.02)
    card = np.array([[0, 0, 0], [0.02, 0, 0], [0.02, 0, 0.1], [0, 0, 0.1]])
    of_cards = len(skin) + 4 * np.arange(count)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    vertices = np.concatenate([skin, (roots[:, None] + card).reshape(-1, 3)])
    return vertices, np.concatenate([faces, of_cards.reshape(-1, 3)])


def star(degree):
    """A disk of two rings around one vertex of that degree."""
    angle = 2 * np.pi * np.arange(degree) / degree
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(3 * angle)])
    inner, outer = 1 + np.arange(degree), 1 + degree + np.arange(degree)
    after = np.roll(inner, -1), np.roll(outer, -1)
    faces = [
        np.column_stack([0 * inner, inner, after[0]]),
        np.column_stack([inner, outer, after[1]]),
        np.column_stack([inner, after[1], after[0]]),
    ]
    return np.concatenate([np.zeros((1, 3)), ring, 2 * ring]), np.concatenate(faces)


def pose(method, shape=tube_of, **options):
    def work(size):
        vertices, faces = shape(size)
        mesh, handles = lissom.Mesh(vertices, faces), ends(vertices)
        return lambda: lissom.Pose(mesh, handles, method=method, **options).solve(MOTIONS, max_iterations=10)

    return work


def handles(count):
    """So many single vertices of a tube of 20,000, each moved a little."""
    vertices, faces = tube_of(20_000)
    mesh = lissom.Mesh(vertices, faces)
    held = np.linspace(0, len(vertices) - 1, count).astype(int)[:, None]
    motions = [rigid(offset=(0, 0, 0.01 * (i % 7))) for i in range(count)]
    return lambda: lissom.Pose(mesh, list(held)).solve(motions, max_iterations=10)


def pair(size, shape=tube_of):
    """A mesh, and the same one larger and turned a little; its vertices and faces."""
    vertices, faces = shape(size)
    other = moved(rigid((1, 2, 3), 0.1), 1.3 * vertices)
    # In another order, since the same triangles would need no fit.
    return lissom.Mesh(vertices, faces), lissom.Mesh(other, faces[::-1]), vertices, faces


def fitted(source, target, marked):
    return lissom.fit_correspondence(source, target, np.column_stack([marked, marked]))


def fit(shape=tube_of):
    def work(size):
        source, target, _, _ = pair(size, shape)
        marked = np.linspace(0, 4_900, 20).astype(int)
        return lambda: fitted(source, target, marked)

    return work


def markers(count):
    source, target, vertices, _ = pair(20_000)
    marked = np.linspace(0, len(vertices) - 1, count).astype(int)
    return lambda: fitted(source, target, marked)


def keys(count):
    source, target, vertices, faces = pair(20_000)
    same = np.column_stack([np.arange(len(faces)), np.arange(len(faces))[::-1]])
    rng = np.random.default_rng(0)
    poses = np.stack([vertices + 0.1 * rng.normal(size=3) * np.sin(vertices) for _ in range(count)])
    return lambda: lissom.Transfer(source, target, same).apply(poses)


def transfer(size):
    source, target, vertices, faces = pair(size)
    same = np.column_stack([np.arange(len(faces)), np.arange(len(faces))[::-1]])
    poses = np.stack([vertices + 0.1 * np.sin(vertices * k) for k in range(10)])
    return lambda: lissom.Transfer(source, target, same).apply(poses)


def path(shape=tube_of, **options):
    def work(size):
        vertices, faces = shape(size)
        mesh = lissom.Mesh(vertices, faces)
        end = moved(rigid((0, 1, 0), 1.0), vertices) + 0.1 * np.sin(vertices[:, [1, 2, 0]])
        asked = {name: make(vertices) for name, make in options.items()}
        return lambda: lissom.Inbetween(mesh, vertices, end, **asked).keyframes(1e-2, 8)

    return work


def ball(vertices):
    """A closed mesh as fine as these vertices, within them, for `clearance`."""
    n = max(int(math.sqrt(len(vertices))), 8)
    around, rings = tube(rows=n, columns=n, length=1.0, bumps=0.0)
    poles = np.array([[0, 0, 0], [1.0, 0, 0]])
    first, last, c = np.arange(n), len(around) - n + np.arange(n), len(around)
    caps = [
        np.column_stack([0 * first + c, np.roll(first, -1), first]),
        np.column_stack([0 * last + c + 1, last, np.roll(last, -1)]),
    ]
    return lissom.Mesh(np.concatenate([around, poles]) * 0.5, np.concatenate([rings, *caps]))


COUNTS = {
    **{
        f"pose.{method}": (SIZES if method != "laplacian_fitted" else SIZES[:3], pose(method))
        for method in lissom.POSE_METHODS
    },
    "pose.arap solid": (SIZES[:4], pose("arap", solid=True)),
    **{f"degree, {method}": ([1_250, 5_000, 20_000], pose(method, star)) for method in lissom.POSE_METHODS},
    "handles": ([10, 100, 1_000], handles),
    "loose cards, pose": ([500, 5_000, 50_000], pose("arap", cards)),
    "fit": (SIZES[:4], fit()),
    "loose cards, fit": ([500, 5_000, 50_000], fit(cards)),
    "markers": ([50, 500, 5_000], markers),
    "transfer of ten keys": (SIZES, transfer),
    "keys": ([5, 50, 500], keys),
    "path": (SIZES[:4], path()),
    "loose cards, path": ([500, 5_000, 50_000], path(cards)),
    "path, refined": (SIZES[:3], path(refinement=lambda _: 4)),
    "path, clearance": (SIZES[:3], path(clearance=ball)),
}


def once(name, size):
    work = COUNTS[name][1](size)
    begin = time.process_time()
    work()
    seconds = time.process_time() - begin
    print(json.dumps([seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024]))


def measured(name, size):
    """Seconds and megabytes of one case; None and why, where there are none."""
    command = [sys.executable, "-W", "ignore", __file__, "--once", name, str(size)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return None, f"over {PATIENCE} s"
    if done.returncode:
        return None, done.stderr.strip().splitlines()[-1].removeprefix("lissom.")
    return json.loads(done.stdout), None


def power(sizes, values):
    """The exponent between the two largest sizes."""
    return (
        math.log(values[-1] / values[-2]) / math.log(sizes[-1] / sizes[-2]) if len(values) > 1 else math.nan
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="a part of what to measure, all by default")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--once", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.once:
        return once(asked.once[0], int(asked.once[1]))
    lines = ["| what | sizes | seconds | MB | power of time | of memory |", "|---|---|---|---|---|---|"]
    print(*lines, sep="\n")
    for name, (sizes, _) in COUNTS.items():
        if asked.names and not any(part in name for part in asked.names):
            continue
        found, why = [], None
        for size in sizes:
            case, why = measured(name, size)
            if why:
                break
            found.append(case)
        seconds, megabytes = [[case[k] for case in found] for k in (0, 1)]
        powers = [power(sizes[: len(found)], values) for values in (seconds, megabytes)]
        told = [f"**{p:.2f}**" if p > MOST else f"{p:.2f}" for p in powers]
        shown = ", ".join(f"{s:,}" for s in sizes[: len(found)]) + (
            f"; {sizes[len(found)]:,}: {why}" if why else ""
        )
        times, memory = (", ".join(f"{v:.3g}" for v in values) for values in (seconds, megabytes))
        lines.append(f"| {name} | {shown} | {times} | {memory} | {told[0]} | {told[1]} |")
        print(lines[-1], flush=True)
    if asked.out:
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / "growth.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
