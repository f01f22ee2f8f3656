"""Posing, measured against libigl and against Blender's own Laplacian Deform, each pair in one run.

    make bench              all of it
    python bench/pose.py arap laplacian_deform table million

Times are medians of five; ratios are taken within the run, since machines differ and are noisy.
"""

import argparse
import json
import os
import resource
import statistics
import sys
import time
from pathlib import Path

import lissom
import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "native"))
from measured import load

REPEATS = 5


def median_time(work, repeats=REPEATS):
    """Median seconds of `work()`, and what it returned last."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times), result


def passes(pose):
    """Seconds that one pass over the memory of the factor takes: the least that a solve can cost."""
    memory = np.ones(max(pose.info["factor_bytes"] // 8, 1))
    return median_time(memory.sum)[0]


def model(name):
    archive = load("models")
    return archive[f"{name}_vertices"].astype(float), archive[f"{name}_faces"].astype(np.int64)


def bend(vertices, low=0.15, high=0.85, degrees=60.0):
    """The ends along the longest axis as handles, and a motion that bends and shifts the upper one."""
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    along = (vertices[:, axis] - vertices[:, axis].min()) / np.ptp(vertices[:, axis])
    fixed, moving = np.flatnonzero(along < low), np.flatnonzero(along > high)
    i, j = [k for k in range(3) if k != axis]
    angle = np.radians(degrees)
    matrix = np.eye(4)
    matrix[axis, axis] = matrix[i, i] = np.cos(angle)
    matrix[axis, i], matrix[i, axis] = -np.sin(angle), np.sin(angle)
    center = vertices[moving].mean(0)
    matrix[:3, 3] = center - matrix[:3, :3] @ center
    matrix[j, 3] += 0.2 * np.ptp(vertices[:, axis])
    return [fixed, moving], [np.eye(4), matrix]


def energy(vertices, faces, posed):
    """The spokes-and-rims energy, for both alike."""
    cells, size = np.zeros((len(vertices), 3, 3)), 0.0
    triangles = np.zeros((len(faces), 3, 3))
    for c in range(3):
        i, j, k = faces[:, c], faces[:, (c + 1) % 3], faces[:, (c + 2) % 3]
        a, b = vertices[j] - vertices[i], vertices[k] - vertices[i]
        weight = 0.5 * (a * b).sum(1) / np.linalg.norm(np.cross(a, b), axis=1)
        old, new = vertices[k] - vertices[j], posed[k] - posed[j]
        triangles += weight[:, None, None] * new[:, :, None] * old[:, None, :]
        size += 3 * (weight * ((old**2).sum(1) + (new**2).sum(1))).sum()
    for c in range(3):
        np.add.at(cells, faces[:, c], triangles)
    u, s, vt = np.linalg.svd(cells)
    s[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return size - 2 * s.sum()


def arap(libigl_iterations):
    """nefertiti: set-up, one iteration, and the time to the energy that libigl ends with."""
    import igl

    vertices, faces = model("nefertiti")
    handles, transforms = bend(vertices)
    given = np.concatenate(handles)
    targets = np.concatenate(
        [vertices[h] @ m[:3, :3].T + m[:3, 3] for h, m in zip(handles, transforms, strict=True)]
    )

    def igl_bind(iterations=1):
        state = igl.ARAPData()
        state.energy = igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS
        state.max_iter = iterations
        igl.arap_precomputation(vertices, faces, 3, given, state)
        return state

    plain = {"rotation_smoothing": 0.0, "smoothness": 0.0}
    bind, pose = median_time(lambda: lissom.Pose(lissom.Mesh(vertices, faces), handles, **plain))
    igl_bind_time, _ = median_time(igl_bind)
    ten = {"max_iterations": 10, "tolerance": 0.0, "warm_start": False}
    zero = ten | {"max_iterations": 0}
    start_time = median_time(lambda: pose.solve(transforms, **zero))[0]
    iteration = (median_time(lambda: pose.solve(transforms, **ten))[0] - start_time) / 10
    few = igl_bind(10)
    igl_iteration = median_time(lambda: igl.arap_solve(targets, few, vertices.copy()))[0] / 10

    many = igl_bind(libigl_iterations)
    igl_total, posed = median_time(lambda: igl.arap_solve(targets, many, vertices.copy()))
    final = energy(vertices, faces, posed)

    low, high = 0, 1

    def reach(iterations):
        options = {"max_iterations": iterations, "tolerance": 0.0, "warm_start": False}
        return energy(vertices, faces, pose.solve(transforms, **options).vertices)

    while reach(high) > final and high < 4096:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if reach(middle) <= final else (middle, high)
    options = {"max_iterations": high, "tolerance": 0.0, "warm_start": False}
    total = median_time(lambda: pose.solve(transforms, **options))[0]
    one_pass = passes(pose)
    return {
        "vertices": len(vertices),
        "bind": bind,
        "libigl bind": igl_bind_time,
        "bind ratio": igl_bind_time / bind,
        "start guess": start_time,
        "iteration": iteration,
        "libigl iteration": igl_iteration,
        "iteration ratio": igl_iteration / iteration,
        "libigl energy": final,
        "libigl iterations": libigl_iterations,
        "libigl seconds": igl_total,
        "iterations to that energy": high,
        "seconds to that energy": total,
        "ratio to that energy": igl_total / total,
        "one pass over the factor": one_pass,
        "in passes: bind, start guess, iteration": [
            seconds / one_pass for seconds in (bind, start_time, iteration)
        ],
    }


def solid():
    """nefertiti as a body against its surface alone: binding, and a move while the pose is live."""
    vertices, faces = model("nefertiti")
    handles, transforms = bend(vertices)
    results = {"vertices": len(vertices)}
    for method in ("arap", "poisson"):
        bind, poses, move = {}, {}, {}
        for body in (False, True):
            bind[body], poses[body] = median_time(
                lambda m=method, b=body: lissom.Pose(lissom.Mesh(vertices, faces), handles, method=m, solid=b)
            )
            poses[body].solve(transforms)
            move[body] = median_time(lambda p=poses[body]: p.solve(transforms, max_iterations=1), 9)[0]
        results[method] = {
            "bind": bind[True],
            "bind ratio": bind[True] / bind[False],
            "move": move[True],
            "move ratio": move[True] / move[False],
        }
    return results


def in_blender(vertices, faces):
    """The only object of a scene."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.meshes.new("Model")
    data.from_pydata(vertices.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new("Model", data)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def laplacian_deform():
    """nefertiti: bind and update, against Blender's Laplacian Deform modifier."""
    import bpy

    vertices, faces = model("nefertiti")
    handles, transforms = bend(vertices)
    obj = in_blender(vertices, faces)
    data = obj.data
    group = obj.vertex_groups.new(name="anchors")
    group.add(np.concatenate(handles).tolist(), 1.0, "REPLACE")
    modifier = obj.modifiers.new("deform", "LAPLACIANDEFORM")
    modifier.vertex_group = "anchors"
    modifier.iterations = 1
    bind_times = []
    for _ in range(REPEATS):
        if modifier.is_bind:
            bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
        begin = time.perf_counter()
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
        bind_times.append(time.perf_counter() - begin)
    flat = vertices.copy()

    def update():
        """Moves the anchors a little further and evaluates."""
        flat[handles[1]] += 0.001
        data.vertices.foreach_set("co", flat.astype(np.float32).ravel())
        data.update()
        bpy.context.view_layer.update()
        return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data

    update_time = median_time(update)[0]
    modifier.show_viewport = False
    without = median_time(update)[0]

    results = {"vertices": len(vertices), "Blender bind": statistics.median(bind_times)}
    results["Blender update"] = update_time - without
    for method in lissom.POSE_METHODS:
        if method in ("arap", "multiresolution"):
            continue
        bind, pose = median_time(
            lambda m=method: lissom.Pose(lissom.Mesh(vertices, faces), handles, method=m)
        )
        pose.solve(transforms)
        frame = median_time(lambda p=pose: p.solve(transforms), 9)[0]
        one_pass = passes(pose)
        results[method] = {
            "bind": bind,
            "bind ratio": results["Blender bind"] / bind,
            "update": frame,
            "update ratio": results["Blender update"] / frame,
            "in passes over the factor: bind, update": [bind / one_pass, frame / one_pass],
        }
    return results


def subdivided(vertices, faces):
    """Each triangle split into four at the middles of its edges."""
    edges = np.sort(np.concatenate([faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]]), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = (inverse.reshape(3, -1) + len(vertices)).astype(np.int64)
    i, j, k = faces.T
    quarters = [[i, c, b], [c, j, a], [b, a, k], [a, b, c]]
    return (
        np.concatenate([vertices, vertices[unique].mean(1)]),
        np.concatenate([np.stack(q, 1) for q in quarters]),
    )


def decimated_to(vertices, faces, wanted):
    """About so many vertices, by Blender's Decimate."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(vertices.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new("mesh", data)
    bpy.context.collection.objects.link(obj)
    modifier = obj.modifiers.new("decimate", "DECIMATE")
    modifier.ratio = wanted / len(vertices)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(evaluated.vertices) * 3, np.float32)
    evaluated.vertices.foreach_get("co", points)
    evaluated.calc_loop_triangles()
    triangles = np.empty(len(evaluated.loop_triangles) * 3, np.int32)
    evaluated.loop_triangles.foreach_get("vertices", triangles)
    return points.reshape(-1, 3).astype(float), triangles.reshape(-1, 3).astype(np.int64)


def in_child(function, *arguments):
    """Runs one measurement in a process of its own, so that its peak memory is its own."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        result = function(*arguments)
        result["peak GB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        result["peak GB before"] = before / 1e6
        os.write(writer, json.dumps(result).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return json.loads(text)


def set_up_and_play(vertices, faces, method, options=None):
    """Set-up (binding and responses) and frames per second while handles move as wholes."""
    handles, transforms = bend(vertices)
    begin = time.perf_counter()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method, **(options or {}))
    pose.solve(transforms)
    seconds = time.perf_counter() - begin
    frame = median_time(lambda: pose.solve(transforms), 20)[0]
    return {"set-up": seconds, "frames per second": 1 / frame}


def table():
    """Table 2-1 of the thesis at its sizes."""
    nefertiti = model("nefertiti")
    large = subdivided(*nefertiti)
    rows = []
    for wanted in (1254, 10139, 20031, 42568, 100086):
        source = nefertiti if wanted < 49000 else large
        mesh = decimated_to(*source, wanted)
        for method in ("laplacian", "laplacian_fitted"):
            row = in_child(set_up_and_play, *mesh, method)
            rows.append({"vertices": len(mesh[0]), "method": method} | row)
    return rows


def million():
    """A million vertices: bind and solve."""
    mesh = model("ogre")
    for _ in range(3):
        mesh = subdivided(*mesh)
    mesh = decimated_to(*mesh, 1_000_000)
    return [
        {"vertices": len(mesh[0]), "method": method} | in_child(bind_and_solve, *mesh, method)
        for method in ("arap", "laplacian", "rotation_invariant", "poisson")
    ]


def bind_and_solve(vertices, faces, method):
    handles, transforms = bend(vertices)
    begin = time.perf_counter()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method)
    bound = time.perf_counter()
    options = {"max_iterations": 10} if method == "arap" else {}
    report = pose.solve(transforms, **options).report
    return {"bind": bound - begin, "solve": time.perf_counter() - bound, "iterations": report["iterations"]}


def main():
    parts = ["arap", "solid", "laplacian_deform", "table", "million"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", default=parts)
    parser.add_argument("--libigl-iterations", type=int, default=1000)
    parser.add_argument("--out", type=Path, default=Path("build/bench"))
    arguments = parser.parse_args()
    load("models")  # or say at once that it is missing
    arguments.out.mkdir(parents=True, exist_ok=True)
    for part in arguments.parts or parts:
        result = arap(arguments.libigl_iterations) if part == "arap" else globals()[part]()
        print(part, json.dumps(result, indent=1), flush=True)
        (arguments.out / f"pose_{part}.json").write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
