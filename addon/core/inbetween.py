"""In-betweens of two shapes, sampled at knots."""

import lissom

from .work import Work


def path_work(mesh, start, end, knots, options):
    """Work whose result is the path at the knots (k, n, 3) and warnings; ``mesh``: vertices, triangles."""

    def steps():
        path = yield lissom.start_inbetween(lissom.Mesh(*mesh), start, end, **options)
        return (yield path.start(knots)), list(path.warnings)

    return Work(steps())
