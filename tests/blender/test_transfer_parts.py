"""Transfer between several objects, keys that move nothing, and the table of quality."""

import json

import bmesh
import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.bridge.meshes import selected_vertices
from bl_ext.user_default.lissom.core.quality import as_dicts, pack_faces
from mathutils import Matrix
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import deltas, monkeys


def wink(source):
    """A key that moves the eyes alone, and one that moves nothing."""
    rest = scene.points(source.data.vertices)
    eyes = of_eyes(source)
    scene.add_key(source, "look", np.where(eyes[:, None], rest + [0.05, 0, 0.02], rest))
    scene.add_key(source, "nothing", rest)


def of_eyes(obj):
    """(n,) which vertices of Suzanne are on her eyes, loose parts of their own."""
    label = np.arange(len(obj.data.vertices))
    edges = np.array([edge.vertices[:] for edge in obj.data.edges])
    while True:
        before = label.copy()
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(label, edges[:, a], label[edges[:, b]])
        if np.array_equal(label, before):
            return label != np.bincount(label).argmax()


def separated(obj):
    """Moves the eyes to an object of their own; returns it, and the vertices of both in the old order."""
    eyes = of_eyes(obj)
    other = obj.copy()
    other.name, other.data = f"{obj.name} eyes", obj.data.copy()
    bpy.context.collection.objects.link(other)
    for one, gone in ((obj, eyes), (other, ~eyes)):
        mesh = bmesh.new()
        mesh.from_mesh(one.data)
        mesh.verts.ensure_lookup_table()
        bmesh.ops.delete(mesh, geom=[mesh.verts[v] for v in np.flatnonzero(gone)])
        mesh.to_mesh(one.data)
        mesh.free()
    return other, np.concatenate([np.flatnonzero(~eyes), np.flatnonzero(eyes)])


@pytest.fixture
def both():
    """What joined monkeys get, then the same ones with separate eyes, whose origins lie elsewhere."""
    source, target = monkeys()
    wink(source)
    settings = bpy.context.scene.lissom_transfer
    places = [
        [tuple(obj.data.vertices[getattr(row, side)].co) for row in settings.markers]
        for side, obj in (("source", source), ("target", target))
    ]
    assert bpy.ops.lissom.transfer_keys() == {"FINISHED"}
    expected = {name: deltas(target, name) for name in ("squash", "ears", "look")}
    target.shape_key_clear()
    eyes = []
    for obj in (source, target):
        other, order = separated(obj)
        eyes.append(other)
        if obj == target:
            expected = {name: values[order] for name, values in expected.items()}
    settings.markers.clear()
    used = set()
    for pair in zip(*places, strict=True):
        (a, near), (b, close) = (
            nearest(obj, place) for obj, place in zip((source, target), pair, strict=True)
        )
        if max(near, close) < 1e-5 and not used & {("source", a), ("target", b)}:
            used |= {("source", a), ("target", b)}
            bpy.ops.lissom.marker_add(source_vertex=a, target_vertex=b)
    for obj in eyes:  # the same place in the world, other coordinates
        obj.data.transform(Matrix.Translation((0.3, -0.2, 0.1)), shape_keys=True)
        obj.location = (-0.3, 0.2, -0.1)
    bpy.context.view_layer.update()
    return (source, eyes[0]), (target, eyes[1]), expected


def nearest(obj, place):
    distance = np.linalg.norm(scene.points(obj.data.vertices) - place, axis=1)
    return int(distance.argmin()), distance.min()


def names(objects):
    return "\n".join(obj.name for obj in objects)


def test_separate_objects_get_what_joined_ones_get(both):
    sources, targets, expected = both
    assert bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets)) == {"FINISHED"}
    counts = [len(obj.data.vertices) for obj in targets]
    for name, wanted in expected.items():
        for obj, own in zip(targets, np.split(wanted, counts[:1]), strict=True):
            if name in obj.data.shape_keys.key_blocks:
                assert_allclose(deltas(obj, name), own, atol=2e-3)
            else:
                assert not own.any(), (obj.name, name)
    assert np.abs(deltas(targets[1], "look")).max() > 0.03


def test_further_objects_get_only_the_keys_that_move_them(both):
    sources, targets, _ = both
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets))
    keys = [list(obj.data.shape_keys.key_blocks.keys()) for obj in targets]
    assert keys[0] == ["Basis", "squash", "ears", "look", "nothing"]
    assert keys[1] == ["Basis", "squash", "look"]
    # One that is there already is written all the same.
    rest = scene.points(targets[1].data.vertices)
    scene.add_key(targets[1], "ears", rest + 1)
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets))
    assert not deltas(targets[1], "ears").any()


def test_row_31_empty_keys_are_dropped_by_option():
    source, target = monkeys()
    wink(source)
    assert bpy.ops.lissom.transfer_keys(drop_empty=True) == {"FINISHED"}
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "squash", "ears", "look"]


def test_row_32_a_renamed_key_has_one_name_on_all_objects(both):
    sources, targets, _ = both
    for obj in targets[1:]:
        scene.add_key(obj, "squash", scene.points(obj.data.vertices))
    sides = {"source": names(sources), "target": names(targets)}
    bpy.ops.lissom.transfer_keys(keys="squash", exists="RENAME", **sides)
    assert all("squash.001" in obj.data.shape_keys.key_blocks for obj in targets)
    assert "squash" not in targets[0].data.shape_keys.key_blocks


def test_row_34_a_locked_key_of_a_further_object(both):
    sources, targets, _ = both
    rest = scene.points(targets[1].data.vertices)
    scene.add_key(targets[1], "squash", rest).lock_shape = True
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets))
    assert_array_equal(scene.key_points(targets[1], "squash"), rest)
    assert deltas(targets[0], "squash").any()


def test_objects_on_both_sides_and_missing_ones_are_refused():
    monkeys()
    with scene.refused("Source and target are the same object, 'Target'"):
        bpy.ops.lissom.transfer_keys(source="Source\nTarget", target="Target")
    with scene.refused("no object named 'Eyes'"):
        bpy.ops.lissom.transfer_keys(source="Source\nEyes", target="Target")


def test_the_panels_further_objects(both):
    sources, targets, _ = both
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = sources[0], targets[0]
    for side, (_, eyes) in (("SOURCE", sources), ("TARGET", targets)):
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj == eyes)
        assert bpy.ops.lissom.transfer_parts(side=side) == {"FINISHED"}
        with scene.refused("Select mesh objects"):
            bpy.ops.lissom.transfer_parts(side=side)
    assert [row.object for row in settings.target_parts] == [targets[1]]
    assert bpy.ops.lissom.transfer_keys() == {"FINISHED"}
    assert "look" in targets[1].data.shape_keys.key_blocks
    bpy.ops.lissom.transfer_parts(side="TARGET", remove=0)
    assert not len(settings.target_parts)
    # A further object that was deleted is passed over.
    bpy.data.objects.remove(sources[1])
    assert bpy.ops.lissom.transfer_keys(keys="squash") == {"FINISHED"}


def test_the_quality_of_every_key_is_listed_and_saved(tmp_path):
    source, target = monkeys()
    wink(source)
    settings = bpy.context.scene.lissom_transfer
    with pytest.raises(RuntimeError, match="Check Quality first"):
        bpy.ops.lissom.quality_save(filepath=str(tmp_path / "quality.json"))
    bpy.ops.lissom.transfer_keys(exists="RENAME", check=False)
    assert not len(settings.quality)
    bpy.ops.lissom.transfer_keys(exists="RENAME")
    assert [row.name for row in settings.quality] == ["squash.001", "ears.001", "look.001", "nothing.001"]
    squash, ears, _, nothing = settings.quality
    assert 0.9 < squash.amplitude < 1.1 and 0.9 < ears.amplitude < 1.1
    assert squash.motion > ears.motion / 10 > 0
    assert nothing.verdict == "good" and nothing.residual == nothing.motion == 0
    bpy.ops.lissom.quality_save(filepath=str(tmp_path / "quality.json"))
    rows = json.loads((tmp_path / "quality.json").read_text())["keys"]
    ranks = [["good", "look", "bad"].index(row["verdict"]) for row in rows]
    assert len(rows) == 4 and ranks == sorted(ranks, reverse=True)
    assert settings.quality[settings.active_quality].name == rows[0]["name"]  # where the list scrolls to
    assert rows[-1] == {
        "name": "nothing.001", "verdict": "good", "reasons": [], "faces": {}, "flipped_triangles": 0,
        "torn_triangles": 0, "contacts": 0, "contact_gap": 0.0, "closing": 1.0, "amplitude": 1.0,
        "crooked": 0.0, "covered": 1.0, "motion": 0.0, "residual": 0.0,
    }  # fmt: skip
    settings.active_quality = 2
    assert target.active_shape_key.name == "look.001"


def test_faces_of_a_row_are_selected_on_their_objects(both):
    sources, targets, _ = both
    settings = bpy.context.scene.lissom_transfer
    settings.target = targets[0]
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets))
    row = settings.quality["look"]
    with scene.refused("'squash' has no faces to look at"):
        settings.quality["squash"].faces = "{}"
        bpy.ops.lissom.quality_select(key="squash")
    row.faces, row.reasons = pack_faces({targets[0].name: [3, 9], targets[1].name: [0]}), "3 triangles torn"
    assert bpy.ops.lissom.quality_select(key="look") == {"FINISHED"}
    for obj, faces in zip(targets, ([3, 9], [0]), strict=True):
        wanted = {v for face in faces for v in obj.data.polygons[face].vertices}
        assert set(selected_vertices(obj).tolist()) == wanted
        assert obj.active_shape_key.name == "look"
    row.faces = pack_faces({targets[1].name: [10**6]})
    with scene.refused("was changed since: transfer again"):
        bpy.ops.lissom.quality_select(key="look")
    with scene.refused("no shape key named 'other'"):
        bpy.ops.lissom.quality_select(key="other")


def test_a_key_that_turns_faces_over_is_bad_and_says_which(both):
    """The source's own key is fine; a fit with markers exchanged is not."""
    sources, targets, _ = both
    settings = bpy.context.scene.lissom_transfer
    count = len(settings.markers)
    for k in range(0, count // 2, 2):
        one, other = settings.markers[k], settings.markers[count - 1 - k]
        one.target, other.target = other.target, one.target
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets), marker_tolerance=0)
    rows = as_dicts(bpy.context.scene.lissom_transfer.quality)
    assert rows[0]["verdict"] == "bad" and rows[0]["faces"]
    counts = {obj.name: len(obj.data.polygons) for obj in targets}
    for row in rows:
        assert (row["verdict"] == "good") == (not row["reasons"])
        for name, faces in row["faces"].items():
            assert faces == sorted(set(faces)) and faces[-1] < counts[name]


def test_the_command_takes_several_objects_and_reports_quality(both, tmp_path):
    sources, targets, _ = both
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "both.blend"))
    bpy.ops.lissom.transfer_keys(source=names(sources), target=names(targets))
    expected = [deltas(obj, "look") for obj in targets]
    words = [
        "--file",
        tmp_path / "both.blend",
        "--out",
        tmp_path / "out.blend",
        "--report",
        tmp_path / "r.json",
    ]
    words += ["--source", *(obj.name for obj in sources), "--target", *(obj.name for obj in targets)]
    chosen = [obj.name for obj in targets]
    assert commands.main(["transfer", *map(str, words), "--drop-empty"]) == 0
    said = json.loads((tmp_path / "r.json").read_text())
    assert {row["name"] for row in said["quality"]} == {"squash", "ears", "look"}
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    head, eyes = (bpy.data.objects[name] for name in chosen)
    assert "nothing" not in head.data.shape_keys.key_blocks
    assert_array_equal(deltas(eyes, "look"), expected[1])
