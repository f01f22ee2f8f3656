import json
import os

import pytest
from lissom_addon_core import markers
from lissom_addon_core.markers import Marker
from lissom_addon_core.refused import Refused

PAIRS = [Marker("tip of the nose", 1834, 92), Marker("Lid 'é' \"x\"", 0, 506)]


def text(**changes):
    document = {"format": "lissom-markers", "version": 1, "pairs": [{"name": "a", "source": 1, "target": 2}]}
    return json.dumps({**document, **changes})


def test_what_is_saved_is_loaded(tmp_path):
    path = tmp_path / "markers.json"
    markers.save(path, PAIRS, ("Face", 2000), ("Suzanne", 507))
    assert markers.load(path) == markers.MarkerFile(PAIRS, 2000, 507)


def test_the_file_is_plain_json_of_the_documented_form(tmp_path):
    document = json.loads(markers.dumps(PAIRS, ("Face", 2000), ("Suzanne", 507)))
    assert document == {
        "format": "lissom-markers",
        "version": 1,
        "source": {"name": "Face", "vertices": 2000},
        "target": {"name": "Suzanne", "vertices": 507},
        "pairs": [{"name": name, "source": a, "target": b} for name, a, b, *_ in PAIRS],
    }


def test_no_pairs_are_saved_and_loaded():
    assert markers.loads(markers.dumps([], ("a", 1), ("b", 2))).pairs == []


def test_a_name_may_be_missing():
    assert markers.loads(text(pairs=[{"source": 3, "target": 4}])).pairs == [Marker("Marker 1", 3, 4)]


def test_a_byte_order_mark_is_skipped(tmp_path):
    path = tmp_path / "markers.json"
    path.write_bytes(b"\xef\xbb\xbf" + text().encode())
    assert len(markers.load(path).pairs) == 1


@pytest.mark.parametrize(
    "content", ["2\n7106,6937\n0, 12\n", "7106:6937\n0:12", "# cat, lion\n7106 6937\n\n0\t12  # nose\n"]
)
def test_lists_of_published_codes_are_read(content):
    pairs = [Marker("Marker 1", 7106, 6937), Marker("Marker 2", 0, 12)]
    assert markers.loads(content) == markers.MarkerFile(pairs, None, None)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("3\n1,2\n3,4", "promises 3 pairs and has 2"),
        ("1,2\n3", "line 2 is no pair of vertices: '3'"),
        ("1,2,3", "line 1 is no pair"),
        ("1:2\n-3:4", "line 2 is no pair"),
        ("1:2\n3:4294967296", "line 2 is no pair"),
        ("1:2\n" * 20_001, "more than 20000 pairs"),
        ("9" * 100, "line 1 is no pair"),
    ],
)
def test_row_41_lists_that_are_none(content, message):
    with pytest.raises(Refused, match=message):
        markers.loads(content)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "not valid JSON"),
        ("{", "not valid JSON"),
        ('{"a": "[[[', "not valid JSON"),
        ("[]", '"format" must be'),
        ("null", '"format" must be'),
        (text(format="other"), '"format" must be'),
        (text(version=2), "update Lissom"),
        (text(version=0), "update Lissom"),
        (text(version=True), "update Lissom"),
        (text(version="1"), "update Lissom"),
        (text(pairs={}), '"pairs" must be a list'),
        (text(pairs=[[1, 2]]), "entry 0 must be an object"),
        (text(pairs=[{"source": 1, "target": 2}, {"source": 1}]), 'entry 1: "target" must be a vertex index'),
        (text(pairs=[{"source": -1, "target": 2}]), 'entry 0: "source" must be'),
        (text(pairs=[{"source": 1.5, "target": 2}]), 'entry 0: "source" must be'),
        (text(pairs=[{"source": True, "target": 2}]), 'entry 0: "source" must be'),
        (text(pairs=[{"source": 2**40, "target": 2}]), 'entry 0: "source" must be'),
        (text(pairs=[{"name": 7, "source": 1, "target": 2}]), 'entry 0: "name" must be text'),
        (text().replace("2}", "NaN}"), "NaN is not a number"),
        (text().replace("2}", "9" * 5000 + "}"), "not valid JSON"),
    ],
)
def test_row_41_a_malformed_file(content, message, tmp_path):
    path = tmp_path / "markers.json"
    path.write_text(content)
    with pytest.raises(Refused, match=message) as caught:
        markers.load(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 500 + len(str(path))


def test_row_41_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "markers.json"
    path.write_bytes(b'{"format": "\xff\xfe"}')
    with pytest.raises(Refused, match="byte 12 is not UTF-8"):
        markers.load(path)


def test_row_41_a_huge_file_is_refused_before_it_is_read_whole(tmp_path):
    path = tmp_path / "markers.json"
    path.touch()
    os.truncate(path, 2**40)  # sparse
    with pytest.raises(Refused, match="larger than 4 MiB"):
        markers.load(path)


@pytest.mark.parametrize("opening", ["[", '{"a":'])
def test_row_41_a_deep_file(opening):
    with pytest.raises(Refused, match="deeper than 16"):
        markers.loads(opening * 100_000)


def test_row_41_brackets_in_names_are_not_depth():
    assert markers.loads(text(pairs=[{"name": "[" * 40, "source": 1, "target": 2}])).pairs[0].name == "[" * 40


def test_row_41_too_many_pairs():
    with pytest.raises(Refused, match="holds 20001 entries"):
        markers.loads(text(pairs=[{"source": 1, "target": 2}] * 20_001))


def test_row_41_a_missing_file_a_folder_and_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "none.json", tmp_path, tmp_path / "pipe"):
        with pytest.raises(Refused, match="does not exist"):
            markers.load(path)


def test_row_28_two_pairs_on_one_vertex_are_named():
    pairs = [Marker("a", 1, 2), Marker("b", 3, 4), Marker("c", 5, 2)]
    with pytest.raises(Refused, match="'a' and 'c' lie on the same target vertex 2"):
        markers.check(pairs, 10, 10)


def test_row_9_a_vertex_out_of_range_is_named_with_the_count():
    pairs = [Marker(f"m{i}", i, i) for i in range(8)]
    with pytest.raises(
        Refused, match=r"target mesh has 3 vertices.*'m3' at 3, 'm4' at 4, 'm5' at 5 ... \(5 in all\)"
    ):
        markers.check(pairs, 8, 3)
    markers.check(pairs, 8, 8)


def test_places_and_symmetry_are_kept(tmp_path):
    pairs = [
        markers.Marker("nose", 1, 2, (0.1, -1.5, 1e-7), (3.0, 4.0, 5.0), False),
        markers.Marker("chin", 3, 4),
    ]
    path = tmp_path / "markers.json"
    markers.save(path, pairs, ("A", 10), ("B", 20))
    assert markers.load(path).pairs == pairs
    assert '"mirror"' not in path.read_text().splitlines()[-3]


@pytest.mark.parametrize(
    "spoiled",
    [
        '"source_place": [1, 2]',
        '"source_place": [1, 2, "3"]',
        '"target_place": [1, 2, 1e999]',
        '"target_place": 7',
        '"mirror": 1',
    ],
)
def test_row_41_places_that_are_none(spoiled):
    text = f'{{"format": "lissom-markers", "version": 1, "pairs": [{{"source": 1, "target": 2, {spoiled}}}]}}'
    with pytest.raises(Refused, match='"pairs" entry 0: "'):
        markers.loads(text)
