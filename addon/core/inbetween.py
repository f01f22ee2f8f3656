"""In-betweens of two shapes, sampled at knots."""

import lissom
import numpy as np

from .work import Pause, Work


def path_work(mesh, start, end, knots, options):
    """Work whose result is the path at the knots (k, n, 3) and warnings; ``mesh``: vertices, triangles."""

    def steps():
        path = lissom.Inbetween(lissom.Mesh(*mesh), start, end, **options)
        shapes = []
        for time in knots:
            shapes.append(path.at(np.array([time]))[0])
            yield Pause(len(shapes) / len(knots), "in-betweens")
        return np.array(shapes), list(path.warnings)

    return Work(steps())
