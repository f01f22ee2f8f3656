"""Flat meshes of images."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._native import Job

if TYPE_CHECKING:
    from typing import Unpack

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._option_types import ImageMeshOptions


@dataclass(frozen=True, eq=False)
class ImageMesh:
    """A flat mesh of an image; unpacks as ``vertices, triangles, uv``."""

    vertices: NDArray[np.float64]
    """(n, 3) in pixels: x to the right and y up from the lower left corner of the image, z = 0."""
    triangles: NDArray[np.int64]
    """(m, 3) indices of vertices, counterclockwise as seen from above."""
    uv: NDArray[np.float64]
    """(n, 2) places in the image, from (0, 0) at the lower left corner to (1, 1) at the upper right."""
    warnings: list[str]
    """What was left out or is doubtful."""

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return iter((self.vertices, self.triangles, self.uv))


def start_image_mesh(alpha: ArrayLike, **options: Unpack[ImageMeshOptions]) -> Job[ImageMesh]:
    """:func:`image_mesh` in the background."""
    return _native.start_image_mesh(alpha, options)._then(lambda made: ImageMesh(**made))


def image_mesh(alpha: ArrayLike, **options: Unpack[ImageMeshOptions]) -> ImageMesh:
    """A flat triangle mesh of what an image shows, with UVs.

    alpha: (h, w) opacity in 0-1 of the pixels, the top row first; bytes are to be divided by 255. It holds at
        the centres of pixels and is linear between them.
    options: those of ``lissom.options("image_mesh")``.

    Islands and holes are kept, each as a ring of the outline, which is where alpha crosses ``threshold``, to
    parts of a pixel, moved by at most ``tolerance``. Inside, triangles are about equilateral with edges of
    length ``edge``, smaller where the outline asks for it. No angle is below 25 degrees, except near tips of
    the outline that are sharper than 60 degrees. Triangulated by the crate spade (constrained Delaunay,
    refined as by Ruppert 1995).

    Raises InvalidValue where nothing is opaque, for alpha beyond 0-1 or not finite, of which ``indices``
    count row by row, and for options out of range; ValueError for an alpha that is not (h, w); OutOfMemory,
    Cancelled.
    """
    return start_image_mesh(alpha, **options).result()
