"""Face keys on heads that no person has: found by the openings of eyes and mouth, or by what somebody has
said.
"""

import json

import bpy
import heads
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.bridge import markers as bridge_markers
from bl_ext.user_default.lissom.bridge import source_face
from bl_ext.user_default.lissom.core.face_lids import Lids
from bl_ext.user_default.lissom.core.landmarks import MIDDLES
from bl_ext.user_default.lissom.core.markers import Marker
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.core.surface import Point
from bl_ext.user_default.lissom.jobs.face import FaceAsked, FaceKeys


def delta(obj, name):
    found = np.empty((2, 3 * len(obj.data.vertices)), dtype=np.float32)
    for row, key in zip(found, ("Basis", name), strict=True):
        obj.data.shape_keys.key_blocks[key].data.foreach_get("co", row)
    return np.diff(found, axis=0).reshape(-1, 3).astype(float)


@pytest.fixture
def mask():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.made("mask")
    return head, scene.mesh_object("Mask", head.vertices, head.triangles)


def test_a_mask_gets_keys_without_a_click_and_its_lids_close(mask):
    head, obj = mask
    for name, eye in zip(("Left", "Right"), head.eyes, strict=True):
        scene.mesh_object(name, *eye)
    job = FaceKeys(bpy.context, FaceAsked(target="Mask", parts="Left\nRight"))
    done = job.write(bpy.context, job.work.wait())
    assert not done.stopped and done.sure > 0.75 and len(done.written["Mask"]) == 51
    assert not [line for line in done.warnings if not line.startswith("Landmarks to look at")]
    assert done.kinds["Left"] == done.kinds["Right"] == ["EYE"]
    blink = head.vertices + delta(obj, "eyeBlinkLeft") + delta(obj, "eyeBlinkRight")
    for side in (0, 1):
        assert heads.seen(head, blink, side) <= 0.02 * heads.seen(head, head.vertices, side)
    left, right = (delta(obj, f"mouthSmile{side}") for side in ("Left", "Right"))
    assert np.abs(left[head.twins] * [-1, 1, 1] - right).max() < 0.01 * np.abs(left).max()
    jaw = head.vertices + delta(obj, "jawOpen")
    before, after = (np.ptp(points[head.lips], axis=0) for points in (head.vertices, jaw))
    assert after[2] > 2 * before[2] and abs(after[0] / before[0] - 1) < 0.2
    smile = delta(obj, "mouthSmileLeft") + delta(obj, "mouthSmileRight")
    corners = head.lips[[head.vertices[head.lips, 0].argmin(), head.vertices[head.lips, 0].argmax()]]
    assert smile[corners, 2].min() > 0.08 * before[0]
    ends = np.sort(np.concatenate([head.triangles[:, k] for k in ([0, 1], [1, 2], [2, 0])]), axis=1)
    rest = np.linalg.norm(np.diff(head.vertices[ends], axis=1), axis=2)
    for name in done.written["Mask"]:
        # mouthClose is for a jaw that is open.
        by = delta(obj, name) + (delta(obj, "jawOpen") if name == "mouthClose" else 0)
        long = np.linalg.norm(np.diff((head.vertices + by)[ends], axis=1), axis=2) / rest
        assert long.max() < 3, name


@pytest.mark.parametrize("name", scene.by_turns(heads.SHAPES))
def test_a_bag_behind_the_mouth_and_sockets_behind_the_eyes_hide_no_opening(name):
    """Most artists close what is behind lips and lids, so that nothing there is a border."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.closed(heads.made(name))
    obj = scene.mesh_object("Head", head.vertices, head.triangles)
    for side, eye in zip(("Left", "Right"), head.eyes, strict=True):
        scene.mesh_object(side, *eye)
    job = FaceKeys(bpy.context, FaceAsked(target="Head", parts="Left\nRight"))
    done = job.write(bpy.context, job.work.wait())
    assert not done.stopped and done.sure > 0.75
    blink = head.vertices + delta(obj, "eyeBlinkLeft") + delta(obj, "eyeBlinkRight")
    for side in (0, 1):
        assert heads.seen(head, blink, side) <= 0.02 * heads.seen(head, head.vertices, side)
    before, after = (
        np.ptp(points[head.lips], axis=0) for points in (head.vertices, head.vertices + delta(obj, "jawOpen"))
    )
    assert after[2] > 2 * before[2] and abs(after[0] / before[0] - 1) < 0.2
    jaw = delta(obj, "jawOpen")
    assert heads.left_open(head, jaw, jaw + delta(obj, "mouthClose")) < 0.1


def test_a_head_that_is_turned_and_wears_hair_is_found_and_stays_the_same_left_and_right():
    """A cap of hair is a ball behind all openings, and goes with what it lies on, not with the lids below."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.closed(heads.made("round"))
    angle = np.radians(22)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    cap, faces = heads.cap((0, 0.15, 0.1), 1.05)
    first = len(head.vertices)
    triangles = np.concatenate([head.triangles, first + faces])
    obj = scene.mesh_object("Head", 30 * np.concatenate([head.vertices, cap]) @ turn.T, triangles)
    for side, (points, own) in zip(("Left", "Right"), head.eyes, strict=True):
        scene.mesh_object(side, 30 * points @ turn.T, own)
    job = FaceKeys(bpy.context, FaceAsked(target="Head", parts="Left\nRight"))
    done = job.write(bpy.context, job.work.wait())
    assert not done.stopped and done.sure > 0.75
    # Lids that go over tall eyes take the skin above them along without folding it.
    assert sum(row["verdict"] == "bad" for row in done.quality) <= 6
    keys = {name: delta(obj, name) @ turn / 30 for name in done.written["Head"]}
    blink = keys["eyeBlinkLeft"] + keys["eyeBlinkRight"]
    for side in (0, 1):
        closed = heads.seen(head, head.vertices + blink[:first], side)
        assert closed <= 0.02 * heads.seen(head, head.vertices, side)
    assert np.abs(blink[first:]).max() < 0.1 * np.abs(blink).max()
    for name in ("eyeBlink", "mouthSmile", "mouthUpperUp", "noseSneer"):
        left, right = (keys[name + side][:first] for side in ("Left", "Right"))
        assert np.abs(left[head.twins] * [-1, 1, 1] - right).max() < 0.01 * np.abs(left).max(), name


def test_halfway_blinks_go_round_tall_eyes_by_one_press_more():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.made("round")
    obj = scene.mesh_object("Head", head.vertices, head.triangles)
    with scene.refused("Add the eyeballs as objects"):
        bpy.ops.lissom.face_blinks(target="Head")
    settings = bpy.context.scene.lissom_transfer
    settings.target = obj
    for side, eye in zip(("Right", "Left"), head.eyes[::-1], strict=True):
        settings.target_parts.add().object = scene.mesh_object(side, *eye)
    with scene.refused("'Head' has no blinks"):
        bpy.ops.lissom.face_blinks(target="Head", eyes="Left\nRight")
    assert bpy.ops.lissom.face_keys() == {"FINISHED"}
    straight = [delta(obj, f"eyeBlink{side}") for side in ("Left", "Right")]
    with scene.refused("No eyeball is beside what 'eyeBlinkRight' moves"):
        bpy.ops.lissom.face_blinks(eyes="Left")
    assert bpy.ops.lissom.face_blinks() == {"FINISHED"}
    for (centre, radius), offsets, side in zip(head.balls, straight, ("Left", "Right"), strict=True):
        half = on_arc(obj, side, 0.5)
        moves = np.linalg.norm(offsets, axis=1) > 1e-3 * radius
        deep = [
            radius - np.linalg.norm(points[moves] - centre, axis=1).min()
            for points in (head.vertices, head.vertices + offsets, head.vertices + offsets / 2, half)
        ]
        assert deep[2] > max(deep[:2]) + 0.15 * radius
        assert deep[3] < max(deep[:2]) + 0.01 * radius
        # Nor does the eye show through faces that are before it at both ends, between two keys neither.
        faces = head.triangles[moves[head.triangles].any(axis=1)]
        ends, way = (
            [np.linalg.norm(points[faces].mean(axis=1) - centre, axis=1) / radius - 1 for points in some]
            for some in (
                (head.vertices, head.vertices + offsets),
                [on_arc(obj, side, t) for t in (0.25, 0.5, 0.6, 0.75, 0.9)],
            )
        )
        before = np.minimum(*ends) > 0
        assert np.array(way)[:, before].min() > -0.01  # straight, -0.34


def on_arc(obj, side, t):
    """(n, 3) where the mesh is with the slider of a blink at t."""
    obj[f"eyeBlink{side} arc"] = t
    obj.update_tag()
    bpy.context.view_layer.update()
    seen = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    return np.array([vertex.co for vertex in seen])


def test_without_eyeballs_the_openings_are_guesses_and_followed_once_confirmed(mask):
    head, obj = mask
    with pytest.raises(RuntimeError, match=r"no eyeball tells .* look at the grey marks.*, and confirm"):
        bpy.ops.lissom.face_keys(target="Mask")
    assert obj.data.shape_keys is None
    settings = bpy.context.scene.lissom_transfer
    source, settings.source = settings.source, None
    with pytest.raises(RuntimeError, match="Choose two different objects"):
        bpy.ops.lissom.landmarks_confirm()
    settings.source = source
    assert bpy.ops.lissom.landmarks_confirm() == {"FINISHED"}
    assert bpy.ops.lissom.face_keys(target="Mask") == {"FINISHED"}
    blink = head.vertices + delta(obj, "eyeBlinkLeft") + delta(obj, "eyeBlinkRight")
    for lid in head.lids:
        lids = Lids.of(head.vertices, np.append(lid, lid[0]))
        before, after = (np.linalg.norm(lids.gaps(points), axis=1).max() for points in (head.vertices, blink))
        assert after < 0.05 * before


def test_eyes_of_one_mesh_would_turn_together_and_are_refused(mask):
    left = scene.mesh_object("Left", *mask[0].eyes[0])
    bpy.context.collection.objects.link(bpy.data.objects.new("Right", left.data))
    with scene.refused("'Left' and 'Right' have one mesh in common"):
        bpy.ops.lissom.face_keys(target="Mask", parts="Left\nRight")


def test_half_a_head_that_a_modifier_completes_is_refused(mask):
    head, whole = mask
    inside = (head.vertices[head.triangles][..., 0] > -1e-6).all(axis=1)
    used, faces = np.unique(head.triangles[inside], return_inverse=True)
    half = scene.mesh_object("Half", head.vertices[used], faces.reshape(-1, 3))
    for obj in (whole, half):
        obj.modifiers.new("Mirror", "MIRROR")
    FaceKeys(bpy.context, FaceAsked(target="Mask"))
    with pytest.raises(Refused, match="'Half' is one half, and its modifier 'Mirror' makes the other"):
        FaceKeys(bpy.context, FaceAsked(target="Half"))


def test_eyes_of_the_panel_are_of_its_target_alone(mask):
    for name, eye in zip(("Left", "Right"), mask[0].eyes, strict=True):
        scene.mesh_object(name, *eye)
    settings = bpy.context.scene.lissom_transfer
    settings.target = mask[1]
    for name in ("Left", "Right"):
        part = settings.target_parts.add()
        part.object, part.kind = bpy.data.objects[name], "EYE"
    other = mask[1].copy()
    other.name = "Other"
    bpy.context.scene.collection.objects.link(other)
    for name, why in (
        ("Mask", "'Mask' has no blinks of Face Keys"),
        ("Other", "Add the eyeballs as objects"),
    ):
        with pytest.raises(RuntimeError, match=why):
            bpy.ops.lissom.face_blinks(target=name)


@pytest.mark.parametrize(
    ("why", "wrong"),
    [
        ("far beside the head", lambda places: places * 100),
        ("left and right", lambda places: places[[1, 0, 2]]),
        ("in one place", lambda places: places[[0, 0, 0]]),
    ],
)
@pytest.mark.parametrize("kind", ["mask", "round"])
def test_landmarks_of_no_face_are_refused(tmp_path, kind, why, wrong):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.made(kind)
    obj = scene.mesh_object("Head", head.vertices, head.triangles)
    places = wrong(np.array(head.clicks)).tolist()
    file = tmp_path / "landmarks.json"
    file.write_text(json.dumps(dict(zip([mark.name for mark in MIDDLES], places, strict=True))))
    with scene.refused(why):
        bpy.ops.lissom.face_keys(target="Head", landmarks=str(file))
    assert obj.data.shape_keys is None


def test_without_a_clue_it_asks_and_goes_on_with_what_was_clicked():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    head = heads.made("mask")
    vertices, triangles = heads.painted(head)
    obj = scene.mesh_object("Mask", vertices, triangles)
    corners = [[0.05, -0.5, -0.5], [-0.05, -0.5, -0.5], [0, -0.4, -0.5], [0, -0.45, -0.55]]
    scene.mesh_object("Gum", corners, [[0, 1, 2], [0, 1, 3]])
    with pytest.raises(RuntimeError, match=r"No key is made: .*\. Do this: press Pick and click on 'Mask'"):
        bpy.ops.lissom.face_keys(target="Mask")
    settings = bpy.context.scene.lissom_transfer
    assert obj.data.shape_keys is None and len(settings.markers) == 0
    assert source_face.is_it(settings.source) and settings.target == obj and settings.landmarks == "FACE_3"
    own = source_face.landmarks()
    rest = source_face.rest()
    pairs = [
        Marker.between(
            name,
            Point.at(int(np.linalg.norm(rest - own[name], axis=1).argmin())),
            Point.at(int(np.linalg.norm(vertices - click, axis=1).argmin())),
        )
        for name, click in zip(
            ("left eye, middle", "right eye, middle", "mouth, middle"), head.clicks, strict=True
        )
    ]
    bridge_markers.append(bpy.context.scene, pairs[:2], settings.source, obj)
    with pytest.raises(RuntimeError, match="2 of the landmarks are set"):
        bpy.ops.lissom.face_keys(target="Mask")
    bridge_markers.append(bpy.context.scene, pairs[2:], settings.source, obj)
    assert bpy.ops.lissom.face_keys(target="Mask", parts="Gum", kinds="LOWER Gum") == {"FINISHED"}
    assert len(obj.data.shape_keys.key_blocks) == 52
    jaw = delta(bpy.data.objects["Gum"], "jawOpen")
    assert jaw[:, 2].max() < 0
    with pytest.raises(RuntimeError, match=r"no kind 'TAIL': choose of EYE, UPPER"):
        bpy.ops.lissom.face_keys(target="Mask", parts="Gum", kinds="TAIL Gum")
    with pytest.raises(RuntimeError, match=r"'Lamp' is neither the head nor a part: choose of Mask, Gum"):
        bpy.ops.lissom.face_keys(target="Mask", parts="Gum", kinds="EYE Lamp")


def test_the_command_says_what_one_does_without_a_window(mask, tmp_path, capsys):
    path, out = str(tmp_path / "in.blend"), str(tmp_path / "out.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    words = ["face", "--file", path, "--target", "Mask", "--out", out]
    assert commands.main(words) == 2
    said = capsys.readouterr().out
    assert "No key is made" in said and "--landmarks" in said and "Pick" not in said
    assert commands.main([*words, "--kinds", "EYE Lamp"]) == 2
    assert "'EYE Lamp' is no KIND=OBJECT" in capsys.readouterr().out
