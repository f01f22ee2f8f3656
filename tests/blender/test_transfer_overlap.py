"""Transfer between meshes that lie on each other, wherever their objects' origins are."""

import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands, session
from bl_ext.user_default.lissom.bridge import attributes, groups
from mathutils import Matrix
from numpy.testing import assert_allclose
from test_panels import draw, panels, text  # noqa: F401 (a fixture)


def dressed(place=(4, -2, 1), turn=0.7, scale=2.0):
    """A tube with a key, a weight and an object matrix, and clothes around it with another."""
    body, shirt = scene.tube(name="Body"), scene.tube(rings=31, around=33, name="Shirt")
    rest = scene.points(body.data.vertices)
    scene.add_key(body, "bulge", rest + 0.2 * rest * [1, 1, 0] * np.exp(-(rest[:, 2:] ** 2)))
    attributes.write_weights(body, "bone", np.clip(0.5 + rest[:, 2] / 6, 0, 1))
    body.matrix_world = Matrix.Translation(place)
    worn = scene.points(shirt.data.vertices) * [1.05, 1.05, 0.5]
    own = Matrix.Rotation(turn, 4, "X") @ Matrix.Scale(scale, 4)
    shirt.matrix_world = Matrix.Translation(place) @ own
    back = worn @ np.linalg.inv(np.array(own)[:3, :3]).T
    shirt.data.vertices.foreach_set("co", back.astype(np.float32).ravel())
    bpy.context.view_layer.update()
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = body, shirt
    return body, shirt, worn, np.array(own)[:3, :3]


def test_clothes_follow_the_body_without_markers():
    _, shirt, worn, own = dressed()
    assert bpy.ops.lissom.transfer_keys(overlap=True) == {"FINISHED"}
    moved = (scene.key_points(shirt, "bulge") - scene.key_points(shirt, "Basis")) @ own.T
    expected = 0.2 * worn * [1, 1, 0] * np.exp(-(worn[:, 2:] ** 2))
    assert np.abs(moved - expected).max() < 0.1 * np.abs(expected).max()
    assert bpy.ops.lissom.transfer_attributes(overlap=True) == {"FINISHED"}
    assert_allclose(groups.weights(shirt, "bone"), 0.5 + worn[:, 2] / 6, atol=0.02)


def test_where_the_objects_are_counts():
    _, shirt, *_ = dressed()
    shirt.location.x += 5
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="0 % of the source and 0 % of the target lie on the other"):
        bpy.ops.lissom.transfer_fit(overlap=True)
    with pytest.raises(RuntimeError, match="need no markers"):
        bpy.ops.lissom.transfer_fit(overlap=True, markers='{"format": "lissom-markers"}')


def test_the_panel_asks_for_no_markers(panels):  # noqa: F811
    dressed()
    settings = bpy.context.scene.lissom_transfer
    bpy.ops.lissom.marker_add(source_vertex=3, target_vertex=5)
    assert "LISSOM_UL_markers" in draw(panels["transfer"])["classes"]
    settings.overlap = True
    drawn = draw(panels["transfer"])
    assert "LISSOM_UL_markers" not in drawn["classes"] and "lissom.marker_suggest" not in drawn["operators"]
    assert drawn["operators"]["lissom.transfer_keys"][0]["overlap"] is True
    assert drawn["operators"]["lissom.transfer_fit"][0]["overlap"] is True
    bpy.ops.lissom.transfer_fit(overlap=True)
    assert session.fit.pairs == [] and "Fit: " in text(draw(panels["transfer"]))
    assert bpy.ops.lissom.fit_show(show=True) == {"FINISHED"}


def test_the_command_line(tmp_path):
    dressed()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "in.blend"))
    words = ["transfer", "--source", "Body", "--target", "Shirt", "--overlap"]
    words += ["--file", str(tmp_path / "in.blend"), "--out", str(tmp_path / "out.blend")]
    assert commands.main(words) == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert "bulge" in bpy.data.objects["Shirt"].data.shape_keys.key_blocks
