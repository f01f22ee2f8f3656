"""The hash of a mesh's faces: what changes it, and what does not."""

import numpy as np
from lissom_addon_core import topology

CORNERS = np.array([0, 1, 2, 2, 1, 3])
STARTS = np.array([0, 3])


def test_row_26_equal_counts_but_other_faces_give_another_hash():
    turned = np.array([0, 1, 3, 0, 3, 2])
    assert topology.signature(4, turned, STARTS) != topology.signature(4, CORNERS, STARTS)


def test_a_further_loose_vertex_gives_another_hash():
    assert topology.signature(5, CORNERS, STARTS) != topology.signature(4, CORNERS, STARTS)


def test_faces_cut_elsewhere_give_another_hash():
    assert topology.signature(4, CORNERS, np.array([0, 2])) != topology.signature(4, CORNERS, STARTS)


def test_the_kind_of_integer_does_not_matter():
    assert topology.signature(4, CORNERS.astype(np.int32), STARTS) == topology.signature(4, CORNERS, STARTS)
