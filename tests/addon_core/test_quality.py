"""The table of quality: order, words, and faces as text."""

import dataclasses
import pathlib
from types import SimpleNamespace

import lissom
import numpy as np
from lissom_addon_core.quality import MEASURES, ORDERS, as_dict, badness, pack_faces, reasons, unpack_faces


def row(name, verdict="good", reasons="", faces="", **measures):
    known = {name: one.fine for name, one in MEASURES.items()} | measures
    return SimpleNamespace(name=name, verdict=verdict, reasons=reasons, faces=faces, **known)


ROWS = [
    row("fine"),
    row("rough", residual=0.2),
    row("weak", "look", "moves only 50 % as far as on the source", amplitude=0.5),
    row("bad", "bad", "12 triangles turned over\n3 triangles torn", flipped_triangles=12, torn_triangles=3),
    row("strong", "look", "moves 140 % as far as on the source", amplitude=1.4, residual=0.1),
]


def test_the_numbers_are_those_of_lissom_and_told_in_the_manual():
    known = [one.name for one in dataclasses.fields(lissom.Quality)]
    assert list(MEASURES) == [name for name in known if name not in ("verdict", "reasons", "faces")]
    assert set(ORDERS) <= {"verdict", *MEASURES}
    page = pathlib.Path(__file__).parents[2] / "docs" / "command_line.md"
    told = page.read_text(encoding="utf-8")
    assert not [name for name in MEASURES if f"`{name}`" not in told], f"missing in {page.name}"


def order(by):
    return [found.name for found in sorted(ROWS, key=lambda one: badness(one, by), reverse=True)]


def test_the_worst_come_first():
    assert order("verdict") == ["bad", "strong", "weak", "rough", "fine"]
    assert order("amplitude")[:2] == ["weak", "strong"]
    assert order("flipped_triangles")[0] == "bad"
    assert badness(row("bare", covered=0.4), "covered") > badness(ROWS[0], "covered")
    for name, (_, told, _) in ORDERS.items():
        assert all(told(one) for one in ROWS), name


def test_reasons_are_told_or_that_it_is_good():
    assert ORDERS["verdict"][1](ROWS[3]) == "12 triangles turned over"
    assert ORDERS["verdict"][1](ROWS[0]) == "Good"
    assert reasons(ROWS[3])[1] == "3 triangles torn"
    assert as_dict(ROWS[0])["reasons"] == [] and as_dict(ROWS[3])["flipped_triangles"] == 12


def test_faces_survive_as_text():
    text = pack_faces({"Head": np.array([3, 5]), "Eyes": np.array([], int), 'Öl "x"': np.array([0])})
    assert unpack_faces(text) == {"Head": [3, 5], 'Öl "x"': [0]}
    assert unpack_faces("") == unpack_faces(pack_faces({})) == {}
