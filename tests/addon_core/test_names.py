"""Names of keys: numbered, cut to Blender's length, left out."""

import pytest
from lissom_addon_core import names


def test_an_unused_name_stays():
    assert names.unused("smile", {"frown"}) == "smile"


def test_a_used_name_is_numbered_past_all_that_are_taken():
    assert names.unused("smile", {"smile", "smile.001", "smile.002"}) == "smile.003"


def test_a_long_name_is_cut_but_its_number_is_not():
    long = "x" * 80
    first = names.unused(long, set())
    second = names.unused(long, {first})
    assert len(first) == names.MAX_BYTES
    assert second == "x" * (names.MAX_BYTES - 4) + ".001"


def test_a_name_is_never_cut_inside_a_character():
    assert names.shorten("é" * 40) == "é" * 31


@pytest.mark.parametrize(
    ("exists", "expected"), [("UPDATE", "smile"), ("SKIP", None), ("RENAME", "smile.001")]
)
def test_row_32_a_name_that_is_taken(exists, expected):
    assert names.resolve("smile", {"smile"}, exists) == expected
    assert names.resolve("frown", {"smile"}, exists) == "frown"
