"""The Rust part: it checks its arguments and returns jobs. What lissom documents is made of these."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, TypeVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_T = TypeVar("_T")
_U = TypeVar("_U")
_Options = Mapping[str, Any]

__version__: str

class Error(Exception):
    """Everything that lissom raises by itself."""

class InvalidMesh(Error):
    """The mesh cannot be worked with."""

    argument: str
    indices: list[int]
    count: int

class InvalidConstraint(Error):
    """Handles, markers, targets or a region contradict the mesh or each other."""

    argument: str
    indices: list[int]
    count: int

class InvalidValue(Error, ValueError):
    """An option or a number is out of its range."""

    argument: str
    indices: list[int]
    count: int

class OutOfMemory(Error, MemoryError):
    """It would take more memory (`needed` bytes) than there is (`available`); nothing was allocated."""

    needed: int
    available: int

class SolveFailed(Error):
    """The linear algebra gave up, or the result overflowed."""

class Cancelled(Error):
    """The job was cancelled; nothing has changed."""

class InternalError(Error):
    """A bug in lissom: please report it with its message."""

@final
class Job(Generic[_T]):
    """Work that goes on in the background; dropping it cancels it."""

    @property
    def progress(self) -> tuple[float, str]:
        """(fraction in 0-1, name of the stage)."""
    @property
    def done(self) -> bool:
        """Whether `result()` returns at once."""
    def cancel(self) -> None:
        """Asks the job to stop; `result()` then raises `lissom.Cancelled` within 0.2 s."""
    def result(self) -> _T:
        """Waits for the job and returns its result, or raises its error. Ctrl-C cancels it."""
    @classmethod
    def __class_getitem__(cls, _item: Any) -> Any:
        """`Job[Posed]`, for annotations."""
    def _then(self, then: Callable[[_T], _U]) -> Job[_U]: ...

@final
class Mesh:
    """A triangle mesh, checked once.

    vertices: (n, 3) floats in any units.
    triangles: (m, 3) integers counted from 0.
    weld: a distance in the same units; vertices that close together count as one, as at seams or where each
        triangle has its own. 0.0 joins those in the very same place. Results keep the number and the order
        of the vertices.

    Raises InvalidMesh for no vertices or faces, values that are not finite, indices out of range and points
    that are all coincident or on one line; TypeError and ValueError for arrays of another type or shape.
    """

    def __new__(cls, vertices: ArrayLike, triangles: ArrayLike, *, weld: float | None = None) -> Mesh: ...
    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 3): the positions as given."""
    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the bounding box, in the mesh's own units."""
    @property
    def components(self) -> int:
        """Number of connected components."""
    @property
    def component_of_vertex(self) -> NDArray[np.int64]:
        """(n,): the number of the connected component of each vertex, from 0; -1 for one in no face."""
    @property
    def border(self) -> NDArray[np.int64]:
        """(k,): the vertices on open borders, ascending, as at the neck of a head; welded seams are none."""
    @property
    def warnings(self) -> list[str]:
        """What was mended or is doubtful."""
    def edge_distances(self, vertices: ArrayLike) -> NDArray[np.float64]:
        """(n,): how far each vertex is from the nearest of `vertices`, (k,) indices, along edges.

        In the mesh's own units; inf where no edges lead (Dijkstra 1959). Raises InvalidConstraint for no
        vertices and for indices out of range.
        """
    def start_limit_stretch(
        self, shapes: ArrayLike, limit: float | None = None, held: ArrayLike | None = None
    ) -> Job[NDArray[np.float64]]:
        """:meth:`limit_stretch` in the background."""
    def limit_stretch(
        self, shapes: ArrayLike, limit: float | None = None, held: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """(k, n, 3): `shapes` (k, n, 3) with no edge longer than `limit` (3) times what it is at rest.

        Ends of what is longer are brought together (Provot 1995); what is not stays to the bit. Edges
        between two of the vertices that are `held`, (h,) indices, keep their length. Raises InvalidValue for
        a limit below 1, InvalidConstraint for indices out of range.
        """
    def start_linings(self) -> Job[NDArray[np.int64]]:
        """:meth:`linings` in the background."""
    def linings(self) -> NDArray[np.int64]:
        """(k,): the input triangles that line a pocket, as mouth bags and eye sockets do.

        These are the ones that nothing outside can see (ambient occlusion: Zhukov et al. 1998), and what is
        behind the shortest loops of edges that part them from what one sees (a minimum cut). As a mask of a
        fit they keep a lining from being matched with what is none.
        """

@final
class Pose:
    @property
    def info(self) -> tuple[int, int, int, float]: ...
    @property
    def warnings(self) -> list[str]: ...
    def start_solve(
        self,
        transforms: ArrayLike,
        turns: ArrayLike | None,
        by_itself: ArrayLike | None,
        options: _Options,
    ) -> Job[tuple[Any, ...]]: ...
    def start_solve_points(self, targets: ArrayLike, options: _Options) -> Job[tuple[Any, ...]]: ...

@final
class Fit:
    def next_marker(
        self,
        fitted: tuple[ArrayLike, ArrayLike, ArrayLike],
        markers: ArrayLike,
        masks: tuple[ArrayLike, ArrayLike],
    ) -> list[int] | None: ...

@final
class Transfer:
    @property
    def warnings(self) -> list[str]: ...
    def start_apply(self, poses: ArrayLike) -> Job[tuple[Any, ...]]: ...
    def start_quality(self, poses: ArrayLike, vertices: ArrayLike, led: ArrayLike) -> Job[dict[str, Any]]: ...
    def start_attributes(self, values: ArrayLike) -> Job[NDArray[np.float64]]: ...
    def start_corner_attributes(
        self, values: ArrayLike, faces: ArrayLike | None
    ) -> Job[NDArray[np.float64]]: ...

@final
class Inbetween:
    @property
    def warnings(self) -> list[str]: ...
    def start_at(self, times: ArrayLike) -> Job[NDArray[np.float64]]: ...
    def start_keyframes(
        self, tolerance: float | None, max_keys: int, count: int | None
    ) -> Job[dict[str, Any]]: ...

@final
class Blend:
    @property
    def warnings(self) -> list[str]: ...
    def start_at(self, weights: ArrayLike) -> Job[NDArray[np.float64]]: ...

def options() -> list[dict[str, Any]]: ...
def start_pose(
    mesh: Mesh,
    handles: Sequence[ArrayLike],
    roi: ArrayLike | None,
    method: str,
    handle_weights: Sequence[ArrayLike | None] | None,
    options: _Options,
) -> Job[Pose]: ...
def start_fit(
    source: Mesh, target: Mesh, markers: ArrayLike | None, options: _Options
) -> Job[tuple[Any, ...]]: ...
def start_transfer(source: Mesh, target: Mesh, fit: Fit | ArrayLike, options: _Options) -> Job[Transfer]: ...
def start_learn(
    mesh: Mesh, vertices: ArrayLike, places: ArrayLike, corrected: ArrayLike, options: _Options
) -> Job[dict[str, Any]]: ...
def start_inbetween(mesh: Mesh, start: ArrayLike, end: ArrayLike, options: _Options) -> Job[Inbetween]: ...
def start_image_mesh(alpha: ArrayLike, options: _Options) -> Job[dict[str, Any]]: ...
def start_blend(mesh: Mesh, start: ArrayLike, shapes: ArrayLike, options: _Options) -> Job[Blend]: ...
def rotation_vectors(rotations: ArrayLike, near: ArrayLike | None) -> NDArray[np.float64]: ...
def nearest_rotations(maps: ArrayLike) -> NDArray[np.float64]: ...
def components(count: int, triangles: ArrayLike) -> NDArray[np.int64]: ...
def closest_points(
    vertices: ArrayLike, triangles: ArrayLike, places: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]: ...
def _panic() -> Any: ...
