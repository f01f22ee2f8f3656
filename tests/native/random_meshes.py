"""Meshes to draw: soups of triangles, grids and fans, crowds of cards and slivers.

Parts are many magnitudes smaller than others, vertices in one place, faces twice or turned over.
"""

import lissom
import numpy as np
from hypothesis import assume
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from shapes import grid_faces, rigid

UNIT = st.floats(-1, 1, allow_subnormal=False)
# Such sizes meet in one mesh; the smallest are far below what squares of lengths can hold.
SIZES = st.sampled_from([1.0, 1.0, 1.0, 1e-3, 1e-9, 1e-60, 1e-150])


def points(n):
    """(n, 3) in -1 to 1."""
    return hnp.arrays(float, (n, 3), elements=UNIT)


@st.composite
def soups(draw):
    n = draw(st.integers(3, 24))
    vertices = draw(points(n)) * draw(hnp.arrays(float, (n, 1), elements=SIZES))
    return vertices, draw(hnp.arrays(np.int64, (draw(st.integers(1, 40)), 3), elements=st.integers(0, n - 1)))


@st.composite
def grids(draw):
    rows, columns = draw(st.integers(2, 7)), draw(st.integers(3, 7))
    faces = grid_faces(rows, columns, closed=draw(st.booleans()))
    even = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), [0.0], indexing="ij"), -1).reshape(-1, 3)
    vertices = even + draw(points(len(even))) * draw(SIZES)
    turned = draw(hnp.arrays(bool, len(faces)))
    return vertices, np.where(turned[:, None], faces[:, ::-1], faces)


@st.composite
def fans(draw):
    n = draw(st.integers(3, 20))
    rim = np.arange(1, n)
    faces = np.column_stack([0 * rim, rim, np.roll(rim, -1)])
    twice = draw(st.lists(st.integers(0, n - 2), max_size=4))
    return draw(points(n)) * draw(SIZES), np.concatenate([faces, faces[twice]])


@st.composite
def crowds(draw):
    """Many triangles from few numbers: fans of high degree, loose cards, slivers, noise at any size."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    kind, count = draw(st.sampled_from(["fan", "cards", "slivers", "noise"])), draw(st.integers(30, 1000))
    if kind == "fan":
        rim = np.arange(1, count)
        faces = np.column_stack([0 * rim, rim, np.roll(rim, -1)])
        angle = 2 * np.pi * rim / len(rim)
        vertices = np.concatenate(
            [np.zeros((1, 3)), np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])]
        )
        vertices += rng.normal(size=vertices.shape) * draw(SIZES)
    elif kind == "cards":
        vertices = (rng.normal(size=(count, 1, 3)) + rng.normal(size=(count, 3, 3)) * 0.1).reshape(-1, 3)
        faces = np.arange(3 * count).reshape(-1, 3)
    else:
        vertices = rng.normal(size=(count, 3)) * (1, 1, 1e-9 if kind == "slivers" else 1)
        faces = rng.integers(0, count, size=(count, 3))
    return vertices * draw(st.sampled_from([1.0, 1e-12, 1e12, 1e60])) + draw(
        st.sampled_from([0.0, 1e4])
    ), faces


def torn(faces):
    """Which faces repeat a vertex; they are left out."""
    return (faces[:, [0, 0, 1]] == faces[:, [1, 2, 2]]).any(axis=1)


def on_a_line(refused):
    return any(text in str(refused) for text in ("all points coincide", "all points lie on one line"))


@st.composite
def meshes(draw, *more):
    """A mesh that is accepted, its vertices and faces."""
    vertices, faces = draw(st.one_of(soups(), grids(), fans(), *more))
    try:
        return lissom.Mesh(vertices, faces), vertices, faces
    except lissom.InvalidMesh as refused:
        assert torn(faces).all() or on_a_line(refused) or np.ptp(vertices) < 1e-140, refused
        assume(False)


@st.composite
def motions(draw):
    axis = draw(points(1))[0]
    assume(np.linalg.norm(axis) > 1e-3)
    return rigid(axis, draw(st.floats(-3.5, 3.5)), draw(points(1))[0])
