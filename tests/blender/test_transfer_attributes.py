"""Transfer of vertex groups, UV maps and colours between Suzannes of other faces."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import attributes
from bl_ext.user_default.lissom.core.attributes import LEAST_WEIGHT, skin
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import monkeys
from test_transfer_parts import both, names  # noqa: F401 (a fixture)

BONES = np.array([[1.2, 0, 0.3], [-1.2, 0, 0.3], [0, -0.7, 0], [0, 0.6, 0.2], [0, 0, 1], [0, -0.2, -0.9]])
MOST = 3
APART = 10  # the charts of the UV map


def bind(obj):
    """(n, k): normalised weights of the three nearest bones, as vertex groups."""
    rest = scene.points(obj.data.vertices)
    near = np.exp(-3 * np.linalg.norm(rest[:, None] - BONES, axis=2))
    near += 1e-9 * np.arange(len(BONES))  # no ties
    near[near < np.sort(near, axis=1)[:, -MOST:][:, :1]] = 0
    near /= near.sum(1, keepdims=True)
    for bone, weights in enumerate(near.T):
        attributes.write_weights(obj, f"bone {bone}", weights)
    return near


def charts(obj):
    """For each polygon the axis it faces along and the sign: the charts of a map with many seams."""
    normals = np.array([polygon.normal for polygon in obj.data.polygons])
    axis = np.abs(normals).argmax(axis=1)
    return 2 * axis + (normals[np.arange(len(axis)), axis] > 0)


def project(obj, name="Box"):
    """(c, 2): a UV map from six sides, each a chart far from the others."""
    mesh = obj.data
    polygon = np.repeat(np.arange(len(mesh.polygons)), [len(face.vertices) for face in mesh.polygons])
    chart = charts(obj)[polygon]
    place = scene.points(mesh.vertices)[[loop.vertex_index for loop in mesh.loops]]
    rows = np.arange(len(place))
    uv = np.column_stack(
        [place[rows, (chart // 2 + 1) % 3] + APART * chart, place[rows, (chart // 2 + 2) % 3]]
    )
    attributes.write(obj, attributes.Layer("UV", name), name, uv)
    return uv


def uv_of(obj, name="Box"):
    return attributes.read([obj], attributes.Layer("UV", name))


def by_polygon(obj, values):
    """Rows of a value of corners, polygon by polygon."""
    ends = np.cumsum([len(polygon.vertices) for polygon in obj.data.polygons])
    return np.split(values, ends[:-1])


def colour(obj, name, domain, kind="FLOAT_COLOR"):
    made = obj.data.color_attributes.new(name, kind, domain)
    for place, row in enumerate(made.data):
        vertex = place if domain == "POINT" else obj.data.loops[place].vertex_index
        row.color = (*(np.array(obj.data.vertices[vertex].co) * 0.2 + 0.5), 1.0)


@pytest.fixture
def dressed():
    source, target = monkeys(levels=2, target_levels=1)
    target.data.uv_layers.remove(target.data.uv_layers[0])
    return source, target, bind(source)


def test_weights_are_as_sparse_and_normalised_as_the_sources(dressed):
    source, target, of_source = dressed
    assert bpy.ops.lissom.transfer_attributes(uv_maps=False, colours=False) == {"FINISHED"}
    names, weights = attributes.weights([target])
    assert names == [f"bone {bone}" for bone in range(len(BONES))]
    assert_allclose(weights.sum(1), 1, atol=1e-6)
    assert np.count_nonzero(weights, axis=1).max() <= np.count_nonzero(of_source, axis=1).max() < 5
    assert weights[weights > 0].min() >= LEAST_WEIGHT * 0.99
    rest, other = (scene.points(obj.data.vertices) for obj in (source, target))
    nearest = np.linalg.norm(other[:, None] - rest, axis=2).argmin(1)
    off = np.abs(weights - of_source[nearest]).max(1)
    assert np.mean(off) < 0.02 and np.quantile(off, 0.99) < 0.15
    assert not target.data.uv_layers.keys() and target.data.shape_keys is None


def test_faces_lie_on_one_side_of_seams(dressed):
    source, target, _ = dressed
    project(source)
    assert bpy.ops.lissom.transfer_attributes(vertex_groups=False, colours=False) == {"FINISHED"}
    found = by_polygon(target, uv_of(target))
    spans = np.array([np.ptp(face, axis=0).max() for face in found])
    place = scene.points(target.data.vertices)
    sides = np.array([np.ptp(place[list(face.vertices)], axis=0).max() for face in target.data.polygons])
    assert (spans <= 2 * sides + 0.05).all(), (spans - 2 * sides).max()
    off = []
    for face, uv in zip(target.data.polygons, found, strict=True):
        chart = int(np.round((uv[:, 0].mean()) / APART))
        at = place[list(face.vertices)]
        expected = np.column_stack([at[:, (chart // 2 + 1) % 3] + APART * chart, at[:, (chart // 2 + 2) % 3]])
        off.append(np.abs(uv - expected).max())
    assert np.median(off) < 0.02 and np.quantile(off, 0.9) < 0.1
    assert not len(target.vertex_groups)


def test_the_same_faces_get_the_same_map(dressed):
    source, target, _ = dressed
    bpy.data.objects.remove(target)
    project(source)
    colour(source, "Paint", "CORNER")
    colour(source, "Dots", "POINT", "BYTE_COLOR")
    copy = source.copy()
    copy.name, copy.data = "Target", source.data.copy()
    bpy.context.collection.objects.link(copy)
    copy.shape_key_clear()
    copy.vertex_groups.clear()
    for layers in (copy.data.uv_layers, copy.data.color_attributes):
        for name in [layer.name for layer in layers]:
            layers.remove(layers[name])
    bpy.context.scene.lissom_transfer.markers.clear()
    assert bpy.ops.lissom.transfer_attributes(source="Source", target="Target") == {"FINISHED"}
    assert_array_equal(uv_of(copy), uv_of(source))
    assert_allclose(attributes.weights([copy])[1], attributes.weights([source])[1], atol=2e-7)
    kinds = {layer.name: (layer.domain, layer.data_type) for layer in copy.data.color_attributes}
    assert kinds == {"Paint": ("CORNER", "FLOAT_COLOR"), "Dots": ("POINT", "BYTE_COLOR")}
    for layer in attributes.layers([source], False, True):
        assert_allclose(attributes.read([copy], layer), attributes.read([source], layer), atol=1e-6)


def test_colours_of_points_and_corners(dressed):
    source, target, _ = dressed
    colour(source, "Paint", "CORNER")
    colour(source, "Dots", "POINT")
    assert bpy.ops.lissom.transfer_attributes(vertex_groups=False, uv_maps=False) == {"FINISHED"}
    place = scene.points(target.data.vertices) * 0.2 + 0.5
    corner = [loop.vertex_index for loop in target.data.loops]
    for layer in attributes.layers([target], False, True):
        found = attributes.read([target], layer)
        expected = place if layer.kind == "POINT" else place[corner]
        assert np.abs(found[:, :3] - expected).mean() < 0.005 and (found[:, 3] == 1).all()


def test_row_32_names_that_exist(dressed):
    source, target, _ = dressed
    project(source)
    attributes.write_weights(target, "bone 1", np.ones(len(target.data.vertices)))
    for exists, groups in (("SKIP", 6), ("RENAME", 12)):
        bpy.ops.lissom.transfer_attributes(exists=exists, colours=False)
        assert len(target.vertex_groups) == groups
        assert (attributes.weights([target])[1][:, 0] == 1).all()
    assert "bone 1.001" in target.vertex_groups and "Box.001" in target.data.uv_layers
    bpy.ops.lissom.transfer_attributes(exists="UPDATE", colours=False)
    names, weights = attributes.weights([target])
    assert len(names) == 12 and weights[:, 0].min() == 0
    with scene.refused("If Exists is Skip: nothing to do"):
        bpy.ops.lissom.transfer_attributes(exists="SKIP")


def test_what_cannot_be_written_is_refused_before_anything_is(dressed):
    source, target, _ = dressed
    project(source)
    with scene.refused("none of what is to be carried over"):
        bpy.ops.lissom.transfer_attributes(vertex_groups=False, uv_maps=False, colours=True)
    target.data.attributes.new("Box", "INT", "POINT")
    with scene.refused("of another kind: rename it first"):
        bpy.ops.lissom.transfer_attributes()
    target.data.attributes.remove(target.data.attributes["Box"])
    target.vertex_groups.new(name="bone 0").lock_weight = True
    with scene.refused("'bone 0' of 'Target' is locked"):
        bpy.ops.lissom.transfer_attributes()
    target.vertex_groups["bone 0"].lock_weight = False
    for number in range(7):
        target.data.uv_layers.new(name=f"Own {number}")
    with scene.refused("Blender has room for 8"):
        bpy.ops.lissom.transfer_attributes()
    scene.select(target, [0], mode="EDIT")
    with scene.refused("is in edit mode"):
        bpy.ops.lissom.transfer_attributes(uv_maps=False)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_mirrored_object_gets_its_corners_in_order(dressed):
    source, target, _ = dressed
    project(source)
    bpy.ops.lissom.transfer_attributes(vertex_groups=False)
    expected = uv_of(target)
    # The same places in the world, by mirrored coordinates.
    source.data.transform(np.diag([-1.0, 1, 1, 1]), shape_keys=True)
    source.data.flip_normals()
    source.scale.x = -1
    bpy.context.view_layer.update()
    bpy.ops.lissom.transfer_attributes(vertex_groups=False)
    # Rounding may bring a face that lies across a seam to its other side: one or two, where order is all.
    off = np.abs(uv_of(target) - expected).max(axis=1)
    assert np.mean(off > 1e-3) < 1e-3


def test_several_objects_get_their_own_parts(both):  # noqa: F811
    sources, targets, _ = both
    for place, obj in enumerate(sources):
        attributes.write_weights(obj, f"part {place}", np.ones(len(obj.data.vertices)))
        attributes.write_weights(obj, "all", np.full(len(obj.data.vertices), 0.5))
        colour(obj, "Dots", "POINT")
    sides = {"source": names(sources), "target": names(targets)}
    assert bpy.ops.lissom.transfer_attributes(uv_maps=False, **sides) == {"FINISHED"}
    for place, obj in enumerate(targets):
        groups, weights = attributes.weights([obj])
        found = dict(zip(groups, weights.T, strict=True))
        assert_allclose(found["all"], 0.5, atol=1e-6)
        assert_allclose(found[f"part {place}"], 1, atol=1e-6)
        assert found.get(f"part {1 - place}", np.zeros(1)).max() < 1e-6
        place = scene.points(obj.data.vertices) * 0.2 + 0.5
        (layer,) = attributes.layers([obj], False, True)
        assert np.median(np.abs(attributes.read([obj], layer)[:, :3] - place)) < 0.005


def test_a_skin_keeps_to_what_the_source_has():
    of_source = np.array([[0.5, 0.5, 0, 0], [1, 0, 0, 0]])
    found = skin(
        np.array([[0.4, 0.3, 0.2, 0.1], [0.99995, 0.00005, 0, 0], [0, 0, 0, 0], [0.3, 0, 0, 0]]), of_source
    )
    assert_allclose(found, [[4 / 7, 3 / 7, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0.3, 0, 0, 0]])
