"""Transfer, measured where the answer is known: ICT's expressions on its own identities, remeshed three ways.

    make bench                                 all benches
    python bench/transfer.py                   in an environment with bpy and the wheel

Offsets of ICT FaceKit add up, so neutral + identity + expression is the answer; at a vertex of a remeshed
identity it is the expression's offset at that place of the surface. The 68 landmarks alone are markers, as
points of the remeshed surface. Errors are root mean squares on the face over those of the expression itself.
The data knows no sizes: an identity that is 4 % smaller has the same offsets, which transfer makes smaller.
"""

import json
import os
import statistics
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "native")]

import bpy  # noqa: E402
import lissom  # noqa: E402
import numpy as np  # noqa: E402
from faces import diagonal, root_mean_square, slid, triangulate  # noqa: E402
from mathutils.bvhtree import BVHTree  # noqa: E402
from measured import load  # noqa: E402
from pose import decimated_to, subdivided  # noqa: E402

FACE = 9409  # vertices of the face come first


def located(points, normals, vertices, faces):
    """Triangle (k,) and weights (k, 3) of the closest place of a surface that faces the same way."""
    corners = vertices[faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    tree = BVHTree.FromPolygons(vertices.tolist(), faces.tolist())
    found = np.empty(len(points), dtype=int)
    places = np.empty((len(points), 3))
    for i, point in enumerate(points):
        place, _, index, distance = tree.find_nearest(point)
        reach = max(1.5 * distance, 1e-3)
        while facing[index] @ normals[i] <= 0 and reach < 10:
            near = [hit for hit in tree.find_nearest_range(point, reach) if facing[hit[2]] @ normals[i] > 0]
            if near:
                place, _, index, _ = min(near, key=lambda hit: hit[3])
            reach *= 2
        found[i], places[i] = index, place
    a, b, c = (vertices[faces[found, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = (normal**2).sum(1)
    v = (np.cross(places - a, c - a) * normal).sum(1) / area
    w = (np.cross(b - a, places - a) * normal).sum(1) / area
    return found, np.column_stack([1 - v - w, v, w])


def vertex_normals(vertices, faces):
    normals = np.zeros_like(vertices)
    cross = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    for k in range(3):
        np.add.at(normals, faces[:, k], cross)
    return normals


def remeshed(archive, full, faces):
    """name -> vertices, faces, and what values (n, 3) of the whole mesh are at these vertices."""
    other = triangulate(archive["loops"], archive["counts"], turn=1)
    corners, weights = slid(full, other, archive["landmarks"])

    def blend(values):
        return np.einsum("nk,nkc->nc", weights, values[corners])

    yield "re-triangulated, vertices moved", blend(full), other, blend
    yield "subdivided", *subdivided(full, faces), lambda values: subdivided(values, faces)[0]
    vertices, fewer = decimated_to(full, faces, len(full) // 2)
    found, places = located(vertices, vertex_normals(vertices, fewer), full, faces)
    yield (
        "decimated to half",
        vertices,
        fewer,
        lambda values: np.einsum("nk,nkc->nc", places, values[faces[found]]),
    )


def accuracy(archive):
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    faces = triangulate(archive["loops"], archive["counts"])
    names = [str(name) for name in archive["expression_names"]]
    wanted = [k for k, name in enumerate(names) if not name.startswith("Pupil")][:53]
    offsets = archive["expressions"][wanted].astype(float)
    source, rows = lissom.Mesh(neutral, faces), []
    on_face = np.zeros((len(neutral), 3))
    on_face[:FACE] = 1
    for identity, name in zip(archive["identities"], archive["identity_names"], strict=True):
        full = neutral + identity
        spread = [np.linalg.norm(p[:FACE] - p[:FACE].mean(0)) for p in (full, neutral)]
        for how, vertices, triangles, at in remeshed(archive, full, faces):
            normals = vertex_normals(full, faces)[landmarks]
            found, places = located(full[landmarks], normals, vertices, triangles)
            points = np.einsum("nk,nkc->nc", places, vertices[triangles[found]])
            pairs = np.column_stack([landmarks, triangles[found, places.argmax(1)]])
            target = lissom.Mesh(vertices, triangles)
            begin = time.perf_counter()
            fit = lissom.fit_correspondence(source, target, pairs, points)
            fitted = time.perf_counter()
            result = lissom.Transfer(source, target, fit).apply(neutral + offsets).vertices
            end = time.perf_counter()
            mask = at(on_face)[:, 0] > 0.99
            relative = {}
            for k, shape, offset in zip(wanted, result, offsets, strict=True):
                expected = at(offset)[mask]
                error = (shape - vertices)[mask] - expected
                relative[names[k]] = root_mean_square(error) / root_mean_square(expected)
            values = list(relative.values())
            worst = sorted(relative, key=relative.get)[-3:]
            rows.append(
                {
                    "identity": str(name),
                    "size": spread[0] / spread[1],
                    "remeshed": how,
                    "vertices": len(vertices),
                    "median": float(np.median(values)),
                    "90th percentile": float(np.percentile(values, 90)),
                    "worst": {key: round(relative[key], 3) for key in reversed(worst)},
                    "fit seconds": fitted - begin,
                    "53 keys, seconds": end - fitted,
                }
            )
            print(json.dumps(rows[-1]), flush=True)
    return rows


def cat_to_lion():
    archive = load("cat_lion")
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        cat = lissom.Mesh(archive["cat_reference"], archive["cat_faces"])
        lion = lissom.Mesh(archive["lion_reference"], archive["lion_faces"])
        fit = lissom.fit_correspondence(cat, lion, archive["markers"])
        result = lissom.Transfer(cat, lion, fit).apply(archive["cat_poses"]).vertices
        times.append(time.perf_counter() - begin)
    errors = result - archive["lion_poses"]
    errors -= errors.mean(axis=1, keepdims=True)
    mean = np.mean([root_mean_square(error) for error in errors]) / diagonal(archive["lion_reference"])
    return {"fit and nine poses, seconds": statistics.median(times), "error of the diagonal": mean}


def one_more_key(archive):
    """What keys cost once all is prepared, over the back-substitution that they need at least."""
    neutral, faces = archive["neutral"].astype(float), triangulate(archive["loops"], archive["counts"])
    target = lissom.Mesh(neutral + archive["identities"][1], faces[::-1])  # not recognised as the same
    fit = lissom.fit_correspondence(
        lissom.Mesh(neutral, faces), target, np.repeat(archive["landmarks"], 2).reshape(-1, 2)
    )
    transfer = lissom.Transfer(lissom.Mesh(neutral, faces), target, fit)
    keys = neutral + archive["expressions"][2:55].astype(float)
    reports = [transfer.apply(keys).report for _ in range(7)]
    return {
        "seconds a key": statistics.median(report["seconds"] for report in reports) / len(keys),
        "over its back-substitution": statistics.median(
            report["seconds"] / report["solve_seconds"] for report in reports
        ),
    }


def large(archive):
    """A face of 200,000 vertices as the target."""
    neutral, landmarks = archive["neutral"].astype(float), archive["landmarks"]
    faces = triangulate(archive["loops"], archive["counts"])
    vertices, triangles = neutral + archive["identities"][1], faces
    for _ in range(2):
        vertices, triangles = subdivided(vertices, triangles)
    vertices, triangles = decimated_to(vertices, triangles, 200_000)
    near = [
        int(np.linalg.norm(vertices - (neutral + archive["identities"][1])[v], axis=1).argmin())
        for v in landmarks
    ]
    _, once = np.unique(near, return_index=True)
    pairs = np.column_stack([landmarks[once], np.array(near)[once]])
    keys = neutral + archive["expressions"][2:55].astype(float)
    begin = time.perf_counter()
    source, target = lissom.Mesh(neutral, faces), lissom.Mesh(vertices, triangles)
    fit = lissom.fit_correspondence(source, target, pairs)
    fitted = time.perf_counter()
    transfer = lissom.Transfer(source, target, fit)
    prepared = time.perf_counter()
    transfer.apply(keys)
    return {
        "vertices": len(vertices),
        "fit seconds": fitted - begin,
        "prepare seconds": prepared - fitted,
        "53 keys, seconds": time.perf_counter() - prepared,
    }


def main():
    archive = dict(load("ict_face"))
    result = {
        "cat to lion": cat_to_lion(),
        "one more key": one_more_key(archive),
        "accuracy": accuracy(archive),
        "large": large(archive),
    }
    print("transfer", json.dumps(result, indent=1), flush=True)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash on its way out


if __name__ == "__main__":
    assert bpy.app.version  # decimation is Blender's
    main()
