"""Point caches: the bytes of a PC2 file, and files that are left whole."""

import numpy as np
import pytest
from lissom_addon_core import cache
from lissom_addon_core.refused import Refused


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


def test_samples_are_written_one_by_one(tmp_path):
    samples = np.random.default_rng(1).normal(size=(3, 5, 3))
    whole, path = tmp_path / "whole.pc2", tmp_path / "a.pc2"
    cache.write(whole, samples, 7, 2)
    with cache.Writer(path, 5, 3, 7, 2) as writer:
        for sample in samples[:2]:
            writer.append(sample)
        with pytest.raises(ValueError, match="1 samples were not written"):
            writer.commit()
        with pytest.raises(ValueError, match="given"):
            writer.append(samples[2][:4])
        assert not path.exists()
        writer.append(samples[2])
        writer.commit()
        writer.discard()
    assert path.read_bytes() == whole.read_bytes()
    assert {file.name for file in tmp_path.iterdir()} == {"whole.pc2", "a.pc2"}


def test_a_writer_that_is_left_by_an_error_leaves_nothing(tmp_path):
    with pytest.raises(KeyError), cache.Writer(tmp_path / "a.pc2", 5, 3, 7, 2) as writer:
        writer.append(np.zeros((5, 3)))
        raise KeyError
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_written_is_refused(tmp_path):
    with (
        pytest.raises(Refused, match="could not be written"),
        cache.Writer(tmp_path / "no" / "a", 5, 3, 7, 2),
    ):
        pass
    (tmp_path / "folder").mkdir()
    with pytest.raises(Refused, match="could not be written"):
        cache.write(tmp_path / "folder", np.zeros((1, 5, 3)), 7, 2)
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]
