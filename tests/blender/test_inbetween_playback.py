"""In-between: how baked arcs play, and what becomes of animation, names and other keys."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.bridge import animation
from bl_ext.user_default.lissom.core import hat
from bl_ext.user_default.lissom.core.easing import EASINGS
from numpy.testing import assert_allclose
from test_inbetween import bend, keyed_tube, native_path, slide

SLIDER = '["full arc"]'
VALUE = 'key_blocks["full"].value'
TIMES = [0.0, 0.05, 0.31, 0.5, 0.77, 0.99, 1.0]


def bake(**settings):
    assert bpy.ops.lissom.inbetween_bake(object="Tube", end="full", **settings) == {"FINISHED"}


def knots(obj, slider="full arc"):
    """The times on the arc of its keys, with that of its start."""
    return np.union1d([0.0], [key.time for key in obj.lissom_inbetween.arcs[slider].keys])


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("easing", EASINGS)
def test_an_eased_slider_plays_the_path_at_eased_times(easing, playback):
    obj = keyed_tube()
    path = native_path(obj, "Basis", "full")
    bake(count=3, easing=easing, playback=playback)
    shapes = path.at(knots(obj))
    for time in [*TIMES, *EASINGS[easing].inverse(knots(obj))]:
        slide(obj, "full arc", float(time))
        weights = hat.weights(knots(obj), EASINGS[easing].value(time))[0]
        assert_allclose(scene.shown(obj), np.tensordot(weights, shapes, axes=1), atol=2e-5)


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("easing", EASINGS)
@pytest.mark.parametrize("through", [(), (0.0002,), (0.5, 0.5005), "drawn"])
def test_any_number_of_keys_however_near_each_other_plays_the_path(through, easing, playback):
    draw = np.random.default_rng([len(through), [*EASINGS].index(easing)])
    times = draw.uniform(0.1, 0.9) + np.array([0, 2e-4, 1e-3]) if through == "drawn" else through
    obj = keyed_tube(rings=4, around=6)
    rest, curve = scene.key_points(obj, "Basis"), EASINGS[easing]
    for number, time in enumerate(times):
        scene.add_key(obj, f"stop {number}", bend(rest, 2.4 * time + 0.1 * (number + 1)))
    stops = [(time, scene.key_points(obj, f"stop {number}")) for number, time in enumerate(times)]
    path = native_path(obj, "Basis", "full", through=stops)
    listed = ", ".join(f"stop {number}: {time}" for number, time in enumerate(times))
    for count in (100, int(draw.integers(2, 100))):
        bake(count=count, through=listed, easing=easing, playback=playback)
        # The file keeps times in single precision.
        on = hat.spread(hat.uniform_knots(count), times)
        assert_allclose(knots(obj), on, atol=1e-7)
        shapes = path.at(on)
        near = curve.inverse(np.clip(np.add.outer(on, [-1e-4, 0, 1e-4]), 0, 1)).ravel()
        values = np.unique([*np.linspace(0, 1, 200), *draw.choice(near, 20)])
        speed = np.abs(np.diff(shapes, axis=0)).max(axis=(1, 2)) / np.diff(on)
        swept = [0.0]
        for value in values.tolist():
            slide(obj, "full arc", value)
            along = curve.value(value)
            fastest = speed[np.abs(np.searchsorted(on, along) - np.arange(1, len(on))) <= 1].max()
            expected = np.tensordot(hat.weights(on, along)[0], shapes, axes=1)
            seen = scene.shown(obj)
            assert_allclose(seen, expected, atol=1e-5 + 3e-7 * fastest)
            if not len(times):
                swept.append(np.arctan2(*(seen[-6:].mean(axis=0) - seen[-12:-6].mean(axis=0))[[0, 2]]))
        assert (np.diff(swept) > -1e-5).all()


@pytest.mark.parametrize("sampling", ["TOLERANCE", "PLACED"])
def test_searched_keys_are_never_closer_than_the_slider_tells_apart(sampling):
    obj = keyed_tube(rings=4, around=6)
    bake(sampling=sampling, count=20, tolerance=3e-4, through="half: 0.0003")
    assert np.diff(knots(obj)).min() > 0.99 * hat.NEAREST
    assert "are left out" in obj.lissom_inbetween.arcs["full arc"].warnings
    slide(obj, "full arc", knots(obj)[-2])
    assert_allclose(
        scene.shown(obj), scene.key_points(obj, obj.data.shape_keys.key_blocks[-2].name), atol=1e-5
    )


@pytest.mark.parametrize("scale", [1.0, 10.0])
@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
def test_the_fewest_keys_stay_within_the_tolerance_in_scene_units(playback, scale):
    obj = keyed_tube()
    obj.scale = (scale,) * 3
    bpy.context.view_layer.update()
    path = native_path(obj, "Basis", "full")
    tolerance = 0.05
    bake(sampling="TOLERANCE", tolerance=tolerance, playback=playback)
    times = knots(obj)
    assert_allclose(times, path.keyframes(tolerance / scale), atol=2e-3)
    assert 4 < len(times) < 25
    for time in times:
        slide(obj, "full arc", float(time))
        assert_allclose(scene.shown(obj), path.at([time])[0], atol=2e-5)
    worst = 0.0
    for time in np.linspace(0.0, 1.0, 41):
        slide(obj, "full arc", time)
        off = scale * np.linalg.norm(scene.shown(obj) - path.at([time])[0], axis=1)
        worst = max(worst, off.max())
    assert 0.5 * tolerance < worst <= tolerance
    # One key less does not do, wherever the others lie.
    fewer = np.linspace(0, 1, 2001)
    with pytest.warns(RuntimeWarning, match="leave an error"):
        few = path.keyframes(tolerance / scale, len(times) - 1)
    played = np.einsum("tk,kni->tni", hat.weights(few, fewer[::50]), path.at(few))
    assert scale * np.linalg.norm(played - path.at(fewer[::50]), axis=2).max() > 0.9 * tolerance


def test_a_tolerance_that_no_number_of_keys_meets_is_said():
    obj = keyed_tube()
    bake(sampling="TOLERANCE", tolerance=1e-6)
    assert "keys leave an error of" in obj.lissom_inbetween.arcs["full arc"].warnings


# Absolute keys


def test_absolute_keys_are_played_by_the_evaluation_time():
    obj = keyed_tube()
    keys = obj.data.shape_keys
    before = scene.snapshot()
    bake(count=1, playback="ABSOLUTE")
    assert not keys.use_relative
    assert "shape key 'half' no longer adds to it" in obj.lissom_inbetween.arcs["full arc"].warnings
    assert keys.key_blocks.keys()[-3:] == ["full arc 0%", "full arc 50%", "full arc 100%"]
    frames = [key.frame for key in keys.key_blocks]
    assert frames == sorted(frames)
    assert_allclose(np.diff(frames[-3:]), 1000, atol=1e-3)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert keys.use_relative
    assert keys.eval_time == 0
    assert len(keys.animation_data.drivers) == 0
    assert scene.snapshot() == before


def test_a_second_arc_beside_an_absolute_one_is_refused():
    obj = keyed_tube()
    bake(playback="ABSOLUTE")
    with scene.refused("play the absolute arc 'full arc': remove it first"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="half")
    bake(count=2)  # the same slider again, relative
    assert obj.data.shape_keys.use_relative
    assert_plays_at_knots(obj, native_path(obj, "Basis", "full"))


def test_row_34_absolute_keys_of_the_artist_are_refused():
    obj = keyed_tube()
    obj.data.shape_keys.use_relative = False
    with scene.refused("are absolute: turn on Relative"):
        bpy.ops.lissom.inbetween_bake(object="Tube", end="full")


def assert_plays_at_knots(obj, path, slider="full arc"):
    for time in knots(obj, slider):
        slide(obj, slider, float(time))
        assert_allclose(scene.shown(obj), path.at([time])[0], atol=1e-5)


# Drivers and animation of the end key


def control(obj, key="full", factor=0.5):
    """A key driven by ``factor`` times the custom property "control"."""
    obj["control"] = 0.0
    curve = obj.data.shape_keys.key_blocks[key].driver_add("value")
    driver = curve.driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "v"
    variable.targets[0].id, variable.targets[0].data_path = obj, '["control"]'
    driver.expression = f"{factor} * v"
    return curve


def read_key(obj, of="full", by="half"):
    """The key ``by`` driven by the value of the key ``of``, as correctives are."""
    keys = obj.data.shape_keys
    driver = keys.key_blocks[by].driver_add("value").driver
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id_type, target.id = "KEY", keys
    target.data_path = f'key_blocks["{of}"].value'


def play(obj, control):
    obj["control"] = control
    obj.update_tag()
    bpy.context.view_layer.update()
    return scene.shown(obj)


def test_the_driver_of_the_end_key_plays_the_arc_and_is_handed_back():
    obj = keyed_tube()
    control(obj)
    straight = play(obj, 1.0)
    path = native_path(obj, "Basis", "full")
    bake(count=3)
    assert obj.data.shape_keys.key_blocks["full"].value == 0
    for value in (0.0, 1.0, 2.0):
        assert_allclose(play(obj, value), path.at([value / 2])[0], atol=1e-5)
    bake(count=1)  # again: the slider keeps what it took over
    assert_allclose(play(obj, 1.0), path.at([0.5])[0], atol=1e-5)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert_allclose(play(obj, 1.0), straight, atol=1e-6)
    assert "full arc" not in obj
    assert len(obj.animation_data.drivers) == 0


def test_the_driver_stays_where_it_is_by_option():
    obj = keyed_tube()
    control(obj)
    bake(reroute=False)
    assert animation.driver(obj.data.shape_keys, VALUE) is not None
    assert animation.driver(obj, SLIDER) is None
    assert "'full' is driven or locked" in obj.lissom_inbetween.arcs["full arc"].warnings


def test_drivers_that_read_the_end_key_read_the_slider():
    obj = keyed_tube()
    read_key(obj)
    bake(count=1)
    slide(obj, "full arc", 0.6)
    keys = obj.data.shape_keys.key_blocks
    assert keys["half"].value == pytest.approx(0.6)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    keys["full"].value = 0.3
    bpy.context.view_layer.update()
    assert keys["half"].value == pytest.approx(0.3)


def animate(key):
    """Two keyframes with handles of their own, and a noise modifier without strength."""
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    curve = animation.curve(key.id_data, key.path_from_id("value"))
    curve.keyframe_points[0].interpolation = "BACK"
    curve.keyframe_points[0].back = 0.4
    curve.modifiers.new("NOISE").strength = 0.25
    return [curve.evaluate(frame) for frame in range(12)]


def test_the_animation_of_the_end_key_moves_to_the_slider_and_back():
    obj = keyed_tube()
    keys = obj.data.shape_keys
    values = animate(keys.key_blocks["full"])
    path = native_path(obj, "Basis", "full")
    bake(count=9)
    assert animation.curve(keys, VALUE) is None
    moved = animation.curve(obj, SLIDER)
    assert_allclose([moved.evaluate(frame) for frame in range(12)], values, atol=1e-6)
    moved.modifiers.remove(moved.modifiers[0])
    bpy.context.scene.frame_set(11)
    assert_allclose(scene.shown(obj), path.at([1.0])[0], atol=1e-5)
    bpy.context.scene.frame_set(1)
    assert_allclose(scene.shown(obj), path.at([0.0])[0], atol=1e-5)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert animation.curve(obj, SLIDER) is None
    back = animation.curve(keys, VALUE)
    assert (back.keyframe_points[0].interpolation, back.keyframe_points[0].back) == (
        "BACK",
        pytest.approx(0.4),
    )
    bpy.context.scene.frame_set(11)
    assert keys.key_blocks["full"].value == pytest.approx(1.0)


@pytest.mark.parametrize("easing", EASINGS)
@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("limits", [(-0.5, 1.5), (0, 2), (-1, 1)])
@pytest.mark.parametrize("start", ["", "half"])
def test_animation_beyond_the_ends_goes_on_straight(start, limits, playback, easing):
    obj = keyed_tube(rings=12, around=8)
    full = obj.data.shape_keys.key_blocks["full"]
    full.slider_min, full.slider_max = limits
    frames = np.linspace(*limits, 9)
    for frame, value in enumerate(frames):
        full.value = value
        full.keyframe_insert("value", frame=frame)
    path = native_path(obj, start or "Basis", "full")
    bake(count=3, start=start, playback=playback, easing=easing)
    bpy.ops.lissom.inbetween_rename(object="Tube", slider="full arc", name="s")
    shapes = path.at(np.linspace(0, 1, 5))
    for frame, value in enumerate(frames):
        bpy.context.scene.frame_set(frame)
        assert obj["s"] == pytest.approx(value)
        within = np.clip(value, 0, 1)
        weights = hat.weights(np.linspace(0, 1, 5), EASINGS[easing].value(within))[0]
        speed = 4 * (shapes[1] - shapes[0] if value < 0 else shapes[4] - shapes[3])
        expected = np.tensordot(weights, shapes, axes=1) + (value - within) * speed
        assert_allclose(scene.shown(obj), expected, atol=3e-5)


@pytest.mark.parametrize("by", ["curve", "driver"])
@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
@pytest.mark.parametrize("limits", [(-0.5, 1.5), (0, 1), (0, 1.2), (-0.25, 1)])
def test_values_beyond_the_end_keys_range_are_shown_as_the_key_itself_shows_them(limits, playback, by):
    obj = keyed_tube(rings=4, around=6)
    rest = scene.key_points(obj, "Basis")
    full = obj.data.shape_keys.key_blocks["full"]
    straight = rest + np.random.default_rng(4).normal(size=3)  # where the arc is the straight line
    full.points.foreach_set("co", straight.astype(np.float32).ravel())
    full.slider_min, full.slider_max = limits
    values = np.linspace(-0.5, 1.5, 9)
    if by == "driver":
        control(obj, factor=1)
        obj["control"] = 0.0
        for frame, value in enumerate(values):
            obj["control"] = float(value)
            obj.keyframe_insert('["control"]', frame=frame)
    else:
        full.slider_min, full.slider_max = -1, 2
        for frame, value in enumerate(values):
            full.value = value
            full.keyframe_insert("value", frame=frame)
        full.slider_min, full.slider_max = limits

    def played():
        for frame in range(len(values)):
            bpy.context.scene.frame_set(frame)
            yield scene.shown(obj)

    before = [*played()]
    assert np.ptp(before, axis=0).max() > 0.5
    bake(count=3, playback=playback)
    assert_allclose([*played()], before, atol=2e-5)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert_allclose([*played()], before, atol=2e-5)


def test_animation_that_others_use_too_stays_and_is_said():
    obj = keyed_tube()
    keys = obj.data.shape_keys
    animate(keys.key_blocks["full"])
    twin = obj.copy()
    twin.data = obj.data.copy()  # with keys of its own, animated by the same curves
    data, other = keys.animation_data, twin.data.shape_keys.animation_data_create()
    other.action = data.action
    if hasattr(other, "action_slot"):
        other.action_slot = data.action_slot
    bake()
    assert animation.curve(keys, VALUE) is not None
    said = obj.lissom_inbetween.arcs["full arc"].warnings
    assert "The animation of shape key 'full' stays with it" in said
    assert "'full' is driven or locked" in said


def test_a_driver_that_reads_the_slider_makes_no_circle():
    obj = keyed_tube()
    bake(count=1)
    variable = obj.data.shape_keys.key_blocks["full"].driver_add("value").driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = obj, SLIDER
    bake(count=1)
    assert animation.driver(obj, SLIDER) is None
    assert "its driver reads the other" in obj.lissom_inbetween.arcs["full arc"].warnings


# Muted, locked


def test_a_muted_end_key_gives_muted_keys():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    keys["full"].mute = True
    bake(count=2)
    assert [key.mute for key in keys if key.name.startswith("full arc")] == [True] * 3
    slide(obj, "full arc", 1.0)
    assert_allclose(scene.shown(obj), scene.key_points(obj, "Basis"), atol=1e-6)


def test_a_muted_start_key_is_said():
    obj = keyed_tube()
    obj.data.shape_keys.key_blocks["half"].mute = True
    bake(start="half")
    assert "'half' is muted: the slider at 0" in obj.lissom_inbetween.arcs["full arc"].warnings


def test_row_34_locked_ends_are_only_read():
    obj = keyed_tube()
    keys = obj.data.shape_keys.key_blocks
    for name in ("half", "full"):
        keys[name].lock_shape = True
    ends = [scene.key_points(obj, name) for name in ("half", "full")]
    bake(start="half", count=1)
    for name, before in zip(("half", "full"), ends, strict=True):
        assert (scene.key_points(obj, name) == before).all()


# Rename, bake again


def test_a_renamed_arc_plays_as_before_with_all_that_animates_and_reads_it():
    obj = keyed_tube()
    control(obj)
    read_key(obj)
    path = native_path(obj, "Basis", "full")
    bake(count=1)
    bpy.ops.lissom.inbetween_rename(object="Tube", slider="full arc", name='bend "it"')
    assert "full arc" not in obj
    assert obj.lissom_inbetween.arcs.keys() == ['bend "it"']
    keys = obj.data.shape_keys.key_blocks
    assert keys.keys() == ["Basis", "half", "full", 'bend "it" 50%', 'bend "it" 100%']
    keys["half"].driver_remove("value")
    keys["half"].value = 0
    assert_allclose(play(obj, 1.0), path.at([0.5])[0], atol=1e-5)
    assert obj.id_properties_ui('bend "it"').as_dict()["max"] == 1.0
    bpy.ops.lissom.inbetween_remove(object="Tube", slider='bend "it"')
    assert animation.driver(obj.data.shape_keys, VALUE) is not None


def test_a_name_that_is_taken_is_refused():
    obj = keyed_tube()
    bake(count=1)
    obj["mine"] = 1.0
    for name, message in (("mine", "a custom property already"), ("location", "choose another name")):
        with scene.refused(message):
            bpy.ops.lissom.inbetween_rename(object="Tube", slider="full arc", name=name)


def test_bake_again_follows_the_end_key_with_the_arcs_own_settings():
    obj = keyed_tube()
    bake(start="half", sampling="TOLERANCE", tolerance=0.1, easing="SMOOTH", rotation="shortest")
    before = knots(obj)
    full = obj.data.shape_keys.key_blocks["full"]
    full.data.foreach_set("co", (scene.points(full.data) * [1, 1, 1.5]).astype(np.float32).ravel())
    bpy.ops.lissom.inbetween_rebake(object="Tube", slider="full arc")
    path = native_path(obj, "half", "full", rotation="shortest")
    arc = obj.lissom_inbetween.arcs["full arc"]
    assert (arc.start, arc.sampling, arc.easing, arc.rotation) == ("half", "TOLERANCE", "SMOOTH", "shortest")
    assert_allclose(knots(obj), path.keyframes(0.1), atol=2e-3)
    assert len(before)
    slide(obj, "full arc", 1.0)
    assert_allclose(scene.shown(obj), scene.key_points(obj, "full"), atol=1e-5)


@pytest.mark.parametrize("action", ["rebake", "rename", "remove"])
def test_an_arc_that_is_not_there(action):
    keyed_tube()
    with scene.refused("has no arc with a slider named 'none'"):
        getattr(bpy.ops.lissom, f"inbetween_{action}")(object="Tube", slider="none")


@pytest.mark.parametrize("playback", ["RELATIVE", "ABSOLUTE"])
def test_a_saved_arc_plays_bakes_again_and_goes(tmp_path, playback):
    obj = keyed_tube()
    before = scene.snapshot()
    control(obj)
    path = native_path(obj, "Basis", "full")
    bake(count=3, playback=playback, easing="SMOOTH")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arc.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "arc.blend"), use_scripts=True)
    obj = bpy.data.objects["Tube"]
    assert_allclose(play(obj, 1.0), path.at([0.5])[0], atol=1e-5)
    bpy.ops.lissom.inbetween_rebake(object="Tube", slider="full arc")
    assert_allclose(play(obj, 1.0), path.at([0.5])[0], atol=1e-5)
    bpy.ops.lissom.inbetween_remove(object="Tube", slider="full arc")
    assert animation.driver(obj.data.shape_keys, VALUE) is not None
    play(obj, 0.0)
    obj.data.shape_keys.key_blocks["full"].driver_remove("value")
    obj.data.shape_keys.key_blocks["full"].value = 0.0
    del obj["control"]
    assert scene.snapshot() == before


def test_placed_keys_follow_the_path_better_than_even_ones():
    obj = keyed_tube()
    full = obj.data.shape_keys.key_blocks["full"]
    stretched = (scene.points(full.data) * [1, 1, 1.5]).astype(np.float32)
    full.data.foreach_set("co", stretched.ravel())
    path = native_path(obj, "Basis", "full")
    bake(count=4, sampling="PLACED")
    assert len(knots(obj)) == 6
    assert_allclose(knots(obj), path.keyframes(count=6), atol=1e-6)
    assert_plays_at_knots(obj, path)
