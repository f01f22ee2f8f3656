"""Several objects under the same handles: rigid parts ride, clothes go with the surface."""

import bpy
import numpy as np
import pytest
import scene
from mathutils import Matrix
from numpy.testing import assert_allclose


def ball(at, radius=0.2, name="Eye"):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8, radius=radius, location=at)
    obj = bpy.context.object
    obj.name = name
    return obj


def sleeve(name="Sleeve"):
    """A wider tube around the middle of the tube, of other faces."""
    obj = scene.tube(rings=25, around=30, name=name)
    points = scene.points(obj.data.vertices) * [1.05, 1.05, 0.6]
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    return obj


def dressed(turned=False, **options):
    """A tube with handles at both ends, an eye on its side and a sleeve, bound; all in the same place."""
    obj = scene.tube()
    eye, cloth = ball((1.15, 0, 1.0)), sleeve()
    if turned:
        placed = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.7, 4, "X") @ Matrix.Scale(2.0, 4)
        for one in (obj, cloth):
            one.matrix_world = placed
        eye.matrix_world = placed @ eye.matrix_world
        bpy.context.view_layer.update()
    scene.group(obj, "bottom", lambda co: co.z < -2.5)
    scene.group(obj, "top", lambda co: co.z > 2.5)
    for name in ("bottom", "top"):
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
        obj.lissom_pose.handles[name].turns_by_itself = False
    bpy.ops.lissom.pose_bind(object=obj.name, company="Eye\nSleeve", **options)
    return obj, eye, cloth


def bend(obj):
    top = scene.empty(obj, "top")
    pivot = obj.matrix_world @ Matrix.Rotation(1.0, 4, "Y") @ obj.matrix_world.inverted()
    top.matrix_world = pivot @ top.matrix_world
    bpy.context.view_layer.update()
    bpy.ops.lissom.pose_update(object=obj.name)


def world(obj):
    matrix = np.array(obj.matrix_world)
    return scene.shown(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def nearest(points, surface):
    return np.sqrt(((points[:, None] - surface[None]) ** 2).sum(axis=2).min(axis=1))


@pytest.mark.parametrize("turned", [False, True])
def test_an_eye_stays_rigid_in_its_place_and_a_sleeve_on_the_arm(turned):
    obj, eye, cloth = dressed(turned)
    assert [row.way for row in obj.lissom_pose.company] == ["RIDE", "DRAPE"]
    before, body = world(eye), world(obj)
    gaps, scale = nearest(before, body), obj.scale[0]
    bend(obj)
    after = world(eye)
    assert np.linalg.norm(after - before, axis=1).min() > 0.5 * scale
    lengths = [np.linalg.norm(points[:, None] - points[None], axis=2) for points in (before, after)]
    assert_allclose(lengths[1], lengths[0], atol=1e-4 * scale)
    assert np.abs(nearest(after, world(obj)) - gaps).max() < 0.08 * scale
    off = nearest(world(cloth), world(obj))
    assert off.max() < 0.2 * scale and np.linalg.norm(world(cloth)[-1] - body[-1]) > scale


def test_apply_makes_the_key_on_each_and_unbind_leaves_no_trace():
    obj, eye, cloth = dressed()
    others = [len(one.data.vertices) for one in (eye, cloth)]
    bend(obj)
    seen = [world(one) for one in (obj, eye, cloth)]
    bpy.ops.lissom.pose_apply(object=obj.name, name="Bent")
    bpy.ops.lissom.pose_unbind(object=obj.name)
    for one, shape in zip((obj, eye, cloth), seen, strict=True):
        assert one.data.shape_keys.key_blocks.keys() == ["Basis", "Bent"]
        assert_allclose(world(one), shape, atol=1e-3)  # Apply goes on to the end of the iteration
    assert [len(one.data.vertices) for one in (eye, cloth)] == others
    bpy.ops.lissom.pose_bind(object=obj.name)
    bpy.ops.lissom.pose_unbind(object=obj.name)
    assert eye.data.shape_keys.key_blocks.keys() == ["Basis", "Bent"]


def test_a_group_of_the_handles_name_belongs_to_the_handle():
    obj, eye = scene.tube(), ball((1.15, 0, 0.0))
    for name, side in (("bottom", -1), ("top", 1)):
        scene.group(obj, name, lambda co, side=side: side * co.z > 2.5)
        bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name)
        obj.lissom_pose.handles[name].turns_by_itself = False
    scene.group(eye, "top", lambda co: True)
    bpy.ops.lissom.pose_bind(object=obj.name, company="Eye")
    before = world(eye)
    scene.empty(obj, "top").location.z += 0.75
    bpy.context.view_layer.update()
    assert_allclose(world(eye), before + [0, 0, 0.75], atol=1e-5)


def test_reset_reload_and_rebind_keep_them_together(tmp_path):
    obj, eye, _ = dressed()
    rest = world(eye)
    bend(obj)
    posed = world(eye)
    path = str(tmp_path / "company.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj, eye = (bpy.data.objects[name] for name in ("Tube", "Eye"))
    bpy.ops.lissom.pose_update(object=obj.name)
    assert_allclose(world(eye), posed, atol=2e-3)
    bpy.ops.lissom.pose_reset(object=obj.name)
    assert_allclose(world(eye), rest, atol=1e-6)


def test_animation_is_baked_to_keys_of_all():
    obj, eye, cloth = dressed()
    top = scene.empty(obj, "top")
    for frame, height in ((1, 0.0), (3, 0.6)):
        top.location.z = 2.8 + height
        top.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
    bpy.context.scene.frame_set(3)
    bpy.ops.lissom.pose_update(object=obj.name)
    seen = [world(one) for one in (obj, eye, cloth)]
    with scene.refused("A point cache holds one object"):
        bpy.ops.lissom.pose_bake(object=obj.name, output="CACHE", filepath="/tmp/none.pc2")
    bpy.ops.lissom.pose_bake(object=obj.name)
    for one, shape in zip((obj, eye, cloth), seen, strict=True):
        assert_allclose(world(one), shape, atol=2e-3)


def test_what_cannot_go_along_is_said():
    obj, other = scene.tube(), scene.bound_tube(name="Other")
    scene.group(obj, "top", lambda co: co.z > 2.5)
    bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group="top")
    with scene.refused("is bound by handles of its own"):
        bpy.ops.lissom.pose_bind(object=obj.name, company="Other")
    with scene.refused("There is no object named 'None'"):
        bpy.ops.lissom.pose_bind(object=obj.name, company="None")
    for one in bpy.data.objects:
        one.select_set(one == obj)
    obj.lissom_pose.company.clear()
    with scene.refused("Select the mesh objects that go along"):
        bpy.ops.lissom.pose_company(object=obj.name)
    ball((1, 0, 0)).select_set(True)
    bpy.ops.lissom.pose_company(object=obj.name)
    assert [row.object.name for row in obj.lissom_pose.company] == ["Eye"]
    bpy.ops.lissom.pose_company(object=obj.name, remove=0)
    assert not len(obj.lissom_pose.company)
    with scene.refused("There is no further object 0"):
        bpy.ops.lissom.pose_company(object=obj.name, remove=0)
    bpy.ops.lissom.pose_unbind(object=other.name)


@pytest.mark.parametrize("purged", [False, True])
def test_a_further_object_that_is_deleted_leaves_the_pose_whole(purged):
    obj, eye, cloth = dressed()
    if purged:
        bpy.data.objects.remove(eye)
    else:
        bpy.context.collection.objects.unlink(eye)
    bend(obj)
    assert np.linalg.norm(world(obj)[-1] - scene.key_points(obj, "Basis")[-1]) > 1
    assert nearest(world(cloth), world(obj)).max() < 0.2, "the other one still goes along"
    bpy.ops.lissom.pose_apply(object=obj.name, name="Bent")
    assert "Bent" in cloth.data.shape_keys.key_blocks
    bpy.ops.lissom.pose_unbind(object=obj.name)
    bpy.ops.lissom.pose_bind(object=obj.name)
    assert [row.object for row in obj.lissom_pose.company] == [cloth]
