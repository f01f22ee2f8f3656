"""Sets of face keys go through glTF and FBX and come back with all their names and what they move."""

import addon_utils
import bpy
import numpy as np
import pytest
from lissom import names

FORMATS = {
    "io_scene_gltf2": ("face.glb", "export_scene.gltf", "import_scene.gltf", {"export_morph": True}),
    "io_scene_fbx": ("face.fbx", "export_scene.fbx", "import_scene.fbx", {}),
}

# EARFaceBlendShape of Unreal's AppleARKitFaceSupport, less turns of head and eyes; Perfect Sync has the same.
UNREAL = """
    EyeBlinkLeft EyeLookDownLeft EyeLookInLeft EyeLookOutLeft EyeLookUpLeft EyeSquintLeft EyeWideLeft
    EyeBlinkRight EyeLookDownRight EyeLookInRight EyeLookOutRight EyeLookUpRight EyeSquintRight EyeWideRight
    JawForward JawLeft JawRight JawOpen MouthClose MouthFunnel MouthPucker MouthLeft MouthRight
    MouthSmileLeft MouthSmileRight MouthFrownLeft MouthFrownRight MouthDimpleLeft MouthDimpleRight
    MouthStretchLeft MouthStretchRight MouthRollLower MouthRollUpper MouthShrugLower MouthShrugUpper
    MouthPressLeft MouthPressRight MouthLowerDownLeft MouthLowerDownRight MouthUpperUpLeft MouthUpperUpRight
    BrowDownLeft BrowDownRight BrowInnerUp BrowOuterUpLeft BrowOuterUpRight CheekPuff CheekSquintLeft
    CheekSquintRight NoseSneerLeft NoseSneerRight TongueOut
""".split()  # noqa: SIM905


def test_unreals_names_are_ours_but_for_the_first_letter():
    assert [name[0].lower() + name[1:] for name in UNREAL] == list(names.TABLES["ARKIT"])


@pytest.mark.parametrize("kind", ["ARKIT", "VRM", "VISEMES"])
@pytest.mark.parametrize("module", FORMATS)
def test_all_names_come_back(tmp_path, module, kind):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable(module) is not None
    file, write, read, settings = FORMATS[module]
    bpy.ops.lissom.source_face_add(names=kind)
    keys = bpy.context.object.data.shape_keys.key_blocks
    written, far = keys.keys()[1:], _far(keys)
    (of, write), (into, read) = write.split("."), read.split(".")
    getattr(getattr(bpy.ops, of), write)(filepath=str(tmp_path / file), **settings)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable(module) is not None
    getattr(getattr(bpy.ops, into), read)(filepath=str(tmp_path / file))
    obj = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    scale = obj.matrix_world.to_scale().x
    keys = obj.data.shape_keys.key_blocks
    assert keys.keys()[1:] == written
    np.testing.assert_allclose(_far(keys) * scale, far, atol=1e-4 * far.max())
    addon_utils.disable(module)


def _far(keys):
    """(k,) how far each key moves what it moves most."""
    places = np.empty((len(keys), 3 * len(keys[0].data)), dtype=np.float32)
    for row, key in zip(places, keys, strict=True):
        key.data.foreach_get("co", row)
    offsets = (places[1:] - places[0]).reshape(len(keys) - 1, -1, 3)
    return np.linalg.norm(offsets, axis=2).max(axis=1).astype(float)
