"""Groups of vertices that can and cannot be handles."""

import numpy as np
import pytest
from lissom_addon_core.pose import check_groups
from lissom_addon_core.refused import Refused

GROUPS = {
    "hand": np.array([1, 2, 3]),
    "foot": np.array([7, 8]),
    "none": np.array([], dtype=int),
    "arm": np.array([3]),
}


@pytest.mark.parametrize(
    ("handles", "roi", "message"),
    [
        ([], "", "There is no handle"),
        (["hand", "tail"], "", "Vertex group 'tail' is missing"),
        (["hand"], "tail", "Vertex group 'tail' is missing"),
        (["none"], "", "'none' holds no vertices"),
        (["hand"], "none", "region's vertex group 'none' holds no vertices"),
        (["hand", "foot", "arm"], "", "'hand' and 'arm' share vertices 3:"),
    ],
)
def test_rows_19_23_and_25_groups_that_cannot_be_handles(handles, roi, message):
    with pytest.raises(Refused, match=message):
        check_groups(GROUPS, handles, roi)


def test_good_groups_pass():
    check_groups(GROUPS, ["hand", "foot"], "arm")
