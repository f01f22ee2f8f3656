"""Two Views: source and target each alone in a view. Without a window views are split, but never close."""

import bpy
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.bridge import views as views3d


def views():
    window = bpy.context.window_manager.windows[0]
    return [area for area in window.screen.areas if area.type == "VIEW_3D"]


def within(area):
    window = bpy.context.window_manager.windows[0]
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window, area=area, region=region)


@pytest.fixture
def pair():
    """Source and target; only the first is selected."""
    source, target = scene.tube(8, 8, "Source"), scene.tube(8, 8, "Target")
    target.location.x = 10
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = source, target
    scene.add_key(source, "wide", scene.points(source.data.vertices) * [1.2, 1, 1])
    source.select_set(True)
    target.select_set(False)
    bpy.context.view_layer.update()
    yield source, target
    for area in views():
        if area.spaces.active.local_view is not None:
            with within(area):
                bpy.ops.view3d.localview(frame_selected=False)
    session.views = None


def test_each_view_shows_one_of_the_two_and_looks_at_it(pair):
    own, *before = views()
    with within(own):
        assert bpy.ops.lissom.marker_views() == {"FINISHED"}
    (new,) = set(views()) - {own, *before}
    seen = [[obj.visible_get(viewport=area.spaces.active) for obj in pair] for area in (new, own)]
    assert seen == [[True, False], [False, True]]
    assert [obj.select_get() for obj in pair] == [True, False]
    views3d.frame(session.views)
    away = [
        area.spaces.active.region_3d.view_location - obj.location
        for area, obj in zip((new, own), pair, strict=True)
    ]
    assert max(vector.length for vector in away) < 5


def test_what_a_local_view_leaves_out_is_fitted_and_posed_all_the_same(pair):
    pivot = bpy.data.objects.new("Pivot", None)
    bpy.context.collection.objects.link(pivot)
    for obj in pair:  # Blender alone knows where such an object is
        obj.constraints.new("CHILD_OF").target = pivot
    bpy.context.view_layer.update()
    area = views()[0]
    with within(area):
        bpy.ops.view3d.localview()
        assert [obj.visible_get() for obj in pair] == [True, False]
        assert bpy.ops.lissom.transfer_fit() == {"FINISHED"}
        assert bpy.ops.lissom.transfer_pose(name="Seen") == {"FINISHED"}
        pair[0].hide_viewport = True
        bpy.context.view_layer.update()
        with scene.refused("is hidden"):
            bpy.ops.lissom.transfer_pose(name="Hidden")


def test_a_view_that_is_local_already_is_refused(pair):
    before = len(views())
    with within(views()[0]):
        bpy.ops.view3d.localview()
        with scene.refused("leave it first"):
            bpy.ops.lissom.marker_views()
    assert len(views()) == before
