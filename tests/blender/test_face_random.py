"""What Face Keys promises, on random stylised heads; more of them by ``bench/face.py random``."""

import bpy
import pytest
import random_heads
import scene
from bl_ext.user_default.lissom.core.face_found import Unsure
from bl_ext.user_default.lissom.jobs.face import FaceAsked, FaceKeys


@pytest.mark.parametrize("seed", scene.by_turns([4, 7, 12]))
def test_random_heads_get_keys_without_a_click_that_are_as_promised(seed):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    drawn = random_heads.drawn(seed)
    scene.mesh_object("Head", drawn.vertices, drawn.triangles)
    parts = [scene.mesh_object("Eye", *part).name for part in drawn.parts]
    found = FaceKeys(bpy.context, FaceAsked(target="Head", parts="\n".join(parts))).work.wait()
    assert not isinstance(found, Unsure), drawn.told
    assert random_heads.broken(drawn, dict(zip(found.names, found.offsets, strict=True))) == [], drawn.told


def test_without_eyeballs_no_key_is_made_silently():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    drawn = random_heads.drawn(7)
    scene.mesh_object("Head", drawn.head.vertices, drawn.head.triangles)
    found = FaceKeys(bpy.context, FaceAsked(target="Head")).work.wait()
    assert isinstance(found, Unsure)
