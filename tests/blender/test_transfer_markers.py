"""Markers in the scene: by symmetry, through edits of the meshes, in files, under the mouse."""

import json

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import picking
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
    monkeys()
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


@pytest.mark.parametrize("modifier", [None, "SUBSURF", "SIMPLE_DEFORM"])
def test_a_ray_finds_the_vertex_that_is_shown_there(modifier):
    obj = scene.monkey(2)
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 1, 0.5)
    scene.add_key(obj, "up", scene.points(obj.data.vertices) + [0, 0, 4], value=1.0)
    if modifier:
        obj.modifiers.new("M", modifier)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = picking.shown_mesh(obj, depsgraph)
    assert (mesh == obj.data) == (modifier == "SUBSURF")
    surface = picking.Surface(obj, depsgraph)
    matrix = obj.matrix_world
    tried = 0
    for vertex in range(0, len(mesh.vertices), 97):
        place = matrix @ mesh.vertices[vertex].co
        normal = (matrix.inverted().to_3x3().transposed() @ mesh.vertices[vertex].normal).normalized()
        hit = surface.hit(place + 0.01 * normal, -normal)
        if hit and abs(hit[0] - 0.01) < 1e-3:
            tried += 1
            found = matrix @ mesh.vertices[hit[1]].co
            assert hit[1] == vertex or (found - place).length < 0.02
    assert tried > 50
    assert surface.hit(Vector((50, 50, 50)), Vector((0, 0, 1))) is None


def test_picking_needs_two_objects_in_a_window():
    monkeys()
    with pytest.raises(RuntimeError, match="scripts use"):
        bpy.ops.lissom.marker_pick()
    settings().target = None
    with pytest.raises(RuntimeError, match="Choose two different objects"):
        bpy.ops.lissom.marker_pick()
