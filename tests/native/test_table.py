"""The table of docs/bad_input.md is complete, and every row of it is tested under its number."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROWS = [int(n) for n in re.findall(r"^\| (\d+) \|", (ROOT / "docs/bad_input.md").read_text(), re.M)]

# Rows that say something of every pose method, and are tested for each.
OF_EVERY_METHOD = {4, 7, 10, 11, 12, 13, 14, 15, 18, 21, 22, 23, 24, 38, 39}


def rows_in(paths) -> set[int]:
    """The numbers in names like test_row_7_slivers and rows_8_and_10."""
    text = "".join(path.read_text() for path in paths)
    names = re.findall(r"(?<![a-z])rows?_((?:\d+_(?:and_)?)+)", text)
    return {int(number) for name in names for number in re.findall(r"\d+", name)}


def test_no_row_is_missing():
    assert list(range(1, 45)) == ROWS


@pytest.mark.parametrize("row", ROWS)
def test_every_row_has_a_test(row):
    assert row in rows_in([*ROOT.glob("tests/*/*.py"), *ROOT.glob("rust/**/*.rs")])


def test_what_concerns_every_method_is_tested_for_each():
    assert rows_in([ROOT / "tests/native/test_pose_methods.py"]) >= OF_EVERY_METHOD
