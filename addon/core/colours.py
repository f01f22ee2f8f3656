"""What a fit looks like: a colour for every vertex of both sides."""

import numpy as np

from .faults import TORN

GOOD, DOUBTFUL, BAD = (0.16, 0.42, 0.75), (0.95, 0.85, 0.25), (0.85, 0.12, 0.08)
WRONG = (0.85, 0.10, 0.75)
UNMATCHED = (0.22, 0.22, 0.24)
LIMIT = 0.005  # of the target's diagonal: from here on a vertex is shown as bad

LEGEND = (
    "Blue: on the other surface. Yellow to red: off it by up to {limit:.2g} % of its size. "
    "Magenta: folded or torn. Dark: matches nothing"
)


def of_distances(distances, limit):
    """(n, 4) colours, from good at 0 over doubtful to bad at ``limit``; NaN is unmatched."""
    share = np.clip(np.nan_to_num(distances) / limit, 0, 1)[:, None]
    low, middle, high = (np.array(colour) for colour in (GOOD, DOUBTFUL, BAD))
    colours = np.where(
        share < 0.5, low + (middle - low) * 2 * share, middle + (high - middle) * (2 * share - 1)
    )
    colours[np.isnan(distances)] = UNMATCHED
    return np.column_stack([colours, np.ones(len(colours))]).astype(np.float32)


def of_fit(fit, triangles, diagonal, limit):
    """Colours (n_source, 4) and (n_target, 4): how far each vertex is from the other side.

    ``triangles`` (m, 3) are the source's; ``limit`` is a fraction of the target's ``diagonal``.
    """
    source = of_distances(fit.distances, limit * diagonal)
    wrong = np.union1d(fit.flipped, np.flatnonzero(fit.distortion > TORN))
    source[triangles[wrong].ravel(), :3] = WRONG
    return source, of_distances(fit.image_distances, limit * diagonal)
