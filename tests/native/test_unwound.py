"""Whole turns that the mesh does not make are told, and only these."""

import lissom
import numpy as np
import pytest
from figures import ring_twist
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import bend, ends, prism, rigid

WAYS = [
    {},
    {"solid": True},
    {"rotation_smoothing": 0.0},
    {"smoothness": 0.1},
    {"method": "poisson"},
    {"method": "poisson", "solid": True},
    {"method": "rotation_invariant"},
    {"method": "multiresolution"},
    {"method": "laplacian"},
    {"method": "laplacian_rotated"},
    {"method": "thin_shell"},
]


def told(result):
    return [warning for warning in result.report["warnings"] if "has unwound" in warning]


@pytest.mark.parametrize("options", WAYS, ids=str)
@settings(max_examples=6, deadline=None)
@given(
    degrees=st.floats(190, 800).filter(lambda degrees: abs(degrees % 360 - 180) > 10),
    thickness=st.floats(0.3, 2.0),
    first=st.floats(-1, 1),
)
def test_a_twist_is_kept_or_told(options, degrees, thickness, first):
    """A prism whose ends turn against each other, each by its part, as the rings between them tell."""
    rows, columns = 80, 16
    vertices, faces = prism(rows, columns, length=6)
    vertices = vertices * (1, thickness, thickness)
    turns = [first * np.radians(degrees), (first + 1) * np.radians(degrees)]
    motions = [rigid((1, 0, 0), turn) for turn in turns]
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), **options)
    result = pose.solve(motions, turns=[(turn, 0, 0) for turn in turns])
    rings = result.vertices[: rows * columns].reshape(rows, columns, 3)
    radius = np.linalg.norm(rings - rings.mean(1, keepdims=True), axis=2).mean(1).min()
    if radius < 0.02 * thickness:
        return  # a neck so thin does not say which way it turns
    made = ring_twist(vertices, result.vertices, rows, columns)
    made = np.degrees(made[-1] - made[0])
    assert bool(told(result)) == (abs(made - degrees) > 180), (made, told(result))
    for warning in told(result):
        assert f"handles 0 and 1 turn by {degrees:.0f} degrees" in warning


def test_what_rests_and_what_bends():
    """A region around one handle; bends beyond half a turn make no turn about themselves, and are kept."""
    rows, columns = 80, 16
    vertices, faces = prism(rows, columns, length=6)
    low, high = ends(vertices)
    mesh = lissom.Mesh(vertices, faces)
    region = np.setdiff1d(np.arange(len(vertices)), low)
    for options, unwinds in (({"method": "laplacian"}, True), ({}, False)):
        pose = lissom.Pose(mesh, [high], roi=region, **options)
        result = pose.solve([rigid((1, 0, 0), 2 * np.pi)], turns=[(2 * np.pi, 0, 0)])
        assert ["turns by 360 degrees, the mesh around it by 0" in w for w in told(result)] == [
            True
        ] * unwinds
    pose = lissom.Pose(mesh, [low, high])
    angle = np.radians(270)
    assert not told(pose.solve([np.eye(4), bend(vertices, angle)], turns=[(0, 0, 0), (0, 0, angle)]))
