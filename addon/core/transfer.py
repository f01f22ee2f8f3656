"""Transfer of keys: fit where none is at hand, then all keys as right-hand sides of one factorization."""

from typing import NamedTuple

import lissom
import numpy as np

from .refused import Refused
from .work import Block, Work


def fit_work(source, target, markers, options):
    """Work whose result is the fit; ``source`` and ``target`` are (vertices, triangles) in solve space."""

    def steps():
        return (yield from fit_steps(*_meshes(source, target), markers, options))

    return Work(steps())


def _meshes(source, target):
    """Both as lissom.Mesh; Refused where one cannot be, and which."""
    made = []
    for side, geometry in (("source", source), ("target", target)):
        try:
            made.append(lissom.Mesh(*geometry))
        except lissom.InvalidMesh as error:
            raise Refused(f"The mesh of the {side} cannot be used: {error}") from error
    return made


def fit_steps(source, target, markers, options):
    """The fit of two meshes by (k, 2) vertex indices ``markers``, or by None; as steps of a Work."""
    fit = yield lissom.start_fit(source, target, markers, **options)
    if not len(fit.pairs):
        raise Refused(
            "No face of the source matches a face of the target: raise Match Distance, or add markers; "
            "the faces of both must look outward"
        )
    return fit


def told(fit, markers, exact, curves=()):
    """A fit's warnings, about its markers (of core.markers) and curves in words of those who see their lists.

    ``curves`` are the names of these.
    """
    theirs = {*fit.doubtful_warnings, *fit.curve_warnings}
    others = [line for line in fit.report["warnings"] if line not in theirs]
    own = [
        f"marker {markers[i].number or i + 1}, '{markers[i].name}', is {why}"
        for i, why in doubts(fit, exact).items()
    ]
    return [*others, *(f"curve '{curves[i]}' {why}" for i, why in curve_doubts(fit, exact)), *own]


def doubts(fit, exact):
    """{number: why} of the markers that a fit doubts; ``exact`` ones are followed all the same."""
    return {
        number: _out_of_place(percent, exact)
        for number, percent in zip(fit.doubtful_markers.tolist(), fit.doubtful_percents, strict=True)
    }


def _out_of_place(percent, exact):
    what = "kept, since the tolerance is 0" if exact else "left out"
    return (
        f"{percent:.1f} % of the target's size away from where the others put it; {what}: "
        "look whether it is out of place or swapped"
    )


def curve_doubts(fit, exact):
    """(number, what is said) of the curves that a fit doubts, did not meet, or found in another order."""
    for number, percent in zip(fit.doubtful_curves.tolist(), fit.doubtful_curve_percents, strict=True):
        yield number, f"is {_out_of_place(percent, exact)}"
    for number, percent in zip(fit.unmet_curves.tolist(), fit.unmet_curve_percents, strict=True):
        yield (
            number,
            f"is met within {percent:.1f} % of the target's size only: look whether it is the same one on "
            "both meshes",
        )
    for number in fit.reordered_curves.tolist():
        yield (
            number,
            "has its markers in another order on the target, so that it is matched by its length alone: "
            "look whether any are swapped",
        )


class Carried(NamedTuple):
    """What a transfer has found: ``shapes`` (k, n_target, 3); ``quality``, of lissom.Transfer, or None."""

    fit: object
    shapes: np.ndarray
    quality: dict | None
    warnings: list


def transfer_work(source, target, fit, shapes, options, check=False):
    """Work whose result is a Carried.

    ``fit`` is one that was made before, or what ``fit_steps`` needs: (markers, its options). ``shapes``
    (k, n_source, 3) are absolute positions in solve space; ``options`` are those of lissom.Transfer. With
    ``check`` the quality of each shape is found too.
    """

    def steps():
        ends, known = yield from known_steps(source, target, fit)
        if not len(shapes):
            return Carried(known, shapes, {} if check else None, [])
        transfer = yield lissom.start_transfer(*ends, known, **options)
        result = (yield transfer.start_apply(shapes)).vertices
        quality = (yield transfer.start_quality(shapes, result)) if check else None
        return Carried(known, result, quality, list(transfer.warnings))

    return Work(steps())


def animation_steps(source, target, fit, blocks, count, options, take):
    """A Work's steps for ``count`` shapes in ``blocks``, an iterable of (k, n_source, 3); (fit, warnings).

    Each block is made when the one before is done, and ``take`` is called with what becomes of it,
    (k, n_target, 3): no more than one is in memory. Else as ``transfer_work``.
    """
    ends, known = yield from known_steps(source, target, fit)
    transfer = yield lissom.start_transfer(*ends, known, **options)
    done = 0
    for shapes in blocks:
        take((yield Block(transfer.start_apply(shapes), done, len(shapes), count, "frame")).vertices)
        done += len(shapes)
    return known, list(transfer.warnings)


def known_steps(source, target, fit):
    """Both as lissom.Mesh, and the fit, given or made of (markers, options); as steps of a Work."""
    ends = _meshes(source, target)
    return ends, (yield from fit_steps(*ends, *fit)) if isinstance(fit, tuple) else fit


def carried_weights(fit, triangles, weights):
    """(n_target,): ``weights`` (n_source,) at the images of the target's vertices, 0 where there is none.

    ``triangles`` (m, 3) are the source's.
    """
    there = fit.image_triangles >= 0
    corners = triangles[np.where(there, fit.image_triangles, 0)]
    return np.where(there, (weights[corners] * fit.image_weights).sum(1), 0.0)


class Keys:
    """The distinct shapes behind a list of (key, relative key) pairs, and the deltas that come back.

    A key's delta counts from its relative key, which need not be the rest shape (row 33). Both shapes are
    carried over, so that on the target too the key is what it adds to its relative key.
    """

    def __init__(self, rest, pairs):
        """``rest`` (n, 3); ``pairs`` of (n, 3) arrays: the shape of a key and that of its relative key."""
        self._shapes, self._index, self._rest_shape = [], {}, rest.shape
        self._pairs = [(self._add(shape, rest), self._add(relative, rest)) for shape, relative in pairs]

    def _add(self, shape, rest):
        if np.array_equal(shape, rest):
            return None
        key = shape.tobytes()
        if key not in self._index:
            self._index[key] = len(self._shapes)
            self._shapes.append(shape)
        return self._index[key]

    @property
    def shapes(self):
        """(k, n, 3): what has to be transferred; the rest shape is not among them."""
        return np.array(self._shapes).reshape(-1, *self._rest_shape)

    def deltas(self, rest, shapes):
        """(n_target, 3) for each pair, from the transferred shapes and the target's rest shape."""
        for shape, relative in self._pairs:
            yield (rest if shape is None else shapes[shape]) - (
                rest if relative is None else shapes[relative]
            )

    def of_key(self, place, quality):
        """What ``quality`` of the shapes says about one pair; of its relative key's shape nothing."""
        shape = self._pairs[place][0]
        if shape is None:
            return {}
        found = {name: values[shape] for name, values in quality.items()}
        return {name: one.item() if isinstance(one, np.generic) else one for name, one in found.items()}
