"""Face keys by one press, on people whose answers are known, and the face that they come from."""

import json

import bpy
import heads
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.bridge.written import Written
from bl_ext.user_default.lissom.core.face_lids import Lids
from bl_ext.user_default.lissom.jobs.face import FaceAsked, FaceKeys
from lissom import data, names

SIZE = 0.07  # of the people's units in centimetres


def positions(points):
    found = np.empty(3 * len(points), dtype=np.float32)
    points.foreach_get("co", found)
    return found.reshape(-1, 3).astype(float)


def delta(obj, name):
    keys = obj.data.shape_keys.key_blocks
    return positions(keys[name].data) - positions(keys["Basis"].data)


@pytest.fixture(scope="module")
def person():
    """{name: (rest, {key: offsets}, its part of the face)} of a random person, keyed, and what was done."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    whole = data.face()
    other = np.tensordot(np.random.default_rng(5).normal(size=len(whole.modes)), whole.modes, 1)
    found = {}
    for name, regions in {
        "Head": ("face", "head_and_neck"),
        "Eyes": ("eyeball_left", "eyeball_right"),
        "Teeth": ("lower_teeth",),
    }.items():
        kept = np.concatenate([whole.regions[region] for region in regions])
        part = whole.only(*regions)
        found[name] = (
            scene.mesh_object(name, SIZE * (part.neutral + other[np.sort(kept)]), part.triangles),
            part,
        )
    job = FaceKeys(bpy.context, FaceAsked(target="Head", parts="Eyes\nTeeth"))
    done = job.write(bpy.context, job.work.wait())
    for name, (obj, part) in found.items():
        deltas = {key: delta(obj, key) for key in obj.data.shape_keys.key_blocks.keys()[1:]}
        found[name] = positions(obj.data.vertices), deltas, part
    return found, done


def test_a_person_gets_arkits_keys_that_are_its_own(person):
    found, done = person
    _, deltas, part = found["Head"]
    made_of, offsets, left = names.combined("ARKIT", part.expression_names, part.expressions)
    assert done.written["Head"] == made_of and done.left == left == ["tongueOut"]
    errors = [
        np.linalg.norm(deltas[name] - SIZE * known) / np.linalg.norm(SIZE * known)
        for name, known in zip(made_of, offsets, strict=True)
    ]
    assert np.median(errors) < 0.12
    assert done.landmarks == []
    assert sum(row["verdict"] == "bad" for row in done.quality) == 0


def test_eyes_turn_about_their_centres_and_teeth_go_with_the_jaw(person):
    found, done = person
    assert done.kinds["Head"] == [] and done.kinds["Eyes"] == ["EYE", "EYE"]
    assert set(done.kinds["Teeth"]) == {"LOWER"}
    rest, deltas, part = found["Eyes"]
    left, up = part.regions["eyeball_left"], deltas["eyeLookUpLeft"]
    assert not up[part.regions["eyeball_right"]].any()
    front = left[rest[left, 1].argmin()]
    assert up[front, 2] > 0.9 * abs(up[front]).max()
    before, after = rest[left], (rest + up)[left]
    kept = [np.linalg.norm(p[1:] - p[:-1], axis=1) for p in (before, after)]
    np.testing.assert_allclose(*kept, rtol=1e-3, atol=1e-5)
    _, deltas, part = found["Teeth"]
    known = SIZE * part.expressions[part.expression_names.index("jawOpen")]
    away = np.linalg.norm(deltas["jawOpen"] - known, axis=1).mean()
    assert away < 0.15 * np.linalg.norm(known, axis=1).mean()
    assert done.written["Eyes"] == [name for name in names.TABLES["ARKIT"] if name.startswith("eyeLook")]


def test_what_lies_behind_lids_and_lips_does_not_hold_them():
    """They meet as far as they do on the person, whose head has sockets and is cut otherwise."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    whole = data.face().only("face", "head_and_neck", "mouth_socket", "eye_sockets")
    random = np.random.default_rng(1)
    shape = whole.neutral + np.tensordot(random.normal(size=len(whole.modes)), whole.modes, 1)
    quads = whole.loops.reshape(-1, 4)
    cut = np.concatenate([quads[:, [0, 1, 3]], quads[:, [1, 2, 3]]])
    corners = np.arange(len(shape))[:, None].repeat(3, 1)  # of a triangle at each vertex, in which it slides
    for k in range(3):
        corners[cut[:, k]] = np.roll(cut, -k, axis=1)
    away = random.uniform(0, 0.15, (len(shape), 2))
    away[np.concatenate(list(whole.curves.values()))] = 0
    weights = np.column_stack([1 - away.sum(axis=1), away])

    def slid(values):
        return SIZE * np.einsum("nk,nkd->nd", weights, values[corners])

    rest = slid(shape)
    head = scene.mesh_object("Head", rest, cut)
    assert bpy.ops.lissom.face_keys(target="Head", names="ICT") == {"FINISHED"}
    known = dict(zip(whole.expression_names, map(slid, whole.expressions), strict=True))
    outside = whole.regions["face"]
    errors = [
        np.linalg.norm((delta(head, name) - answer)[outside]) / np.linalg.norm(answer[outside])
        for name, answer in known.items()
    ]
    assert np.median(errors) < 0.03 and max(errors) < 0.06, (np.median(errors), max(errors))
    diagonal = np.linalg.norm(np.ptp(rest, axis=0))
    for curve, keys in {
        "lid_left": ["eyeBlink_L"],
        "lid_right": ["eyeBlink_R"],
        "lips": ["jawOpen", "mouthClose"],
    }.items():
        sides = Lids.of(rest, whole.curves[curve])
        offsets = sum(delta(head, key) for key in keys), sum(known[key] for key in keys)
        apart, answer = (np.linalg.norm(sides.gaps(rest + by), axis=1).mean() for by in offsets)
        assert abs(apart - answer) < 1e-3 * diagonal, curve


def test_what_is_no_face_is_refused_and_nothing_written():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_torus_add(major_segments=60, minor_segments=30)
    torus = bpy.context.object
    with pytest.raises(RuntimeError, match=r"face|common"):
        bpy.ops.lissom.face_keys(target=torus.name)
    assert torus.data.shape_keys is None


def test_a_head_whose_faces_look_inward_is_told_so():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = heads.made("round")
    head = scene.mesh_object("Head", made.vertices, made.triangles[:, ::-1])
    with scene.refused("faces of the head look inward"):
        bpy.ops.lissom.face_keys(target=head.name)
    assert head.data.shape_keys is None


def test_the_face_is_added_as_high_as_what_is_selected():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add(size=3.0)
    bpy.context.object.rotation_euler = (0.3, 0, 0)
    bpy.context.object.scale = (1, 1, 2)
    bpy.context.view_layer.update()
    high = np.ptp([(bpy.context.object.matrix_world @ v.co).z for v in bpy.context.object.data.vertices])
    assert bpy.ops.lissom.source_face_add(names="ARKIT") == {"FINISHED"}
    made = bpy.context.object
    assert made.name == "Source Face" and made.dimensions.z == pytest.approx(high, rel=1e-5)
    assert made.data.shape_keys.key_blocks.keys()[1:] == list(names.TABLES["ARKIT"])[:-1]
    assert all(key.value == 0 for key in list(made.data.shape_keys.key_blocks)[1:])
    lids = made.vertex_groups["upper_lid_left"].index
    count = sum(any(g.group == lids for g in v.groups) for v in made.data.vertices)
    assert count == len(data.face().regions["upper_lid_left"])
    assert not made.data.validate()


def test_one_mesh_with_its_eyes_is_told_apart_and_parts_are_carried():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    whole = data.face().only("face", "head_and_neck", "eyeball_left", "eyeball_right")
    lash = data.face().only("upper_lid_left")
    amounts = [1.0, -0.5, 0.7]
    person, lashes = (
        SIZE * (part.neutral + np.tensordot(amounts, part.modes[:3], 1)) for part in (whole, lash)
    )
    head = scene.mesh_object("Head", person, whole.triangles)
    scene.mesh_object("Lashes", lashes + [0, -0.01, 0], lash.triangles)
    assert bpy.ops.lissom.face_keys(target="Head", parts="Lashes", names="ICT") == {"FINISHED"}
    blink = delta(bpy.data.objects["Lashes"], "eyeBlink_L")
    known = SIZE * lash.expressions[lash.expression_names.index("eyeBlink_L")]
    # Lids of a head with eyeballs close from corner to corner, which ICT's own do not: 0.30.
    assert np.linalg.norm(blink - known) < 0.35 * np.linalg.norm(known)
    look = delta(head, "eyeLookUp_L")
    left, right = (whole.regions[f"eyeball_{side}"] for side in ("left", "right"))
    assert np.linalg.norm(look[left], axis=1).max() > 0.3 * SIZE and not look[right].any()
    assert not delta(head, "jawOpen")[left].any()


def test_the_command_writes_keys_and_a_report(tmp_path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    whole = data.face().only("face", "head_and_neck")
    scene.mesh_object("Head", SIZE * whole.neutral, whole.triangles)
    path, out, report = (str(tmp_path / name) for name in ("in.blend", "out.blend", "report.json"))
    bpy.ops.wm.save_as_mainfile(filepath=path)
    words = [
        "face",
        "--file",
        path,
        "--target",
        "Head",
        "--names",
        "visemes",
        "--strengths",
        "viseme_aa=0.5",
        "--out",
        out,
        "--report",
        report,
    ]
    assert commands.main(words) == 0
    with open(report, encoding="utf-8") as file:
        told = json.load(file)
    assert told["written"]["Head"] == list(names.TABLES["VISEMES"]) and told["report"]["certainty"] > 0.9
    assert told["fit"] == told["report"] and told["certainty"] == told["sure"] and told["warnings"] == []
    bpy.ops.wm.open_mainfile(filepath=out)
    head = bpy.data.objects["Head"]
    assert head.data.shape_keys.key_blocks.keys()[1:] == told["written"]["Head"] and told["errors"] == []
    assert [Written(head).strength(name) for name in ("viseme_aa", "viseme_O")] == [0.5, 1.0]
    assert commands.main([*words[:4], "Nobody", *words[5:]]) == 2
