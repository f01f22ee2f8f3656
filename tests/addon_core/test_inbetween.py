"""Stops of an arc, as the artist writes them."""

import pytest
from lissom_addon_core.inbetween import stops
from lissom_addon_core.refused import Refused


def test_stops_are_read_in_the_order_of_their_times():
    assert stops("") == []
    assert stops(" wide : 0.75, half: 0.5,a:b:.25 ") == [("a:b", 0.25), ("half", 0.5), ("wide", 0.75)]


@pytest.mark.parametrize(
    "text",
    [
        "half",
        "half: soon",
        ": 0.5",
        "half: 0",
        "half: 1",
        "half: nan",
        "half: 1e-5",
        "half: 0.99999",
        "a: 0.5, b",
    ],
)
def test_what_is_no_stop_is_named(text):
    with pytest.raises(Refused, match="is not a shape key and a time between 0 and 1"):
        stops(text)


def test_two_stops_at_one_time():
    with pytest.raises(Refused, match="'a' and another key have the same time"):
        stops("a: 0.5, b: 0.50")
    with pytest.raises(Refused, match="'a' and another key have the same time"):
        stops("b: 0.50005, a: 0.5")
