"""In-between: Bake, and what the slider then plays."""

import time

import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import meshes, sliders
from bl_ext.user_default.lissom.core import hat
from bl_ext.user_default.lissom.core.inbetween import ArcAsked
from bl_ext.user_default.lissom.core.refused import Refused
from bl_ext.user_default.lissom.jobs.bake import Bake
from bl_ext.user_default.lissom.properties import inbetween as properties
from numpy.testing import assert_allclose, assert_array_equal

COUNT = 4
KNOTS = np.linspace(0, 1, COUNT + 2)


def bend(rest, angle, radius=3.0):
    """The tube bent about the y axis by ``angle`` over its length."""
    x, y, z = rest.T
    turn = angle * (z + 3) / 6
    centre = 6 / angle
    return np.stack([centre - (centre - x) * np.cos(turn), y, (centre - x) * np.sin(turn) - 3], axis=1)


def keyed_tube(**size):
    """A tube with the keys half (bent by 0.8) and full (bent by 2.4)."""
    obj = scene.tube(**size)
    rest = scene.points(obj.data.vertices)
    scene.add_key(obj, "half", bend(rest, 0.8))
    scene.add_key(obj, "full", bend(rest, 2.4))
    return obj


def native_path(obj, start, end, **options):
    mesh = lissom.Mesh(scene.key_points(obj, "Basis"), meshes.triangles(obj.data))
    return lissom.Inbetween(mesh, scene.key_points(obj, start), scene.key_points(obj, end), **options)


def slide(obj, slider, value):
    obj[slider] = value
    obj.update_tag()
    bpy.context.view_layer.update()


def assert_plays(obj, slider, path, atol=1e-5):
    """The slider shows the path at the knots, and straight lines between them."""
    shapes = path.at(KNOTS)
    for value in [*KNOTS, 0.05, 0.31, 0.77, 0.99]:
        slide(obj, slider, value)
        expected = np.tensordot(hat.weights(KNOTS, value)[0], shapes, axes=1)
        assert_allclose(scene.shown(obj), expected, atol=atol)


@pytest.mark.parametrize(
    "options",
    [
        {"rotation": "consistent"},
        {"rotation": "shortest"},
        {"rotation": "relative"},
        {"stretch": "logarithmic"},
        {"refinement": 2},
        {"preserve_volume": True},
    ],
    ids=str,
)
def test_the_slider_plays_the_path_from_the_basis(options):
    obj = keyed_tube()
    path = native_path(obj, "Basis", "full", **options)
    assert bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=COUNT, **options) == {"FINISHED"}
    assert_plays(obj, "full arc", path)


def test_the_arc_goes_through_other_keys():
    obj = keyed_tube()
    rest = scene.key_points(obj, "Basis")
    scene.add_key(obj, "swerve", bend(rest, 1.6) + [0, 1, 0])
    bpy.ops.lissom.inbetween_bake(
        object="Tube", end="full", count=2, through="swerve: 0.6, half: 0.25", slider="way"
    )
    for value, name in ((0.25, "half"), (0.6, "swerve"), (1.0, "full")):
        slide(obj, "way", value)
        assert_allclose(scene.shown(obj), scene.key_points(obj, name), atol=1e-5)
    for through, message in (
        ("full: 0.5", "'full' is an end of the arc"),
        ("none: 0.5", "has no shape key named 'none'"),
        ("half: 2", "is not a shape key and a time between 0 and 1"),
    ):
        with scene.refused(message):
            bpy.ops.lissom.inbetween_bake(object="Tube", end="full", through=through)


def test_the_slider_plays_the_path_from_another_key():
    obj = keyed_tube()
    path = native_path(obj, "half", "full")
    bpy.ops.lissom.inbetween_bake(object="Tube", start="half", end="full", count=COUNT, slider="bend")
    keys = obj.data.shape_keys.key_blocks
    assert (keys["half"].value, keys["full"].value) == (1, 0)
    assert_plays(obj, "bend", path)


def test_row_33_a_relative_key_that_is_not_the_basis():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    keys["full"].relative_key = keys["half"]
    keys["half"].value = keys["full"].value = 1
    both = scene.shown(obj)
    assert_allclose(both, scene.key_points(obj, "full"), atol=1e-5)
    bpy.ops.lissom.inbetween_bake(object="Tube", start="half", end="full", count=COUNT)
    assert all(key.relative_key == keys["Basis"] for key in keys if key.name.startswith("full arc"))
    slide(obj, "full arc", 1.0)
    assert_allclose(scene.shown(obj), both, atol=1e-5)


def test_other_keys_add_to_the_arc_as_they_do_to_its_end():
    obj = keyed_tube()
    rest = scene.key_points(obj, "Basis")
    scene.add_key(obj, "fat", rest * [1.5, 1.5, 1], value=0.5)
    path = native_path(obj, "Basis", "full")
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=COUNT)
    slide(obj, "full arc", KNOTS[2])
    assert_allclose(scene.shown(obj) - path.at([KNOTS[2]])[0], 0.25 * rest * [1, 1, 0], atol=1e-5)


@pytest.mark.parametrize("scale", [(1, 1, 1), (-0.5, 2, 1)])
def test_row_36_the_path_is_that_of_the_scaled_mesh(scale):
    obj = keyed_tube()
    obj.scale = scale
    bpy.context.view_layer.update()
    world = [scene.key_points(obj, name) * scale for name in ("Basis", "full")]
    path = lissom.Inbetween(lissom.Mesh(world[0], meshes.triangles(obj.data)), *world)
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    slide(obj, "full arc", 0.5)
    assert_allclose(scene.shown(obj) * scale, path.at([0.5])[0], atol=2e-5)


def test_keys_and_slider_are_as_documented():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=3)
    keys = obj.data.shape_keys.key_blocks
    baked = ["full arc 25%", "full arc 50%", "full arc 75%", "full arc 100%"]
    assert keys.keys() == ["Basis", "half", "full", *baked]
    for name in baked:
        key = keys[name]
        assert (key.slider_min, key.slider_max, key.mute) == (0, 1, False)
        assert key.relative_key == keys["Basis"]
    assert_allclose(scene.key_points(obj, baked[-1]), scene.key_points(obj, "full"), atol=1e-6)
    limits = obj.id_properties_ui("full arc").as_dict()
    assert (obj["full arc"], limits["min"], limits["max"]) == (0.0, 0.0, 1.0)
    for curve in obj.data.shape_keys.animation_data.drivers:
        assert curve.driver.is_simple_expression  # plays where scripts may not run
        assert not curve.modifiers
        assert curve.is_valid and curve.driver.is_valid
    assert [(arc.name, arc.start, arc.end) for arc in obj.lissom_inbetween.arcs] == [
        ("full arc", "Basis", "full")
    ]


def test_the_slider_survives_saving(tmp_path):
    obj = keyed_tube()
    path = native_path(obj, "Basis", "full")
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=COUNT)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arc.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "arc.blend"))
    assert_plays(bpy.data.objects["Tube"], "full arc", path)


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("start", ["", "half"])
@pytest.mark.parametrize("relative", [False, True])
def test_a_masked_key_gives_the_arc_between_what_is_seen_in_keys_without_a_mask(start, relative, playback):
    obj = keyed_tube(rings=12, around=8)
    keys, rest = obj.data.shape_keys.key_blocks, scene.key_points(obj, "Basis")
    draw = np.random.default_rng(3)
    for name in ("half", "full"):
        soft = np.clip(rest @ draw.normal(size=3) + draw.uniform(), 0, 1)
        made = obj.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(soft):
            made.add([int(vertex)], soft[vertex], "REPLACE")
        keys[name].vertex_group = name
    if relative:
        keys["full"].relative_key = keys["half"]

    def seen(*on):
        for key in keys:
            key.value = float(key.name in on)
        bpy.context.view_layer.update()
        return scene.shown(obj)

    ends = seen(start), seen("full", *([start] if relative else []))
    seen()
    mesh = lissom.Mesh(rest, meshes.triangles(obj.data))
    path = lissom.Inbetween(mesh, *ends)
    bpy.ops.lissom.inbetween_bake(object="Tube", start=start, end="full", count=COUNT, playback=playback)
    assert not any(keys[key.name].vertex_group for key in obj.lissom_inbetween.arcs["full arc"].keys)
    assert_plays(obj, "full arc", path)


def test_row_32_baking_again_replaces_renames_or_skips():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=6)
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    assert keys.keys() == ["Basis", "half", "full", "full arc 50%", "full arc 100%"]
    assert len(obj.data.shape_keys.animation_data.drivers) == 2
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1, exists="RENAME")
    assert [arc.name for arc in obj.lissom_inbetween.arcs] == ["full arc", "full arc.001"]
    with scene.refused("If Exists is Skip"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=2, exists="SKIP")


def test_removing_an_arc_leaves_nothing_of_it():
    obj = keyed_tube()
    before = scene.snapshot()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full")
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert scene.snapshot() == before
    assert len(obj.data.shape_keys.animation_data.drivers) == 0
    assert len(obj.lissom_inbetween.arcs) == 0


def drive(key, obj, slider):
    """A driver of the artist's own: the key follows the slider."""
    variable = key.driver_add("value").driver.variables.new()
    variable.targets[0].id = obj
    variable.targets[0].data_path = f'["{slider}"]'


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("value", [0.0, 0.25, 0.5, 1.0])
def test_the_slider_takes_over_how_far_the_end_key_is_on(value, playback):
    obj = keyed_tube(rings=12, around=8)
    keys = obj.data.shape_keys.key_blocks
    path = native_path(obj, "Basis", "full")
    for slider_before in (0.0, 0.75):
        keys["full"].value = value
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=3, playback=playback)
        bpy.context.view_layer.update()
        assert keys["full"].value == 0
        assert_allclose(scene.shown(obj), path.at([value or slider_before])[0], atol=1e-5)
        obj["full arc"] = 0.75


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("seed", range(6))
def test_bake_and_remove_keep_what_is_shown_and_all_that_is_not_the_arcs(seed, playback):
    draw = np.random.default_rng(seed)
    obj = keyed_tube(rings=4, around=6)
    keys, rest = obj.data.shape_keys.key_blocks, scene.key_points(obj, "Basis")
    for number in range(3):
        scene.add_key(obj, f"key {number}", rest + draw.normal(size=3), slider_min=-1, slider_max=2)
    start = draw.choice(["Basis", "half"])
    if start == "half" and draw.uniform() < 0.5:
        keys["full"].relative_key = keys["half"]
        keys["half"].value = 1
    for key in keys[3:]:
        key.value, key.mute = draw.uniform(-1, 2), bool(draw.integers(2))
        if playback == "ABSOLUTE":
            key.value = 0
        key.lock_shape = bool(draw.integers(2))
    keys["full"].value = 1
    obj.active_shape_key_index = int(draw.integers(len(keys)))

    def state(*left_out):
        chosen = obj.active_shape_key.name
        return chosen, [row for row in scene.snapshot()["Tube"][4] if row[0] not in left_out]

    seen, everything, others = scene.shown(obj), state(), state("half", "full")
    bpy.ops.lissom.inbetween_bake(
        object="Tube", start=start, end="full", count=3, playback=playback, slider="s"
    )
    bpy.context.view_layer.update()
    assert obj["s"] == 1
    assert_allclose(scene.shown(obj), seen, atol=1e-5)
    made = [key.name for key in obj.lissom_inbetween.arcs["s"].keys]
    assert state("half", "full", *made) == others
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="s")
    bpy.context.view_layer.update()
    assert state() == everything
    assert_allclose(scene.shown(obj), seen, atol=1e-5)


@pytest.mark.parametrize("value", [0.0, 0.25, 1.0, 1])
def test_a_slider_that_goes_leaves_its_value_to_the_end_key_unless_that_is_held(value):
    obj = keyed_tube(rings=4, around=6)
    full = obj.data.shape_keys.key_blocks["full"]
    for locked in (False, True):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", slider="s")
        slide(obj, "s", value)
        full.lock_shape = locked
        bpy.ops.lissom.inbetween_remove(object="Tube", slider="s")
        assert full.value == (0 if locked else value)
        full.value = 0


@pytest.mark.parametrize("chosen", ["Basis", "half", "full", "full arc 50%", "late"])
def test_the_chosen_key_stays_chosen(chosen):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=3)
    scene.add_key(obj, "late", scene.key_points(obj, "half"))
    obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(chosen)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert obj.active_shape_key.name == ("full" if chosen.startswith("full") else chosen)


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
def test_an_override_of_a_linked_character_plays_its_slider_set_driven_and_animated(tmp_path, playback):
    obj = keyed_tube(rings=12, around=8)
    path = native_path(obj, "Basis", "full")
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=COUNT, slider="old", playback=playback)
    bpy.ops.lissom.inbetween_rename(object="Tube", slider="old", name='"bend"')
    character = bpy.data.collections.new("Character")
    bpy.context.scene.collection.children.link(character)
    character.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "character.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "character.blend"), link=True) as (_, wanted):
        wanted.collections = ["Character"]
    instance = bpy.data.objects.new("instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", wanted.collections[0]
    bpy.context.scene.collection.objects.link(instance)
    wanted.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)

    def opened_again():
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
        return _overridden()

    at = sliders.data_path('"bend"')
    slide(_overridden(), '"bend"', 0.7)
    obj = opened_again()
    assert obj['"bend"'] == pytest.approx(0.7)
    assert_plays(obj, '"bend"', path)
    driver = obj.driver_add(at).driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    control = bpy.data.objects.new("control", None)
    bpy.context.scene.collection.objects.link(control)
    variable.targets[0].id, variable.targets[0].transform_type = control, "LOC_X"
    obj = opened_again()
    for knot in KNOTS:
        bpy.data.objects["control"].location.x = knot
        bpy.context.view_layer.update()
        assert_allclose(scene.shown(obj), path.at([knot])[0], atol=1e-5)
    if bpy.app.version >= (5, 0):  # 4.2 keeps no keys on overrides, whosever property it is
        obj.driver_remove(at)
        for frame, knot in enumerate(KNOTS):
            obj['"bend"'] = float(knot)
            obj.keyframe_insert(at, frame=frame)
        obj = opened_again()
        for frame, knot in enumerate(KNOTS):
            bpy.context.scene.frame_set(frame)
            assert_allclose(scene.shown(obj), path.at([knot])[0], atol=1e-5)


def _overridden():
    return next(obj for obj in bpy.data.objects if obj.override_library and obj.type == "MESH")


def test_keys_that_the_artist_drives_by_the_slider_stay():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=2, slider="arc")
    drive(scene.add_key(obj, "wrinkle", scene.key_points(obj, "half")), obj, "arc")
    wrinkle = scene.key_points(obj, "wrinkle")
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1, slider="arc")
    assert keys.keys() == ["Basis", "half", "full", "wrinkle", "arc 50%", "arc 100%"]
    assert len(obj.data.shape_keys.animation_data.drivers) == 3
    bpy.ops.lissom.inbetween_bake(object="Tube", end="wrinkle", count=1, slider="other")  # may lead there
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="other")
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="arc")
    assert keys.keys() == ["Basis", "half", "full", "wrinkle"]
    assert_array_equal(scene.key_points(obj, "wrinkle"), wrinkle)


def test_a_baked_key_that_the_artist_renamed_is_the_artists():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    keys["full arc 50%"].name = "sculpted"
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert keys.keys() == ["Basis", "half", "full", "sculpted"]


@pytest.mark.parametrize("shared", [False, True])
def test_the_arc_of_a_scripts_copy_is_its_own(shared):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    copy = obj.copy()
    if not shared:
        copy.data = obj.data.copy()
    bpy.context.collection.objects.link(copy)
    bpy.ops.lissom.inbetween_remove(object=copy.name, slider="full arc")
    baked = ["full arc 50%", "full arc 100%"]
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "half", "full", *baked]
    assert copy.data.shape_keys.key_blocks.keys() == ["Basis", "half", "full", *(baked if shared else [])]
    assert "full arc" in obj
    assert "full arc" not in copy


def test_a_driver_without_its_slider_is_said(capfd):
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", slider="arc")
    drive(obj.data.shape_keys.key_blocks["half"], obj, "arc")
    obj.lissom_inbetween.arcs["arc"].reroute = False
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="arc")
    assert "The driver of shape key 'half' has lost its slider 'arc'" in capfd.readouterr().out


def test_baking_again_keeps_the_value_of_the_slider():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    slide(obj, "full arc", 0.7)
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=3)
    assert obj["full arc"] == pytest.approx(0.7)


def shown_alone(obj, name):
    """What is seen with one key at 1 and all others at 0."""
    keys = obj.data.shape_keys.key_blocks
    values = {key.name: key.value for key in keys}
    for key in keys:
        key.value = float(key.name == name)
    positions = scene.shown(obj)
    for key in keys:
        key.value = values[key.name]
    return positions


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("seed", range(4))
def test_an_arc_goes_through_what_is_seen_of_masked_keys(seed, playback):
    draw = np.random.default_rng(seed)
    obj = keyed_tube(rings=12, around=8)
    keys, rest = obj.data.shape_keys.key_blocks, scene.key_points(obj, "Basis")
    scene.add_key(obj, "swerve", bend(rest, 1.6) + [0, 1, 0])
    for name in draw.choice(["half", "swerve", "full"], size=2, replace=False):
        soft = np.clip(rest @ draw.normal(size=3) + draw.uniform(), 0, 1)
        made = obj.vertex_groups.new(name=f"mask of {name}")
        for vertex in np.flatnonzero(soft):
            made.add([int(vertex)], soft[vertex], "REPLACE")
        keys[name].vertex_group = made.name
    times = {"half": 0.3, "swerve": 0.7, "full": 1.0}
    seen = {name: shown_alone(obj, name) for name in times}
    bpy.ops.lissom.inbetween_bake(
        object="Tube", end="full", through="half: 0.3, swerve: 0.7", count=3, playback=playback, slider="s"
    )
    for name, at in times.items():
        slide(obj, "s", at)
        assert_allclose(scene.shown(obj), seen[name], atol=1e-5)


@pytest.mark.parametrize("start", ["", "half"])
def test_row_33_both_ends_are_as_they_are_seen(start):
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    scene.add_key(obj, "other", scene.key_points(obj, "Basis") + [0.5, 0, 0])
    keys["full"].relative_key = keys["half"].relative_key = keys["other"]
    ends = [shown_alone(obj, start), shown_alone(obj, "full")]
    assert np.abs(ends[1] - scene.key_points(obj, "full")).max() > 0.4
    path = lissom.Inbetween(lissom.Mesh(scene.key_points(obj, "Basis"), meshes.triangles(obj.data)), *ends)
    bpy.ops.lissom.inbetween_bake(object="Tube", start=start, end="full", count=COUNT)
    assert_plays(obj, "full arc", path)


# Bad input


@pytest.mark.parametrize("name", ["location", "lissom_inbetween", "lissom_pose", " ", "a\nb", "\t"])
def test_names_that_are_none_for_a_slider(name):
    keyed_tube()
    with scene.refused("for a slider" if not name.strip() or "\n" in name else "for the slider"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", slider=name)


def test_the_live_pose_is_no_end_of_an_arc():
    obj = scene.bound_tube()
    scene.add_key(obj, "full", bend(scene.key_points(obj, "Basis"), 2.4))
    for ends in ({"end": "Lissom Pose"}, {"start": "Lissom Pose", "end": "full"}):
        with scene.refused("'Lissom Pose' shows the live pose"):
            bpy.ops.lissom.inbetween_bake(object="Tube", **ends)
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)


def test_row_3_a_key_that_is_not_finite():
    obj = keyed_tube()
    obj.data.shape_keys.key_blocks["full"].data[5].co.x = float("nan")
    try:
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full")
    except RuntimeError as error:
        assert "not finite" in str(error)
        assert "at 5" in str(error)
    else:
        raise AssertionError("not refused")
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "half", "full"]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "Choose the shape key that the arc leads to first"),
        ({"end": "none"}, "no shape key named 'none'"),
        ({"start": "none", "end": "full"}, "no shape key named 'none'"),
        ({"start": "full", "end": "full"}, "are the same shape key"),
        ({"end": "Basis"}, "are the same shape key"),
        ({"end": "full", "slider": "mine"}, "'mine' is a custom property of another kind"),
    ],
)
def test_settings_that_make_no_arc(settings, message):
    obj = keyed_tube()
    obj["mine"] = "precious"
    with scene.refused(message):
        bpy.ops.lissom.inbetween_bake(object="Tube", **settings)


def test_a_mesh_without_keys():
    scene.tube()
    with scene.refused("no shape key named 'full'"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full")


def test_an_arc_is_not_baked_from_its_own_keys():
    keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    with scene.refused("must not be keys of slider 'full arc' itself"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full arc 100%", slider="full arc")


def test_row_34_locked_baked_keys_and_edit_mode():
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    obj.data.shape_keys.key_blocks["full arc 50%"].lock_shape = True
    with scene.refused("'full arc 50%' is locked"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    with scene.refused("'full arc 50%' is locked"):
        bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    bpy.ops.object.mode_set(mode="EDIT")
    with scene.refused("go to Object Mode first"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)


def test_row_35_mesh_data_with_several_users(capfd):
    obj = keyed_tube()
    bpy.context.collection.objects.link(bpy.data.objects.new("Twin", obj.data))
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    assert "Warning: The mesh of 'Tube' is used by 2 objects" in capfd.readouterr().out


def test_row_36_a_scale_of_zero():
    obj = keyed_tube()
    obj.scale.z = 0
    bpy.context.view_layer.update()
    with scene.refused("'Tube' is zero along an axis"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full")


def test_row_37_identical_ends_give_an_arc_that_stands_still():
    obj = keyed_tube()
    rest = scene.key_points(obj, "Basis")
    scene.add_key(obj, "same", rest)
    bpy.ops.lissom.inbetween_bake(object="Tube", end="same", count=2)
    slide(obj, "same arc", 0.4)
    assert_array_equal(scene.shown(obj), rest)


def test_a_driven_start_key_is_left_alone_and_said(capfd):
    obj = keyed_tube()
    obj.data.shape_keys.key_blocks["half"].driver_add("value")
    bpy.ops.lissom.inbetween_bake(object="Tube", start="half", end="full", count=1)
    assert "Warning: Shape key 'half' is driven or locked: set it to 1 yourself" in capfd.readouterr().out


def test_the_key_that_shows_a_live_pose_is_not_offered():
    obj = scene.bound_tube()
    scene.add_key(obj, "K", scene.points(obj.data.vertices))
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Lissom Pose", "K"]
    assert properties.ends(obj.lissom_inbetween, bpy.context, "") == ["Basis", "K"]
    bpy.ops.lissom.pose_unbind(object=obj.name)
    scene.add_key(obj, "Lissom Pose", scene.points(obj.data.vertices))  # the artist's own, of that name
    assert properties.ends(obj.lissom_inbetween, bpy.context, "") == ["Basis", "K", "Lissom Pose"]
    assert properties.ends(scene.tube(name="Bare").lissom_inbetween, bpy.context, "") == []


def test_row_6_points_on_one_line():
    obj = keyed_tube()
    for key in obj.data.shape_keys.key_blocks:
        for index, point in enumerate(key.data):
            point.co = (index, 0, 0)
    with scene.refused("vertices"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full")


def test_row_7_faces_without_area_are_said_and_the_arc_is_finite(capfd):
    obj = keyed_tube()
    for key in obj.data.shape_keys.key_blocks:
        key.data[40].co = key.data[0].co  # the faces between the first two rings lose a side
        key.data[41].co = key.data[1].co
    bpy.ops.lissom.inbetween_bake(object="Tube", end="full", count=1)
    assert "next to no area" in capfd.readouterr().out
    slide(obj, "full arc", 0.5)
    assert np.isfinite(scene.shown(obj)).all()
    assert np.abs(scene.shown(obj)).max() < 10


def test_row_37_a_mirror_image_is_said(capfd):
    obj = keyed_tube()
    scene.add_key(obj, "mirrored", scene.key_points(obj, "Basis") * [-1, 1, 1])
    bpy.ops.lissom.inbetween_bake(object="Tube", end="mirrored", count=1)
    assert "mirror image of the start" in capfd.readouterr().out
    slide(obj, "mirrored arc", 1.0)
    assert_allclose(scene.shown(obj), scene.key_points(obj, "mirrored"), atol=1e-5)


class Running:
    """An operator between ``begin`` and ``finish``, as the timer has it."""

    def __init__(self, obj, **settings):
        self.bake = Bake(bpy.context, ArcAsked(object=obj.name, end="full", **settings))
        self.work = self.bake.work

    def finish(self):
        return self.bake.write(bpy.context, self.work.wait())


def test_row_40_cancelled_nothing_is_changed():
    obj = keyed_tube()
    before = scene.snapshot()
    running = Running(obj, sampling="TOLERANCE")
    running.work.cancel()
    started = time.monotonic()
    with pytest.raises(lissom.Cancelled):
        running.work.poll()
    assert time.monotonic() - started < 0.2
    assert scene.snapshot() == before


def test_row_42_the_object_or_an_end_is_gone_meanwhile():
    obj = keyed_tube()
    running = Running(obj)
    obj.shape_key_remove(obj.data.shape_keys.key_blocks["full"])
    before = scene.snapshot()
    with pytest.raises(Refused, match="no shape key named 'full'"):
        running.finish()
    assert scene.snapshot() == before
    scene.add_key(obj, "full", scene.key_points(obj, "half"))
    running = Running(obj)
    bpy.data.objects.remove(obj)
    with pytest.raises(Refused, match="'Tube' is gone: nothing was changed"):
        running.finish()


def test_row_42_the_slider_is_taken_by_another_meanwhile():
    obj = keyed_tube()
    running = Running(obj)
    obj["full arc"] = "mine"
    with pytest.raises(Refused, match="custom property of another kind"):
        running.finish()
    assert obj["full arc"] == "mine"
