"""How strong transferred keys are: kept when they are transferred again."""

import bpy
import numpy as np
import pytest
import scene
from numpy.testing import assert_allclose, assert_array_equal
from test_transfer import deltas
from test_transfer_corrections import edit, states, transferred

ROUNDED = 2e-6


def test_a_key_is_as_strong_as_it_is_told_also_when_transferred_again():
    source, target = transferred()
    plain, other = deltas(target, "squash"), deltas(target, "ears")
    bpy.ops.lissom.key_strength(object=target.name, keys="squash", strength=1.5)
    assert_allclose(deltas(target, "squash"), 1.5 * plain, atol=ROUNDED)
    assert_array_equal(deltas(target, "ears"), other)
    assert states(target) == ["WRITTEN", "WRITTEN"]
    row = source.data.shape_keys.key_blocks["squash"].data[40]
    row.co = np.array(row.co) + (0, 0, 0.1)
    bpy.ops.lissom.transfer_keys()
    again = deltas(target, "squash")
    bpy.ops.lissom.key_strength(object=target.name, keys="squash", strength=1.0)
    assert np.abs(deltas(target, "squash") - plain).max() > 1e-3, "the source was changed"
    assert_allclose(again, 1.5 * deltas(target, "squash"), atol=ROUNDED)
    assert_array_equal(deltas(target, "ears"), other)


def test_what_was_corrected_stays_on_top():
    _, target = transferred()
    plain = deltas(target, "squash")
    edit(target, "squash")
    bpy.ops.lissom.key_strength(object=target.name, every=True, strength=0.5)
    expected = 0.5 * plain
    expected[7] += (0.1, 0.0, 0.05)
    assert_allclose(deltas(target, "squash"), expected, atol=ROUNDED)
    assert states(target) == ["EDITED", "WRITTEN"]
    bpy.ops.lissom.transfer_keys(edited="OVERWRITE")
    assert_allclose(deltas(target, "squash"), 0.5 * plain, atol=ROUNDED)


def test_the_active_key_is_meant_where_none_is_told_and_renamed_ones_are_known():
    _, target = transferred()
    plain = deltas(target, "squash")
    keys = target.data.shape_keys.key_blocks
    keys["squash"].name = "flat"
    target.active_shape_key_index = keys.find("flat")
    bpy.ops.lissom.key_strength(object=target.name, strength=2.0)
    assert_allclose(deltas(target, "flat"), 2.0 * plain, atol=ROUNDED)


def test_what_no_transfer_wrote_or_is_locked_is_refused():
    _, target = transferred()
    scene.add_key(target, "mine", scene.key_points(target, "Basis") + 0.1)
    target.data.shape_keys.key_blocks["ears"].lock_shape = True
    before = scene.snapshot()
    for keys, said in {"mine": "No transfer wrote", "ears": "locked", "gone": "no shape key"}.items():
        with pytest.raises(RuntimeError, match=said):
            bpy.ops.lissom.key_strength(object=target.name, keys=keys, strength=2.0)
    assert scene.snapshot() == before
