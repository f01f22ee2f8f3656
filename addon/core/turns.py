"""Whole turns of a handle: its matrix tells at most half a turn, how it came there tells all of them.

A turn is told by a rotation vector, axis times angle, that is right to within half a turn; the native module
lifts the matrix's own rotation to the branch nearest to it.
"""

import numpy as np
from lissom import nearest_rotations, rotation_vectors

# Beside a channel that has gone through more than half a turn, others may have gone this far. Further, and
# the same matrix has several equally good stories.
ASIDE = np.pi / 2

# A rotation vector and what it was lifted to are the same story up to this angle.
NEAR = np.pi / 2

# Less, of the object's size or in radians, is what single precision makes of an Empty that nobody touched.
MOVED = 1e-4
UNTURNED = 1e-4

# Channels tell the turns of an Empty where they explain its rotation to within this angle: not where a
# constraint or another parent turns it.
EXPLAINED = 0.05


def only_moved(transforms, origins, extent):
    """(h,) bool: the handles that were moved and not turned since Bind.

    ``transforms`` (h, 4, 4) lead from rest to posed in solve space, ``origins`` (h, 3) are where the Empties
    stood, ``extent`` is the size of the object.
    """
    moves = np.einsum("hij,hj->hi", transforms[:, :3, :3], origins) + transforms[:, :3, 3] - origins
    turned = np.linalg.norm(rotation_vectors(nearest_rotations(transforms[:, :3, :3])), axis=1)
    return (np.linalg.norm(moves, axis=1) > MOVED * extent) & (turned < UNTURNED)


def along(path):
    """(3,): how far rotations (k, 3, 3), each near the one before, turn from the first to the last."""
    return rotation_vectors(path[1:] @ np.swapaxes(path[:-1], -1, -2)).sum(axis=0)


def is_told_by_angles(change):
    """True where three angles that change so have one story: one of them has done more than half a turn."""
    size = np.sort(np.abs(change))
    return bool(size[2] > np.pi and size[1] <= ASIDE)


def explained(path, placed, rotation):
    """(3,): the turn along ``path`` (k, 3, 3), or None where that is not how ``rotation`` (3, 3) came about.

    ``placed`` (3, 3) is the linear map from the space of the path to that of the rotation.
    """
    u, _, vt = np.linalg.svd(placed)
    frame = u @ vt  # a reflection where the object is mirrored
    led_to = nearest_rotations(placed @ path[-1] @ path[0].T @ np.linalg.inv(placed))
    off = rotation_vectors(rotation @ led_to.T)
    return along(frame @ path @ frame.T) if np.linalg.norm(off) <= EXPLAINED else None


def follow(near, rotation):
    """(3,): the turn of a rotation (3, 3) that has just been at about ``near`` (3,)."""
    lifted = rotation_vectors(rotation, near)
    # Near whole turns the matrix says nothing of their axis.
    return lifted if np.linalg.norm(lifted - near) <= NEAR else near


class Tracker:
    """Turns of several handles, from what their channels tell, else from one look to the next."""

    def __init__(self):
        self._last = None

    def turns(self, transforms, told):
        """(h, 3) for the matrices (h, 4, 4) of now, or None where those tell all.

        ``told`` has for each handle what its channels tell (3,), or None.
        """
        rotations = nearest_rotations(transforms[:, :3, :3])
        own = rotation_vectors(rotations)
        turns = np.empty_like(own)
        for h, rotation in enumerate(rotations):
            if told[h] is not None:
                turns[h] = told[h]
            elif self._last is not None:
                before, turned = self._last
                turns[h] = follow(turned[h] + rotation_vectors(rotation @ before[h].T), rotation)
            else:
                turns[h] = own[h]
        self._last = rotations, turns
        return turns if np.linalg.norm(turns, axis=1).max(initial=0.0) > np.pi + 1e-6 else None
