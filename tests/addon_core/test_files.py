"""Files that appear whole or not at all."""

import json
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lissom_addon_core import cache, files, marker_file


def test_an_error_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("good")
    with pytest.raises(ZeroDivisionError), files.replacing(path, "w") as file:
        file.write("half")
        raise ZeroDivisionError
    assert path.read_text() == "good" and [p.name for p in tmp_path.iterdir()] == ["a.json"]
    with files.replacing(path, "w") as file:
        file.write("new")
    assert path.read_text() == "new" and [p.name for p in tmp_path.iterdir()] == ["a.json"]


def test_a_cache_leaves_the_part_files_of_others(tmp_path):
    other = tmp_path / "x.pc2.part"
    other.write_text("of someone else")
    with pytest.raises(ValueError), cache.Writer(str(tmp_path / "x.pc2"), 3, 1, 1, 1) as writer:
        writer.append([[0, 0, 0]])
    assert other.read_text() == "of someone else" and list(tmp_path.iterdir()) == [other]


def test_row_41_a_megabyte_of_quotes_is_read_once():
    with pytest.raises(marker_file.Refused, match="not valid JSON"):
        marker_file.loads('{"format": "' + '\\"' * 500_000)
    with pytest.raises(marker_file.Refused, match="not valid JSON"):
        marker_file.loads('{"a": "' + "\\\\" * 500_000 + "\\")


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_a_link_stays_a_link_and_rights_stay(tmp_path, mode):
    path, link = tmp_path / "kept.json", tmp_path / "link.json"
    path.write_text("old")
    path.chmod(mode)
    link.symlink_to(path)
    with files.replacing(link, "w") as file:
        file.write("new")
    assert link.is_symlink() and path.read_text() == "new" and path.stat().st_mode & 0o777 == mode


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with files.replacing(pipe, "w") as file:
        file.write("told")
    assert os.read(reader, 10) == b"told" and pipe.is_fifo()
    os.close(reader)
    with pytest.raises(OSError, match="no file that could be replaced"):
        files.new_beside(pipe)
    assert pipe.is_fifo() and [p.name for p in tmp_path.iterdir()] == ["pipe"]


_NUMBERS = st.floats() | st.integers() | st.booleans() | st.none() | st.text() | st.floats().map(np.float64)


@settings(max_examples=200, deadline=None)
@given(st.recursive(_NUMBERS, lambda item: st.lists(item) | st.dictionaries(st.text(), item), max_leaves=20))
def test_a_report_is_json_whatever_the_numbers(tmp_path_factory, value):
    path = tmp_path_factory.mktemp("report") / "report.json"
    files.write_json(path, value)

    def no_constant(word):
        raise AssertionError(word)

    json.loads(path.read_text(encoding="utf-8"), parse_constant=no_constant)
