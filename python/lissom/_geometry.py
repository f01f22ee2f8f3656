"""Rotations, components and closest points, as the three jobs themselves use them."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native


def rotation_vectors(rotations: ArrayLike, near: ArrayLike | None = None) -> NDArray[np.float64]:
    """(..., 3): axis times angle, in radians, of rotations (..., 3, 3).

    The angle is at most pi; with ``near`` (..., 3) it is the whole turns further that come nearest to that.
    """
    found = _native.rotation_vectors(_in_a_row(rotations, 3, 3), None if near is None else _in_a_row(near, 3))
    return found.reshape(np.shape(rotations)[:-1])


def nearest_rotations(maps: ArrayLike) -> NDArray[np.float64]:
    """(..., 3, 3): the rotations nearest to linear maps (..., 3, 3) (Kabsch 1976; Umeyama 1991)."""
    return _native.nearest_rotations(_in_a_row(maps, 3, 3)).reshape(np.shape(maps))


def _in_a_row(values: ArrayLike, *shape: int) -> NDArray[Any]:
    """(..., *shape) as (k, *shape); what has another shape as it is, to be refused by its name."""
    array = np.asarray(values)
    return array.reshape(-1, *shape) if array.shape[-len(shape) :] == shape else array


def components(count: int, triangles: ArrayLike) -> NDArray[np.int64]:
    """(count,): the number of the connected component of each vertex, from 0; -1 for one in no triangle.

    Of any ``triangles`` (m, 3), such as a part of a mesh's. Raises InvalidMesh for indices out of range.
    """
    return _native.components(count, triangles)


def closest_points(
    vertices: ArrayLike, triangles: ArrayLike, places: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """The points of a surface nearest to ``places`` (k, 3) (Ericson 2005, 5.1.5).

    ``vertices`` (n, 3), ``triangles`` (m, 3); returns the triangles (k,), the barycentric weights of their
    corners (k, 3) and the distances (k,). Raises InvalidMesh for indices out of range and for no triangles.
    """
    return _native.closest_points(vertices, triangles, places)
