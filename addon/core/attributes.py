"""Transfer of attributes: what a fit carries over, and weights as a skin needs them."""

from typing import NamedTuple

import lissom
import numpy as np

from .transfer import known_steps
from .work import Work

# Below this a weight moves nothing that one sees, and only costs a group at a vertex.
LEAST_WEIGHT = 1e-4


class Carried(NamedTuple):
    """What came over: ``points`` (n_target, k); ``corners``, an (m_target, 3, k) for each layer; warnings."""

    fit: object
    points: np.ndarray
    corners: list
    warnings: list


def attributes_work(source, target, fit, points, corners, faces):
    """Work whose result is a Carried.

    ``source`` and ``target`` are (vertices, triangles) in solve space, ``fit`` as in transfer_work.
    ``points`` (n_source, k) are values of vertices; ``corners`` layers (m_source, 3, k) of triangles'
    corners, each with seams of its own; ``faces`` (m_target,) says which polygon each target triangle is
    part of.
    """

    def steps():
        ends, known = yield from known_steps(source, target, fit)
        transfer = yield lissom.start_transfer(*ends, known)
        carried = yield transfer.start_attributes(points)
        found = Carried(known, carried, [], list(transfer.warnings))
        for layer in corners:
            made = yield transfer.start_corner_attributes(layer, faces)
            found.corners.append(made)
        return found

    return Work(steps())


def skin(weights, of_source):
    """(n_target, k) weights of groups as the source has them, from those carried over.

    No vertex is in more groups than any of ``of_source`` (n_source, k) is: the smallest weights go, then
    those below LEAST_WEIGHT. What is left is scaled to the sum that came over, which is 1 where the source's
    are.
    """
    weights = np.clip(weights, 0.0, None)
    sums = weights.sum(axis=1, keepdims=True)
    most = int(np.count_nonzero(of_source > 0, axis=1).max(initial=0))
    if 0 < most < weights.shape[1]:
        smallest = np.argpartition(-weights, most - 1, axis=1)[:, most:]
        np.put_along_axis(weights, smallest, 0.0, axis=1)
    weights[weights < LEAST_WEIGHT] = 0.0
    kept = weights.sum(axis=1, keepdims=True)
    scale = np.divide(sums, kept, out=np.ones_like(sums), where=kept > 0)
    return np.minimum(weights * scale, max(1.0, of_source.max(initial=0.0)))
