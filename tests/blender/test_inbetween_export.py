"""In-between: arcs exported by the exporters' own defaults, and read back, play as the sliders do."""

import addon_utils
import bpy
import numpy as np
import pytest
import scene
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube
from test_inbetween_gltf import order

FRAMES = 12


def animated():
    """A tube with two arcs whose sliders are animated, one of them held half of the time."""
    obj = keyed_tube()
    bpy.ops.lissom.inbetween_bake_all(object=obj.name, count=4)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    for slider, frames in (("full arc", ((1, 0.0), (FRAMES, 1.0))), ("half arc", ((6, 0.0), (FRAMES, 0.3)))):
        for frame, value in frames:
            obj[slider] = value
            obj.keyframe_insert(f'["{slider}"]', frame=frame)
    return obj


def shown_at(obj):
    """(FRAMES, n, 3): what is seen at every frame."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scene.shown(obj))
    return np.array(found)


def test_keyframes_play_as_the_drivers_did_and_go_away_again():
    obj = animated()
    seen = shown_at(obj)
    bpy.context.scene.frame_set(3)
    names = obj.data.shape_keys.key_blocks.keys()
    bpy.ops.lissom.inbetween_export(object=obj.name)
    assert bpy.context.scene.frame_current == 3 and obj.lissom_inbetween.exported
    assert_allclose(shown_at(obj), seen, atol=2e-6)
    bpy.ops.lissom.inbetween_export(object=obj.name)  # again, after the slider was animated anew
    assert_allclose(shown_at(obj), seen, atol=2e-6)
    bpy.ops.lissom.inbetween_export(object=obj.name, restore=True)
    assert not obj.lissom_inbetween.exported and obj.data.shape_keys.key_blocks.keys() == names
    assert_allclose(shown_at(obj), seen, atol=1e-6)
    for value in (0.2, 0.9):
        bpy.context.scene.frame_set(1)
        obj["full arc"] = value
        obj.update_tag()
        bpy.context.view_layer.update()
        assert np.abs(scene.shown(obj) - seen[0]).max() > 0.01


def test_nothing_to_export_is_said():
    obj = keyed_tube()
    with scene.refused("has no arcs that export as relative keys"):
        bpy.ops.lissom.inbetween_export(object=obj.name)


def gltf(path):
    assert addon_utils.enable("io_scene_gltf2") is not None
    file = str(path / "arc.glb")
    bpy.ops.export_scene.gltf(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable("io_scene_gltf2") is not None
    bpy.ops.import_scene.gltf(filepath=file)


def fbx(path):
    assert addon_utils.enable("io_scene_fbx") is not None
    file = str(path / "arc.fbx")
    bpy.ops.export_scene.fbx(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable("io_scene_fbx") is not None
    bpy.ops.import_scene.fbx(filepath=file)


def usd(path):
    file = str(path / "arc.usdc")
    bpy.ops.wm.usd_export(filepath=file, export_animation=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=file)


@pytest.mark.parametrize("way", [gltf, fbx, usd])
def test_read_back_it_plays_the_arcs(tmp_path, way):
    obj = animated()
    seen = shown_at(obj)
    bpy.ops.lissom.inbetween_export(object=obj.name)
    way(tmp_path)
    read = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    bpy.context.scene.frame_set(1)
    world = np.array(read.matrix_world)

    def upright(points):
        return points @ world[:3, :3].T + world[:3, 3]

    back = np.array([upright(shape) for shape in shown_at(read)])
    same = order(back[0], seen[0])
    assert np.abs(seen[-1] - seen[0]).max() > 1
    assert_allclose(back[:, same], seen, atol=2e-4)
    addon_utils.disable("io_scene_gltf2")
    addon_utils.disable("io_scene_fbx")
