"""Transfer: markers, Fit, Transfer of keys."""

import json
import pathlib

import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import meshes
from mathutils import Matrix
from numpy.testing import assert_allclose, assert_array_equal

SETTINGS = {
    "squash": {"value": 0.25, "slider_min": -1.0, "slider_max": 2.0},
    "ears": {"value": -0.5, "slider_min": -1.0, "slider_max": 1.0, "mute": True},
}


def monkeys(levels=1, target_levels=1, every=20):
    """Suzanne with keys, and Suzanne of other faces; a marker at every so many of the plain vertices."""
    bpy.ops.mesh.primitive_monkey_add()
    plain = bpy.context.object
    places = scene.points(plain.data.vertices)[::every]
    bpy.data.objects.remove(plain)
    source = scene.monkey(levels, "Source")
    target = scene.monkey(target_levels, "Target")
    target.modifiers.new("Triangles", "TRIANGULATE")
    bpy.ops.object.modifier_apply(modifier="Triangles")
    rest = scene.points(source.data.vertices)
    scene.add_key(source, "squash", rest * [1.1, 1, 0.8], **limits("squash"))
    ears = np.clip(np.abs(rest[:, :1]) - 0.9, 0, None)
    scene.add_key(source, "ears", rest + ears * [0, 0.5, 1.0], **limits("ears"))
    nearest = [
        [int(np.argmin(np.linalg.norm(points - place, axis=1))) for place in places]
        for points in (rest, scene.points(target.data.vertices))
    ]
    used = set()
    for a, b in zip(*nearest, strict=True):
        if a not in used and ("t", b) not in used:
            used |= {a, ("t", b)}
            bpy.ops.lissom.marker_add(source="Source", target="Target", source_vertex=a, target_vertex=b)
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    return source, target


def limits(name):
    ordered = {"slider_max": SETTINGS[name]["slider_max"], "slider_min": SETTINGS[name]["slider_min"]}
    return ordered | SETTINGS[name]


def pairs():
    return [(row.source, row.target) for row in bpy.context.scene.lissom_transfer.markers]


def deltas(obj, name, relative="Basis"):
    return scene.key_points(obj, name) - scene.key_points(obj, relative)


def native(source, target, shapes):
    """The same by the native module alone."""
    ends = [
        lissom.Mesh(meshes.rest_positions(obj.data), meshes.triangles(obj.data)) for obj in (source, target)
    ]
    fit = lissom.fit_correspondence(*ends, np.array(pairs()))
    return lissom.Transfer(*ends, fit).apply(np.array(shapes)).vertices


def test_keys_are_carried_over_with_names_values_and_ranges():
    source, target = monkeys()
    assert min(len(obj.data.vertices) for obj in (source, target)) > 2000
    assert bpy.ops.lissom.transfer_keys() == {"FINISHED"}
    keys = target.data.shape_keys.key_blocks
    assert keys.keys() == ["Basis", "squash", "ears"]
    for name, settings in SETTINGS.items():
        for setting, value in settings.items():
            assert getattr(keys[name], setting) == value, (name, setting)
        assert keys[name].relative_key == keys["Basis"]
    expected = native(source, target, [scene.key_points(source, name) for name in SETTINGS])
    for name, shape in zip(SETTINGS, expected, strict=True):
        assert_allclose(scene.key_points(target, name), shape, atol=2e-6)


def test_the_same_surface_gets_the_same_expression():
    """Known answer: both are Suzanne's limit surface, so the squash must come out as a squash."""
    _, target = monkeys(levels=2, target_levels=2)
    bpy.ops.lissom.transfer_keys(keys="squash")
    rest = scene.key_points(target, "Basis")
    expected = rest * [1.1, 1, 0.8]
    error = np.linalg.norm((scene.key_points(target, "squash") - expected), axis=1)
    moved = np.linalg.norm(expected - rest, axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.2 * np.sqrt(np.mean(moved**2))


def test_only_the_named_keys_are_carried_over():
    _, target = monkeys()
    bpy.ops.lissom.transfer_keys(keys="ears")
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "ears"]


def test_row_33_a_key_relative_to_another_key_is_so_on_the_target():
    source, target = monkeys()
    keys = source.data.shape_keys.key_blocks
    fix = scene.key_points(source, "squash") + [0, 0.1, 0] * np.sin(scene.key_points(source, "Basis")[:, :1])
    scene.add_key(source, "fix", fix)
    keys["fix"].relative_key = keys["squash"]
    bpy.ops.lissom.transfer_keys(keys="fix\nsquash")  # in the wrong order
    carried = target.data.shape_keys.key_blocks
    assert carried["fix"].relative_key == carried["squash"]
    squash, both = native(
        source, target, [scene.key_points(source, "squash"), scene.key_points(source, "fix")]
    )
    assert_allclose(deltas(target, "fix", "squash"), both - squash, atol=3e-6)
    carried["fix"].value = carried["squash"].value = 1
    assert_allclose(scene.shown(target), both, atol=3e-6)


def test_row_33_a_relative_key_that_is_not_carried_over():
    source, target = monkeys()
    keys = source.data.shape_keys.key_blocks
    scene.add_key(source, "fix", scene.key_points(source, "squash") + [0, 0.1, 0])
    keys["fix"].relative_key = keys["squash"]
    bpy.ops.lissom.transfer_keys(keys="fix")
    carried = target.data.shape_keys.key_blocks
    assert carried["fix"].relative_key == carried["Basis"]
    assert_allclose(deltas(target, "fix"), [[0, 0.1, 0]] * len(target.data.vertices), atol=5e-3)


def test_row_31_a_key_that_moves_nothing_moves_nothing():
    source, target = monkeys()
    scene.add_key(source, "still", scene.key_points(source, "Basis"))
    bpy.ops.lissom.transfer_keys(keys="still")
    assert_array_equal(deltas(target, "still"), 0)


@pytest.mark.parametrize(
    ("exists", "names", "overwritten"),
    [("UPDATE", ["squash", "ears"], True), ("SKIP", ["squash", "ears"], False),
     ("RENAME", ["squash", "squash.001", "ears"], False)],
)  # fmt: skip
def test_row_32_a_key_of_that_name_exists(exists, names, overwritten):
    _, target = monkeys()
    rest = scene.points(target.data.vertices)
    scene.add_key(target, "squash", rest + 1)
    bpy.ops.lissom.transfer_keys(exists=exists)
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", *names]
    assert np.allclose(deltas(target, "squash"), 1, atol=1e-5) != overwritten


def test_row_32_nothing_is_left_to_do():
    monkeys()
    bpy.ops.lissom.transfer_keys()
    with scene.refused("has all of these keys, and If Exists is Skip"):
        bpy.ops.lissom.transfer_keys(exists="SKIP")


def test_row_36_meshes_stand_as_in_the_scene():
    source, target = monkeys()
    bpy.ops.lissom.transfer_keys()
    plain = deltas(target, "ears")
    target.shape_key_clear()
    quarter = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # as importers of y-up files leave objects
    for key in source.data.shape_keys.key_blocks:
        key.points.foreach_set("co", (scene.points(key.data) @ quarter).ravel())
    source.data.vertices.foreach_set("co", (scene.points(source.data.vertices) @ quarter).ravel())
    source.rotation_euler.x = np.pi / 2
    target.scale = (2, 2, 2)
    source.scale = (-2, 2, 2)
    mirror = np.array([-1, 1, 1])
    for key in source.data.shape_keys.key_blocks:
        key.points.foreach_set("co", (scene.points(key.data) * mirror).ravel())
    source.data.flip_normals()  # Blender shows a mirrored object's faces from the same side as its own
    bpy.context.view_layer.update()
    bpy.ops.lissom.transfer_keys()
    assert_allclose(deltas(target, "ears"), plain, atol=2e-4)


def test_row_36_a_mirrored_target_gets_the_same_key():
    """A pure z key: mirrored along x, nothing of the answer changes."""
    source, target = monkeys()
    rest = scene.key_points(source, "Basis")
    scene.add_key(source, "rise", rest + [0, 0, 0.3] * np.clip(rest[:, 2:], 0, None))
    bpy.ops.lissom.transfer_keys(keys="rise")
    plain = deltas(target, "rise")
    assert np.abs(plain[:, 2]).max() > 0.2
    target.shape_key_clear()
    for obj in (source, target):
        obj.scale.x = -1
    bpy.context.view_layer.update()
    bpy.ops.lissom.transfer_keys(keys="rise")
    assert_allclose(deltas(target, "rise"), plain, atol=2e-4)


@pytest.mark.parametrize("side", [0, 1])
def test_row_36_one_mirrored_end_gets_the_mirrored_key(side):
    """Suzanne is her own mirror image: with the markers moved across, the answer is the mirrored one."""
    ends = monkeys()
    rests = [scene.points(obj.data.vertices) for obj in ends]
    rise = rests[0] + [0, 0, 0.3] * np.clip(rests[0][:, 2:], 0, None)
    scene.add_key(ends[0], "rise", rise)
    bpy.ops.lissom.transfer_keys(keys="rise")
    plain = deltas(ends[1], "rise")
    ends[1].shape_key_clear()
    ends[side].scale.x = -1
    bpy.context.view_layer.update()
    across = [
        int(np.argmin(np.linalg.norm(rests[side] * [-1, 1, 1] - point, axis=1))) for point in rests[side]
    ]
    for row in bpy.context.scene.lissom_transfer.markers:
        name = ("source", "target")[side]
        setattr(row, name, across[getattr(row, name)])
    bpy.ops.lissom.transfer_keys(keys="rise")
    expected = 0.3 * np.clip(rests[1][:, 2], 0, None)
    errors = [
        np.linalg.norm(found - expected[:, None] * [0, 0, 1]) for found in (plain, deltas(ends[1], "rise"))
    ]
    assert max(errors) < 1e-3, errors  # all vertices together


def test_masked_vertices_match_nothing():
    source, target = monkeys()
    faces = [meshes.triangles(obj.data) for obj in (source, target)]
    hidden = [scene.group(obj, "hidden", lambda co: co.z > 0.4) for obj in (source, target)]
    bpy.ops.lissom.transfer_fit(source_mask="hidden", target_mask="hidden")
    pairs = session.fit.fit.pairs
    for side in (0, 1):
        masked = np.isin(faces[side], hidden[side]).any(axis=1)
        assert masked.any() and not masked[pairs[:, side]].any()
    with scene.refused("has no vertex group named 'gone'"):
        bpy.ops.lissom.transfer_fit(target_mask="gone")
    fit = session.fit.fit
    bpy.ops.lissom.transfer_keys(source_mask="hidden", target_mask="hidden")
    assert session.fit.fit is fit
    bpy.ops.lissom.transfer_keys(source_mask="hidden")
    assert session.fit.fit is not fit


def test_the_same_faces_need_no_markers():
    source, target = scene.monkey(1, "Source"), scene.monkey(1, "Target")
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    rest = scene.points(source.data.vertices)
    key = rest + 0.1 * np.sin(5 * rest[:, [1, 2, 0]])
    scene.add_key(source, "wave", key)
    bpy.ops.lissom.transfer_keys()
    assert_allclose(deltas(target, "wave"), key - rest, atol=1e-5)
    settings.target = other = scene.tube(name="Other")
    with scene.refused("too little in common"):
        bpy.ops.lissom.transfer_keys(target=other.name)


def test_what_is_moved_and_scaled_is_found_by_its_shape():
    """Known answer: both are Suzanne's limit surface, so the squash must come out as a squash."""
    _, target = monkeys(levels=2, target_levels=2)
    bpy.ops.lissom.marker_clear()
    rest = scene.points(target.data.vertices)
    target.data.transform(Matrix.Translation((3, -1, 2)) @ Matrix.Scale(2.5, 4))
    assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}
    fit = session.fit.fit
    assert 0.5 < fit.report["certainty"] < 1 and session.fit.pairs == []
    bpy.ops.lissom.transfer_keys(keys="squash")
    assert session.fit.fit is fit
    moved = 2.5 * (rest * [1.1, 1, 0.8] - rest)
    error = np.linalg.norm(deltas(target, "squash") - moved, axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.2 * np.sqrt(np.mean(np.sum(moved**2, axis=1)))


def test_a_marker_file_without_pairs_is_no_way_to_say_none():
    monkeys()
    with scene.refused("hold no pairs"):
        bpy.ops.lissom.transfer_fit(markers='{"format": "lissom-markers", "version": 1, "pairs": []}')


def driven_monkeys():
    """The key squash driven by a slider of the source, ears by squash itself."""
    source, target = monkeys()
    source["slider"] = 0.25
    source.id_properties_ui("slider").update(min=0.0, max=0.5)
    keys = source.data.shape_keys
    for name, kind, block, path in (
        ("squash", "OBJECT", source, '["slider"]'),
        ("ears", "KEY", keys, 'key_blocks["squash"].value'),
    ):
        driver = keys.key_blocks[name].driver_add("value").driver
        driver.type = "SUM"
        goal = driver.variables.new().targets[0]
        goal.id_type, goal.id, goal.data_path = kind, block, path
    return source, target


def value(obj, name):
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    return obj.evaluated_get(graph).data.shape_keys.key_blocks[name].value


@pytest.mark.parametrize(("drivers", "reads"), [("REWIRE", "target"), ("KEEP", "source"), ("NONE", None)])
def test_drivers_come_along(drivers, reads):
    source, target = driven_monkeys()
    bpy.ops.lissom.transfer_keys(drivers=drivers)
    found = target.data.shape_keys.animation_data
    if reads is None:
        assert found is None or not len(found.drivers)
        return
    obj = {"source": source, "target": target}[reads]
    assert obj["slider"] == 0.25
    obj["slider"] = 0.4
    obj.update_tag()
    assert_allclose([value(target, name) for name in ("squash", "ears")], 0.4, atol=1e-6)
    assert ("slider" in target) == (reads == "target")
    if reads == "target":
        assert target.id_properties_ui("slider").as_dict()["max"] == 0.5
        assert_allclose(source.data.shape_keys.key_blocks["squash"].value, 0.25, atol=1e-6)


def test_a_fit_is_used_again_until_something_changes():
    source, _ = monkeys()
    bpy.ops.lissom.transfer_fit()
    fit = session.fit.fit
    bpy.ops.lissom.transfer_keys()
    assert session.fit.fit is fit
    bpy.ops.lissom.marker_remove(index=0)
    bpy.ops.lissom.transfer_keys()
    assert session.fit.fit is not fit
    fit = session.fit.fit
    source.data.shape_keys.reference_key.data[0].co.x += 0.01
    bpy.ops.lissom.transfer_keys()
    assert session.fit.fit is not fit


def test_properties_alone_suffice(tmp_path):
    _, target = monkeys()
    path = str(tmp_path / "markers.json")
    bpy.ops.lissom.marker_save(filepath=path)
    text = pathlib.Path(path).read_text()
    bpy.ops.lissom.transfer_keys()
    expected = deltas(target, "squash")
    settings = bpy.context.scene.lissom_transfer
    settings.markers.clear()
    settings.source = settings.target = None
    bpy.context.view_layer.objects.active = None
    for markers in ({"filepath": path}, {"markers": text}):
        target.shape_key_clear()
        session.clear()
        bpy.ops.lissom.transfer_keys(source="Source", target="Target", keys="squash", **markers)
        assert_allclose(deltas(target, "squash"), expected, atol=1e-6)


def test_a_linked_source_may_be_read(tmp_path):
    monkeys()
    path = str(tmp_path / "library.blend")
    markers = str(tmp_path / "markers.json")
    bpy.ops.lissom.marker_save(filepath=markers)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.data.objects.remove(bpy.data.objects["Source"])
    with bpy.data.libraries.load(path, link=True) as (_, into):
        into.objects = ["Source"]
    bpy.context.collection.objects.link(into.objects[0])
    bpy.ops.lissom.transfer_keys(source="Source", target="Target", keys="squash", filepath=markers)
    assert "squash" in bpy.data.objects["Target"].data.shape_keys.key_blocks
    with scene.refused("is linked from another file"):
        bpy.ops.lissom.transfer_keys(source="Target", target="Source", filepath=swapped(markers, tmp_path))


def swapped(path, folder):
    document = json.loads(pathlib.Path(path).read_text())
    document["source"], document["target"] = document["target"], document["source"]
    for pair in document["pairs"]:
        pair["source"], pair["target"] = pair["target"], pair["source"]
    (folder / "swapped.json").write_text(json.dumps(document))
    return str(folder / "swapped.json")


def test_the_live_pose_is_not_carried_over():
    source, target = monkeys()
    scene.group(source, "top", lambda co: co.z > 0.8)
    bpy.ops.lissom.pose_handle_add(object="Source", vertex_group="top")
    bpy.ops.lissom.pose_bind(object="Source")
    assert "Lissom Pose" in source.data.shape_keys.key_blocks
    bpy.ops.lissom.transfer_keys()
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "squash", "ears"]
    bpy.ops.lissom.transfer_choose(action="ALL")
    assert bpy.context.scene.lissom_transfer.chosen.keys() == ["squash", "ears"]
    with scene.refused("'Lissom Pose' shows the live pose"):
        bpy.ops.lissom.transfer_keys(keys="Lissom Pose")
    bpy.ops.lissom.pose_unbind(object="Source")


def test_the_live_pose_of_the_target_is_not_written_over():
    source, target = monkeys()
    scene.group(target, "top", lambda co: co.z > 0.8)
    bpy.ops.lissom.pose_handle_add(object="Target", vertex_group="top")
    bpy.ops.lissom.pose_bind(object="Target")
    scene.add_key(source, "Lissom Pose", scene.key_points(source, "squash"))
    with scene.refused("'Lissom Pose' shows the live pose"):
        bpy.ops.lissom.transfer_keys()
    bpy.ops.lissom.transfer_keys(exists="RENAME")
    assert "Lissom Pose.001" in target.data.shape_keys.key_blocks


def test_empty_lines_between_the_names_of_keys_do_not_count():
    _, target = monkeys()
    bpy.ops.lissom.transfer_keys(keys="squash\n\nears\n")
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "squash", "ears"]


def test_meshes_that_nowhere_match():
    """A triangle, and a steep tent over it: the markers hold the corners, the faces stay far apart."""
    corners = [(1, 0, 0), (-0.5, 0.87, 0), (-0.5, -0.87, 0)]
    settings = bpy.context.scene.lissom_transfer
    for side, vertices, faces in (
        ("source", corners, [(0, 1, 2)]),
        ("target", [*corners, (0, 0, 9)], [(0, 1, 3), (1, 2, 3), (2, 0, 3)]),
    ):
        mesh = bpy.data.meshes.new(side)
        mesh.from_pydata(vertices, [], faces)
        setattr(settings, side, bpy.data.objects.new(side, mesh))
        bpy.context.collection.objects.link(getattr(settings, side))
    for vertex in range(3):
        bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=vertex)
    scene.add_key(settings.source, "wide", np.array(corners) * [2, 1, 1])
    for operator in (bpy.ops.lissom.transfer_fit, bpy.ops.lissom.transfer_keys):
        with scene.refused("raise Match Distance, or add markers"):
            operator()
    assert session.fit is None


# Markers


def two_meshes():
    source, target = scene.tube(name="Source"), scene.tube(20, 30, name="Target")
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    return source, target


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_marker_is_added_from_the_selected_vertices(mode):
    source, target = two_meshes()
    scene.select(source, [17])
    scene.select(target, [4])
    for obj in (source, target):
        obj.select_set(True)
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.lissom.marker_add(name="lip")
    (row,) = bpy.context.scene.lissom_transfer.markers
    assert (row.name, row.source, row.target) == ("lip", 17, 4)


def test_several_clicked_vertices_are_paired_in_the_order_of_the_clicks():
    import bmesh

    source, target = two_meshes()
    for obj in (source, target):
        obj.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    for obj, vertices in ((source, [9, 3, 5]), (target, [1, 8, 2])):
        edit = bmesh.from_edit_mesh(obj.data)
        edit.verts.ensure_lookup_table()
        for vertex in vertices:
            edit.verts[vertex].select_set(True)
            edit.select_history.add(edit.verts[vertex])
        bmesh.update_edit_mesh(obj.data)
    bpy.ops.lissom.marker_add()
    assert pairs() == [(9, 1), (3, 8), (5, 2)]
    assert [row.name for row in bpy.context.scene.lissom_transfer.markers] == [
        "Marker 1",
        "Marker 2",
        "Marker 3",
    ]


def test_an_unclear_selection_is_refused():
    source, target = two_meshes()
    scene.select(source, [])
    scene.select(target, [4])
    with scene.refused("'Source' has 0 selected, 'Target' 1"):
        bpy.ops.lissom.marker_add()
    scene.select(source, [1, 2])
    scene.select(target, [4, 5])
    with scene.refused("2 vertices are selected on each mesh"):
        bpy.ops.lissom.marker_add()


def test_rows_9_and_28_bad_vertices_are_not_added():
    two_meshes()
    bpy.ops.lissom.marker_add(source_vertex=1, target_vertex=2)
    with scene.refused("'Marker 1' and 'Marker 2' lie on the same source vertex 1"):
        bpy.ops.lissom.marker_add(source_vertex=1, target_vertex=3)
    with scene.refused("target mesh has 630 vertices"):
        bpy.ops.lissom.marker_add(source_vertex=3, target_vertex=630)


def test_markers_are_removed_shown_and_cleared():
    source, target = two_meshes()
    for vertex in range(3):
        bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=vertex + 10)
    bpy.ops.lissom.marker_show(index=1)
    assert meshes.selected_vertices(source).tolist() == [1]
    assert meshes.selected_vertices(target).tolist() == [11]
    bpy.ops.lissom.marker_remove()
    assert pairs() == [(0, 10), (2, 12)]
    bpy.ops.lissom.marker_remove(index=0)
    assert pairs() == [(2, 12)]
    with scene.refused("no marker 7"):
        bpy.ops.lissom.marker_remove(index=7)
    bpy.ops.lissom.marker_clear()
    assert pairs() == []
    with scene.refused("There are no markers yet"):
        bpy.ops.lissom.marker_clear()


def test_saved_markers_are_loaded(tmp_path):
    two_meshes()
    path = str(tmp_path / "markers.json")
    for vertex in range(3):
        bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=vertex + 10, name=f"é{vertex}")
    bpy.ops.lissom.marker_save(filepath=path)
    before = scene.snapshot()
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.marker_load(filepath=path)
    assert scene.snapshot() == before


def test_markers_of_another_mesh_are_said(tmp_path, capfd):
    two_meshes()
    path = tmp_path / "markers.json"
    bpy.ops.lissom.marker_add(source_vertex=0, target_vertex=0)
    bpy.ops.lissom.marker_save(filepath=str(path))
    document = json.loads(path.read_text().replace('"vertices": 630', '"vertices": 631'))
    for side in ("source", "target"):  # by which they would be found again
        del document["pairs"][0][f"{side}_place"]
    path.write_text(json.dumps(document))
    bpy.ops.lissom.marker_load(filepath=str(path))
    assert "made for a target of 631 vertices, 'Target' has 630" in capfd.readouterr().out


def test_row_41_a_bad_file_leaves_the_list_as_it_was(tmp_path):
    two_meshes()
    bpy.ops.lissom.marker_add(source_vertex=0, target_vertex=0)
    path = tmp_path / "markers.json"
    for content, message in (
        ("[" * 100_000, "deeper than 16"),
        ("{", "not valid JSON"),
        ("x" * (5 << 20), "larger than 4 MiB"),
        ('{"format": "lissom-markers", "version": 1, "pairs": [{"source": 0, "target": 9999}]}', "9999"),
        ('{"format": "lissom-markers", "version": 1, "pairs": []}', "holds no pairs"),
        ('{"format": "lissom-markers", "version": 0, "pairs": [{"source": 0, "target": 0}]}', "version"),
    ):
        path.write_text(content)
        with scene.refused(message):
            bpy.ops.lissom.marker_load(filepath=str(path))
    with scene.refused("does not exist"):
        bpy.ops.lissom.marker_load(filepath=str(tmp_path / "none.json"))
    with scene.refused("not valid JSON"):
        bpy.ops.lissom.transfer_fit(markers="{")


# Bad input


def test_row_27_markers_that_are_too_few(capfd):
    monkeys()
    markers = bpy.context.scene.lissom_transfer.markers
    while len(markers) > 2:
        markers.remove(0)
    bpy.ops.lissom.transfer_fit()
    assert "Warning: " in capfd.readouterr().out


def test_objects_that_are_missing_or_the_same():
    source, _ = monkeys()
    settings = bpy.context.scene.lissom_transfer
    settings.target = source
    with scene.refused("are the same object"):
        bpy.ops.lissom.transfer_fit()
    settings.target = None
    with scene.refused("Choose the target object first"):
        bpy.ops.lissom.transfer_fit()
    with scene.refused("no object named 'Nobody'"):
        bpy.ops.lissom.transfer_fit(target="Nobody")


def test_keys_that_are_missing_or_named_twice():
    monkeys()
    with scene.refused("'Source' has no shape key named 'frown'"):
        bpy.ops.lissom.transfer_keys(keys="squash\nfrown")
    for exists in ("UPDATE", "RENAME"):
        with scene.refused("'squash' is asked for twice"):
            bpy.ops.lissom.transfer_keys(keys="squash\nsquash", exists=exists)
    with scene.refused("'Target' has no shape keys"):
        bpy.ops.lissom.transfer_keys(source="Target", target="Source", markers=_swapped_text())


def _swapped_text():
    rows = [{"source": b, "target": a} for a, b in pairs()]
    return json.dumps({"format": "lissom-markers", "version": 1, "pairs": rows})


def test_row_34_a_locked_key_edit_mode_and_a_basis_by_another_name():
    _, target = monkeys()
    key = scene.add_key(target, "squash", scene.points(target.data.vertices))
    key.lock_shape = True
    with scene.refused("Nothing to write. Locked, and left as they are: 'squash'"):
        bpy.ops.lissom.transfer_keys(keys="squash")
    scene.add_key(target, "ears", scene.points(target.data.vertices)).lock_shape = True
    with scene.refused("Nothing to write. Locked, and left as they are: 'squash', 'ears'"):
        bpy.ops.lissom.transfer_keys()
    bpy.context.view_layer.update()
    target.shape_key_remove(target.data.shape_keys.key_blocks["ears"])
    key = target.data.shape_keys.key_blocks["squash"]
    key.lock_shape = False
    target.data.shape_keys.reference_key.name = "ears"
    with scene.refused("'ears' is the Basis of 'Target'"):
        bpy.ops.lissom.transfer_keys()
    bpy.context.view_layer.objects.active = target
    bpy.ops.object.mode_set(mode="EDIT")
    with scene.refused("'Target' is in edit mode"):
        bpy.ops.lissom.transfer_keys()


def test_row_35_mesh_data_with_several_users(capfd):
    _, target = monkeys()
    bpy.context.collection.objects.link(bpy.data.objects.new("Twin", target.data))
    bpy.ops.lissom.transfer_keys(keys="squash")
    assert "Warning: The mesh of 'Target' is used by 2 objects" in capfd.readouterr().out


def test_row_36_a_scale_of_zero():
    source, _ = monkeys()
    source.scale.x = 0
    bpy.context.view_layer.update()
    with scene.refused("'Source' is zero along an axis"):
        bpy.ops.lissom.transfer_keys()


# The choice of keys


def test_keys_are_ticked_and_unticked():
    monkeys()
    chosen = bpy.context.scene.lissom_transfer.chosen
    for arguments, expected in (
        ({"action": "ALL"}, ["squash", "ears"]),
        ({"action": "TOGGLE", "key": "squash"}, ["ears"]),
        ({"action": "TOGGLE", "key": "squash"}, ["squash", "ears"]),
        ({"action": "NONE"}, []),
    ):
        bpy.ops.lissom.transfer_choose(**arguments)
        assert chosen.keys() == expected
    with scene.refused("no shape key named 'none' to tick"):
        bpy.ops.lissom.transfer_choose(action="TOGGLE", key="none")


def test_the_panels_button_says_what_is_missing():
    monkeys()
    settings = bpy.context.scene.lissom_transfer
    settings.which = "SELECTED"
    with bpy.context.temp_override(lissom_transfer=settings):
        with scene.refused("Tick the shape keys to carry over first"):
            bpy.ops.lissom.transfer_keys()
        settings.source = None
        with scene.refused("Choose two different objects"):
            bpy.ops.lissom.transfer_fit()
