"""The arc between two shape keys before it is baked: shapes on it, computed beside Blender once per choice.

Nothing is written to the scene, and nothing is computed while no ghost is asked for.
"""

from functools import cached_property

import lissom
import numpy as np

from ..bridge import arcs
from ..core import ghost
from ..core.easing import EASINGS
from ..core.inbetween import ArcAsked
from ..core.refused import Refused

SAMPLES = 11  # between both ends: trails are smooth, and what is straight between them is near the arc
EVERY = 2  # so many of these a step that is outlined
LARGE, SAMPLES_LARGE = 200_000, 3  # from so many vertices on, the middle alone is outlined
HUGE = 1_000_000  # from so many on, none


class Ghost:
    """The ghost of one object: at work, then ``times`` (k,) and ``shapes`` (k, n, 3), or why there are none.

    ``message`` says the latter. ``steps`` are the places of those to outline.
    """

    def __init__(self, obj):
        self.message, self.shapes, self.steps, self._work = "", None, [], None
        self._seen = None
        try:
            self._start(obj)
        except (Refused, lissom.Error) as error:
            self.message = str(error)

    def _start(self, obj):
        count = len(obj.data.vertices)
        if count >= HUGE:
            raise Refused(f"No ghost: {count} vertices are too many to draw several times over")
        if not obj.lissom_inbetween.end:
            raise Refused("Choose the shape key that the arc leads to")
        samples = SAMPLES if count < LARGE else SAMPLES_LARGE
        asked = ArcAsked.of(obj.lissom_inbetween, sampling="COUNT", count=samples)
        self._ends = arcs.Ends(obj, asked)
        self._work = self._ends.path(asked)

    def poll(self):
        """True while it is at work."""
        if self._work is None:
            return False
        try:
            if not self._work.poll():
                return True
            self._take(self._work.result)
        except (Refused, lissom.Error) as error:
            self.message = str(error)
        self._work = None
        return False

    def wait(self):
        """Computes to the end: background mode."""
        if self._work is not None:
            self._take(self._work.wait())
            self._work = None

    def cancel(self):
        """Stops its work."""
        if self._work is not None:
            self._work.cancel()
            self._work = None

    def _take(self, sampled):
        self.triangles = self._ends.mesh.triangles
        self.times = np.asarray(sampled.knots)
        shapes = np.array(self._ends.back(sampled.shapes), dtype=np.float32)
        if not ghost.ways(shapes).any():
            self.message = "This shape key moves nothing yet"
            return
        self.shapes = shapes
        few = len(self.times) <= SAMPLES_LARGE + 2
        self.steps = [len(self.times) // 2] if few else list(range(EVERY, len(self.times) - 1, EVERY))

    @cached_property
    def moving(self):
        """(m, 3): the triangles that move."""
        return ghost.moving(self.shapes, self.triangles)

    @cached_property
    def borders(self):
        """(b, 2): open edges among them."""
        open_edges = ghost.borders(self.triangles)
        return open_edges[np.isin(open_edges, self.moving).any(axis=1)]

    @cached_property
    def normals(self):
        """[(n, 3)] of the steps."""
        return [ghost.normals(self.shapes[step], self.triangles) for step in self.steps]

    @cached_property
    def trails(self):
        """(c, k, 3): the ways of the vertices that move most."""
        return self.shapes[:, ghost.trailed(self.shapes)].swapaxes(0, 1)

    def outlines(self, eye):
        """[(time, (k, 2, 3))] of the steps; ``eye`` is (4,), homogeneous, in the object's coordinates."""
        return [
            (
                self.times[step],
                np.concatenate(
                    [
                        ghost.outline(self.shapes[step], unit, self.moving, eye),
                        self.shapes[step][self.borders],
                    ]
                ),
            )
            for step, unit in zip(self.steps, self.normals, strict=True)
        ]

    def at(self, slider, easing):
        """(n, 3) float32: the shape that a slider of that easing will show, and its time on the arc."""
        time = float(EASINGS[easing].value(slider))
        if self._seen is None or self._seen[0] != time:
            self._seen = time, ghost.between(self.times, self.shapes, time)
        return self._seen[1], time
