"""Offsets of shape keys as they were written, kept beside the mesh to tell what the artist has changed since.

A row of properties has ``offsets``, in single precision and compressed, and ``probes``, some vertices of the
Basis then: by these one tells that transforms of the object were applied since; offsets turn and scale along.
"""

import numpy as np

from ..core import corrections, space
from . import shape_keys

PROBES = 32


def keep(row, mesh, offsets):
    """Keeps (n, 3) offsets in the coordinates that the mesh has now."""
    row.offsets = corrections.pack(offsets)
    row.probes = corrections.pack(shape_keys.probes(mesh, PROBES))


def kept(row, mesh, packed=None):
    """(n, 3): the offsets of a row, or others packed with them, in the coordinates that the mesh has now."""
    before = corrections.unpack(row.probes)
    change = space.linear_change(before, shape_keys.probes(mesh, PROBES))
    return corrections.unpack(row.offsets if packed is None else packed) @ change.T


def offsets(key):
    """(n, 3): what a key adds to its relative key."""
    return shape_keys.shape(key) - shape_keys.shape(key.relative_key)


def is_edited(key, written):
    """Whether a key's offsets are others than those (n, 3) that were written."""
    largest = np.abs(shape_keys.shape(key)).max(initial=0.0)
    return corrections.differs(offsets(key), written, largest)
