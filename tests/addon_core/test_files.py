"""Files that appear whole or not at all."""

import pytest
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
