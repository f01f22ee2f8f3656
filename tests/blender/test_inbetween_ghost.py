"""In-between: the ghost of the arc. What it looks like is seen in a window (tests/blender/window.py)."""

import bpy
import numpy as np
import scene
from bl_ext.user_default.lissom.drawing import ghost
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube, native_path


def ghost_of(obj, **settings):
    for name, value in ({"ghost": True} | settings).items():
        setattr(obj.lissom_inbetween, name, value)
    return ghost.of(obj)


def test_its_steps_lie_on_the_path():
    obj = keyed_tube()
    made = ghost_of(obj, end="full")
    shapes = native_path(obj, "Basis", "full").at(np.linspace(0, 1, ghost.STEPS + 2))
    assert len(made.steps) == ghost.STEPS
    for (time, step, light), shape in zip(made.steps, shapes[1:-1], strict=True):
        assert_allclose(step, shape, atol=1e-5)
        assert 0 < time < 1 and ((light >= 0) & (light <= 1)).all()


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
    monkeypatch.setattr(ghost, "LARGE", len(obj.data.vertices))
    assert len(ghost_of(obj, end="full").steps) == 1
    monkeypatch.setattr(ghost, "HUGE", len(obj.data.vertices))
    made = ghost_of(obj, start="half")
    assert "are too many to draw" in made.message
    assert not made.steps


def test_it_goes_with_the_file():
    obj = keyed_tube()
    ghost_of(obj, end="full")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not ghost._ghosts
