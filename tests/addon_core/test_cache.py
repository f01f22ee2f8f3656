import numpy as np
import pytest
from lissom_addon_core import cache


def test_a_cache_is_what_the_format_says(tmp_path):
    path = tmp_path / "a.pc2"
    samples = np.random.default_rng(0).normal(size=(3, 5, 3))
    cache.write(path, samples, 7, 2)
    data = path.read_bytes()
    assert data[:12] == b"POINTCACHE2\0" and cache.is_cache(path)
    assert np.frombuffer(data[12:20], "<i4").tolist() == [1, 5]
    assert np.frombuffer(data[20:28], "<f4").tolist() == [7, 2]
    assert np.frombuffer(data[28:32], "<i4").tolist() == [3]
    np.testing.assert_array_equal(np.frombuffer(data[32:], "<f4").reshape(3, 5, 3), samples.astype("f4"))


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.pc2"
    cache.write(path, np.zeros((1, 2, 3)), 0, 1)
    before = path.read_bytes()
    with pytest.raises(ValueError):
        cache.write(path, np.array([[["a", "b", "c"]] * 2]), 0, 1)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["a.pc2"]
