"""Where a landmark is to be expected on a mesh, by those that it bears already."""

import numpy as np

from .face_parts import Frame
from .marker_places import diagonal

FEWEST = 2  # landmarks that tell: with the way out at each, there is a place, a turn and a size
NEAR, LEAST = 0.35, 0.05  # what to look at: so much of what the marks span, but of the mesh at least


def expected(wanted, marks, guides):
    """(3,): where a mesh should bear ``wanted``, or None where nothing tells.

    ``marks`` {name: (2, 3)} are places and normals of what it bears. Each of ``guides`` has the same of
    another mesh, or of a picture; the first that knows the landmark, and enough of those borne, is taken here
    by the similarity between what both bear and a point as far out of it as it spreads, along the mean
    normal: two places, or any on a line, would leave the turn about them open.
    """
    for guide in guides:
        shared = [name for name in marks if name in guide and name != wanted]
        if wanted not in guide or len(shared) < FEWEST:
            continue
        there, here = (_steadied(np.array([side[name] for name in shared])) for side in (guide, marks))
        if there is not None and here is not None:
            return Frame.of(there, here).there(guide[wanted][:1])[0]
    return None


def _steadied(marks):
    """(k + 1, 3): places of (k, 2, 3) marks, and one as far off along their mean normal as they spread."""
    places, normals = marks[:, 0], marks[:, 1].mean(axis=0)
    far, long = np.sqrt(places.var(axis=0).sum()), np.linalg.norm(normals)
    return np.r_[places, [places.mean(axis=0) + far * normals / long]] if far > 0 and long > 0 else None


def reach(places, whole):
    """Half the width of what to look at around one of (k, 3) marks, on a mesh whose diagonal is ``whole``."""
    return max(NEAR * diagonal(places), LEAST * whole)
