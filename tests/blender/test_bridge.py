"""What is read from Blender's meshes and groups, and written to them."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import groups, meshes, shape_keys
from bl_ext.user_default.lissom.core.refused import Refused
from numpy.testing import assert_allclose, assert_array_equal


def test_positions_and_triangles_are_blenders_own():
    obj = scene.monkey(1)
    assert_array_equal(meshes.rest_positions(obj.data), scene.points(obj.data.vertices))
    triangles = meshes.triangles(obj.data)
    assert_array_equal(triangles, [list(t.vertices) for t in obj.data.loop_triangles])
    assert len(triangles) == sum(len(face.vertices) - 2 for face in obj.data.polygons)


def test_row_17_a_concave_polygon_is_cut_inside_itself():
    mesh = bpy.data.meshes.new("Arrow")
    outline = np.array([(0, 0), (4, 0), (1, 1), (0, 4)], dtype=float)
    mesh.from_pydata([(x, y, 0) for x, y in outline], [], [range(4)])
    corners = outline[meshes.triangles(mesh)]
    edges = corners[:, 1:] - corners[:, :1]
    area = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    assert area.sum() == pytest.approx(4.0)


def test_groups_hold_weighted_members_only():
    obj = scene.tube(4, 6)
    heavy = obj.vertex_groups.new(name="heavy")
    heavy.add([3, 1], 0.4, "REPLACE")
    heavy.add([2], 0.0, "REPLACE")
    obj.vertex_groups.new(name="none")
    found = groups.members(obj, ["heavy", "none", "missing"])
    assert_array_equal(found["heavy"], [1, 3])
    assert len(found["none"]) == 0
    assert "missing" not in found


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_group_is_made_of_the_selection(mode):
    obj = scene.tube(4, 6)
    scene.select(obj, [5, 8], mode)
    name = groups.from_selection(obj, "mine")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert_array_equal(groups.members(obj, [name])["mine"], [5, 8])


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_one_vertex_is_selected_and_nothing_else(mode):
    obj = scene.tube(4, 6)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.object.mode_set(mode=mode)
    meshes.select_only(obj, 7)
    assert_array_equal(meshes.selected_vertices(obj), [7])
    bpy.ops.object.mode_set(mode="EDIT")
    assert_array_equal(meshes.selected_vertices(obj), [7])


def test_a_new_key_has_given_settings_in_every_version():
    obj = scene.tube(4, 6)
    rest = meshes.rest_positions(obj.data)
    key = shape_keys.write(obj, "K", rest + 1)
    assert (key.value, key.slider_min, key.slider_max, key.mute) == (0, 0, 1, False)
    assert key.relative_key == obj.data.shape_keys.reference_key
    assert_allclose(shape_keys.shape(key), rest + 1, atol=1e-6)


@pytest.mark.parametrize("limits", [(0.0, 1.0), (-3.0, -2.0), (2.0, 5.0), (-10.0, 10.0)])
def test_ranges_are_kept_whatever_they_were_before(limits):
    obj = scene.tube(4, 6)
    settings = shape_keys.Settings(limits[1], *limits, True)
    for before in ((0, 1), (-4, -3), (4, 5)):
        key = shape_keys.write(obj, "K", meshes.rest_positions(obj.data), shape_keys.Settings(0, *before))
        shape_keys.apply(key, settings, obj)
        assert shape_keys.Settings.of(key) == settings


def test_written_points_are_shown_at_once():
    obj = scene.tube(4, 6)
    rest = meshes.rest_positions(obj.data)
    key = shape_keys.write(obj, "K", rest, shape_keys.Settings(value=1.0))
    for step in (1.0, 2.0):
        shape_keys.write_points(key, rest + step)
        assert_allclose(scene.shown(obj), rest + step, atol=1e-6)


def test_row_26_another_diagonal_with_equal_counts_changes_the_signature():
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2), (0, 2, 3)])
    before = meshes.signature(mesh)
    mesh.clear_geometry()
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 3), (1, 2, 3)])
    assert meshes.signature(mesh) != before


def delete(obj):
    bpy.data.objects.remove(obj)


def delete_but_still_referred_to(obj):
    bpy.context.scene.lissom_transfer.source = obj
    bpy.ops.object.delete()
    assert obj.name in bpy.data.objects


def replace(obj):
    name = obj.name
    bpy.data.objects.remove(obj)
    assert scene.tube(4, 6, name).name == name


def remodel(obj):
    obj.data.clear_geometry()


@pytest.mark.parametrize("change", [delete, delete_but_still_referred_to, replace, remodel])
def test_row_42_an_object_that_is_gone_or_changed_is_refused(change):
    obj = scene.tube(4, 6)
    kept = meshes.Snapshot.of(obj, np.eye(3))
    assert kept.find() == obj
    change(obj)
    with pytest.raises(Refused, match="is gone" if change != remodel else "was changed meanwhile"):
        kept.find()
