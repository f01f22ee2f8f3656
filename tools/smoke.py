"""Does the zip work in this Blender? Installs it, away from your settings, and runs the three jobs.

python tools/smoke.py dist/lissom-<version>-<platform>.zip --blender blender
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

MODULE = "bl_ext.user_default.lissom"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("zip", type=pathlib.Path, help="the extension")
    parser.add_argument("--blender", default="blender", help="Blender's executable")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as settings:
        environment = {**os.environ, "BLENDER_USER_RESOURCES": settings}

        def blender(*words):
            subprocess.run([options.blender, *words], env=environment, check=True)

        file = str(options.zip.resolve())
        blender("--command", "extension", "validate", file)
        blender("--command", "extension", "install-file", "-r", "user_default", "-e", file)
        blender("-b", "--python-exit-code", "1", "--python", str(pathlib.Path(__file__).resolve()))


def inside():
    """The three jobs, in Blender."""
    import addon_utils
    import bpy

    assert addon_utils.check(MODULE) == (True, True), f"{MODULE} is not enabled"
    import lissom

    assert bpy.app.tempdir not in lissom.__file__ and "site-packages" in lissom.__file__, lissom.__file__
    for job in (pose, transfer, inbetween):
        job(bpy)
        print(f"{job.__name__}: works", flush=True)
    print(f"Lissom {lissom.__version__} in Blender {bpy.app.version_string}: three jobs done", flush=True)


def run(operator, **properties):
    """Calls an operator, which must say that it is done."""
    assert operator(**properties) == {"FINISHED"}, operator.idname_py()


def tube(bpy, name):
    """A tube along z from 0 to 8, whose ends are groups."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.5, depth=8, end_fill_type="NOTHING")
    made = bpy.context.object
    made.name = name
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=15)
    bpy.ops.object.mode_set(mode="OBJECT")
    for group, holds in (("bottom", lambda z: z < -3.4), ("top", lambda z: z > 3.4)):
        members = [vertex.index for vertex in made.data.vertices if holds(vertex.co.z)]
        made.vertex_groups.new(name=group).add(members, 1.0, "REPLACE")
    return made


def heights(points):
    return [point.co.z for point in points]


def pose(bpy):
    """The top goes up, and the bottom stays."""
    made = tube(bpy, "Posed")
    for group in ("bottom", "top"):
        run(bpy.ops.lissom.pose_handle_add, object=made.name, vertex_group=group)
    run(bpy.ops.lissom.pose_bind, object=made.name)
    made.lissom_pose.handles["top"].empty.location.z += 1.0
    run(bpy.ops.lissom.pose_apply, object=made.name, name="longer")
    rest, posed = heights(made.data.vertices), heights(made.data.shape_keys.key_blocks["longer"].data)
    for before, after in zip(rest, posed, strict=True):
        shift = 0.0 if before < -3.4 else 1.0 if before > 3.4 else None
        assert shift is None or abs(after - before - shift) < 1e-5, (before, after)
    run(bpy.ops.lissom.pose_unbind, object=made.name)


def transfer(bpy):
    """A key of one tube on another of other topology in the same place."""
    source, target = tube(bpy, "Source"), tube(bpy, "Target")
    target.modifiers.new("Other faces", "SUBSURF").subdivision_type = "SIMPLE"
    bpy.context.view_layer.objects.active = target
    bpy.ops.object.modifier_apply(modifier="Other faces")
    source.shape_key_add(name="Basis", from_mix=False)
    key = source.shape_key_add(name="wider", from_mix=False)
    for point in key.data:
        point.co.x *= 1.5
    run(bpy.ops.lissom.transfer_keys, source=source.name, target=target.name, overlap=True)
    got = target.data.shape_keys.key_blocks["wider"]
    widest = max(point.co.x for point in got.data)
    assert abs(widest - 0.75) < 0.02, widest


def inbetween(bpy):
    """An arc from rest to a half turn keeps its radius."""
    made = tube(bpy, "Turned")
    made.shape_key_add(name="Basis", from_mix=False)
    key = made.shape_key_add(name="turned", from_mix=False)
    for point in key.data:
        point.co = (-point.co.z, point.co.y, point.co.x)
    run(bpy.ops.lissom.inbetween_bake, object=made.name, end="turned", count=5, slider="turn")
    made["turn"] = 0.5
    made.update_tag()
    bpy.context.view_layer.update()
    shown = made.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    farthest = max(vertex.co.length for vertex in shown.vertices)
    rest = max(vertex.co.length for vertex in made.data.vertices)
    assert abs(farthest / rest - 1) < 0.02, (farthest, rest)


if __name__ == "__main__":
    if "bpy" in sys.modules:
        inside()
    else:
        main()
