"""Pose, transfer and interpolate triangle meshes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
POSE_METHODS: tuple[str, ...]

class Error(Exception): ...

class InvalidMesh(Error):
    argument: str
    indices: list[int]
    count: int

class InvalidConstraint(Error):
    argument: str
    indices: list[int]
    count: int

class InvalidValue(Error, ValueError):
    argument: str
    indices: list[int]
    count: int

class SolveFailed(Error): ...

class OutOfMemory(Error, MemoryError):
    needed: int
    available: int

class Cancelled(Error): ...
class InternalError(Error): ...

class Job:
    @property
    def progress(self) -> tuple[float, str]: ...
    @property
    def done(self) -> bool: ...
    def cancel(self) -> None: ...
    def result(self) -> Any: ...

class Mesh:
    def __init__(self, vertices: ArrayLike, triangles: ArrayLike, *, weld: float | None = None) -> None: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def diagonal(self) -> float: ...
    @property
    def components(self) -> int: ...
    @property
    def warnings(self) -> list[str]: ...

class Posed:
    vertices: NDArray[np.float64]
    report: dict[str, Any]

class Pose:
    def __init__(
        self,
        mesh: Mesh,
        handles: Sequence[ArrayLike],
        roi: ArrayLike | None = None,
        method: str = "arap",
        handle_weights: Sequence[ArrayLike | None] | None = None,
        **options: Any,
    ) -> None: ...
    @property
    def info(self) -> dict[str, Any]: ...
    @property
    def warnings(self) -> list[str]: ...
    def solve(
        self,
        transforms: ArrayLike,
        *,
        turns: ArrayLike | None = None,
        max_iterations: int = 200,
        tolerance: float = 1e-6,
        warm_start: bool = True,
    ) -> Posed: ...
    def solve_points(
        self,
        targets: ArrayLike,
        *,
        max_iterations: int = 200,
        tolerance: float = 1e-6,
        warm_start: bool = True,
    ) -> Posed: ...
    def start(
        self,
        transforms: ArrayLike,
        *,
        turns: ArrayLike | None = None,
        max_iterations: int = 200,
        tolerance: float = 1e-6,
        warm_start: bool = True,
    ) -> Job: ...

def start_pose(
    mesh: Mesh,
    handles: Sequence[ArrayLike],
    roi: ArrayLike | None = None,
    method: str = "arap",
    handle_weights: Sequence[ArrayLike | None] | None = None,
    **options: Any,
) -> Job: ...

class Fit:
    pairs: NDArray[np.int64]
    image_triangles: NDArray[np.int64]
    image_weights: NDArray[np.float64]
    fitted_vertices: NDArray[np.float64]
    distances: NDArray[np.float64]
    image_distances: NDArray[np.float64]
    stretch: NDArray[np.float64]
    flipped: NDArray[np.int64]
    report: dict[str, Any]

def fit_correspondence(
    source: Mesh,
    target: Mesh,
    markers: ArrayLike,
    points: ArrayLike | None = None,
    *,
    smoothness: float = 1.0,
    identity: float = 0.001,
    closest: float = 5000.0,
    steps: int = 6,
    rounds: int = 4,
    match_distance: float = 0.02,
    source_mask: ArrayLike | None = None,
    target_mask: ArrayLike | None = None,
) -> Fit: ...
def start_fit(
    source: Mesh,
    target: Mesh,
    markers: ArrayLike,
    points: ArrayLike | None = None,
    *,
    smoothness: float = 1.0,
    identity: float = 0.001,
    closest: float = 5000.0,
    steps: int = 6,
    rounds: int = 4,
    match_distance: float = 0.02,
    source_mask: ArrayLike | None = None,
    target_mask: ArrayLike | None = None,
) -> Job: ...

class Transferred:
    vertices: NDArray[np.float64]
    report: dict[str, float]

class Transfer:
    def __init__(
        self,
        source: Mesh,
        target: Mesh,
        fit: Fit | ArrayLike,
        *,
        unmatched: str = "follow",
        weighting: str = "area",
        anchor: float = 1.0,
        contact: bool = False,
    ) -> None: ...
    @property
    def warnings(self) -> list[str]: ...
    def apply(self, poses: ArrayLike) -> Transferred: ...
    def start(self, poses: ArrayLike) -> Job: ...
    def quality(self, poses: ArrayLike, vertices: ArrayLike) -> dict[str, NDArray[Any]]: ...
    def start_quality(self, poses: ArrayLike, vertices: ArrayLike) -> Job: ...

class Inbetween:
    def __init__(
        self,
        mesh: Mesh,
        start: ArrayLike,
        end: ArrayLike,
        rotation: str = "consistent",
        *,
        stretch: str = "linear",
        refinement: int = 0,
        through: Sequence[tuple[float, ArrayLike]] = (),
        preserve_volume: bool = False,
        clearance: Mesh | None = None,
        clearance_end: ArrayLike | None = None,
    ) -> None: ...
    @property
    def warnings(self) -> list[str]: ...
    def at(self, times: ArrayLike) -> NDArray[np.float64]: ...
    def keyframes(
        self, tolerance: float | None = None, max_keys: int = 32, *, count: int | None = None
    ) -> NDArray[np.float64]: ...
    def start_keyframes(
        self, tolerance: float | None = None, max_keys: int = 32, *, count: int | None = None
    ) -> Job: ...
    def start(self, times: ArrayLike) -> Job: ...

class Keyframes:
    times: NDArray[np.float64]
    warnings: list[str]

class Blend:
    def __init__(self, mesh: Mesh, start: ArrayLike, shapes: ArrayLike, *, refinement: int = 0) -> None: ...
    @property
    def warnings(self) -> list[str]: ...
    def at(self, weights: ArrayLike) -> NDArray[np.float64]: ...

def start_transfer(
    source: Mesh,
    target: Mesh,
    fit: Fit | ArrayLike,
    *,
    unmatched: str = "follow",
    weighting: str = "area",
    anchor: float = 1.0,
    contact: bool = False,
) -> Job: ...
def start_inbetween(
    mesh: Mesh,
    start: ArrayLike,
    end: ArrayLike,
    rotation: str = "consistent",
    *,
    stretch: str = "linear",
    refinement: int = 0,
    through: Sequence[tuple[float, ArrayLike]] = (),
    preserve_volume: bool = False,
    clearance: Mesh | None = None,
    clearance_end: ArrayLike | None = None,
) -> Job: ...
