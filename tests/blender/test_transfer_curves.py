"""Curves in the scene: from selected edges, in files, through edits of the meshes, in the fit."""

import bmesh
import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import meshes
from test_transfer_markers import subdivided

RINGS, AROUND = 12, 16


def tubes():
    """Two tubes, the second wider, of other rings and upside down in its numbers; four markers."""
    source = scene.tube(RINGS, AROUND, "Source")
    target = scene.tube(2 * RINGS, AROUND + 4, "Target")
    for vertex in target.data.vertices:
        vertex.co.x *= 1.3
        vertex.co.y *= 0.8
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    for ring, quarter in ((0, 0), (12, 1), (12, 3), (6, 2)):
        places = ring * AROUND + quarter * AROUND // 4, 2 * ring * (AROUND + 4) + quarter * (AROUND + 4) // 4
        bpy.ops.lissom.marker_add(source_vertex=places[0], target_vertex=places[1])
    return source, target


def ring(around, row):
    return [row * around + i for i in range(around)]


def select_between(obj, vertices):
    """Selects the edges whose ends are all among these, as an artist does."""
    scene.select(obj, [], mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    for edge in edit.edges:
        if {vertex.index for vertex in edge.verts} <= vertices:
            edge.select_set(True)
    bmesh.update_edit_mesh(obj.data)
    bpy.ops.object.mode_set(mode="OBJECT")


def add(vertices, others, mode="OBJECT", **properties):
    """Selects these on both meshes and makes a curve of the edges between them."""
    ends = bpy.context.scene.lissom_transfer.source, bpy.context.scene.lissom_transfer.target
    for obj, own in zip(ends, (vertices, others), strict=True):
        select_between(obj, set(own))
    if mode == "EDIT":
        for obj in ends:
            obj.select_set(True)
        bpy.ops.object.mode_set(mode="EDIT")
    try:
        return bpy.ops.lissom.curve_add(**properties)
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def rows():
    return bpy.context.scene.lissom_transfer.curves


def paths():
    return [[list(map(int, side.split())) for side in row.vertices] for row in rows()]


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_selected_edges_of_both_meshes_become_a_curve(mode):
    tubes()
    assert add(ring(AROUND, 3), ring(AROUND + 4, 6), mode, name="belt") == {"FINISHED"}
    assert add(ring(AROUND, 7)[2:6], ring(AROUND + 4, 14)[2:8], mode) == {"FINISHED"}
    assert [row.name for row in rows()] == ["belt", "Curve 2"]
    (belt, other), (path, _) = paths()
    assert belt[0] == belt[-1] and sorted(belt[1:]) == ring(AROUND, 3)
    assert other[0] == other[-1] and sorted(other[1:]) == ring(AROUND + 4, 6)
    assert path == ring(AROUND, 7)[2:6]
    assert bpy.ops.lissom.curve_remove(index=0) == {"FINISHED"}
    assert [row.name for row in rows()] == ["Curve 2"]
    with pytest.raises(RuntimeError, match="no curve 1: the list holds 1"):
        bpy.ops.lissom.curve_remove(index=1)
    bpy.ops.lissom.marker_clear()
    assert not len(rows())


def test_what_is_no_curve_changes_nothing():
    tubes()
    add(ring(AROUND, 3), ring(AROUND + 4, 6))
    for chosen, message in (
        (([], ring(AROUND + 4, 2)), "No edges of 'Source' are selected"),
        ((ring(AROUND, 4), [0, 1, 40, 41]), "'Target' are in several pieces"),
        ((ring(AROUND, 4), ring(AROUND + 4, 2) + [60]), "'Target' branch at 1 vertex: 40"),
        ((ring(AROUND, 4), ring(AROUND + 4, 2)[:5]), "'Source' form a loop, those of 'Target' a path"),
        ((ring(AROUND, 3), ring(AROUND + 4, 2)), "Curves 'Curve 1' and 'Curve 2' are the same on the source"),
    ):
        before = paths()
        with pytest.raises(RuntimeError, match=message):
            add(*chosen)
        assert paths() == before


def test_files_hold_curves(tmp_path):
    tubes()
    add(ring(AROUND, 3), ring(AROUND + 4, 6), name="belt")
    file, before = str(tmp_path / "markers.json"), paths()
    assert bpy.ops.lissom.marker_save(filepath=file) == {"FINISHED"}
    bpy.ops.lissom.marker_clear()
    assert bpy.ops.lissom.marker_load(filepath=file) == {"FINISHED"}
    assert paths() == before and rows()[0].name == "belt"
    assert len(bpy.context.scene.lissom_transfer.markers) == 4
    bpy.context.scene.lissom_transfer.markers.clear()
    assert bpy.ops.lissom.marker_save(filepath=file) == {"FINISHED"}
    rows().clear()
    assert bpy.ops.lissom.marker_load(filepath=file) == {"FINISHED"}
    assert paths() == before


def test_a_curve_survives_other_numbers_by_its_places_and_is_refused_where_it_is_cut():
    source, _ = tubes()
    add(ring(AROUND, 3), ring(AROUND + 4, 6), name="belt")
    rest = scene.points(source.data.vertices)
    wanted = rest[paths()[0][0]]
    order = np.random.default_rng(0).permutation(len(rest))
    place = np.argsort(order)
    mesh = bpy.data.meshes.new("Shuffled")
    faces = [[int(place[v]) for v in face.vertices] for face in source.data.polygons]
    mesh.from_pydata(rest[order].tolist(), [], faces)
    source.data = mesh
    bpy.ops.lissom.marker_mirror(axis="X")  # any operator on the list finds it again
    assert np.allclose(scene.points(mesh.vertices)[paths()[0][0]], wanted, atol=1e-6)
    subdivided(source)
    with pytest.raises(RuntimeError, match="remodelled where curve 'belt' runs"):
        bpy.ops.lissom.transfer_fit()
    assert bpy.ops.lissom.curve_remove(index=0) == {"FINISHED"}
    assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}


def test_the_fit_goes_by_the_curves_of_the_scene_or_of_a_file(tmp_path):
    source, target = tubes()
    bpy.ops.lissom.transfer_fit()
    without = session.fit.fit.fitted_vertices
    add(ring(AROUND, 3), ring(AROUND + 4, 5))
    assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}
    by = session.fit.fit.fitted_vertices
    assert not np.array_equal(by, without)
    ends = [lissom.Mesh(meshes.rest_positions(o.data), meshes.triangles(o.data)) for o in (source, target)]
    markers = [(row.source, row.target) for row in bpy.context.scene.lissom_transfer.markers]
    fit = lissom.fit_correspondence(*ends, markers, curves=paths(), **{
        name: getattr(bpy.context.scene.lissom_transfer, name)
        for name in ("marker_tolerance", "match_distance", "closest")
    })  # fmt: skip
    assert np.array_equal(by, fit.fitted_vertices)
    file = str(tmp_path / "markers.json")
    bpy.ops.lissom.marker_save(filepath=file)
    bpy.ops.lissom.marker_clear()
    bpy.ops.lissom.transfer_fit(filepath=file)
    assert np.array_equal(session.fit.fit.fitted_vertices, by)
