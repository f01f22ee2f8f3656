"""Pose, transfer and interpolate triangle meshes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
POSE_METHODS: tuple[str, ...]

class Error(Exception):
    argument: str
    indices: list[int]
    count: int

class InvalidMesh(Error): ...
class InvalidConstraint(Error): ...
class InvalidValue(Error, ValueError): ...
class SolveFailed(Error): ...
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
    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None: ...
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
        self, mesh: Mesh, handles: Sequence[ArrayLike], roi: ArrayLike | None = None, method: str = "arap"
    ) -> None: ...
    @property
    def warnings(self) -> list[str]: ...
    def solve(
        self,
        transforms: ArrayLike,
        *,
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
        max_iterations: int = 200,
        tolerance: float = 1e-6,
        warm_start: bool = True,
    ) -> Job: ...
