"""Presets of the options: kept as files of Blender, and taken again by another mesh."""

import bpy
import pytest
import scene
from bl_ext.user_default.lissom.properties import presets
from test_panels import draw


@pytest.fixture(autouse=True)
def scripts(tmp_path, monkeypatch):
    """The user's scripts are in a folder of the test."""

    def user_resource(_, *, path="", create=False):
        made = tmp_path / path
        if create:
            made.mkdir(parents=True, exist_ok=True)
        return str(made)

    monkeypatch.setattr(bpy.utils, "user_resource", user_resource)
    monkeypatch.setattr(bpy.utils, "preset_paths", lambda subdir: [str(tmp_path / "presets" / subdir)])
    return tmp_path / "presets"


def kept(scripts, job, name):
    getattr(bpy.ops.lissom, f"preset_{job}")(name=name)
    (file,) = (scripts / "lissom" / job).glob("*.py")
    return file


def take(file, job):
    bpy.ops.script.execute_preset(filepath=str(file), menu_idname=f"LISSOM_MT_{job}_presets")


def test_a_pose_preset_is_taken_by_another_mesh(scripts):
    one, other = scene.tube(name="A"), scene.tube(name="B")
    bpy.context.view_layer.objects.active = one
    one.lissom_pose.method, one.lissom_pose.symmetry = "thin_shell", "X"
    one.lissom_pose.options.thin_shell.k_b = 7.5
    file = kept(scripts, "pose", "Cloth")
    bpy.context.view_layer.objects.active = other
    take(file, "pose")
    assert (other.lissom_pose.method, other.lissom_pose.symmetry) == ("thin_shell", "X")
    assert other.lissom_pose.options.thin_shell.k_b == 7.5
    assert bpy.types.LISSOM_MT_pose_presets.bl_label == "Cloth"
    bpy.types.LISSOM_MT_pose_presets.bl_label = "Presets"


def test_a_transfer_preset_keeps_no_names_of_one_mesh(scripts):
    settings = bpy.context.scene.lissom_transfer
    settings.match_distance, settings.edited, settings.source_mask = 0.07, "CARRY", "mouth"
    file = kept(scripts, "transfer", "Loose")
    assert "mouth" not in file.read_text()
    settings.match_distance, settings.edited, settings.source_mask = 0.02, "KEEP", "eyes"
    take(file, "transfer")
    assert settings.match_distance == pytest.approx(0.07)
    assert (settings.edited, settings.source_mask) == ("CARRY", "eyes")
    bpy.types.LISSOM_MT_transfer_presets.bl_label = "Presets"


def test_an_inbetween_preset_is_removed_again(scripts):
    obj = scene.tube()
    bpy.context.view_layer.objects.active = obj
    settings = obj.lissom_inbetween
    settings.count, settings.easing, settings.end = 9, "IN", "K"
    file = kept(scripts, "inbetween", "Slow Start")
    settings.count, settings.easing = 5, "LINEAR"
    take(file, "inbetween")
    assert (settings.count, settings.easing) == (9, "IN")
    assert "settings.end" not in file.read_text()
    bpy.ops.lissom.preset_inbetween(remove_active=True)
    assert not file.exists()
    bpy.types.LISSOM_MT_inbetween_presets.bl_label = "Presets"


def test_all_that_a_preset_sets_is_there():
    obj = scene.tube()
    roots = {"pose": obj.lissom_pose, "transfer": bpy.context.scene.lissom_transfer}
    roots["inbetween"] = obj.lissom_inbetween
    for job, (_, values) in presets.FILES.items():
        assert len(values) > 8
        for value in values:
            roots[job].path_resolve(value.removeprefix("settings."))


@pytest.mark.parametrize("job", ["pose", "transfer", "inbetween"])
def test_the_panels_offer_them(job):
    obj, other = scene.tube(name="A"), scene.tube(name="B")
    bpy.context.view_layer.objects.active = obj
    scene.add_key(obj, "K", scene.points(obj.data.vertices))
    settings = bpy.context.scene.lissom_transfer
    settings.source, settings.target = obj, other
    drawn = draw(getattr(bpy.types, f"LISSOM_PT_{job}"))
    assert f"LISSOM_MT_{job}_presets" in drawn["classes"]
    assert drawn["operators"][f"lissom.preset_{job}"] == [{}, {"remove_active": True}]
