"""``blender --command lissom inbetween``: the command itself, on files."""

import json

import bpy
import lissom
import numpy as np
import pytest
import scene
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.bridge import sheet
from bl_ext.user_default.lissom.core.work import Work
from numpy.testing import assert_allclose
from test_inbetween import keyed_tube, native_path, slide


@pytest.fixture
def file(tmp_path):
    """A file with the keyed tube, and an empty Blender."""
    keyed_tube()
    path = str(tmp_path / "in.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return path


def command(*words):
    return commands.main(["inbetween", *(str(word) for word in words)])


def test_it_bakes_what_the_panel_bakes_and_reports_it(file, tmp_path):
    out, report = tmp_path / "out.blend", tmp_path / "report.json"
    asked = ("--file", file, "--object", "Tube", "--start", "half", "--end", "full", "--tolerance", 0.05)
    assert command(*asked, "--rotation", "shortest", "--out", out, "--report", report) == 0
    told = json.loads(report.read_text())
    (arc,) = told["arcs"]
    assert (arc["slider"], arc["warnings"]) == ("full arc", [])
    assert (arc["easing"], arc["playback"]) == ("linear", "relative"), "as the arguments have them"
    assert (told["warnings"], told["errors"]) == ([], []) and told["seconds"] > 0
    bpy.ops.wm.open_mainfile(filepath=str(out))
    obj = bpy.data.objects["Tube"]
    path = native_path(obj, "half", "full", rotation="shortest")
    times = [key["time"] for key in arc["keys"]]
    assert_allclose([0, *times], path.keyframes(0.05), atol=2e-3)
    for time in times:
        slide(obj, "full arc", time)
        assert_allclose(scene.shown(obj), path.at([time])[0], atol=1e-4)


def test_an_arc_that_fails_leaves_the_others(file, tmp_path, capfd):
    out, report = tmp_path / "out.blend", tmp_path / "report.json"
    asked = ("--file", file, "--object", "Tube", "--end", "half", "none", "full", "--out", out)
    assert command(*asked, "--count", 1, "--report", report) == 3
    told = json.loads(report.read_text())
    arcs = told["arcs"]
    assert told["errors"] == [f"'none': {arcs[1]['error']}"]
    assert ["error" in arc for arc in arcs] == [False, True, False]
    assert "no shape key named 'none'" in arcs[1]["error"]
    assert "no shape key named 'none'" in capfd.readouterr().out
    bpy.ops.wm.open_mainfile(filepath=str(out))
    assert bpy.data.objects["Tube"].lissom_inbetween.arcs.keys() == ["half arc", "full arc"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--file", "none.blend"), "no file 'none.blend'"),
        (("--object", "none"), "no object named 'none'"),
        (("--end", "none"), "no shape key named 'none'"),
        (("--out", "no/folder/out.blend"), "--out: there is no folder"),
        (("--sheet", "sheet.tiff"), "end it in .png or .jpg"),
        (("--count", "0"), "--count: choose 1 to"),
        (("--tolerance", "-1"), "--tolerance: choose a distance"),
        (("--tolerance", "nan"), "--tolerance: choose a distance"),
        (("--steps", "1"), "--steps: choose"),
    ],
)
def test_bad_input_writes_no_file_and_ends_with_2(file, tmp_path, capfd, words, message):
    out = tmp_path / "out.blend"
    asked = ("--file", file, "--object", "Tube", "--end", "full", "--out", out)
    assert command(*asked, *words) == 2
    assert message in capfd.readouterr().out
    assert not out.exists()


def test_words_that_make_no_command_end_with_2(capfd):
    for words in ([], ["none"], ["inbetween", "--file", "x"], ["inbetween", "--count", "many"]):
        assert commands.main(words) == 2
    assert commands.main(["--help"]) == 0
    assert "Bake the arc" in capfd.readouterr().out


def test_row_40_a_cancelled_bake_writes_nothing_and_ends_with_130(file, tmp_path, monkeypatch):
    def cancelled(work):
        raise lissom.Cancelled("cancelled")

    monkeypatch.setattr(Work, "wait", cancelled)
    out = tmp_path / "out.blend"
    assert command("--file", file, "--object", "Tube", "--end", "full", "--out", out) == 130
    assert not out.exists()


@pytest.mark.parametrize("playback", ["relative", "absolute"])
def test_the_sheet_shows_both_ways_and_leaves_nothing_behind(file, tmp_path, monkeypatch, playback):
    picture, drawn = tmp_path / "sheet.png", []
    render = sheet.render

    def watched(obj, rows, *arguments, **options):
        drawn.extend(rows)
        before = [len(getattr(bpy.data, kind)) for kind in KINDS]
        render(obj, rows, *arguments, width=320, **options)
        assert before == [len(getattr(bpy.data, kind)) for kind in KINDS]

    monkeypatch.setattr(sheet, "render", watched)
    asked = ("--file", file, "--object", "Tube", "--start", "half", "--end", "full", "--count", 3)
    out = tmp_path / "out.blend"
    assert command(*asked, "--out", out, "--sheet", picture, "--steps", 5, "--playback", playback) == 0
    obj = bpy.data.objects["Tube"]
    ends = [scene.key_points(obj, name) for name in ("half", "full")]
    shapes = native_path(obj, "half", "full").at(np.linspace(0, 1, 5))
    (label, arc), (_, line) = drawn
    assert label == "full arc"
    assert_allclose([shape for _, shape in arc], shapes, atol=1e-4)
    assert_allclose(
        [shape for _, shape in line],
        [(1 - t) * ends[0] + t * ends[1] for t in np.linspace(0, 1, 5)],
        atol=1e-5,
    )
    assert [text for text, _ in arc] == ["0 %", "25 %", "50 %", "75 %", "100 %"]
    assert ink_per_tile(picture, rows=2, columns=5).min() > 0.02


KINDS = ("meshes", "objects", "materials", "worlds", "scenes", "curves", "cameras", "lights")


def ink_per_tile(picture, rows, columns):
    """(rows, columns): the part of each tile that is darker than the paper."""
    image = bpy.data.images.load(str(picture))
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, 4)[::-1, :, :3].mean(axis=2)
    assert width == 320
    dark = pixels < 0.75
    return np.array(
        [[tile.mean() for tile in np.array_split(row, columns, axis=1)] for row in np.array_split(dark, rows)]
    )
