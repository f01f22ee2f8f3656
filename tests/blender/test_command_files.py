"""What the commands write takes the place of nothing else, and says so before anything is done."""

import itertools

import bpy
import lissom
import pytest
from bl_ext.user_default.lissom import commands
from bl_ext.user_default.lissom.core.refused import Refused

READS = {
    "transfer": ("file", "source-file", "markers"),
    "inbetween": ("file",),
    "image": ("file", "second"),
}
WRITES = {"transfer": ("out", "report", "cache"), "inbetween": ("out", "sheet", "report"), "image": ("out",)}
REST = {
    "transfer": ("--source", "Source", "--target", "Target", "--frames", "1", "2"),
    "inbetween": ("--object", "Cube", "--end", "key"),
    "image": ("--object", "Cube"),
}
CLASHES = [
    (command, written, other)
    for command, writes in WRITES.items()
    for written, other in itertools.product(writes, (*READS[command], *writes))
    if written != other and (written, other) != ("out", "file")
]


@pytest.fixture
def folder(tmp_path):
    """A file for every argument that reads one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file"))
    for name in ("source-file", "markers", "second"):
        (tmp_path / name).write_bytes(b"kept")
    return tmp_path


def words(command, folder, **paths):
    names = (*READS[command], *WRITES[command])
    paths = {name: str(folder / name) for name in names} | {n.replace("_", "-"): p for n, p in paths.items()}
    return [command, *REST[command], *(word for name in names for word in (f"--{name}", str(paths[name])))]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.exists()}


@pytest.mark.parametrize(("command", "written", "other"), CLASHES)
@pytest.mark.parametrize("how", ["same", "link", "detour"])
def test_a_file_takes_the_place_of_no_other(folder, capfd, command, written, other, how):
    path = folder / other
    if how == "link":
        path = folder / "link"
        path.symlink_to(folder / other)
    elif how == "detour":
        path = folder / ".." / folder.name / other
    before = contents(folder)
    assert commands.main(words(command, folder, **{written: path})) == 2
    said = capfd.readouterr().out
    assert "choose another" in said and f"--{written}" in said and f"--{other}" in said
    assert contents(folder) == before


@pytest.mark.parametrize("command", WRITES)
def test_a_device_is_not_replaced(folder, capfd, command):
    assert commands.main(words(command, folder, out="/dev/null")) == 2
    assert "no file that could be replaced" in capfd.readouterr().out


@pytest.mark.parametrize("command", WRITES)
def test_words_that_are_not_utf8_are_refused(folder, capfd, command):
    assert commands.main(words(command, folder, out=f"{folder}/caf\udce9.blend")) == 2
    assert "is not UTF-8" in capfd.readouterr().out


def test_saving_keeps_links_and_rights(folder):
    from bl_ext.user_default.lissom.commands import outputs

    kept, link = folder / "kept.blend", folder / "link.blend"
    kept.write_bytes(b"old")
    kept.chmod(0o640)
    link.symlink_to(kept)
    outputs.save(link)
    assert link.is_symlink() and kept.stat().st_mode & 0o777 == 0o640 and kept.read_bytes() != b"old"


@pytest.mark.parametrize("command", READS)
@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (lissom.Cancelled("cancelled"), 130, "Cancelled"),
        (KeyboardInterrupt(), 130, "Cancelled"),
        (lissom.SolveFailed("it overflows"), 2, "Error: it overflows"),
        (Refused("There is no face"), 2, "Error: There is no face"),
        (RuntimeError("Error: not a .blend\n"), 2, "Error: not a .blend"),
        (OSError("no space left"), 2, "Error: no space left"),
    ],
)
def test_all_commands_end_alike_by_what_goes_wrong(folder, capsys, monkeypatch, command, error, code, said):
    def fails(arguments):
        raise error

    monkeypatch.setattr(commands.COMMANDS[command], "run", fails)
    assert commands.main(words(command, folder)) == code
    assert capsys.readouterr().out.splitlines()[-1] == said
