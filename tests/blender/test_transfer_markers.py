"""Markers in the scene: by symmetry, through edits of the meshes, in files, under the mouse."""

import json

import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import markers as bridge_markers
from bl_ext.user_default.lissom.bridge.assembly import Assembly
from bl_ext.user_default.lissom.core.surface import Point
from mathutils import Vector
from numpy.testing import assert_allclose
from test_transfer import monkeys, pairs


def settings():
    return bpy.context.scene.lissom_transfer


def rests():
    ends = settings().source, settings().target
    return [scene.points(obj.data.shape_keys.key_blocks[0].data if obj.data.shape_keys else obj.data.vertices)
            for obj in ends]  # fmt: skip


def subdivided(obj, kind="SUBSURF"):
    """Other faces; with kind SUBSURF also other vertices, in another order than before."""
    obj.shape_key_clear()
    obj.modifiers.new("Other", kind)
    if kind == "SUBSURF":
        obj.modifiers["Other"].subdivision_type = "SIMPLE"
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.modifier_apply(modifier="Other")
    if kind == "SUBSURF":
        count = len(obj.data.vertices)
        order = np.random.default_rng(0).permutation(count)
        place = np.argsort(order)
        points = scene.points(obj.data.vertices)[order]
        faces = [[int(place[v]) for v in face.vertices] for face in obj.data.polygons]
        mesh = bpy.data.meshes.new("Shuffled")
        mesh.from_pydata(points.tolist(), [], faces)
        obj.data = mesh


def test_pairs_of_one_side_are_completed():
    monkeys(every=10)
    rows = settings().markers
    sides = [rests()[0][row.source][0] for row in rows]
    for index in reversed(range(len(rows))):
        if sides[index] < -0.01:
            rows.remove(index)
    rows[1].name = "brow.L"
    left = [row for row in rows if rests()[0][row.source][0] > 0.05]
    rows[rows.find("brow.L")].mirror = False
    kept = len(rows)
    expected = sum(row.mirror for row in left)
    assert bpy.ops.lissom.marker_mirror() == {"FINISHED"}
    assert len(rows) == kept + expected and expected > 10
    for row in list(rows)[kept:]:
        for rest, side in zip(rests(), ("source", "target"), strict=True):
            image = rest[getattr(row, side)] * [-1, 1, 1]
            marked = [rest[getattr(other, side)] for other in list(rows)[:kept]]
            assert np.linalg.norm(marked - image, axis=1).min() < 1e-5
    bpy.ops.lissom.marker_mirror()  # a second time adds nothing
    assert len(rows) == kept + expected


def test_what_has_no_other_side_is_refused():
    monkeys()
    rows = settings().markers
    while len(rows) > 1:
        rows.remove(len(rows) - 1)
    rest = rests()[0]
    rows[0].source = int(np.argmax(rest[:, 2] + rest[:, 0]))
    with scene.refused("No counterpart is on the other side"):
        bpy.ops.lissom.marker_mirror(axis="Z")


def test_a_marker_survives_new_faces_by_its_place():
    _, target = monkeys()
    bpy.ops.lissom.transfer_fit()
    before = [rest[list(side)] for rest, side in zip(rests(), zip(*pairs(), strict=True), strict=True)]
    subdivided(target)
    assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}
    after = [rest[list(side)] for rest, side in zip(rests(), zip(*pairs(), strict=True), strict=True)]
    for a, b in zip(before, after, strict=True):
        assert_allclose(a, b, atol=1e-6)


def test_a_marker_stays_on_its_vertex_through_sculpting():
    _, target = monkeys()
    bpy.ops.lissom.transfer_fit()
    before = pairs()
    for vertex in target.data.vertices:
        vertex.co = vertex.co * 1.3 + Vector((0, 0, 0.5))
    bpy.ops.lissom.transfer_fit()
    assert pairs() == before
    place = settings().markers[0].target_place
    assert_allclose(place, target.data.vertices[before[0][1]].co, atol=1e-6)  # that of now
    subdivided(target)
    bpy.ops.lissom.transfer_fit()
    assert_allclose(rests()[1][pairs()[0][1]], place, atol=1e-6)


def test_row_42_markers_of_another_mesh_are_refused():
    _, target = monkeys()
    bpy.ops.lissom.transfer_fit()
    for vertex in target.data.vertices:
        vertex.co.x += 5
    subdivided(target)
    with scene.refused("is not the mesh that these markers were placed on"):
        bpy.ops.lissom.transfer_fit()


def test_a_number_changed_by_hand_has_the_place_of_its_vertex():
    monkeys()
    row = settings().markers[0]
    row.source = 77
    assert_allclose(row.source_place, rests()[0][77], atol=1e-7)


def test_files_know_the_places(tmp_path):
    _, target = monkeys()
    path = str(tmp_path / "markers.json")
    bpy.ops.lissom.marker_save(filepath=path)
    document = json.loads((tmp_path / "markers.json").read_text())
    assert_allclose(document["pairs"][3]["target_place"], rests()[1][pairs()[3][1]], atol=1e-6)
    before = rests()[1][[target for _, target in pairs()]]
    subdivided(target)
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.marker_load(filepath=path)
    assert_allclose(rests()[1][[target for _, target in pairs()]], before, atol=1e-6)
    settings().target = None  # read before the target is chosen
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.marker_load(filepath=path)
    settings().target = target
    bpy.ops.lissom.transfer_fit()
    assert_allclose(rests()[1][[target for _, target in pairs()]], before, atol=1e-6)


def between_vertices():
    """The monkeys' markers, each moved into the middle of a face beside it, on both sides."""
    monkeys()
    ends = settings().source, settings().target
    random = np.random.default_rng(0)
    for index, row in enumerate(settings().markers):
        for side, obj in zip(("source", "target"), ends, strict=True):
            face = next(face for face in obj.data.polygons if getattr(row, side) in face.vertices)
            point = Point.of(list(face.vertices)[:3], random.dirichlet([5, 5, 5]))
            bridge_markers.move(bpy.context.scene, index, side, point)
    assert not any(point.is_vertex for row in settings().markers for point in row.ends)


def spots():
    """For each pair (2, 3): where its points are at rest."""
    return np.array([
        [point.position(rest) for point, rest in zip(row.ends, rests(), strict=True)]
        for row in settings().markers
    ])  # fmt: skip


@pytest.mark.parametrize("moved", [False, True])
def test_the_fit_goes_by_the_points_as_the_module_does(moved):
    between_vertices()
    if moved:
        settings().source.location, settings().target.scale = (1, 2, 3), (1, 1, 1.2)
        bpy.context.view_layer.update()
    assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}
    found = session.fit.fit
    ends = [Assembly([obj]) for obj in (settings().source, settings().target)]
    fit = lissom.fit_correspondence(
        *(lissom.Mesh(*end.geometry()) for end in ends),
        [(row.source, row.target) for row in settings().markers],
        source_points=[row.point("source").position(ends[0].rest()) for row in settings().markers],
        points=[row.point("target").position(ends[1].rest()) for row in settings().markers],
        marker_tolerance=settings().marker_tolerance,
        match_distance=settings().match_distance,
        closest=settings().closest,
    )
    assert np.array_equal(found.fitted_vertices, fit.fitted_vertices)
    assert np.array_equal(found.marker_distances, fit.marker_distances)
    before = found.fitted_vertices
    bridge_markers.move(bpy.context.scene, 0, "target", settings().markers[0].point("target"))
    row = settings().markers[0]
    assert session.fit.pairs[0] == row.ends
    row.target = row.target  # onto the vertex itself
    assert session.fit.pairs[0] != row.ends
    bpy.ops.lissom.transfer_fit()
    assert not np.array_equal(session.fit.fit.fitted_vertices, before), "a fit of its own"


def test_points_survive_files_remodelling_and_mirroring(tmp_path):
    between_vertices()
    _, target = settings().source, settings().target
    path = str(tmp_path / "markers.json")
    before, known = spots(), [(row.ends, row.number) for row in settings().markers]
    bpy.ops.lissom.marker_save(filepath=path)
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.marker_load(filepath=path)
    assert [(row.ends, row.number) for row in settings().markers] == known
    subdivided(target)  # by halves: the surface, but for bent quads, is the same
    bpy.ops.lissom.transfer_fit()
    size = np.linalg.norm(np.ptp(rests()[1], axis=0))
    assert np.abs(spots() - before).max() < 2e-3 * size
    assert [row.number for row in settings().markers] == [number for _, number in known]
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.marker_load(filepath=path)
    assert np.abs(spots() - before).max() < 2e-3 * size
    count = len(settings().markers)
    while len(settings().markers) > 1:
        bpy.ops.lissom.marker_remove(index=len(settings().markers) - 1)
    bpy.ops.lissom.marker_mirror()
    if len(settings().markers) == 2:
        one, other = spots()
        assert np.abs(other - one * [-1, 1, 1]).max() < 2e-3 * size
    assert count > 5 and len(settings().markers) in (1, 2)


def test_a_point_stays_in_its_face_through_sculpting():
    between_vertices()
    bpy.ops.lissom.transfer_fit()
    known = [row.ends for row in settings().markers]
    for vertex in settings().target.data.vertices:
        vertex.co = vertex.co * 1.3 + Vector((0, 0, 0.5))
    bpy.ops.lissom.transfer_fit()
    assert [row.ends for row in settings().markers] == known
    assert_allclose([row.target_place for row in settings().markers], spots()[:, 1], atol=1e-5)


def test_points_whose_place_is_gone_are_named():
    between_vertices()
    bpy.ops.lissom.transfer_fit()
    target = settings().target
    settings().markers[2].name = "left ear"
    lost = spots()[2, 1]
    subdivided(target)
    for vertex in target.data.vertices:
        if np.linalg.norm(np.array(vertex.co) - lost) < 0.3:
            vertex.co.y -= 3
    with scene.refused("is not the mesh that these markers were placed on"):
        bpy.ops.lissom.transfer_fit()
    with pytest.raises(RuntimeError, match="'left ear'"):
        bpy.ops.lissom.transfer_fit()


def test_picking_needs_two_objects_in_a_window():
    monkeys()
    with pytest.raises(RuntimeError, match="scripts use"):
        bpy.ops.lissom.marker_pick()
    settings().target = None
    with pytest.raises(RuntimeError, match="Choose two different objects"):
        bpy.ops.lissom.marker_pick()
