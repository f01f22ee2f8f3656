"""Landmarks: kept on each mesh by name, paired by it, guessed and confirmed; asked for in turn by Pick."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import landmarks
from bl_ext.user_default.lissom.core.picking import Picking
from bl_ext.user_default.lissom.core.surface import Point
from bl_ext.user_default.lissom.jobs.pick import Picks


def sides(*names, **options):
    """Bumpy tubes as source and target."""
    made = [scene.tube(name=name, **options) for name in names]
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = made[:2]
    return settings, *made


def pair(vertex, other, name):
    bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=other, name=name)


def test_names_stay_on_both_meshes_and_numbers_do_not():
    _, source, target = sides("Source", "Target")
    pair(3, 8, "chin")
    pair(5, 21, "")
    assert landmarks.of(source) == {"chin": Point.at(3)}
    assert landmarks.of(target) == {"chin": Point.at(8)}
    bpy.ops.lissom.marker_clear()
    assert set(landmarks.of(source)) == {"chin"}


def test_one_source_serves_several_characters():
    settings, source, one, other = sides("Source", "One", "Other")
    for vertex, name in ((3, "chin"), (30, "nose"), (60, "ear")):
        pair(vertex, vertex + 1, name)
    bpy.ops.lissom.marker_clear()
    settings.source, settings.target = other, one
    pair(9, 33, "brow")
    pair(40, 4, "chin")
    bpy.ops.lissom.marker_clear()
    settings.source = source
    bpy.ops.lissom.landmarks_pair()
    found = {row.name: row.ends for row in settings.markers}
    assert found == {
        "chin": (Point.at(3), Point.at(4)),
        "nose": (Point.at(30), Point.at(31)),
        "ear": (Point.at(60), Point.at(61)),
    }
    with scene.refused("bear no further landmarks"):
        bpy.ops.lissom.landmarks_pair()


def test_they_are_found_again_where_a_mesh_was_remodelled():
    _, source, _ = sides("Source", "Target")
    pair(30, 31, "nose")
    place = scene.points(source.data.vertices)[30]
    source.data.clear_geometry()
    finer = scene.tube(name="Finer", rings=61)
    source.data = finer.data
    point = landmarks.of(source)["nose"]
    assert np.linalg.norm(point.position(scene.points(finer.data.vertices)) - place) < 1e-4


def test_the_rest_is_guessed_counts_only_once_confirmed_and_is_kept_then():
    settings, source, target = sides("Source", "Target")
    rest = scene.points(source.data.vertices)
    wanted = {"a": 5, "b": 37, "c": 64, "d": 90, "e": 121}
    for name, vertex in wanted.items():
        pair(vertex, vertex, name)
    bpy.ops.lissom.marker_clear()
    target.lissom_landmarks.clear()
    for name in "abc":
        pair(wanted[name], wanted[name], name)
    bpy.ops.lissom.landmarks_guess()
    rows = {row.name: row for row in settings.markers}
    assert [name for name, row in rows.items() if row.guessed] == ["d", "e"]
    for name in "de":
        assert np.linalg.norm(rows[name].point("target").position(rest) - rest[wanted[name]]) < 1e-3
    assert set(landmarks.of(target)) == set("abc")
    bpy.ops.lissom.transfer_fit()
    assert len(session.fit.pairs) == 3 and len(settings.markers) == 5
    bpy.ops.lissom.landmarks_guess()  # again: in place of the first guesses
    assert len(settings.markers) == 5
    bpy.ops.lissom.landmarks_confirm()
    assert not any(row.guessed for row in settings.markers)
    assert set(landmarks.of(target)) == set("abcde")
    with scene.refused("No marker is guessed"):
        bpy.ops.lissom.landmarks_confirm()


class Picker:
    """Picking without a window."""

    def __init__(self):
        self._scene, self._picks = bpy.context.scene, Picks(lambda message: None)

    def ask(self):
        self._picks.ask(self._scene)

    def click(self, side, vertex):
        self._picks.take(self._scene, side, Point.at(vertex))

    def skip(self):
        self._picks.skip(self._scene)

    def asked(self):
        return self._picks.asked(self._scene)


@pytest.fixture
def picker(monkeypatch):
    monkeypatch.setattr(session, "picking", Picking())
    return Picker()


def test_pick_asks_for_one_landmark_after_the_other(picker):
    settings, *_ = sides("Source", "Target")
    settings.landmarks = "FACE_7"
    picker.ask()
    assert picker.asked().startswith("1 of 7: right eye, outer corner, on either mesh")
    picker.click("source", 3)
    assert picker.asked().startswith("1 of 7: right eye, outer corner, on the target")
    picker.click("target", 4)
    assert picker.asked().startswith("2 of 7: right eye, inner corner")
    picker.skip()
    assert picker.asked().startswith("3 of 7: left eye, inner corner")
    picker.click("target", 9)
    picker.click("source", 8)
    assert [(row.name, row.ends) for row in settings.markers] == [
        ("right eye, outer corner", (Point.at(3), Point.at(4))),
        ("left eye, inner corner", (Point.at(8), Point.at(9))),
    ]


def test_what_a_mesh_bears_already_is_not_asked_for_again(picker):
    settings, _, target = sides("Source", "Target")
    other = scene.tube(name="Other")
    pair(3, 4, "right eye, outer corner")
    pair(6, 7, "right eye, inner corner")
    bpy.ops.lissom.marker_clear()
    settings.target = other
    settings.landmarks = "FACE_7"
    picker.ask()
    assert picker.asked().startswith("1 of 7: right eye, outer corner, on the target")
    picker.click("target", 20)
    assert picker.asked().startswith("2 of 7: right eye, inner corner, on the target")
    bpy.ops.lissom.marker_clear()
    settings.target = target  # which bears both
    picker.ask()
    assert [row.ends for row in settings.markers] == [(Point.at(3), Point.at(4)), (Point.at(6), Point.at(7))]
    assert picker.asked().startswith("3 of 7")
    settings.landmarks = "OWN"
    picker.ask()
    assert session.picking.wanted == "" and picker.asked() == ""
