"""An arm that bends by its bone: by weights, with a corrective on top, and by an arc that the bone drives."""

import bpy
import numpy as np
import scene
from mathutils import Matrix, Vector
from studio import Tile

BEND = 120.0  # degrees
SHOWN = (0.0, 0.5, 1.0)  # of the bend
TOLERANCE = 0.004  # of the arm's length of 3.2
LENGTH, AROUND, RINGS = 1.6, 48, 121  # of upper arm and forearm, from the elbow at the origin
ELBOW = 0.5  # how far from it the bones hold the arm
UPPER, FOREARM, TIP = "upper arm", "forearm", "elbow"
MENDED, BENT, SLIDER = "elbow mended", "bent", "bend"
PULL = 0.14  # of the elbow's tip, out of the bend


def run(given, made, studio, picture):
    """Poses, bakes and drives by operators, as docs/tutorials/arm.md tells; returns figures."""
    into = scene.collection("7 Elbow")
    rig, arm = skeleton(into), tube("Arm", made, into)
    skinned, corrected = tube("Skinned arm", given, into), tube("Skinned arm, corrected", made, into)
    for obj in (skinned, corrected):
        obj.modifiers.new("Armature", "ARMATURE").object = rig
    correct(corrected, rig)
    bend(arm)
    drive(arm, rig)

    rows, area = [], {}
    for label, obj in (("by weights", skinned), ("corrected", corrected), ("arc", arm)):
        rows.append([])
        for part in SHOWN:
            rig.pose.bones[FOREARM].rotation_euler.z = -np.radians(BEND) * part
            mesh = evaluated(obj)
            area[label, part] = girth(mesh)
            note = f"{100 * area[label, part] / area[label, 0.0]:.0f} % of the elbow's section"
            rows[-1].append(Tile([mesh], f"{label}, {BEND * part:.0f}°", (0.5, -0.25), 4.1, note=note))
    studio.sheet(rows, picture, aspect=0.9, width=1200)
    return {
        "keys": len(arm.lissom_inbetween.arcs[SLIDER].keys),
        "section_percent": {
            label: 100 * area[label, 1.0] / area[label, 0.0] for label in ("by weights", "corrected", "arc")
        },
    }


def correct(obj, rig):
    """A key that mends the bent elbow, through the weights, and the bone that drives it."""
    rig.pose.bones[FOREARM].rotation_euler.z = -np.radians(BEND)
    bpy.context.view_layer.update()
    for name in (f"held {UPPER}", f"held {FOREARM}", TIP):
        scene.run(bpy.ops.lissom.pose_handle_add, object=obj.name, vertex_group=name)
    scene.run(bpy.ops.lissom.pose_bind, object=obj.name)
    half = np.radians(BEND / 2)
    obj.lissom_pose.handles[TIP].empty.location += PULL * Vector((-np.cos(half), 0, np.sin(half)))
    scene.run(bpy.ops.lissom.pose_apply, object=obj.name, name=MENDED)
    scene.run(bpy.ops.lissom.pose_unbind, object=obj.name)
    scene.run(bpy.ops.lissom.pose_drive, object=obj.name, key=MENDED, armature=rig.name, bone=FOREARM)


def bend(arm):
    """The shape at the end of the bend, by two handles, and the arc to it."""
    for name in (f"held {UPPER}", f"held {FOREARM}"):
        scene.run(bpy.ops.lissom.pose_handle_add, object=arm.name, vertex_group=name)
    scene.run(bpy.ops.lissom.pose_bind, object=arm.name, solid=True)
    empty = arm.lissom_pose.handles[f"held {FOREARM}"].empty
    empty.matrix_world = Matrix.Rotation(np.radians(BEND), 4, "Y") @ empty.matrix_world
    scene.run(bpy.ops.lissom.pose_apply, object=arm.name, name=BENT, value=0.0)
    scene.run(bpy.ops.lissom.pose_unbind, object=arm.name)
    scene.run(
        bpy.ops.lissom.inbetween_bake,
        object=arm.name,
        end=BENT,
        sampling="TOLERANCE",
        tolerance=TOLERANCE,
        slider=SLIDER,
    )


def drive(arm, rig):
    """The bone's turn about its own Z drives the slider."""
    driver = arm.driver_add(f'["{SLIDER}"]').driver
    variable = driver.variables.new()
    variable.name, variable.type = "turn", "TRANSFORMS"
    target = variable.targets[0]
    target.id, target.bone_target = rig, FOREARM
    target.transform_type, target.transform_space = "ROT_Z", "LOCAL_SPACE"
    driver.expression = f"-turn / radians({BEND:g})"


def skeleton(into):
    """Two bones that meet at the elbow."""
    rig = bpy.data.objects.new("Skeleton", bpy.data.armatures.new("Skeleton"))
    into.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    upper, forearm = (rig.data.edit_bones.new(name) for name in (UPPER, FOREARM))
    upper.head, upper.tail = (0, 0, -LENGTH), (0, 0, 0)
    forearm.head, forearm.tail, forearm.parent = (0, 0, 0), (0, 0, LENGTH), upper
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.pose.bones[FOREARM].rotation_mode = "XYZ"
    return rig


def tube(name, skin, into):
    """A closed arm along z, thinner towards the hand, with weights that change over about the elbow."""
    along = np.linspace(-LENGTH, LENGTH, RINGS)
    radius = 0.33 - 0.06 * along + 0.04 * np.cos(2.5 * (along + 0.2))
    radius *= np.sqrt(np.clip((LENGTH + 0.02 - np.abs(along)) / 0.3, 0.0, 1.0))
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    walls = [np.column_stack([r * ring, np.full(AROUND, z)]) for r, z in zip(radius, along, strict=True)]
    vertices = np.concatenate([*walls, [[0, 0, -LENGTH - 0.02]], [[0, 0, LENGTH + 0.02]]])
    here = np.arange(AROUND)
    there, last = np.roll(here, -1), (RINGS - 1) * AROUND
    faces = [
        (AROUND * k + a, AROUND * k + b, AROUND * (k + 1) + b, AROUND * (k + 1) + a)
        for k in range(RINGS - 1)
        for a, b in zip(here, there, strict=True)
    ]
    faces += [(int(b), int(a), len(vertices) - 2) for a, b in zip(here, there, strict=True)]
    faces += [(int(last + a), int(last + b), len(vertices) - 1) for a, b in zip(here, there, strict=True)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [], [tuple(int(v) for v in face) for face in faces])
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    mesh.materials.append(skin)
    made = bpy.data.objects.new(name, mesh)
    into.objects.link(made)
    x, _, z = vertices.T
    weight = np.clip(0.5 + z / (2 * ELBOW), 0, 1)
    groups = {UPPER: 1 - weight, FOREARM: weight, TIP: ((np.abs(z) < 0.08) & (x < -0.2)).astype(float)}
    groups |= {f"held {UPPER}": (weight == 0).astype(float), f"held {FOREARM}": (weight == 1).astype(float)}
    for group, weights in groups.items():
        members = made.vertex_groups.new(name=group)
        for vertex in np.flatnonzero(weights):
            members.add([int(vertex)], float(weights[vertex]), "REPLACE")
    return made


def evaluated(obj):
    """A mesh of what is seen; the caller removes it."""
    obj.update_tag()
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    return bpy.data.meshes.new_from_object(obj.evaluated_get(graph), depsgraph=graph)


def girth(mesh):
    """The area that the ring at the elbow encloses."""
    ring = scene.positions(mesh.vertices)[AROUND * (RINGS // 2) : AROUND * (RINGS // 2 + 1)]
    return float(np.linalg.norm(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)) / 2)
