"""A bound mesh: handles and region by name, checked, and the native pose that follows the handles."""

import lissom
import numpy as np

from .refused import Refused, first
from .work import Work


def check_groups(groups, handles, roi):
    """Refused where a vertex group is missing, empty or overlaps another handle (rows 19, 23, 25).

    ``groups`` maps names to sorted vertex indices, ``handles`` is a list of names, ``roi`` a name or "".
    """
    if not handles:
        raise Refused("There is no handle: add a vertex group as a handle, then bind")
    missing = [name for name in [*handles, *([roi] if roi else [])] if name not in groups]
    if missing:
        raise Refused(
            f"Vertex group {first(repr(name) for name in missing)} is missing: it was renamed or removed. "
            "Choose it anew in the list of handles or as region, then bind"
        )
    for name in handles:
        if not len(groups[name]):
            raise Refused(f"Vertex group '{name}' holds no vertices: assign some, then bind")
    if roi and not len(groups[roi]):
        raise Refused(
            f"The region's vertex group '{roi}' holds no vertices: assign some, or clear the region"
        )
    for number, name in enumerate(handles):
        for other in handles[:number]:
            shared = np.intersect1d(groups[name], groups[other])
            if len(shared):
                raise Refused(
                    f"Handles '{other}' and '{name}' share vertices {first(shared)}: "
                    "take them out of one of the two vertex groups"
                )


class BoundPose:
    """The native pose of one bound mesh, with what it was made from, to tell whether it still holds."""

    def __init__(self, vertices, triangles, corners, handles, roi, method):
        """``vertices`` (n, 3) in solve space, ``corners`` (c,) the vertices of the faces in turn.

        ``handles`` is a list of vertex index arrays, ``roi`` one such array or None.
        """
        self.vertices = vertices
        self.corners = corners
        self.method = method
        mesh = lissom.Mesh(vertices, triangles)
        self.pose = lissom.Pose(mesh, handles, roi=roi, method=method)
        self.warnings = list(mesh.warnings)
        self.transforms = None  # of the last solve; None: solve at the next occasion
        self.converged = True

    def fits(self, vertices, corners, method):
        """True while mesh and method are the ones this pose was made for."""
        return (
            method == self.method
            and np.array_equal(corners, self.corners)
            and np.array_equal(vertices, self.vertices)
        )

    def is_due(self, transforms):
        """True where a solve would change something: the handles moved, or the last solve stopped early."""
        return (
            not self.converged or self.transforms is None or not np.array_equal(transforms, self.transforms)
        )

    def solve(self, transforms):
        """One solve, at once, from the previous pose: (n, 3) in solve space and the report."""
        return self.note(transforms, self.pose.solve(transforms))

    def work(self, transforms):
        """The same on a thread of its own, as Work; its result is that of ``solve``."""

        def steps():
            return self.note(transforms, (yield self.pose.start(transforms)))

        return Work(steps())

    def note(self, transforms, result):
        """Remembers what was solved."""
        self.transforms = transforms
        self.converged = result.report.get("converged", True)
        return result.vertices, result.report
