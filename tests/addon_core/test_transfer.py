"""Shapes of keys that are carried over, and what they are as deltas on the target."""

from types import SimpleNamespace

import lissom
import numpy as np
from lissom_addon_core.markers import Marker
from lissom_addon_core.transfer import Keys, doubts, told
from numpy.testing import assert_allclose, assert_array_equal

REST, SMILE, FIX = np.random.default_rng(0).normal(size=(3, 5, 3))
TARGET = np.random.default_rng(1).normal(size=(9, 3))


def carried(shapes):
    """Some map of whole shapes."""
    return np.array([TARGET + np.resize(shape - REST, (9, 3)) ** 2 for shape in shapes]).reshape(-1, 9, 3)


def test_every_distinct_shape_is_carried_over_once_and_the_rest_shape_never():
    keys = Keys(REST, [(SMILE, REST), (FIX, SMILE), (SMILE, REST)])
    assert_array_equal(keys.shapes, [SMILE, FIX])


def test_row_33_a_delta_counts_from_the_relative_key_on_the_target_too():
    keys = Keys(REST, [(SMILE, REST), (FIX, SMILE)])
    smile, fix = keys.deltas(TARGET, carried(keys.shapes))
    assert_allclose(TARGET + smile + fix, carried([FIX])[0], atol=1e-14)


def test_row_31_a_key_that_moves_nothing_has_a_delta_of_exactly_zero():
    keys = Keys(REST, [(REST, REST), (SMILE, SMILE.copy())])
    first, second = keys.deltas(TARGET, carried(keys.shapes))
    assert_array_equal(first, 0)
    assert_array_equal(second, 0)


def test_keys_that_move_nothing_leave_nothing_to_carry_over():
    assert Keys(REST, [(REST, REST)]).shapes.shape == (0, 5, 3)


def test_markers_and_curves_are_named_as_the_lists_have_them():
    lines = ["target: 2 slivers", "number 1 is off", "number 2 is off", "a", "b", "c"]
    fit = SimpleNamespace(
        doubtful_markers=np.array([1, 2]),
        doubtful_percents=np.array([9.04, 12]),
        doubtful_warnings=lines[1:3],
        doubtful_curves=np.array([2]),
        doubtful_curve_percents=np.array([7.06]),
        unmet_curves=np.array([0]),
        unmet_curve_percents=np.array([3.0]),
        reordered_curves=np.array([1]),
        curve_warnings=lines[3:],
        report={"warnings": lines},
    )
    markers = [Marker("chin", 0, 0), Marker(r"nose \1", 1, 1, number=7), Marker("ear", 2, 2)]
    said = told(fit, markers, False, ["lid", "lip", r"rim \1"])
    assert said[0] == "target: 2 slivers" and len(said) == 6
    assert said[1].startswith(r"curve 'rim \1' is 7.1 % of the target's size away from where the others put")
    assert said[2].startswith("curve 'lid' is met within 3.0 % of the target's size only")
    assert said[3].startswith("curve 'lip' has its markers in another order on the target")
    assert said[4].startswith(r"marker 7, 'nose \1', is 9.0 % of the target's size away")
    assert said[5].startswith("marker 3, 'ear', is 12.0 %")
    assert "left out" in doubts(fit, exact=False)[2] and "kept" in doubts(fit, exact=True)[2]


def test_doubts_are_told_once_and_by_name():
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 13)), axis=-1).reshape(-1, 2)
    vertices = np.column_stack([grid, 0.2 * np.sin(4 * grid[:, 0]) * np.cos(3 * grid[:, 1])])
    corner = np.arange(12 * 13).reshape(12, 13)[:, :12].ravel()
    faces = np.concatenate([corner[:, None] + [0, 1, 14], corner[:, None] + [0, 14, 13]])
    markers = np.repeat(np.arange(0, 169, 7)[:, None], 2, axis=1)
    markers[4, 1] = 160
    mesh = lissom.Mesh(vertices, faces)
    fit = lissom.fit_correspondence(mesh, mesh, markers)
    assert fit.doubtful_markers.tolist() == [4]
    assert "away from where the others put it" in doubts(fit, exact=False)[4]
    pairs = [Marker(f"Marker {number + 1}", *ends) for number, ends in enumerate(markers.tolist())]
    (line,) = told(fit, pairs, exact=False)
    assert line.startswith("marker 5, 'Marker 5', is ")
