"""Three short examples, one a job: ``python -m lissom.examples``. Read them: that is what they are for.

``python -m lissom.examples FOLDER`` also writes what they make as .obj files.
"""

import pathlib
import sys

import numpy as np
from numpy.typing import NDArray

import lissom

Array = NDArray[np.float64]


def tube(around: int = 24, along: int = 60) -> tuple[Array, NDArray[np.int64]]:
    """Positions and triangles of an open tube of radius 0.5 along z, from 0 to 6."""
    z, angle = np.meshgrid(np.linspace(0, 6, along), 2 * np.pi * np.arange(around) / around, indexing="ij")
    vertices = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), z], axis=-1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    a, b = row * around + column, row * around + (column + 1) % around
    c, d = a + around, b + around
    triangles = np.stack([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3)
    return vertices, triangles


def turn(degrees: float, at: float) -> Array:
    """(4, 4): a turn about the y axis through the point at height ``at`` of the z axis."""
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(4)
    matrix[:3, :3] = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    matrix[:3, 3] = [-sin * at, 0, at - cos * at]
    return matrix


def pose() -> Array:
    """A tube bent by 90 degrees: its bottom is held, its top turned, and the rest follows."""
    vertices, triangles = tube()
    mesh = lissom.Mesh(vertices, triangles)
    bottom, top = np.flatnonzero(vertices[:, 2] < 1), np.flatnonzero(vertices[:, 2] > 5)
    posed = lissom.Pose(mesh, [bottom, top]).solve([np.eye(4), turn(90, at=3)])
    print(f"pose: {len(vertices)} vertices, {posed.report.iterations} iterations")
    return posed.vertices


def transfer(bent: Array) -> Array:
    """The bend goes to a tube of other vertices, which is thicker and leans, by four markers."""
    vertices, triangles = tube()
    others, their_triangles = tube(around=31, along=47)
    others = (others * [1.3, 1.3, 1.0]) @ turn(8, at=0)[:3, :3].T
    places = np.array([[0.5, 0, 0], [0, 0.5, 2], [-0.5, 0, 4], [0, -0.5, 6]])
    their_places = (places * [1.3, 1.3, 1.0]) @ turn(8, at=0)[:3, :3].T
    markers = [
        [np.linalg.norm(vertices - here, axis=1).argmin(), np.linalg.norm(others - there, axis=1).argmin()]
        for here, there in zip(places, their_places, strict=True)
    ]
    source, target = lissom.Mesh(vertices, triangles), lissom.Mesh(others, their_triangles)
    fit = lissom.fit_correspondence(source, target, markers)
    keys = lissom.Transfer(source, target, fit).apply(bent[None]).vertices
    print(f"transfer: {len(others)} vertices, {fit.report.distance_mean_percent:.2f} % off after the fit")
    return keys.reshape(-1, 3)


def inbetween(bent: Array) -> Array:
    """Half way into the bend, and how many straight keys the whole way takes."""
    vertices, triangles = tube()
    path = lissom.Inbetween(lissom.Mesh(vertices, triangles), vertices, bent)
    halfway = path.at([0.5]).reshape(-1, 3)
    times = path.keyframes(tolerance=0.01).times
    shrunk = np.linalg.norm((vertices + bent)[-1] / 2 - (vertices + bent)[0] / 2)
    kept = np.linalg.norm(halfway[-1] - halfway[0])
    print(f"in-between: end to end {kept:.2f} half way, {shrunk:.2f} straight; {len(times)} keys within 0.01")
    return halfway


def write(path: pathlib.Path, vertices: Array, triangles: NDArray[np.int64]) -> None:
    """Writes a mesh as .obj."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main(words: list[str]) -> None:
    """Runs the three; writes what they make where a folder is given."""
    bent = pose()
    made = {"pose": bent, "transfer": transfer(bent), "inbetween": inbetween(bent)}
    for folder in map(pathlib.Path, words[:1]):
        folder.mkdir(parents=True, exist_ok=True)
        for name, vertices in made.items():
            triangles = tube(31, 47)[1] if name == "transfer" else tube()[1]
            write(folder / f"{name}.obj", vertices, triangles)


if __name__ == "__main__":
    main(sys.argv[1:])
