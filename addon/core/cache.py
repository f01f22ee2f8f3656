"""Point caches: the positions of all vertices at every sample, for Blender's Mesh Cache modifier.

PC2: a header of 32 bytes (12 characters, version, vertices, first frame, frames a sample, samples), then the
samples one after another, each (n, 3) single precision; all little-endian.
"""

import os
import struct

import numpy as np

MAGIC = b"POINTCACHE2\0"


def write(path, samples, first, step):
    """Writes (k, n, 3) positions, one sample every ``step`` frames from frame ``first`` on.

    The file appears whole or not at all: what was there stays until everything is written.
    """
    samples = np.asarray(samples)
    header = struct.pack("<12siiffi", MAGIC, 1, samples.shape[1], first, step, samples.shape[0])
    partial = f"{path}.part"
    try:
        with open(partial, "wb") as file:
            file.write(header)
            for sample in samples:
                file.write(np.ascontiguousarray(sample, dtype="<f4").tobytes())
        os.replace(partial, path)
    finally:
        if os.path.exists(partial):
            os.remove(partial)


def is_cache(path):
    """True where the file is a point cache of this kind."""
    with open(path, "rb") as file:
        return file.read(len(MAGIC)) == MAGIC
