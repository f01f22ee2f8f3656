"""In-between: the ghost of the arc. What it looks like is seen in a window (tests/blender/window.py)."""

import bpy
import numpy as np
import scene
from bl_ext.user_default.lissom.drawing import ghost
from bl_ext.user_default.lissom.jobs import ghost as job
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube, native_path


def ghost_of(obj, **settings):
    for name, value in ({"ghost": True} | settings).items():
        setattr(obj.lissom_inbetween, name, value)
    return ghost.of(obj)


def test_its_steps_lie_on_the_path():
    obj = keyed_tube()
    made = ghost_of(obj, end="full")
    assert_allclose(made.times, np.linspace(0, 1, job.SAMPLES + 2))
    assert_allclose(made.shapes, native_path(obj, "Basis", "full").at(made.times), atol=1e-5)
    outlines = made.outlines(np.array([0, -1, 0, 0.0]))  # from the side
    assert [time for time, _ in outlines] == list(made.times[2:-1:2])
    for step, (_, pieces) in zip(made.steps, outlines, strict=True):
        sides = pieces[np.abs(pieces[..., 1]).max(axis=1) < 0.2]  # beside them there are the two rims
        far = np.linalg.norm(sides.reshape(-1, 1, 3) - made.shapes[step], axis=2).min(axis=1)
        assert len(sides) > 20 and far.max() < 0.3  # on the surface of its step


def test_trails_are_those_of_the_vertices_that_go_farthest():
    obj = keyed_tube()
    made = ghost_of(obj, end="full")
    ways = np.linalg.norm(made.trails[:, -1] - made.trails[:, 0], axis=1)
    far = np.linalg.norm(made.shapes[-1] - made.shapes[0], axis=1)
    assert ways.max() == far.max() and made.trails.shape[1:] == (len(made.times), 3)
    assert np.median(ways) > np.median(far)


def test_preview_shows_what_the_slider_will_play_and_touches_no_key():
    obj = keyed_tube()
    obj.data.shape_keys.key_blocks["half"].value = 0.3
    before = scene.snapshot()
    made = ghost_of(obj, end="full", easing="SMOOTH", preview=0.3)
    shape, time = made.at(obj.lissom_inbetween.preview, "SMOOTH")
    assert_allclose(time, 0.3**2 * (3 - 2 * 0.3))
    assert_allclose(shape, native_path(obj, "Basis", "full").at([time])[0], atol=0.02)
    obj.lissom_inbetween.preview = 1.0
    assert_allclose(made.at(1.0, "SMOOTH")[0], scene.key_points(obj, "full"), atol=1e-5)
    obj.lissom_inbetween.ghost = False
    assert scene.snapshot() == before and ghost.of(obj) is None
    assert not obj.lissom_inbetween.is_property_set("preview")


def test_it_is_computed_once_per_choice_and_only_while_it_is_on():
    obj = keyed_tube()
    settings = obj.lissom_inbetween
    settings.end = "full"
    assert ghost.of(obj) is None
    first = ghost_of(obj)
    settings.count = 7  # no matter of the path
    assert ghost.of(obj) is first
    settings.start = "half"
    second = ghost.of(obj)
    assert second is not first
    settings.rotation = "shortest"
    assert ghost.of(obj) is not second
    settings.ghost = False
    assert ghost.of(obj) is None


def test_it_changes_nothing_in_the_scene():
    obj = keyed_tube()
    before = scene.snapshot()
    ghost_of(obj, end="full")
    assert scene.snapshot() == before


def test_ends_that_make_no_arc_are_said():
    obj = keyed_tube()
    assert ghost_of(obj).message == "Choose the shape key that the arc leads to"
    assert "are the same shape key" in ghost_of(obj, end="Basis").message
    assert "no shape key named 'none'" in ghost_of(obj, end="none").message


def test_a_large_mesh_gets_fewer_steps_and_a_huge_one_none(monkeypatch):
    obj = keyed_tube()
    monkeypatch.setattr(job, "LARGE", len(obj.data.vertices))
    assert len(ghost_of(obj, end="full").steps) == 1
    monkeypatch.setattr(job, "HUGE", len(obj.data.vertices))
    made = ghost_of(obj, start="half")
    assert "are too many to draw" in made.message
    assert made.shapes is None


def test_it_goes_with_the_file_and_comes_back_with_it(tmp_path):
    obj = keyed_tube()
    ghost_of(obj, end="full")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "ghost.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not ghost._ghosts
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "ghost.blend"))
    assert ghost.of(bpy.data.objects["Tube"]).steps


def test_a_key_that_moves_nothing_has_no_ghost_and_says_so():
    obj = keyed_tube()
    scene.add_key(obj, "new", scene.points(obj.data.vertices))
    obj.lissom_inbetween.end, obj.lissom_inbetween.ghost = "new", True
    shadow = ghost.of(obj)
    assert shadow.shapes is None and "moves nothing yet" in shadow.message
