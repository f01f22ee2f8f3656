import numpy as np
from lissom_addon_core.transfer import Keys
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
