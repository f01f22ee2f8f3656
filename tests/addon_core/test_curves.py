"""Selected edges as paths and loops, and curves in marker files."""

import json
import random
from itertools import pairwise

import pytest
from lissom_addon_core import curves, marker_file, markers
from lissom_addon_core.markers import Curve, Marker
from lissom_addon_core.refused import Refused


@pytest.mark.parametrize("seed", range(20))
def test_edges_in_any_order_become_the_path_or_loop_they_are(seed):
    chance = random.Random(seed)
    count, closed = chance.randint(3, 30), seed % 2 == 0
    path = chance.sample(range(1000), count)
    edges = list(pairwise(path)) + ([(path[-1], path[0])] if closed else [])
    chance.shuffle(edges)
    found = curves.ordered([edge[:: chance.choice((1, -1))] for edge in edges], "Face")
    assert len(found) == count + closed and (found[0] == found[-1]) == closed
    assert {frozenset(edge) for edge in edges} == {frozenset(edge) for edge in pairwise(found)}


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        ([], "No edges of 'Face' are selected"),
        ([(0, 1), (1, 2), (1, 3)], "branch at 1 vertices: 1"),
        ([(0, 1), (1, 2), (2, 0), (2, 3)], "branch at 1 vertices: 2"),
        ([(0, 1), (2, 3)], "several pieces, the first of 2 vertices of 4"),
        ([(0, 1), (2, 3), (3, 4), (4, 2)], "several pieces, the first of 2 vertices of 5"),
        ([(0, 1), (1, 2), (2, 0), (5, 6), (6, 7), (7, 5)], "several pieces, the first of 3 vertices of 6"),
    ],
)
def test_what_is_no_single_rim_is_refused(edges, message):
    with pytest.raises(Refused, match=message):
        curves.ordered(edges, "Face")


LID = Curve("lid", (4, 5, 9, 4), (7, 2, 3, 7), tuple((float(i), 0.5, 1.0) for i in range(4)))


def test_curves_are_saved_and_loaded_beside_pairs():
    pairs = [Marker("nose", 1, 2)]
    text = marker_file.dumps(pairs, ("Face", 10), ("Suzanne", 10), [LID])
    assert marker_file.loads(text) == marker_file.MarkerFile(pairs, 10, 10, [LID])
    assert "curves" not in marker_file.dumps(pairs, ("Face", 10), ("Suzanne", 10))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (3, '"curves" entry 1 must be an object'),
        ({"source": [1, 2]}, '"curves" entry 1: "target" must be a list of two vertex indices'),
        ({"source": [1], "target": [1, 2]}, '"source" must be a list of two vertex indices'),
        ({"source": [1, -2], "target": [1, 2]}, '"source" must be a list of two vertex indices'),
        ({"source": [1, True], "target": [1, 2]}, '"source" must be a list of two vertex indices'),
        ({"source": [1, 2], "target": [1, 2], "target_places": [[0, 0, 0]]}, '"target_places" must be three'),
        ({"source": [1, 2], "target": [1, 2], "name": 7}, '"curves" entry 1: "name" must be text'),
    ],
)
def test_row_41_a_malformed_curve_is_refused(row, message):
    document = {"format": "lissom-markers", "version": 1, "pairs": []}
    with pytest.raises(Refused, match=message):
        marker_file.loads(json.dumps({**document, "curves": [{"source": [1, 2], "target": [3, 4]}, row]}))
    with pytest.raises(Refused, match='"curves" must be a list'):
        marker_file.loads(json.dumps({**document, "curves": 3}))


def test_rows_9_and_28_curves_beyond_a_mesh_or_twice_are_named():
    other = LID._replace(name="other")
    markers.check_curves([LID, LID._replace(source=(1, 2), target=(3, 4))], 10, 10)
    with pytest.raises(Refused, match="Curves 'lid' and 'other' are the same on the source"):
        markers.check_curves([LID, other._replace(source=(5, 9, 4, 5))], 10, 10)
    with pytest.raises(Refused, match="target mesh has 7 vertices, which these curves go beyond: 'lid'"):
        markers.check_curves([LID], 10, 7)
