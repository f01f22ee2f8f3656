"""``blender --command lissom transfer``: the command itself, on files."""

import json

import bpy
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.core.marker_file import save
from bl_ext.user_default.lissom.core.markers import Marker
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import deltas, monkeys


@pytest.fixture
def files(tmp_path):
    """Files of the source, of the target and of their markers; what the operator makes of them."""
    source, target = monkeys()
    markers = [Marker(row.name, row.source, row.target) for row in bpy.context.scene.lissom_transfer.markers]
    save(
        tmp_path / "markers.json",
        markers,
        (source.name, len(source.data.vertices)),
        (target.name, len(target.data.vertices)),
    )
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "both.blend"))
    bpy.ops.lissom.transfer_keys()
    expected = {name: deltas(target, name) for name in ("squash", "ears")}
    target.shape_key_clear()
    bpy.data.objects.remove(source)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "target.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return tmp_path, expected


def command(*words):
    return commands.main(["transfer", "--source", "Source", "--target", "Target", *map(str, words)])


def test_it_transfers_what_the_panel_transfers(files):
    folder, expected = files
    out, report = folder / "out.blend", folder / "report.json"
    markers = ("--markers", folder / "markers.json")
    assert command("--file", folder / "both.blend", *markers, "--out", out, "--report", report) == 0
    said = json.loads(report.read_text())
    assert said["keys"] == ["squash", "ears"] and said["errors"] == said["warnings"] == []
    assert said["certainty"] == said["fit"]["certainty"] == 1 and said["seconds"] > 0
    assert said["fit"]["distance_mean_percent"] < 1
    bpy.ops.wm.open_mainfile(filepath=str(out))
    for name, delta in expected.items():
        assert_array_equal(deltas(bpy.data.objects["Target"], name), delta)


def test_the_source_may_come_from_another_file(files):
    folder, expected = files
    out, report = folder / "out.blend", folder / "report.json"
    asked = ("--file", folder / "target.blend", "--source-file", folder / "both.blend")
    asked += ("--markers", folder / "markers.json", "--keys", "ears", "none", "--out", out)
    assert command(*asked, "--report", report) == 3
    assert json.loads(report.read_text())["errors"] == ["'Source' has no shape key named 'none'"]
    bpy.ops.wm.open_mainfile(filepath=str(out))
    assert bpy.data.objects.keys() == ["Target"]
    target = bpy.data.objects["Target"]
    assert target.data.shape_keys.key_blocks.keys() == ["Basis", "ears"]
    assert_array_equal(deltas(target, "ears"), expected["ears"])


def test_without_markers_the_shapes_tell(files):
    folder, _ = files
    bpy.ops.wm.open_mainfile(filepath=str(folder / "both.blend"))
    bpy.ops.lissom.marker_clear()
    bpy.ops.wm.save_mainfile()
    report = folder / "report.json"
    asked = ("--file", folder / "both.blend", "--out", folder / "out.blend", "--report", report)
    assert command(*asked) == 0
    said = json.loads(report.read_text())
    assert 0.5 < said["fit"]["certainty"] < 1 and said["doubtful_markers"] == []
    assert said["fit"]["distance_mean_percent"] < 1


def test_markers_out_of_place_are_reported(files):
    folder, _ = files
    path, report = folder / "markers.json", folder / "report.json"
    document = json.loads(path.read_text())
    pairs = document["pairs"]
    wrong = pairs[2]["source"]
    pairs[2]["target"], pairs[20]["target"] = pairs[20]["target"], pairs[2]["target"]
    path.write_text(json.dumps(document))
    asked = ("--file", folder / "both.blend", "--markers", path, "--out", folder / "out.blend")
    assert command(*asked, "--report", report) == 0
    said = json.loads(report.read_text())
    assert said["fit"]["certainty"] == 1
    doubtful = {row["source"]: row for row in said["doubtful_markers"]}
    assert set(doubtful) == {wrong, pairs[20]["source"]}
    assert doubtful[wrong]["name"] == pairs[2]["name"]
    assert "away from where the others put it" in doubtful[wrong]["reason"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--file", "none.blend"), "--file: there is no file 'none.blend'"),
        (("--file", "both.blend", "--markers", "none.json"), "--markers: there is no file"),
        (("--file", "both.blend", "--keys", "none"), "has none of these shape keys: none"),
        (("--file", "target.blend"), "There is no object named 'Source'"),
        (("--file", "target.blend", "--source-file", "target.blend"), "There is no object named 'Source'"),
        (("--file", "both.blend", "--match-distance", "0"), "--match-distance"),
        (("--file", "both.blend", "--marker-tolerance", "-1"), "--marker-tolerance"),
        (("--file", "both.blend", "--tightness", "0"), "--tightness"),
        (("--file", "both.blend", "--target", "a\nb"), "there is a line break in this name"),
    ],
)
def test_bad_input_writes_nothing(files, words, message, capfd, monkeypatch):
    folder, _ = files
    monkeypatch.chdir(folder)
    assert command(*words, "--out", folder / "out.blend", "--report", folder / "report.json") == 2
    assert message in capfd.readouterr().out
    assert not (folder / "out.blend").exists() and not (folder / "report.json").exists()


def test_row_41_a_marker_file_that_is_none(files, capfd):
    folder, _ = files
    (folder / "markers.json").write_text('{"format": "lissom-markers", "version": 1, "pairs": [[[')
    asked = ("--file", folder / "both.blend", "--markers", folder / "markers.json")
    assert command(*asked, "--out", folder / "out.blend") == 2
    assert "Error: " in capfd.readouterr().out


def test_a_word_that_is_none(capfd):
    assert commands.main(["transfer", "--file", "a.blend"]) == 2
    assert "required" in capfd.readouterr().err
    assert scene.snapshot()["scene"] == []


def test_single_keys_may_be_stronger_and_stay_so(files, capsys):
    folder, expected = files
    out, again = folder / "out.blend", folder / "again.blend"
    asked = ("--file", folder / "both.blend", "--markers", folder / "markers.json")
    assert command(*asked, "--strengths", "squash=0.5", "tail=2", "--out", out) == 3
    assert "no object has a shape key named 'tail'" in capsys.readouterr().out
    assert command("--file", out, "--markers", folder / "markers.json", "--out", again) == 0
    for path in (out, again):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        target = bpy.data.objects["Target"]
        assert_allclose(deltas(target, "squash"), 0.5 * expected["squash"], atol=1e-6)
        assert_array_equal(deltas(target, "ears"), expected["ears"])


@pytest.mark.parametrize(
    "told", ["squash", "squash=", "squash=much", "=1", "squash=0", "squash=11", "squash=nan"]
)
def test_strengths_that_are_none_are_refused_before_anything_is_done(files, told, capsys):
    folder, _ = files
    out = folder / "out.blend"
    assert command("--file", folder / "both.blend", "--strengths", told, "--out", out) == 2
    assert f"'{told}'" in capsys.readouterr().out and not out.exists()
