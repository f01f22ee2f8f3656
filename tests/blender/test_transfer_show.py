"""The colours of a fit, and suggested markers."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import session
from bl_ext.user_default.lissom.core.colours import GOOD, UNMATCHED
from test_transfer import monkeys

NAME = "Lissom Fit"


def colours(obj):
    flat = np.empty(4 * len(obj.data.vertices), dtype=np.float32)
    obj.data.color_attributes[NAME].data.foreach_get("color", flat)
    return flat.reshape(-1, 4)


def test_a_fit_is_shown_as_colours_and_taken_away():
    source, target = monkeys()
    with pytest.raises(RuntimeError, match="Press Fit first"):
        bpy.ops.lissom.fit_show()
    inside = scene.group(target, "inside", lambda co: co.z < -0.6)
    assert bpy.ops.lissom.transfer_fit(target_mask="inside") == {"FINISHED"}
    before = [obj.data.color_attributes.keys() for obj in (source, target)]
    assert bpy.ops.lissom.fit_show() == {"FINISHED"}
    seen = colours(target)
    assert np.allclose(seen[inside, :3], UNMATCHED, atol=0.01)
    matched = np.isfinite(session.fit.fit.image_distances)
    assert 0.8 < matched.mean() < 1
    near = np.linalg.norm(seen[matched, :3] - GOOD, axis=1) < 0.3
    assert near.mean() > 0.9, "the same surface lies well"
    assert source.data.color_attributes.active_color.name == NAME
    bpy.ops.lissom.fit_show()  # again: no second attribute
    assert len(target.data.color_attributes) == len(before[1]) + 1
    assert bpy.ops.lissom.fit_show(show=False) == {"FINISHED"}
    assert [obj.data.color_attributes.keys() for obj in (source, target)] == before


def test_colours_of_meshes_that_changed_since_are_refused():
    source, target = monkeys()
    bpy.ops.lissom.transfer_fit()
    target.data.vertices.add(1)
    with scene.refused("was changed since the last fit"):
        bpy.ops.lissom.fit_show()
    bpy.data.objects.remove(source)
    with scene.refused("is gone: press Fit again"):
        bpy.ops.lissom.fit_show()


def test_a_marker_is_suggested_where_the_fit_is_least_certain():
    _, target = monkeys()
    settings = bpy.context.scene.lissom_transfer
    while len(settings.markers) > 6:
        settings.markers.remove(len(settings.markers) - 1)
    bpy.ops.lissom.transfer_fit()
    assert bpy.ops.lissom.marker_suggest() == {"FINISHED"}
    assert len(settings.markers) == 7 and settings.active_marker == 6
    new = settings.markers[6]
    assert new.source not in [row.source for row in list(settings.markers)[:6]]
    place = session.fit.fit.fitted_vertices[new.source]
    away = np.linalg.norm(scene.points(target.data.vertices) - place, axis=1)
    assert away[new.target] == away.min()
    with scene.refused("changed since the last fit"):
        bpy.ops.lissom.marker_suggest()
