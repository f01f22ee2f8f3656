"""Transfer of what the source looks like: poses and animation."""

import json
import struct

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands, session
from bl_ext.user_default.lissom.core.work import Work
from bl_ext.user_default.lissom.jobs import transfer_pose
from mathutils import Vector
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import monkeys, native

FRAMES = range(3, 12)


def rig(obj):
    """An armature with bones "root", "jaw" and "eye", the jaw of which turns the lower half of a mesh."""
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, head, tail in (
        ("root", (0, 0, -1), (0, 0, 0)),
        ("jaw", (0, 0, 0), (0, -1, 0)),
        ("eye", (0.3, -0.7, 0.3), (0.3, -1.5, 0.3)),
    ):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        if name != "root":
            bone.parent = armature.data.edit_bones["root"]
    bpy.ops.object.mode_set(mode="OBJECT")
    for name in ("root", "jaw"):
        obj.vertex_groups.new(name=name)
    for vertex in obj.data.vertices:
        weight = float(np.clip(0.2 - vertex.co.z, 0, 1))
        obj.vertex_groups["jaw"].add([vertex.index], weight, "REPLACE")
        obj.vertex_groups["root"].add([vertex.index], 1 - weight, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = armature
    return armature


def turn(armature, bone, x, frame=None):
    """Turns a bone about its x axis, in radians; with ``frame`` as a keyframe."""
    posed = armature.pose.bones[bone]
    posed.rotation_mode = "XYZ"
    posed.rotation_euler.x = x
    if frame is not None:
        posed.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.view_layer.update()


def posed_monkeys():
    source, target = monkeys()
    armature = rig(source)
    turn(armature, "jaw", 0.4)
    return source, target, armature


def animated_monkeys():
    """The jaw opens over FRAMES; the scene stands at frame 5."""
    source, target = monkeys()
    armature = rig(source)
    for frame, angle in ((FRAMES[0], 0.1), (FRAMES[-1], 0.5)):
        turn(armature, "jaw", angle, frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FRAMES[0], FRAMES[-1]
    bpy.context.scene.frame_set(5)
    return source, target, armature


def at_frames(obj, frames=FRAMES):
    """(k, n, 3): what Blender shows at these frames; the scene stays at its frame."""
    before, found = bpy.context.scene.frame_current, []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        found.append(scene.shown(obj))
    bpy.context.scene.frame_set(before)
    return np.array(found)


# Poses


def test_a_pose_by_an_armature_is_what_the_native_module_makes_of_it():
    source, target, armature = posed_monkeys()
    assert min(len(obj.data.vertices) for obj in (source, target)) > 2000
    shown = scene.shown(source)
    assert np.abs(shown - scene.key_points(source, "Basis")).max() > 0.2
    assert bpy.ops.lissom.transfer_pose(name="Open") == {"FINISHED"}
    (expected,) = native(source, target, [shown])
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "Open"]
    assert target.data.shape_keys.key_blocks["Open"].value == 0
    assert_allclose(scene.key_points(target, "Open"), expected, atol=2e-6)
    assert armature.data.pose_position == "POSE"
    assert_array_equal(scene.shown(source), shown)


def test_the_same_faces_get_the_same_pose():
    source, target = scene.monkey(1, "Source"), scene.monkey(1, "Target")
    turn(rig(source), "jaw", 0.4)
    assert bpy.ops.lissom.transfer_pose(source="Source", target="Target") == {"FINISHED"}
    assert_allclose(scene.key_points(target, "Pose"), scene.shown(source), atol=1e-5)


def test_a_pose_without_keyframes_on_animated_bones_stays():
    source, target, armature = animated_monkeys()
    armature.pose.bones["jaw"].rotation_euler.x = 0.9
    bpy.context.view_layer.update()
    shown = scene.shown(source)
    assert bpy.ops.lissom.transfer_pose() == {"FINISHED"}
    assert_allclose(armature.pose.bones["jaw"].rotation_euler.x, 0.9, rtol=1e-6)
    assert_array_equal(scene.shown(source), shown)
    assert_allclose(scene.key_points(target, "Pose"), native(source, target, [shown])[0], atol=2e-6)


def test_a_fit_is_used_again_whatever_the_pose():
    *_, armature = posed_monkeys()
    bpy.ops.lissom.transfer_fit()
    fit = session.fit.fit
    bpy.ops.lissom.transfer_pose()
    turn(armature, "jaw", 0.1)
    bpy.ops.lissom.transfer_pose()
    bpy.ops.lissom.transfer_animation(frame_start=1, frame_end=2)
    assert session.fit.fit is fit


def test_the_motion_of_the_object_is_no_deformation():
    source, target, armature = posed_monkeys()
    bpy.ops.lissom.transfer_pose(name="still")
    for frame, x in ((1, 0), (5, 30)):
        source.location.x = x
        source.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)
    turn(armature, "jaw", 0.4)
    # The armature deforms in the world: it goes along.
    armature.parent = source
    bpy.ops.lissom.transfer_animation(frame_start=1, frame_end=5, step=4)
    still = scene.key_points(target, "still")
    assert_allclose(scene.key_points(target, "Pose 0001"), still, atol=1e-5)
    assert_allclose(scene.key_points(target, "Pose 0005"), still, atol=1e-5)


@pytest.mark.parametrize(
    ("exists", "names", "overwritten"),
    [("UPDATE", ["Pose"], True), ("RENAME", ["Pose", "Pose.001"], False), ("SKIP", ["Pose"], False)],
)
def test_row_32_a_key_of_that_name_exists(exists, names, overwritten):
    _, target, _ = posed_monkeys()
    rest = scene.points(target.data.vertices)
    scene.add_key(target, "Pose", rest + 1)
    if exists == "SKIP":
        with scene.refused("'Pose' exists, and If Exists is Skip"):
            bpy.ops.lissom.transfer_pose(exists=exists)
    else:
        bpy.ops.lissom.transfer_pose(exists=exists)
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", *names]
    assert np.allclose(scene.key_points(target, "Pose"), rest + 1, atol=1e-5) != overwritten


def test_a_source_at_rest_makes_a_key_that_moves_nothing(capfd):
    source, target = monkeys()
    rig(source)
    source.data.shape_keys.key_blocks["squash"].value = 0
    assert bpy.ops.lissom.transfer_pose() == {"FINISHED"}
    assert_array_equal(scene.key_points(target, "Pose"), scene.key_points(target, "Basis"))
    assert "moves nothing" in capfd.readouterr().out


# Modifiers that make other vertices


def nodes(obj, kind, name):
    """A Geometry Nodes modifier of one node."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    ends = [tree.nodes.new(f"NodeGroup{side}") for side in ("Input", "Output")]
    node = tree.nodes.new(kind)
    tree.links.new(ends[0].outputs[0], node.inputs[0])
    tree.links.new(node.outputs[0], ends[1].inputs[0])
    obj.modifiers.new(name, "NODES").node_group = tree
    return node


def boolean(obj):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 1))
    obj.modifiers.new("Cut", "BOOLEAN").object = bpy.context.object


MAKERS = {
    "SUBSURF": lambda obj: obj.modifiers.new("Smooth", "SUBSURF"),
    "MIRROR": lambda obj: obj.modifiers.new("Twin", "MIRROR"),
    "DECIMATE": lambda obj: setattr(obj.modifiers.new("Few", "DECIMATE"), "ratio", 0.5),
    "ARRAY": lambda obj: obj.modifiers.new("Row", "ARRAY"),
    "SOLIDIFY": lambda obj: obj.modifiers.new("Thick", "SOLIDIFY"),
    "BOOLEAN": boolean,
    "NODES": lambda obj: nodes(obj, "GeometryNodeSubdivideMesh", "Finer"),
}


@pytest.mark.parametrize("kind", MAKERS)
def test_modifiers_that_make_other_vertices_are_ignored(kind):
    source, target, _ = posed_monkeys()
    expected = native(source, target, [scene.shown(source)])[0]
    MAKERS[kind](source)
    count = len(scene.shown(source))
    assert count != len(source.data.vertices)
    assert bpy.ops.lissom.transfer_pose() == {"FINISHED"}
    assert_allclose(scene.key_points(target, "Pose"), expected, atol=2e-6)
    assert all(modifier.show_viewport for modifier in source.modifiers)
    assert len(scene.shown(source)) == count


def test_a_modifier_that_is_off_stays_off():
    source, target, _ = posed_monkeys()
    expected = native(source, target, [scene.shown(source)])[0]
    source.modifiers.new("Smooth", "SUBSURF").show_viewport = False
    source.modifiers["Armature"].show_viewport = True
    bpy.ops.lissom.transfer_pose()
    assert_allclose(scene.key_points(target, "Pose"), expected, atol=2e-6)
    assert [modifier.show_viewport for modifier in source.modifiers] == [True, False]


def test_nodes_that_only_move_vertices_count():
    source, target, _ = posed_monkeys()
    nodes(source, "GeometryNodeSetPosition", "Lift").inputs["Offset"].default_value = (0, 0, 0.5)
    lifted = scene.shown(source)
    expected = native(source, target, [lifted])[0]
    nodes(source, "GeometryNodeSubdivideMesh", "Finer")
    source.modifiers.new("Smooth", "SUBSURF")
    bpy.ops.lissom.transfer_pose()
    assert np.abs(lifted - scene.key_points(source, "Basis"))[:, 2].min() > 0.05
    assert_allclose(scene.key_points(target, "Pose"), expected, atol=2e-6)
    assert all(modifier.show_viewport for modifier in source.modifiers)


def test_what_cannot_be_matched_is_named():
    source, _, _ = posed_monkeys()
    modifier = source.modifiers.new("Stubborn", "SUBSURF")
    modifier.driver_add("show_viewport").driver.expression = "1"
    bpy.context.view_layer.update()
    shown, own = len(scene.shown(source)), len(source.data.vertices)
    for operator in (bpy.ops.lissom.transfer_pose, bpy.ops.lissom.transfer_animation):
        with scene.refused(f"'Source' is shown with {shown} vertices, its mesh has {own}"):
            operator()
        with scene.refused("'Stubborn'"):
            operator()
    assert modifier.show_viewport


def test_what_is_hidden_or_edited_is_refused():
    source, _, _ = posed_monkeys()
    source.hide_set(True)
    with scene.refused("'Source' is hidden"):
        bpy.ops.lissom.transfer_pose()
    source.hide_set(False)
    scene.select(source, [0], "EDIT")
    with scene.refused("'Source' is in edit mode"):
        bpy.ops.lissom.transfer_pose()
    bpy.ops.object.mode_set(mode="OBJECT")


# Animation


@pytest.mark.parametrize("output", ["KEYS", "CACHE"])
def test_every_frame_is_what_the_native_module_makes_of_it(output, tmp_path, monkeypatch):
    monkeypatch.setattr(transfer_pose, "BLOCK", 4)
    source, target, _ = animated_monkeys()
    source.modifiers.new("Smooth", "SUBSURF").show_viewport = False
    expected = native(source, target, at_frames(source))
    assert np.abs(expected[-1] - expected[0]).max() > 0.1
    source.modifiers["Smooth"].show_viewport = True
    path = tmp_path / "face.pc2"
    more = {"cache_path": str(path)} if output == "CACHE" else {}
    assert bpy.ops.lissom.transfer_animation(output=output, **more) == {"FINISHED"}
    assert bpy.context.scene.frame_current == 5
    assert source.modifiers["Smooth"].show_viewport
    assert_allclose(at_frames(target), expected, atol=3e-6)
    between = 0.25 * (3 * expected[2] + expected[3])
    bpy.context.scene.frame_set(FRAMES[2], subframe=0.25)
    assert_allclose(scene.shown(target), between, atol=5e-6)
    if output == "CACHE":
        assert [file.name for file in tmp_path.iterdir()] == ["face.pc2"]
        header = struct.unpack("<12siiffi", path.read_bytes()[:32])
        assert header == (b"POINTCACHE2\0", 1, len(target.data.vertices), 3, 1, len(FRAMES))
        assert path.stat().st_size == 32 + 12 * len(FRAMES) * len(target.data.vertices)


def test_blocks_make_no_difference(tmp_path, monkeypatch):
    animated_monkeys()
    found = []
    for block in (32, 9, 2, 1):
        monkeypatch.setattr(transfer_pose, "BLOCK", block)
        path = tmp_path / f"{block}.pc2"
        bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=str(path))
        found.append(np.frombuffer(path.read_bytes()[32:], "<f4"))
    for other in found[1:]:
        assert_allclose(other, found[0], atol=1e-6)


def test_every_other_frame_and_the_progress(monkeypatch):
    source, target, _ = animated_monkeys()
    monkeypatch.setattr(transfer_pose, "BLOCK", 2)
    stages = []

    def wait(work):
        stages.append(work.progress)
        while not work.poll():
            stages.append(work.progress)
        return work.result

    monkeypatch.setattr(Work, "wait", wait)
    expected = native(source, target, at_frames(source, FRAMES[::2]))
    assert bpy.ops.lissom.transfer_animation(step=2, name="Talk") == {"FINISHED"}
    assert target.data.shape_keys.key_blocks.keys() == [
        "Basis",
        *(f"Talk {frame:04d}" for frame in FRAMES[::2]),
    ]
    assert_allclose(at_frames(target, FRAMES[::2]), expected, atol=3e-6)
    frames = [stage for _, stage in stages if stage.startswith("frame")]
    assert frames[0] == "frame 1 of 5" and "frame 5 of 5" in frames
    shares = [share for share, stage in stages if stage.startswith("frame")]
    assert shares == sorted(shares) and shares[0] < 0.5 and shares[-1] >= 0.8


def test_an_earlier_result_of_that_name_is_replaced(tmp_path):
    source, target, armature = animated_monkeys()
    animate = bpy.ops.lissom.transfer_animation
    animate(name="Talk")
    animate(name="Other", step=8)
    animate(name="Talk", step=4)
    talk = ["Talk 0003", "Talk 0007", "Talk 0011"]
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "Other 0003", "Other 0011", *talk]
    animate(name="Other", output="CACHE", cache_path=str(tmp_path / "a.pc2"))
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", *talk]
    animate(name="Other", output="CACHE", cache_path=str(tmp_path / "b.pc2"))
    assert [modifier.filepath for modifier in target.modifiers] == [str(tmp_path / "b.pc2")]
    turn(armature, "jaw", 0.9, FRAMES[-1])
    animate(name="Talk")
    animate(name="Other", frame_start=11, frame_end=11)
    assert not target.modifiers
    expected = native(source, target, at_frames(source, [11]))[0]
    assert_allclose(scene.key_points(target, "Talk 0011"), expected, atol=3e-6)


def test_what_cannot_be_animated_changes_nothing(tmp_path):
    _, target, _ = animated_monkeys()
    animate = bpy.ops.lissom.transfer_animation
    scene.add_key(target, "Pose 0004", scene.points(target.data.vertices))
    target.modifiers.new("Smoother", "SMOOTH")
    for message, words in (
        ("The last frame, 2, is before the first, 3", {"frame_end": 2}),
        ("'Target' has a shape key 'Pose 0004' already", {}),
        ("a name first", {"name": ""}),
        ("too many for Blender", {"frame_end": 20_000}),
        ("'Target' has a modifier 'Smoother' already", {"output": "CACHE", "name": "Smoother"}),
        ("Save the file first", {"output": "CACHE"}),
        ("There is no folder", {"output": "CACHE", "cache_path": str(tmp_path / "none" / "a.pc2")}),
        ("no object named 'Nobody'", {"target": "Nobody"}),
    ):
        with scene.refused(message):
            animate(**words)
    bpy.context.scene.lissom_transfer.target = None
    for operator in (animate, bpy.ops.lissom.transfer_pose):
        with scene.refused("Choose the target object first"):
            operator()
    assert list(tmp_path.iterdir()) == []


def test_a_locked_key_of_an_earlier_result_is_refused():
    _, target, _ = animated_monkeys()
    bpy.ops.lissom.transfer_animation(step=4)
    target.data.shape_keys.key_blocks["Pose 0007"].lock_shape = True
    with scene.refused("'Pose 0007' is locked"):
        bpy.ops.lissom.transfer_animation(step=4)


def cancel_at_third_frame(folder):
    def wait(work):
        while not work.progress[1].startswith("frame 3"):
            assert not work.poll()
        # Between two blocks the artist sees, saves and undoes what was there.
        assert bpy.data.objects["Source"].modifiers["Smooth"].show_viewport
        assert bpy.context.scene.frame_current == 5
        assert len(list(folder.glob("*.part"))) == 1
        work.cancel()
        while not work.poll():
            pass
        raise AssertionError("not cancelled")

    return wait


def test_cancelled_it_leaves_no_file(tmp_path, monkeypatch):
    source, _, _ = animated_monkeys()
    source.modifiers.new("Smooth", "SUBSURF")
    monkeypatch.setattr(transfer_pose, "BLOCK", 2)
    monkeypatch.setattr(Work, "wait", cancel_at_third_frame(tmp_path))
    before = scene.snapshot()
    path = str(tmp_path / "a.pc2")
    assert bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=path) == {"CANCELLED"}
    assert scene.snapshot() == before
    assert list(tmp_path.iterdir()) == [] and source.modifiers["Smooth"].show_viewport
    assert bpy.context.scene.frame_current == 5


def test_a_target_that_goes_meanwhile_leaves_no_file(tmp_path, monkeypatch):
    animated_monkeys()
    whole = Work.wait

    def wait(work):
        result = whole(work)
        assert len(list(tmp_path.glob("*.part"))) == 1
        bpy.data.objects.remove(bpy.data.objects["Target"])
        return result

    monkeypatch.setattr(Work, "wait", wait)
    with pytest.raises(RuntimeError, match="'Target' is gone"):
        bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=str(tmp_path / "a.pc2"))
    assert list(tmp_path.iterdir()) == []


def test_an_error_on_the_way_leaves_what_was_there(tmp_path, monkeypatch):
    source, target, _ = animated_monkeys()
    path = tmp_path / "a.pc2"
    bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=str(path))
    before = path.read_bytes()
    monkeypatch.setattr(transfer_pose, "BLOCK", 2)
    # A scale of zero from the frame 8 on.
    for frame, scale in ((7, 1), (8, 0)):
        source.scale.x = scale
        source.keyframe_insert("scale", frame=frame)
    bpy.context.scene.frame_set(5)
    with scene.refused("The scale of object 'Source' is zero"):
        bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=str(path))
    assert path.read_bytes() == before and [file.name for file in tmp_path.iterdir()] == ["a.pc2"]
    assert len(target.modifiers) == 1 and bpy.context.scene.frame_current == 5


def test_a_live_pose_follows_its_handles_at_every_frame():
    source, target = scene.bound_tube(name="Source"), scene.tube(name="Target")
    handle = scene.empty(source, "top")
    rest = handle.location.copy()
    for frame, x in ((1, 0.0), (3, 1.0)):
        handle.location = rest + Vector((x, 0, 0))
        handle.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(2)
    expected = at_frames(source, (1, 2, 3))
    shown = scene.shown(source)
    assert np.abs(expected[2] - expected[0]).max() > 0.9
    sides = {"source": "Source", "target": "Target"}
    bpy.ops.lissom.transfer_animation(frame_start=1, frame_end=3, **sides)
    # The solver starts from where it was: the same to its own tolerance.
    assert_allclose(at_frames(target, (1, 2, 3)), expected, atol=1e-3)
    assert_allclose(scene.shown(source), shown, atol=1e-3)
    assert source.lissom_pose.bound


# Several objects


def faces_with_eyes():
    """Suzanne with an eyeball that hangs on a bone, and the same without bones; (sources, targets, rig)."""
    sides = []
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.2, location=(0.3, -0.7, 0.3))
    ball = bpy.context.object  # once: the order of its faces differs from run to run
    for side in ("Source", "Target"):
        eye = ball.copy()
        eye.name, eye.data = f"{side} eye", ball.data.copy()
        bpy.context.collection.objects.link(eye)
        sides.append((scene.monkey(1, side), eye))
    bpy.data.objects.remove(ball)
    (face, eye), _ = sides
    armature = rig(face)
    bpy.context.view_layer.update()
    world = eye.matrix_world.copy()
    eye.parent, eye.parent_type, eye.parent_bone = armature, "BONE", "eye"
    face.parent = armature
    bpy.context.view_layer.update()
    eye.matrix_world = world
    bpy.context.view_layer.update()
    return *sides, armature


def names(objects):
    return "\n".join(obj.name for obj in objects)


def in_face(face, eye):
    """(n, 3): the shown vertices of the eye in the coordinates of the face."""
    points = np.c_[scene.shown(eye), np.ones(len(eye.data.vertices))]
    return (points @ np.array(face.matrix_world.inverted() @ eye.matrix_world).T)[:, :3]


@pytest.mark.parametrize("moved", [False, True])
def test_an_eyeball_on_a_bone_turns_in_its_socket(moved):
    sources, targets, armature = faces_with_eyes()
    if moved:
        armature.location, armature.rotation_euler = (3, 4, 5), (0.3, 0.2, 0.1)
        for obj in targets:  # they stand as the sources do
            obj.matrix_world = armature.matrix_world @ obj.matrix_world
        bpy.context.view_layer.update()
        for obj in targets:
            obj.matrix_world = armature.matrix_world @ obj.matrix_world
    turn(armature, "jaw", 0.3)
    turn(armature, "eye", 0.5)
    expected = in_face(*sources)
    assert np.abs(expected - in_face(*targets)).max() > 0.05
    bpy.ops.lissom.transfer_pose(source=names(sources), target=names(targets))
    for obj in targets:
        obj.data.shape_keys.key_blocks["Pose"].value = 1
    bpy.context.view_layer.update()
    assert_allclose(scene.shown(targets[0]), scene.shown(sources[0]), atol=2e-5)
    assert_allclose(in_face(*targets), expected, atol=2e-5)


def test_a_part_that_does_not_move_is_exactly_its_local_deformation():
    sources, targets, armature = faces_with_eyes()
    rest = scene.points(sources[1].data.vertices)
    scene.add_key(sources[1], "wide", rest * [1.3, 1, 1], value=1)
    for frame, place in ((1, (0, 0, 0)), (2, (3, -4, 5))):
        armature.location, armature.rotation_euler = place, np.array(place) / 10
        armature.keyframe_insert("location", frame=frame)
        armature.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_set(1)
    sides = {"source": names(sources), "target": names(targets)}
    bpy.ops.lissom.transfer_animation(frame_start=1, frame_end=2, **sides)
    for obj in targets:
        one, other = (scene.key_points(obj, f"Pose {frame:04d}") for frame in (1, 2))
        assert_allclose(other, one, atol=1e-6)
    assert_allclose(scene.key_points(targets[1], "Pose 0001"), rest * [1.3, 1, 1], atol=1e-6)


def test_each_object_has_its_own_cache(tmp_path):
    sources, targets, armature = faces_with_eyes()
    for frame, angle in ((1, 0.0), (3, 0.5)):
        turn(armature, "eye", angle, frame)
    bpy.context.scene.frame_set(1)
    expected = []
    for frame in (1, 2, 3):
        bpy.context.scene.frame_set(frame)
        expected.append(in_face(*sources))
    bpy.context.scene.frame_set(1)
    sides = {"source": names(sources), "target": names(targets), "frame_start": 1, "frame_end": 3}
    path = str(tmp_path / "talk.pc2")
    bpy.ops.lissom.transfer_animation(output="CACHE", cache_path=path, **sides)
    assert {file.name for file in tmp_path.iterdir()} == {"talk Target.pc2", "talk Target_eye.pc2"}
    for frame, wanted in zip((1, 2, 3), expected, strict=True):
        bpy.context.scene.frame_set(frame)
        assert_allclose(in_face(*targets), wanted, atol=2e-5)


def test_a_further_object_that_does_not_move_gets_no_keys():
    sources, targets, armature = faces_with_eyes()
    turn(armature, "jaw", 0.3)
    sides = {"source": names(sources), "target": names(targets)}
    bpy.ops.lissom.transfer_pose(**sides)
    bpy.ops.lissom.transfer_animation(frame_start=1, frame_end=2, name="Talk", **sides)
    assert targets[0].data.shape_keys.key_blocks.keys() == ["Basis", "Pose", "Talk 0001", "Talk 0002"]
    assert targets[1].data.shape_keys is None


def test_a_linked_source_with_its_armature(tmp_path):
    source, target, _ = posed_monkeys()
    source.modifiers.new("Smooth", "SUBSURF")
    markers, library = str(tmp_path / "markers.json"), str(tmp_path / "library.blend")
    bpy.ops.lissom.marker_save(filepath=markers)
    bpy.ops.wm.save_as_mainfile(filepath=library)
    bpy.ops.lissom.transfer_pose()
    expected = scene.key_points(target, "Pose")
    target.shape_key_clear()
    for name in ("Source", "Rig"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    with bpy.data.libraries.load(library, link=True) as (_, into):
        into.objects = ["Source"]
    bpy.context.collection.objects.link(into.objects[0])
    bpy.ops.lissom.transfer_pose(source="Source", target="Target", filepath=markers)
    assert_allclose(scene.key_points(target, "Pose"), expected, atol=1e-6)
    assert into.objects[0].modifiers["Smooth"].show_viewport
    assert {armature.pose_position for armature in bpy.data.armatures} == {"POSE"}


# The command


@pytest.fixture
def file(tmp_path):
    """A file of an animated source and a target with markers, at frame 5."""
    animated_monkeys()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "both.blend"))
    return tmp_path


def command(folder, *words):
    fixed = ("--file", folder / "both.blend", "--source", "Source", "--target", "Target")
    fixed += ("--out", folder / "out.blend", "--report", folder / "r.json")
    return commands.main(["transfer", *map(str, (*fixed, *words))])


def test_the_command_transfers_a_pose(file):
    bpy.ops.lissom.transfer_pose(name="Open")
    expected = scene.key_points(bpy.data.objects["Target"], "Open")
    assert command(file, "--pose", "Open") == 0
    said = json.loads((file / "r.json").read_text())
    assert said["pose"] == "Open" and "keys" not in said and said["fit"]["distance_mean_percent"] < 1
    bpy.ops.wm.open_mainfile(filepath=str(file / "out.blend"))
    target = bpy.data.objects["Target"]
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "Open"]
    assert_array_equal(scene.key_points(target, "Open"), expected)


def test_the_source_of_a_pose_may_come_from_another_file(file):
    bpy.ops.lissom.transfer_animation(frame_start=3, frame_end=11, step=8)
    expected = [scene.key_points(bpy.data.objects["Target"], f"Pose {frame:04d}") for frame in (3, 11)]
    bpy.ops.lissom.marker_save(filepath=str(file / "markers.json"))
    bpy.ops.wm.open_mainfile(filepath=str(file / "both.blend"))
    for name in ("Source", "Rig"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.wm.save_as_mainfile(filepath=str(file / "target.blend"))
    words = ("--file", file / "target.blend", "--source-file", file / "both.blend", "--frames", 3, 11, 8)
    assert command(file, *words, "--markers", file / "markers.json") == 0
    bpy.ops.wm.open_mainfile(filepath=str(file / "out.blend"))
    assert bpy.data.objects.keys() == ["Target"]
    for frame, shape in zip((3, 11), expected, strict=True):
        assert_allclose(scene.key_points(bpy.data.objects["Target"], f"Pose {frame:04d}"), shape, atol=1e-6)


def test_the_command_transfers_frames(file):
    source, target = (bpy.data.objects[name] for name in ("Source", "Target"))
    expected = native(source, target, at_frames(source, [4, 6, 8]))
    assert command(file, "--frames", 4, 8, 2) == 0
    said = json.loads((file / "r.json").read_text())
    assert said["frames"] == [4, 6, 8] and said["caches"] == []
    cache = file / "talk.pc2"
    for words in ((), ("--cache", cache)):
        assert command(file, "--frames", 4, 8, 2, *words) == 0
        bpy.ops.wm.open_mainfile(filepath=str(file / "out.blend"))
        assert bpy.context.scene.frame_current == 5
        assert_allclose(at_frames(bpy.data.objects["Target"], [4, 6, 8]), expected, atol=3e-6)
    assert json.loads((file / "r.json").read_text())["caches"] == [str(cache)] and cache.exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--pose", ""), "--pose: give the shape key a name"),
        (("--frames", 5), "--frames: give the first and the last frame"),
        (("--frames", 5, 6, 0), "--frames: give the first and the last frame"),
        (("--frames", 6, 5), "The last frame, 5, is before the first, 6"),
        (("--cache", "a.pc2"), "--cache: it keeps what --frames makes"),
        (("--frames", 5, 6, "--cache", "/none/a.pc2"), "--cache: there is no folder"),
        (("--frames", 5, 6, "--pose", "Open"), "not allowed with"),
        (("--keys", "squash", "--pose", "Open"), "not allowed with"),
    ],
)
def test_bad_words_write_nothing(file, words, message, capfd):
    assert command(file, *words) == 2
    said = capfd.readouterr()
    assert message in said.out + said.err
    assert {path.name for path in file.iterdir()} == {"both.blend"}
