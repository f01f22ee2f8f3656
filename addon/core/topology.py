"""A mesh's connectivity: its edges, and a hash, equal exactly when the faces are, whatever the positions."""

import hashlib

import numpy as np


def signature(vertex_count, corner_vertices, face_starts):
    """32 hex digits for (c,) vertex indices of the corners and (f,) first corners of the faces."""
    digest = hashlib.blake2b(str(vertex_count).encode(), digest_size=16)
    for array in (corner_vertices, face_starts):
        digest.update(np.ascontiguousarray(array, dtype=np.int32).tobytes())
        digest.update(b"|")
    return digest.hexdigest()


def edges(triangles):
    """(m, 2): the edges of (t, 3) triangles, each once, and (m,) how many triangles have it."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)


def joined(meshes):
    """One mesh of several."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    triangles = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(triangles)
