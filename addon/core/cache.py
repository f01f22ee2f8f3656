"""Point caches: the positions of all vertices at every sample, for Blender's Mesh Cache modifier.

PC2: a header of 32 bytes (12 characters, version, vertices, first frame, frames a sample, samples), then the
samples one after another, each (n, 3) single precision; all little-endian.
"""

import contextlib
import os
import struct

import numpy as np

from .files import new_beside, take_place
from .refused import Refused

MAGIC = b"POINTCACHE2\0"


class Writer:
    """A cache that is written sample by sample, so that no more than one of them need be in memory.

    The file appears whole, by ``commit``, or not at all: what was there stays until then. As a context it
    discards what is written when left by an exception. Refused where the file cannot be written.
    """

    def __init__(self, path, vertices, samples, first, step):
        """``samples`` of ``vertices`` each, one every ``step`` frames from frame ``first`` on."""
        self.path, self._partial = path, None
        self._shape, self._left, self._file = (vertices, 3), samples, None
        self._header = struct.pack("<12siiffi", MAGIC, 1, vertices, first, step, samples)

    def __enter__(self):
        with self._telling():
            self._partial = new_beside(self.path)
            self._file = open(self._partial, "wb")
            self._file.write(self._header)
        return self

    def __exit__(self, kind, error, trace):
        if kind is not None:
            self.discard()

    def append(self, positions):
        """Writes the next sample, (n, 3); ValueError where it is of another shape."""
        sample = np.ascontiguousarray(positions, dtype="<f4")
        if sample.shape != self._shape or not self._left:
            raise ValueError(f"{self._left} samples of {self._shape} are left to write, given {sample.shape}")
        with self._telling():
            self._file.write(sample.tobytes())
        self._left -= 1

    def commit(self):
        """Puts the file in its place; ValueError where samples are missing."""
        if self._left:
            raise ValueError(f"{self._left} samples were not written")
        with self._telling():
            self._file.close()
            take_place(self._partial, self.path)
        self._file = None

    def discard(self):
        """Leaves nothing behind; does nothing after ``commit``."""
        if self._file is not None:
            self._file.close()
            self._file = None
            os.remove(self._partial)

    @contextlib.contextmanager
    def _telling(self):
        try:
            yield
        except OSError as error:
            if self._file is not None:
                with contextlib.suppress(OSError):  # closing writes what is left: the disk is full still
                    self.discard()
            raise Refused(f"'{self.path}' could not be written: {error.strerror}") from None


def write(path, samples, first, step):
    """Writes (k, n, 3) positions, one sample every ``step`` frames from frame ``first`` on.

    The file appears whole or not at all, as with Writer.
    """
    samples = np.asarray(samples)
    with Writer(path, samples.shape[1], samples.shape[0], first, step) as writer:
        for sample in samples:
            writer.append(sample)
        writer.commit()


def is_cache(path):
    """True where the file is a point cache of this kind that can be read."""
    if not os.path.isfile(path):  # a pipe or a device would block
        return False
    try:
        with open(path, "rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False
