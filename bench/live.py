"""Live posing in Blender: updates a second while a handle of a mesh of 50,000 vertices moves.

    python bench/live.py [method ...]          in an environment with bpy and the wheel

What an update costs beside the solve is the bridge: reading handles, checking that the mesh is the one that
was bound, and writing the shape key; and what Blender itself takes to evaluate the changed mesh.
"""

import json
import os
import pathlib
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "blender"), str(ROOT / "bench")]

import conftest  # noqa: E402

conftest._package.register()

import bpy  # noqa: E402
import lissom  # noqa: E402
import numpy as np  # noqa: E402
import pose  # noqa: E402
from bl_ext.user_default.lissom import live  # noqa: E402
from bl_ext.user_default.lissom.jobs.bound import follow  # noqa: E402

MOVES = 40


def bound(method):
    """nefertiti with both ends as handles."""
    vertices, faces = pose.model("nefertiti")
    handles, _ = pose.bend(vertices)
    obj = pose.in_blender(vertices, faces)
    for name, members in zip(("held", "moved"), handles, strict=True):
        obj.vertex_groups.new(name=name).add(members.tolist(), 1.0, "REPLACE")
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
    bpy.ops.lissom.pose_bind(object=obj.name, method=method)
    return obj


def play(obj):
    """Milliseconds of one move: all of it, our update within it, and the native solve within that."""
    bpy.app.handlers.depsgraph_update_post.remove(live._on_update)
    from bl_ext.user_default.lissom import session

    handle = obj.lissom_pose.handles["moved"].empty
    whole, ours, solves = [], [], []
    native = session.poses[obj.session_uid]
    steps = native.steps

    def timed(*arguments, **options):
        begin = time.perf_counter()
        result = yield from steps(*arguments, **options)
        solves.append(time.perf_counter() - begin)
        return result

    native.steps = timed
    for _ in range(MOVES):
        handle.rotation_euler.z += np.radians(1.0)
        begin = time.perf_counter()
        bpy.context.view_layer.update()
        middle = time.perf_counter()
        follow(obj, live.BUDGET)
        end = time.perf_counter()
        obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        whole.append(time.perf_counter() - begin)
        ours.append(end - middle)
    bpy.app.handlers.depsgraph_update_post.append(live._on_update)
    update, own, solving = (1e3 * statistics.median(times[5:]) for times in (whole, ours, solves))
    return {
        "move ms": update,
        "moves a second": 1e3 / update,
        "solve ms": solving,
        "bridge ms": own - solving,
        "Blender ms": update - own,
    }


def main():
    methods = sys.argv[1:] or lissom.POSE_METHODS
    result = {"Blender": bpy.app.version_string} | {method: play(bound(method)) for method in methods}
    print("live", json.dumps(result, indent=1), flush=True)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash on its way out


if __name__ == "__main__":
    main()
