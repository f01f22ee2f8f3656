"""What an artist has changed of a shape key since it was written, and the same change on another surface."""

import zlib

import numpy as np
from lissom import nearest_rotations

# Rounding that a key may go through without being edited: written, shifted along with its Basis, read.
NOISE = 8 * float(np.finfo(np.float32).eps)  # of the largest coordinate
ALIKE = 0.5  # of a key's own size: another within it is the same one under another name


def pack(offsets):
    """(n, 3) offsets as bytes in single precision; what rests takes next to nothing."""
    return zlib.compress(np.ascontiguousarray(offsets, dtype=np.float32).tobytes(), 1)


def unpack(packed):
    """What ``pack`` has packed; (0, 3) of nothing."""
    flat = np.frombuffer(zlib.decompress(packed), dtype=np.float32) if packed else np.zeros(0)
    return flat.reshape(-1, 3).astype(np.float64)


def differs(offsets, written, largest):
    """Whether (n, 3) offsets are others than those written, where coordinates are up to ``largest``."""
    return bool(np.any(np.abs(offsets - written) > NOISE * largest))


def alike(offsets, written):
    """How far (n, 3) offsets are from those written, as a part of these; None where they are others."""
    size = np.linalg.norm(written)
    away = np.linalg.norm(offsets - written)
    return away / size if size and away < ALIKE * size else None


def turned(correction, before, after, triangles):
    """(n, 3): a correction made on one shape of a surface, turned as the surface is in another.

    Each vertex turns as its neighbourhood does: by the rotation nearest to sum e' e^T over its edges e
    (Sorkine & Alexa 2007). ``before`` and ``after`` are (n, 3), ``triangles`` (m, 3).
    """
    moved = np.flatnonzero(correction.any(axis=1))
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = np.concatenate([ends, ends[:, ::-1]])
    place = np.full(len(correction), -1)
    place[moved] = np.arange(len(moved))
    ends = ends[place[ends[:, 0]] >= 0]
    old, new = (shape[ends[:, 1]] - shape[ends[:, 0]] for shape in (before, after))
    covariance = np.zeros((len(moved), 3, 3))
    np.add.at(covariance, place[ends[:, 0]], new[:, :, None] * old[:, None, :])
    result = np.zeros_like(correction)
    result[moved] = np.einsum("nij,nj->ni", nearest_rotations(covariance), correction[moved])
    return result
