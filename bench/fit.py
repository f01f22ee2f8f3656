"""How forgiving a fit is: errors over those of perfect correspondence, by how far how many clicks are off.

    python bench/fit.py [SEEDS]        in an environment with the wheel; needs LISSOM_DATA

People are random sums of the ICT face's identity modes. Ten seeds take some half an hour.
"""

import os
import sys
from pathlib import Path

import lissom
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "native")]

from test_fit_forgives import Head, carried, clicked, shuffled  # noqa: E402

DATA = Path(os.environ.get("LISSOM_DATA", ROOT.parent / "shared" / "data"))

AMOUNTS = (0.0, 0.0025, 0.005, 0.01, 0.02)

# Of the 68 landmarks of the iBUG scheme: all, those that say where what is, and fewer.
MARKERS = {
    68: np.arange(68),
    21: np.r_[0, 4, 8, 12, 16, 19, 21, 24, 27, 30, 33, 36, 39, 42, 45, 48, 51, 54, 57, 62, 66],
    13: np.r_[0, 8, 16, 27, 30, 36, 39, 42, 45, 48, 51, 54, 57],
    6: np.r_[8, 27, 36, 45, 48, 54],
}


def load(name):
    path = DATA / f"{name}.npz"
    if not path.is_file():
        sys.exit(f"no {path.name} in {DATA}: set LISSOM_DATA to the folder that has it")
    return dict(np.load(path))


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    head = Head(load)
    source = lissom.Mesh(head.rest, head.faces)
    times = {}
    for seed in range(seeds):
        person = head.person(seed)
        best = head.best(person)
        vertices, faces, place, order = shuffled(person, head.faces)
        target = lissom.Mesh(vertices, faces)

        def cost(markers, points=None, target=target, vertices=vertices, order=order, best=best):
            _, keys = carried(source, target, markers, head.rest + head.offsets, points)
            return np.median(head.errors(keys, vertices, head.offsets[:, order])) / best

        for count, chosen in MARKERS.items():
            landmarks = head.landmarks[chosen]
            for amount in AMOUNTS:
                points = clicked(person[landmarks], person, head.faces, amount, seed)
                times.setdefault((count, amount), []).append(
                    cost(np.column_stack([landmarks, place[landmarks]]), points)
                )
        times.setdefault((0, 0.0), []).append(cost(None))
    print(f"{seeds} people; median and worst of the error over that of perfect correspondence")
    print("| markers | " + " | ".join(f"{100 * amount:g} % off" for amount in AMOUNTS) + " |")
    print("|---:|" + "---:|" * len(AMOUNTS))
    for count in MARKERS:
        cells = [times[count, amount] for amount in AMOUNTS]
        print(f"| {count} | " + " | ".join(f"{np.median(c):.2f}, {max(c):.2f}" for c in cells) + " |")
    print(f"| none | {np.median(times[0, 0.0]):.2f}, {max(times[0, 0.0]):.2f} |" + " |" * (len(AMOUNTS) - 1))


if __name__ == "__main__":
    main()
