"""What stays where nothing but what is dragged holds a mesh: else the head would go with the ear."""

import numpy as np

from .refused import Refused

# Only append: a file stores the place.
STAYS = [
    ("FAR", "What Is Far", "Everything beyond a distance from the handles stays in its place"),
    (
        "BORDER",
        "Open Borders",
        "The open borders of the mesh stay in their place, such as the neck of a head",
    ),
    ("NOTHING", "Nothing", "The whole mesh goes along"),
]

# The suggested distance: at least this part of the diagonal, at most this of the way to what is furthest.
_LEAST, _MOST = 0.1, 0.5


def moving(mesh, handles, stays, reach):
    """((k,) vertices that may move, or None for all; the distance) where ``handles``, (h,) each, are dragged.

    ``mesh`` is a lissom.Mesh, ``stays`` one of STAYS; ``reach`` is the distance along edges of what is far,
    in the mesh's units, or 0 for a suggestion by the size of the largest handle.
    """
    handle = np.concatenate(handles)
    if stays == "NOTHING":
        return None, reach
    if stays == "BORDER":
        held = np.setdiff1d(mesh.border, handle)
        if not len(held):
            raise Refused(
                "The mesh has no open border that could stay: let what is far stay, or add a handle"
            )
        return np.setdiff1d(np.arange(len(mesh.vertices)), held), reach
    away = mesh.edge_distances(handle)
    reached = np.isfinite(away)  # loose parts follow what they sit on
    if not reach:
        size = max(np.linalg.norm(np.ptp(mesh.vertices[own], axis=0)) for own in handles)
        reach = min(max(size, _LEAST * mesh.diagonal), _MOST * away[reached].max())
        reach = float(str(np.float32(reach)))  # as Blender keeps it
    far = reached & (away > reach)
    return (np.flatnonzero(~far) if far.any() else None), reach
