"""A list of names of which some are ticked."""

import pytest
from lissom_addon_core.refused import Refused
from lissom_addon_core.ticks import ticked

KNOWN = ["a", "b", "c"]


def test_all_and_none():
    assert ticked(KNOWN, ["b"], "ALL", "") == KNOWN
    assert ticked(KNOWN, ["b"], "NONE", "") == []


def test_one_is_turned_and_those_that_are_gone_are_dropped():
    assert ticked(KNOWN, ["c", "gone"], "TOGGLE", "a") == ["a", "c"]
    assert ticked(KNOWN, ["a", "c"], "TOGGLE", "a") == ["c"]


def test_an_unknown_name_is_refused():
    with pytest.raises(Refused, match="no shape key named 'd' to tick"):
        ticked(KNOWN, [], "TOGGLE", "d")
