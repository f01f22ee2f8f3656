"""Marker files, and markers as points of a surface."""

import json
import os

import pytest
from lissom_addon_core import marker_file, markers
from lissom_addon_core.markers import Marker
from lissom_addon_core.refused import Refused
from lissom_addon_core.surface import Point

PAIRS = [Marker("tip of the nose", 1834, 92), Marker("Lid 'é' \"x\"", 0, 506)]


def text(**changes):
    document = {"format": "lissom-markers", "version": 1, "pairs": [{"name": "a", "source": 1, "target": 2}]}
    return json.dumps({**document, **changes})


def test_what_is_saved_is_loaded(tmp_path):
    path = tmp_path / "markers.json"
    marker_file.save(path, PAIRS, ("Face", 2000), ("Suzanne", 507))
    assert marker_file.load(path) == marker_file.MarkerFile(PAIRS, 2000, 507)


def test_the_file_is_plain_json_of_the_documented_form(tmp_path):
    document = json.loads(marker_file.dumps(PAIRS, ("Face", 2000), ("Suzanne", 507)))
    assert document == {
        "format": "lissom-markers",
        "version": 1,
        "source": {"name": "Face", "vertices": 2000},
        "target": {"name": "Suzanne", "vertices": 507},
        "pairs": [{"name": name, "source": a, "target": b} for name, a, b, *_ in PAIRS],
    }


def test_no_pairs_are_saved_and_loaded():
    assert marker_file.loads(marker_file.dumps([], ("a", 1), ("b", 2))).pairs == []


def test_a_name_may_be_missing():
    assert marker_file.loads(text(pairs=[{"source": 3, "target": 4}])).pairs == [Marker("Marker 1", 3, 4)]


def test_a_byte_order_mark_is_skipped(tmp_path):
    path = tmp_path / "markers.json"
    path.write_bytes(b"\xef\xbb\xbf" + text().encode())
    assert len(marker_file.load(path).pairs) == 1


@pytest.mark.parametrize(
    "content", ["2\n7106,6937\n0, 12\n", "7106:6937\n0:12", "# cat, lion\n7106 6937\n\n0\t12  # nose\n"]
)
def test_lists_of_published_codes_are_read(content):
    pairs = [Marker("Marker 1", 7106, 6937), Marker("Marker 2", 0, 12)]
    assert marker_file.loads(content) == marker_file.MarkerFile(pairs, None, None)


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
        marker_file.loads(content)


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
        marker_file.load(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 500 + len(str(path))


def test_row_41_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "markers.json"
    path.write_bytes(b'{"format": "\xff\xfe"}')
    with pytest.raises(Refused, match="byte 12 is not UTF-8"):
        marker_file.load(path)


def test_row_41_a_huge_file_is_refused_before_it_is_read_whole(tmp_path):
    path = tmp_path / "markers.json"
    path.touch()
    os.truncate(path, 2**40)  # sparse
    with pytest.raises(Refused, match="larger than 4 MiB"):
        marker_file.load(path)


@pytest.mark.parametrize("opening", ["[", '{"a":'])
def test_row_41_a_deep_file(opening):
    with pytest.raises(Refused, match="deeper than 16"):
        marker_file.loads(opening * 100_000)


def test_row_41_brackets_in_names_are_not_depth():
    assert (
        marker_file.loads(text(pairs=[{"name": "[" * 40, "source": 1, "target": 2}])).pairs[0].name
        == "[" * 40
    )


def test_row_41_too_many_pairs():
    with pytest.raises(Refused, match="holds 20001 entries"):
        marker_file.loads(text(pairs=[{"source": 1, "target": 2}] * 20_001))


def test_row_41_a_missing_file_a_folder_and_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "none.json", tmp_path, tmp_path / "pipe"):
        with pytest.raises(Refused, match="does not exist"):
            marker_file.load(path)


def test_row_28_two_pairs_on_one_vertex_are_named():
    pairs = [Marker("a", 1, 2), Marker("b", 3, 4), Marker("c", 5, 2)]
    with pytest.raises(Refused, match="'a' and 'c' lie on the same target vertex 2"):
        markers.check(pairs, 10, 10)
    points = [Point.of([1, 2, 3], weights) for weights in ([3, 2, 1], [3, 2, 1.1], [3, 2, 1])]
    pairs = [
        Marker.between(name, point, Point.at(i))
        for i, (name, point) in enumerate(zip("abc", points, strict=True))
    ]
    markers.check(pairs[:2], 10, 10)
    with pytest.raises(Refused, match="'a' and 'c' lie on the same point of the source"):
        markers.check(pairs, 10, 10)


def test_row_9_a_vertex_out_of_range_is_named_with_the_count():
    pairs = [Marker(f"m{i}", i, i) for i in range(8)]
    with pytest.raises(
        Refused, match=r"target mesh has 3 vertices.*'m3' at 3, 'm4' at 4, 'm5' at 5 ... \(5 in all\)"
    ):
        markers.check(pairs, 8, 3)
    markers.check(pairs, 8, 8)
    point = Marker.between("p", Point.of([1, 2, 9], [3, 2, 1]), Point.at(0))
    with pytest.raises(Refused, match="The source mesh has 8 vertices"):
        markers.check([point], 8, 8)


def test_places_and_symmetry_are_kept(tmp_path):
    pairs = [
        markers.Marker("nose", 1, 2, (0.1, -1.5, 1e-7), (3.0, 4.0, 5.0), False),
        markers.Marker("chin", 3, 4),
        Marker.between("ear", Point.of([5, 6, 7], [1, 2, 1.5]), Point.of([8, 9, 1], [0, 1, 1])),
        Marker.between("lip", Point.at(5), Point.of([8, 9, 1], [1, 1, 7]))._replace(
            source_place=(1.0, 2.0, 3.0), number=9
        ),
    ]
    path = tmp_path / "markers.json"
    marker_file.save(path, pairs, ("A", 10), ("B", 20))
    assert marker_file.load(path).pairs == pairs
    rows = path.read_text().splitlines()[-6:-2]
    assert ['"mirror"' in row for row in rows] == [True, False, False, False]
    assert ['"number"' in row for row in rows] == [False, False, False, True]
    assert '"source": 6, "target": 1, "source_point": [[5, 6, 7], [0.222223, 0.444444, 0.333333]]' in rows[2]
    assert '"source": 5' in rows[3] and "source_point" not in rows[3]


def test_a_file_of_points_is_read_by_vertices_where_points_are_not_known():
    """Releases before read "source" and "target" alone: these are the vertices that count most."""
    pair = Marker.between("ear", Point.of([5, 6, 7], [1, 2, 1.5]), Point.at(3))
    row = json.loads(marker_file.dumps([pair], ("A", 10), ("B", 20)))["pairs"][0]
    assert (row["source"], row["target"]) == (6, 3)


def test_pairs_keep_their_numbers_whatever_becomes_of_others():
    pairs = markers.numbered([Marker("a", 1, 1), Marker("b", 2, 2), Marker("c", 3, 3)])
    assert [pair.number for pair in pairs] == [1, 2, 3]
    assert markers.new_name(pairs) == "Marker 4"
    left = markers.numbered([*pairs[1:], Marker("d", 4, 4)])
    assert [(pair.name, pair.number) for pair in left] == [("b", 2), ("c", 3), ("d", 4)]
    twice = markers.numbered([left[0], left[0]._replace(name="e"), left[1]])
    assert [(pair.name, pair.number) for pair in twice] == [("b", 2), ("e", 4), ("c", 3)]
    assert markers.new_name([Marker("Marker 2", 1, 1)]) == "Marker 3"


@pytest.mark.parametrize(
    "spoiled",
    [
        '"source_place": [1, 2]',
        '"source_place": [1, 2, "3"]',
        '"target_place": [1, 2, 1e999]',
        '"target_place": 7',
        '"mirror": 1',
        '"number": -1',
        '"number": "3"',
        '"source_point": 7',
        '"source_point": [1, 2]',
        '"source_point": [[1, 2], [0.5, 0.5]]',
        '"source_point": [[1, 2, -3], [0.5, 0.3, 0.2]]',
        '"target_point": [[1, 2, 3], [0.5, 0.3, 0.1]]',
        '"target_point": [[1, 2, 3], [1.5, -0.3, -0.2]]',
        '"target_point": [[1, 2, 3], [1e999, 0, 0]]',
        '"target_point": [[1, 2, 3], [true, false, false]]',
    ],
)
def test_row_41_places_that_are_none(spoiled):
    text = f'{{"format": "lissom-markers", "version": 1, "pairs": [{{"source": 1, "target": 2, {spoiled}}}]}}'
    with pytest.raises(Refused, match='"pairs" entry 0: "'):
        marker_file.loads(text)
