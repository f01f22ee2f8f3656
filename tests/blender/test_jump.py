"""Views that jump to where the next landmark is to be expected."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import preferences, session
from bl_ext.user_default.lissom.bridge import views
from bl_ext.user_default.lissom.core.landmarks import SETS
from bl_ext.user_default.lissom.core.picking import Picking
from bl_ext.user_default.lissom.core.surface import Point
from bl_ext.user_default.lissom.jobs.jump import Jumps
from bl_ext.user_default.lissom.jobs.pick import Picks
from mathutils import Quaternion, Vector

NAMES = [landmark.name for landmark in SETS["FACE_7"]]
PLACES = [(-0.6, -0.7, 0.25), (-0.2, -0.75, 0.2), (0.2, -0.75, 0.2), (0.6, -0.7, 0.25), (0, -0.95, -0.3)]


@pytest.fixture
def picking():
    """Two monkeys side by side, the target twice as large; four landmarks of seven are marked on both."""
    source, target = scene.monkey(1, "Source"), scene.monkey(1, "Target")
    target.location, target.scale, target.rotation_euler = (8, 0, 0), (2, 2, 2), (0, 0, 0.5)
    bpy.context.view_layer.update()
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target, settings.landmarks = source, target, "FACE_7"
    for name, place in zip(NAMES[:4], PLACES, strict=False):
        vertex = nearest(source, place)
        bpy.ops.lissom.marker_add(source_vertex=vertex, target_vertex=vertex, name=name)
    session.picking = Picking()
    picks = Picks(lambda message: None)
    picks.ask(bpy.context.scene)
    yield source, target, picks
    session.picking = None


def nearest(obj, place):
    return int(np.linalg.norm(scene.points(obj.data.vertices) - place, axis=1).argmin())


def view():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def looked_at():
    return np.array(view().spaces.active.region_3d.view_location)


def nose(obj):
    return np.array(obj.matrix_world @ Vector(PLACES[4]))


def test_the_view_shows_the_next_place_first_on_the_source_then_on_the_target(picking):
    source, target, picks = picking
    address = view().as_pointer()
    view().spaces.active.region_3d.view_rotation = Quaternion((0.0, 0.0, 0.7071, 0.7071))  # from behind
    before = views.looks([address])[address]
    jumps = Jumps()
    for side, obj in (("source", source), ("target", target)):
        assert session.picking.wanted == "tip of the nose"
        jumps.follow(bpy.context, session.picking, None, address)
        assert np.linalg.norm(looked_at() - nose(obj)) < 0.3 * obj.scale[0]
        outward = obj.matrix_world.to_3x3() @ Vector((0, -1, 0))
        assert views.direction(view()) @ -np.array(outward.normalized()) > 0.5
        spot = looked_at()
        view().spaces.active.region_3d.view_location.z += 1  # the artist's: it is left alone until then
        jumps.follow(bpy.context, session.picking, None, address)
        assert np.allclose(looked_at() - spot, [0, 0, 1])
        picks.take(bpy.context.scene, side, Point.at(nearest(obj, PLACES[4])))
    assert session.picking.wanted == NAMES[5]
    jumps.follow(bpy.context, session.picking, None, address)
    assert np.linalg.norm(looked_at() - source.matrix_world @ Vector((-0.3, -0.75, -0.7))) < 0.6
    jumps.back()
    assert views.same(views.looks([address])[address], before)


def test_a_view_that_the_artist_moved_since_stays_and_a_camera_is_not_moved(picking):
    address, region = view().as_pointer(), view().spaces.active.region_3d
    jumps = Jumps()
    jumps.follow(bpy.context, session.picking, None, address)
    region.view_location.x += 1
    spot = looked_at()
    jumps.back()
    assert np.allclose(looked_at(), spot)
    region.view_perspective = "CAMERA"
    Jumps().follow(bpy.context, session.picking, None, address)
    assert np.allclose(looked_at(), spot)
    region.view_perspective = "PERSP"


def test_of_two_views_each_shows_its_own_side(picking):
    source, target, _ = picking
    address = view().as_pointer()
    Jumps().follow(bpy.context, session.picking, (address, 0), None)
    assert np.linalg.norm(looked_at() - nose(target)) < 0.6
    Jumps().follow(bpy.context, session.picking, (0, address), None)
    assert np.linalg.norm(looked_at() - nose(source)) < 0.3


def test_nothing_jumps_before_two_are_marked_nor_where_any_place_will_do(picking):
    spot = looked_at()
    settings = bpy.context.scene.lissom_transfer
    settings.landmarks = "FREE"
    picking[2].ask(bpy.context.scene)
    Jumps().follow(bpy.context, session.picking, None, view().as_pointer())
    bpy.ops.lissom.marker_clear()
    settings.landmarks = "FACE_7"
    for obj in picking[:2]:
        obj.lissom_landmarks.clear()
    picking[2].ask(bpy.context.scene)
    assert session.picking.wanted == NAMES[0]
    Jumps().follow(bpy.context, session.picking, None, view().as_pointer())
    assert np.allclose(looked_at(), spot)
    assert preferences.jumps()  # by default
