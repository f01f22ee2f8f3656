"""In-between: a baked arc, exported to glTF and read back, plays within its tolerance of the path."""

import addon_utils
import bpy
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom.core import hat
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube, native_path
from test_inbetween_playback import bake, knots

TOLERANCE = 0.02
FRAMES = 25


@pytest.fixture(autouse=True)
def gltf():
    assert addon_utils.enable("io_scene_gltf2") is not None
    yield
    addon_utils.disable("io_scene_gltf2")


def round_trip(path, **settings):
    """The tube, exported and read into an empty file; positions are compared, so normals stay out."""
    file = str(path / "arc.glb")
    bpy.ops.export_scene.gltf(
        filepath=file, export_morph=True, export_morph_normal=False, export_normals=False, **settings
    )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable("io_scene_gltf2") is not None
    bpy.ops.import_scene.gltf(filepath=file)
    return next(obj for obj in bpy.data.objects if obj.type == "MESH")


def order(read, written):
    """For every vertex as written, its index as read: the file may hold them in another order."""
    distances = np.linalg.norm(written[:, None] - read[None], axis=2)
    nearest = distances.argmin(axis=1)
    assert distances.min(axis=1).max() < 1e-5
    return nearest


@pytest.mark.parametrize("start", ["", "half"])
def test_morph_targets_read_back_play_the_path_within_the_tolerance(tmp_path, start):
    obj = keyed_tube()
    path = native_path(obj, start or "Basis", "full")
    basis = scene.key_points(obj, "Basis")
    bake(start=start, sampling="TOLERANCE", tolerance=TOLERANCE)
    times, baked = knots(obj), [key.name for key in obj.lissom_inbetween.arcs["full arc"].keys]
    read = round_trip(tmp_path, export_animations=False)
    keys = read.data.shape_keys.key_blocks
    same = order(scene.key_points(read, keys[0].name), basis)
    worst = 0.0
    for time in np.linspace(0, 1, 51):
        weights = hat.weights(times, time)[0]
        for name, weight in zip(baked, weights[1:], strict=True):
            keys[name].value = weight
        if start:
            keys[start].value = 1.0
        off = np.linalg.norm(scene.shown(read)[same] - path.at([time])[0], axis=1)
        worst = max(worst, off.max())
    assert 0.5 * TOLERANCE < worst <= TOLERANCE
    print(f"{len(baked)} morph targets, at most {worst:.4f} from the path")


def test_an_animated_slider_is_exported_as_weights_that_play_the_path(tmp_path):
    obj = keyed_tube()
    path = native_path(obj, "Basis", "full")
    basis = scene.key_points(obj, "Basis")
    bake(sampling="TOLERANCE", tolerance=TOLERANCE)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        obj["full arc"] = value
        obj.keyframe_insert('["full arc"]', frame=frame)
    bpy.context.scene.frame_set(1)
    slider = [curve_value(obj, frame) for frame in range(1, FRAMES + 1)]
    rate = bpy.context.scene.render.fps
    read = round_trip(tmp_path, export_animations=True, export_animation_mode="SCENE")
    assert bpy.context.scene.render.fps == rate
    same = order(scene.key_points(read, read.data.shape_keys.key_blocks[0].name), basis)
    off, travelled = [], []
    for frame, time in enumerate(slider, start=1):
        bpy.context.scene.frame_set(frame)
        seen = scene.shown(read)[same]
        off.append(np.linalg.norm(seen - path.at([time])[0], axis=1).max())
        travelled.append(np.linalg.norm(seen - basis, axis=1).max())
    assert travelled[-1] > 1
    assert max(off) <= TOLERANCE
    assert_allclose(off[0], 0, atol=1e-5)


def curve_value(obj, frame):
    bpy.context.scene.frame_set(frame)
    return float(obj["full arc"])
