"""A newcomer's paths from the empty scene, by the buttons that the panels offer, in clicks.

A click is a press of a button, a tick, a place in the view, or a drag; a choice from a list is two. Folded
parts of the panels stay folded. The table in docs/benchmarks.md says how many each path takes.
"""

import contextlib
import pathlib
import re

import bpy
import numpy as np
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import brush
from bl_ext.user_default.lissom.jobs import touch
from bl_ext.user_default.lissom.jobs.review import Review
from bl_ext.user_default.lissom.properties.main import PAGES
from mathutils import Vector
from numpy.testing import assert_allclose
from test_inbetween import bend, slide
from test_panels import draw
from test_pose_stands import arm

TABLE = pathlib.Path(__file__).parents[2] / "docs" / "benchmarks.md"


class Newcomer:
    """Presses what is on show, and counts."""

    def __init__(self):
        self.clicks = 0
        for obj in bpy.context.view_layer.objects:
            obj.select_set(False)
        bpy.context.view_layer.objects.active = None
        self._click()  # the tab

    def _click(self, count=1):
        self.clicks += count

    @property
    def _panel(self):
        kinds = [getattr(bpy.types, f"LISSOM_PT_{page.lower()}") for page, *_ in PAGES]
        (shown,) = [kind for kind in kinds if kind.poll(bpy.context)]
        return shown

    def select(self, obj, more=False):
        if not more:
            for other in bpy.context.selected_objects:
                other.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        self._click()

    def page(self, name):
        assert "lissom_page" in draw(bpy.types.LISSOM_PT_main)["settings"]
        if bpy.context.window_manager.lissom_page != name:
            bpy.context.window_manager.lissom_page = name
            self._click()

    def tick(self, settings, name):
        assert name in draw(self._panel, closed=True)["settings"], f"{name} is not on show"
        assert settings.bl_rna.properties[name].type == "BOOLEAN"
        setattr(settings, name, not getattr(settings, name))
        self._click()

    def press(self, idname, run=True, without="", **having):
        """Presses the one button of an operator with these properties; without ``run`` one only could."""
        drawn = draw(self._panel, closed=True)
        buttons = drawn["operators"].get(idname, [])
        found = [given for given in buttons if having.items() <= given.items() and without not in given]
        assert len(found) == 1, f"{idname} is {len(found)} times on show"
        operator = getattr(getattr(bpy.ops, idname.split(".")[0]), idname.split(".")[1])
        with contextlib.ExitStack() as stack:
            stack.enter_context(bpy.context.temp_override(**drawn["pointers"]))
            assert operator.poll(), f"{idname} is grey"
            if run:
                assert operator(**found[0]) == {"FINISHED"}
        self._click()


def in_the_table(path):
    """The clicks that the table has for a path."""
    (row,) = [line for line in TABLE.read_text().splitlines() if line.startswith(f"| {path} |")]
    return int(re.findall(r"\d+", row.split("|")[2])[0])


def test_two_heads_to_reviewed_keys():
    source, target = scene.monkey(1, "Source"), scene.monkey(1, "Target")
    target.modifiers.new("Triangles", "TRIANGULATE")
    bpy.context.view_layer.objects.active = target
    bpy.ops.object.modifier_apply(modifier="Triangles")
    target.location.x = 4
    rest = scene.points(source.data.vertices)
    scene.add_key(source, "squash", rest * [1.1, 1, 0.8])
    ears = np.clip(np.abs(rest[:, :1]) - 0.9, 0, None) * [0, 0.5, 1.0]
    scene.add_key(source, "ears", rest + ears)
    bpy.context.view_layer.update()
    artist = Newcomer()
    artist.page("TRANSFER")
    artist.select(source)
    artist.select(target, more=True)
    artist.press("lissom.transfer_sides", without="swap")
    artist.press("lissom.transfer_keys")
    artist.press("lissom.review", run=False)  # its views are split in a window only
    session.review = Review(bpy.context, ([source], [target]))
    try:
        assert set(draw(artist._panel)["operators"]) >= {"lissom.review", "lissom.review_mend"}
        assert target.show_only_shape_key and target.active_shape_key.name == session.review.key
    finally:
        session.review = session.review.leave(bpy.context)
    moved = scene.key_points(target, "squash") - scene.key_points(target, "Basis")
    assert_allclose(moved, scene.points(target.data.vertices) * [0.1, 0, -0.2], atol=0.02)
    assert artist.clicks == in_the_table("Two heads to reviewed keys")


def test_a_bent_arm_to_a_driven_corrective():
    obj, rig = arm(degrees=90.0)
    artist = Newcomer()
    artist.select(obj)
    artist.page("POSE")
    artist.press("wm.tool_set_by_id", run=False, name="lissom.pose_tool")  # a window has tools
    shown = scene.shown(obj)
    vertex = int(np.linalg.norm(shown - shown.mean(axis=0), axis=1).argmin())
    found = brush.Hit(vertex, obj.matrix_world @ Vector(shown[vertex]), 0.01)
    taken = touch.on(bpy.context, obj, found, 40)
    bpy.data.objects[taken.empty].matrix_world.translation += Vector((0, 0, 0.2))
    bpy.context.view_layer.update()
    artist._click()  # the drag
    posed = scene.shown(obj)
    assert np.abs(posed - shown).max() > 0.1
    artist.press("lissom.pose_apply", without="value")
    artist.press("lissom.pose_drive")
    key = obj.data.shape_keys.key_blocks["Pose"]
    assert key.id_data.animation_data.drivers and key.value > 0.999
    assert_allclose(scene.shown(obj), posed, atol=1e-3)
    rig.data.pose_position = "REST"
    bpy.context.view_layer.update()
    assert artist.clicks == in_the_table("A bent arm to a driven corrective")
    assert key.value == 0


def test_eight_arcs():
    obj = scene.tube()
    rest = scene.points(obj.data.vertices)
    turns = {f"bent {number}": 0.3 * number for number in range(1, 9)}
    for name, turn in turns.items():
        scene.add_key(obj, name, bend(rest, turn))
    artist = Newcomer()
    artist.select(obj)
    artist.page("INBETWEEN")
    artist.tick(obj.lissom_inbetween, "several")
    artist.press("lissom.inbetween_choose", action="ALL")
    artist.press("lissom.inbetween_bake_all")
    assert len(obj.lissom_inbetween.arcs) == 8
    slide(obj, "bent 3 arc", 1.0)
    assert_allclose(scene.shown(obj), bend(rest, turns["bent 3"]), atol=1e-4)
    assert artist.clicks == in_the_table("Eight arcs")
