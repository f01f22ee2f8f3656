"""In-betweens, measured: seconds at 50,000 vertices, and the lengths along the way to nine poses of a cat.

    make bench
    python bench/inbetween.py speed cat

Times are medians of five; each is also given as a multiple of blending the two shapes along a straight line.
"""

import argparse

import lissom
import numpy as np
from pose import load, median_time, model

TIMES = np.linspace(0, 1, 12)[1:-1]
OPTIONS = {
    "consistent": {},
    "consistent, 4 rounds": {"refinement": 4},
    "consistent, 16 rounds": {"refinement": 16},
    "relative": {"rotation": "relative"},
    "relative, 16 rounds": {"rotation": "relative", "refinement": 16},
}


def twisted(vertices, angle=2.0):
    """The far end along z turned by `angle` radians about z, everything else in proportion."""
    z = vertices[:, 2]
    turn = angle * (z - z.min()) / np.ptp(z)
    x, y = vertices[:, 0], vertices[:, 1]
    return np.column_stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z])


def speed():
    start, faces = model("nefertiti")
    end, mesh = twisted(start), lissom.Mesh(start, faces)
    straight, _ = median_time(lambda: start + TIMES[:, None, None] * (end - start))
    print(f"{len(start)} vertices; ten straight-line blends {straight:.4f} s")
    print("| options | prepare | ten in-betweens | one more | of straight |")
    print("|---|---:|---:|---:|---:|")
    for name, options in OPTIONS.items():
        prepare, path = median_time(lambda options=options: lissom.Inbetween(mesh, start, end, **options))
        ten, _ = median_time(lambda path=path: path.at(TIMES))
        one, _ = median_time(lambda path=path: path.at([0.37]))
        print(f"| {name} | {prepare:.3f} | {ten:.3f} | {one:.3f} | {ten / straight:.0f} x |", flush=True)
    path = lissom.Inbetween(mesh, start, end)
    for share in (1e-2, 1e-3):
        seconds, times = median_time(lambda share=share: path.keyframes(share * mesh.diagonal), 3)
        print(f"keyframes at {share:g} of the diagonal: {len(times)} keys, {seconds:.2f} s")


def edge_error(faces, start, end, x):
    """Root mean square relative deviation of the edge lengths from the mean of both ends."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    i, j = np.unique(np.sort(sides, axis=1), axis=0).T
    a, b, now = (np.linalg.norm(p[i] - p[j], axis=1) for p in (start, end, x))
    return np.sqrt(np.mean((2 * now / (a + b) - 1) ** 2))


def cat():
    archive = load("cat_lion")
    start, faces = archive["cat_reference"].astype(float), archive["cat_faces"]
    mesh, times = lissom.Mesh(start, faces), [1 / 6, 1 / 2, 5 / 6]
    print("error of edge lengths at t = 1/6, 1/2, 5/6")
    print("| pose | straight | " + " | ".join(OPTIONS) + " |")
    print("|---:|" + "---:|" * (len(OPTIONS) + 1))
    for number, pose in enumerate(archive["cat_poses"].astype(float), 1):
        ways = [[start + t * (pose - start) for t in times]]
        ways += [lissom.Inbetween(mesh, start, pose, **options).at(times) for options in OPTIONS.values()]
        cells = (", ".join(f"{edge_error(faces, start, pose, x):.3f}" for x in way) for way in ways)
        print(f"| {number} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    jobs = {"speed": speed, "cat": cat}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("jobs", nargs="*", choices=[[], *jobs], default=[])
    for job in parser.parse_args().jobs or jobs:
        jobs[job]()
