"""Drawings: image meshes, and a second image at the end of an arc."""

import json

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from numpy.testing import assert_allclose

WIDTH, HEIGHT = 120, 80


def drawn(name="Drawing", size=(WIDTH, HEIGHT), bar=(10, 110, 30, 50), colour=(0.8, 0.2, 0.1)):
    """An image with an opaque bar: columns from, to, rows from, to, counted from below."""
    image = bpy.data.images.new(name, *size, alpha=True)
    pixels = np.zeros((size[1], size[0], 4), dtype=np.float32)
    pixels[..., :3] = colour
    pixels[bar[2] : bar[3], bar[0] : bar[1], 3] = 1.0
    image.pixels.foreach_set(pixels.ravel())
    return image


def made(name="Drawing", **settings):
    assert bpy.ops.lissom.inbetween_image(image=name, **settings) == {"FINISHED"}
    return bpy.context.object


def uv_of_vertices(obj, name):
    """(n, 2)"""
    mesh = obj.data
    flat = np.empty(2 * len(mesh.loops), dtype=np.float32)
    mesh.uv_layers[name].data.foreach_get("uv", flat)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    uv = np.full((len(mesh.vertices), 2), np.nan)
    uv[corners] = flat.reshape(-1, 2)
    return uv


def bend(obj):
    """The right end's handle lifted and turned in the plane, kept as the key 'bent'."""
    for name, where in (("left", lambda co: co.x < -1.1), ("right", lambda co: co.x > 1.1)):
        scene.group(obj, name, where)
        assert bpy.ops.lissom.pose_handle_add(object=obj.name, vertex_group=name) == {"FINISHED"}
    assert bpy.ops.lissom.pose_bind(object=obj.name) == {"FINISHED"}
    empty = scene.empty(obj, "right")
    empty.location.x -= 0.4
    empty.location.y += 0.7
    empty.rotation_euler.z = 0.9
    assert bpy.ops.lissom.pose_apply(object=obj.name, name="bent", value=0.0) == {"FINISHED"}
    assert bpy.ops.lissom.pose_unbind(object=obj.name) == {"FINISHED"}


def areas(obj, shape):
    a, b, c = (shape[[polygon.vertices[k] for polygon in obj.data.polygons], :2] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def slide(obj, slider, value):
    obj[slider] = float(value)
    obj.update_tag()
    bpy.context.view_layer.update()


def dissolve(obj):
    """What the material shows of the second image, as Blender evaluates it."""
    graph = bpy.context.evaluated_depsgraph_get()
    material = obj.active_material.evaluated_get(graph)
    return material.node_tree.nodes["Dissolve"].outputs[0].default_value


def test_the_mesh_lies_where_the_image_would():
    drawn()
    bpy.context.scene.cursor.location = (1, 2, 3)
    obj = made(height=4.0)
    rest = scene.points(obj.data.vertices)
    assert (rest[:, 2] == 0).all() and tuple(obj.location) == (1, 2, 3)
    # The middle of the image is the origin, and 80 pixels are 4 units.
    assert_allclose(np.ptp(rest[:, :2], axis=0), (100 / 20, 20 / 20), atol=1e-3)
    assert_allclose(uv_of_vertices(obj, "Image"), rest[:, :2] * 20 / (WIDTH, HEIGHT) + 0.5, atol=1e-5)
    assert (areas(obj, rest) > 0).all()
    assert obj.active_material.node_tree.nodes["Image"].image == bpy.data.images["Drawing"]


@pytest.mark.parametrize("easing", ["LINEAR", "SMOOTH"])
def test_one_slider_plays_shape_and_dissolve(easing):
    drawn()
    drawn("Other", colour=(0.1, 0.3, 0.9))
    obj = made(edge=4.0)
    rest = scene.points(obj.data.vertices)
    bend(obj)
    asked = {"object": obj.name, "end": "bent", "slider": "s", "easing": easing}
    assert bpy.ops.lissom.inbetween_bake(**asked) == {"FINISHED"}
    assert bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Other") == {"FINISHED"}
    end = scene.key_points(obj, "bent")
    # Where the end key has a vertex, there the second image is shown.
    scale = HEIGHT / 2.0
    assert_allclose(
        uv_of_vertices(obj, "Second Image"), end[:, :2] * scale / (WIDTH, HEIGHT) + 0.5, atol=1e-5
    )
    eased = (lambda t: t) if easing == "LINEAR" else (lambda t: t * t * (3 - 2 * t))
    for time in np.linspace(0, 1, 50):
        slide(obj, "s", time)
        shape = scene.shown(obj)
        assert (shape[:, 2] == 0).all() and (areas(obj, shape) > 0).all()
        assert dissolve(obj) == pytest.approx(eased(time), abs=1e-3)
    assert_allclose(shape, end, atol=1e-5)
    slide(obj, "s", 0.0)
    assert_allclose(scene.shown(obj), rest, atol=1e-6)


def test_the_dissolve_follows_a_renamed_slider_and_is_the_objects_own():
    drawn()
    drawn("Other")
    obj = made(edge=6.0)
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    twin.data = obj.data.copy()
    bend(obj)
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="bent", slider="s")
    assert bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Other", slider="s") == {"FINISHED"}
    assert "Dissolve" not in twin.active_material.node_tree.nodes
    assert bpy.ops.lissom.inbetween_rename(object=obj.name, slider="s", name="other") == {"FINISHED"}
    slide(obj, "other", 0.25)
    assert dissolve(obj) == pytest.approx(0.25, abs=1e-3)


def drivers(obj):
    data = obj.active_material.node_tree.animation_data
    return list(data.drivers) if data else []


@pytest.mark.parametrize("reroute", [True, False])
@pytest.mark.parametrize("end_goes", [True, False])
@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
def test_an_arc_that_is_removed_leaves_no_dissolve_without_a_slider(playback, end_goes, reroute):
    drawn()
    drawn("Other")
    obj = made(edge=6.0)
    bend(obj)
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="bent", slider="s", playback=playback, reroute=reroute)
    bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Other")
    slide(obj, "s", 0.75)
    assert dissolve(obj) == pytest.approx(0.75, abs=1e-3)
    if end_goes:
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["bent"])
    bpy.ops.lissom.inbetween_remove(object=obj.name, slider="s")
    if reroute and not end_goes:  # the end key has the dissolve back with what else the slider played
        obj.data.shape_keys.key_blocks["bent"].value = 0.25
        bpy.context.view_layer.update()
        assert dissolve(obj) == pytest.approx(0.25, abs=1e-3)
        bpy.ops.lissom.inbetween_bake(object=obj.name, end="bent", slider="again")
        assert dissolve(obj) == pytest.approx(0.25, abs=1e-3)
        return
    assert not drivers(obj)
    assert obj.data.uv_layers.keys() == ["Image"]
    nodes = obj.active_material.node_tree.nodes
    assert "Dissolve" not in nodes and nodes["Image"].image == bpy.data.images["Drawing"]


def test_an_arc_that_is_baked_anew_takes_the_second_image_along():
    drawn()
    drawn("Other")
    obj = made(edge=6.0)
    bend(obj)
    asked = {"object": obj.name, "end": "bent", "slider": "s"}
    bpy.ops.lissom.inbetween_bake(**asked)
    bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Other")
    moved = scene.key_points(obj, "bent") * [0.9, 0.8, 1]
    obj.data.shape_keys.key_blocks["bent"].points.foreach_set("co", moved.astype(np.float32).ravel())
    bpy.ops.lissom.inbetween_bake(**asked, easing="SMOOTH")
    slide(obj, "s", 0.25)
    assert dissolve(obj) == pytest.approx(0.25**2 * 2.5, abs=1e-3)
    assert_allclose(uv_of_vertices(obj, "Second Image"), moved[:, :2] * 40 / (WIDTH, HEIGHT) + 0.5, atol=1e-5)


def test_a_second_image_of_another_size_lies_on_the_middle_of_the_first():
    drawn()
    drawn("Small", size=(60, 40), bar=(5, 55, 15, 25))
    obj = made(edge=6.0)
    bend(obj)
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="bent")
    assert bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Small") == {"FINISHED"}
    first = scene.key_points(obj, "bent")[:, :2] * 40
    assert_allclose(uv_of_vertices(obj, "Second Image"), first / (60, 40) + 0.5, atol=1e-5)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"image": "nothing"}, "no image named 'nothing'"),
        ({"filepath": "/nowhere.png"}, "no file '/nowhere.png'"),
        ({}, "Choose an image first"),
        ({"image": "Clear"}, "no pixel is as opaque"),
    ],
)
def test_what_cannot_be_made_is_refused_in_words(settings, message):
    drawn("Clear", bar=(0, 0, 0, 0))
    before = len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.lissom.inbetween_image(**settings)
    assert (len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)) == before


def test_a_second_image_needs_an_arc_of_an_image_mesh():
    drawn()
    obj = made(edge=6.0)
    with pytest.raises(RuntimeError, match="Bake the arc"):
        bpy.ops.lissom.inbetween_second_image(object=obj.name, image="Drawing")
    tube = scene.tube()
    tube.shape_key_add(name="Basis")
    tube.shape_key_add(name="end").data[0].co.x += 1
    bpy.ops.lissom.inbetween_bake(object=tube.name, end="end")
    with pytest.raises(RuntimeError, match="no mesh of an image"):
        bpy.ops.lissom.inbetween_second_image(object=tube.name, image="Drawing")


def test_the_command_makes_what_the_operators_make(tmp_path, capfd):
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    for name, path in (("One", one), ("Two", two)):
        image = drawn(name)
        image.filepath_raw, image.file_format = str(path), "PNG"
        image.save()
    first, second = str(tmp_path / "first.blend"), str(tmp_path / "second.blend")
    report = tmp_path / "report.json"
    words = ["image", "--image", str(one), "--edge", "6", "--out", first, "--report", str(report)]
    assert commands.main(words) == 0
    told = json.loads(report.read_text())
    assert told["object"] == "one.png" and told["errors"] == [] and told["seconds"] > 0
    bpy.ops.wm.open_mainfile(filepath=first)
    obj = bpy.data.objects["one.png"]
    bend(obj)
    bpy.ops.lissom.inbetween_bake(object=obj.name, end="bent", slider="s")
    bpy.ops.wm.save_as_mainfile(filepath=first)
    words = ["image", "--second", str(two), "--file", first, "--object", "one.png", "--out", second]
    assert commands.main(words) == 0
    bpy.ops.wm.open_mainfile(filepath=second)
    obj = bpy.data.objects["one.png"]
    slide(obj, "s", 0.5)
    assert dissolve(obj) == pytest.approx(0.5, abs=1e-3)
    for words in (
        ["--image", "nowhere.png"],
        ["--second", str(two)],
        ["--image", str(one), "--threshold", "2"],
    ):
        assert commands.main(["image", *words, "--out", first]) == 2
    assert "there is no file 'nowhere.png'" in capfd.readouterr().out
