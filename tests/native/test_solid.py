"""`solid=True`: closed parts keep their body by rods through it."""

import lissom
import numpy as np
import pytest
from figures import closed_volume, edge_error, ring_twist
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import bend, diagonal, ends, moved, prism, rigid, rotation, tube

METHODS = ("arap", "poisson")


def posed(vertices, faces, handles, transform, method="arap", turns=None, **options):
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method, **{"solid": True} | options)
    turns = None if turns is None else [(0, 0, 0), turns]
    return pose.solve([np.eye(4), transform], turns=turns, max_iterations=500).vertices


def kept(vertices, result, faces):
    return closed_volume(result, faces) / closed_volume(vertices, faces)


def body(seed, rows=24, columns=16):
    """A closed prism with a random cross-section that changes along x, turned and put somewhere."""
    random = np.random.default_rng(seed)
    vertices, faces = prism(rows, columns, length=4, square=bool(seed % 2))
    a, b = random.uniform(0.5, 2, 2)
    vertices[:, 1:] *= (1 + 0.3 * np.sin(a * vertices[:, :1] + b)) * random.uniform(0.5, 1.5, 2)
    return vertices, faces, random


@pytest.mark.parametrize("method", METHODS)
def test_the_surveys_bar_keeps_its_body(data, method):
    archive = data("survey")
    vertices, faces = archive["bar_vertices"].astype(float), archive["bar_faces"].astype(np.int64)
    handles = [np.flatnonzero(archive["bar_status"] == k) for k in (0, 2)]
    result = posed(vertices, faces, handles, archive["bar_transform"].astype(float), method)
    assert kept(vertices, result, faces) > 0.95
    assert edge_error(vertices, result, faces) < 0.08


@pytest.mark.parametrize("method", METHODS)
def test_a_cylinder_bends_by_half_a_turn_however_fine(method):
    found = []
    for rows, columns in ((50, 16), (100, 32), (150, 48)):
        vertices, faces = prism(rows, columns, length=6)
        result = posed(vertices, faces, ends(vertices), bend(vertices, np.pi), method)
        found.append(kept(vertices, result, faces))
    assert min(found) > 0.95, "0.8 by the surface alone"
    assert np.ptp(found) < 0.015


@pytest.mark.parametrize(("method", "least"), [("arap", 0.8), ("poisson", 0.75)])
def test_a_box_keeps_two_turns_and_its_body(method, least):
    rows, columns = 200, 24
    vertices, faces = prism(rows, columns, length=12, square=True)
    result = posed(vertices, faces, ends(vertices, 0.05), np.eye(4), method, (4 * np.pi, 0, 0))
    twist = ring_twist(vertices, result, rows, columns)
    assert np.isclose(twist[-1] - twist[0], 4 * np.pi, rtol=0, atol=1e-6)
    assert kept(vertices, result, faces) > least


@pytest.mark.parametrize("rows", [60, 120])
def test_a_thick_ellipsoid_keeps_most_of_its_body(rows):
    """Its normals cross no two alike: rods hold it less well than a prism."""
    vertices, faces = prism(rows, 32, length=6)
    along = vertices[:, :1] / 3 - 1
    vertices = (
        vertices * (1, 2, 2) * np.where([True, False, False], 1, np.sqrt(np.maximum(1 - along**2, 1e-3)))
    )
    for angle, least in ((np.pi * 0.75, 0.9), (np.pi, 0.88)):
        result = posed(vertices, faces, ends(vertices), bend(vertices, angle), turns=(0, 0, angle))
        assert kept(vertices, result, faces) > least
    result = posed(vertices, faces, ends(vertices), np.eye(4), turns=(2 * np.pi, 0, 0))
    assert kept(vertices, result, faces) > 0.8


@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_rigid_motions_are_exact_and_stillness_is_to_the_last_bit(method, seed):
    vertices, faces, random = body(seed)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method=method, solid=True)
    assert (pose.solve([np.eye(4)] * 2).vertices == vertices).all()
    motion = rigid(random.normal(size=3), random.uniform(0, 3), random.normal(size=3))
    result = pose.solve([motion] * 2, warm_start=False).vertices
    assert np.abs(result - moved(motion, vertices)).max() < 1e-9 * diagonal(vertices)
    held = np.concatenate(ends(vertices))
    assert (result[held] == pose.solve_points(result[held]).vertices[held]).all()


@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_it_does_not_matter_how_a_body_lies_nor_which_side_its_faces_show(method, seed):
    vertices, faces, random = body(seed)
    handles, motion = ends(vertices), bend(vertices, 1.5)
    result = posed(vertices, faces, handles, motion, method)
    lie = rigid(random.normal(size=3), random.uniform(0, 3), 3 * random.normal(size=3))
    lain = posed(moved(lie, vertices), faces, handles, lie @ motion @ np.linalg.inv(lie), method)
    inside_out = posed(vertices, faces[:, ::-1], handles, motion, method)
    for other in (moved(np.linalg.inv(lie), lain), inside_out):
        assert np.abs(other - result).max() < 1e-4 * diagonal(vertices)
    hollow = posed(vertices, faces, handles, motion, method, solid=False)
    assert kept(vertices, result, faces) > kept(vertices, hollow, faces)


def test_open_parts_are_told_and_stay_as_they_were():
    vertices, faces = tube(rows=20, columns=12)
    handles, motion = ends(vertices), rigid((0, 0, 1), 1.0)
    hollow = lissom.Pose(lissom.Mesh(vertices, faces), handles)
    solid = lissom.Pose(lissom.Mesh(vertices, faces), handles, solid=True)
    assert any("solid: open parts" in warning for warning in solid.warnings)
    assert not any("solid" in warning for warning in hollow.warnings)
    motions = [np.eye(4), motion]
    assert (hollow.solve(motions).vertices == solid.solve(motions).vertices).all()


def test_parts_are_bodies_of_their_own():
    """A part inside another, one through another and an open one: each poses as it would alone."""
    outer, faces = prism(30, 16, length=6)
    inner = outer * (1, 0.5, 0.5)
    across = outer @ rotation((0, 0, 1), 0.4).T
    sheet, sheet_faces = tube(20, 12, length=3)
    shapes = [(outer, faces), (inner, faces[:, ::-1]), (across, faces), (sheet + (0, 0, 5), sheet_faces)]
    starts = np.cumsum([0] + [len(v) for v, _ in shapes])
    vertices = np.concatenate([v for v, _ in shapes])
    triangles = np.concatenate([f + start for (_, f), start in zip(shapes, starts, strict=False)])
    motion = rigid((0, 1, 0), 0.8, (-0.3, 0, 0.4))
    given = [ends(v) for v, _ in shapes]
    handles = [
        np.concatenate([own[k] + start for own, start in zip(given, starts, strict=False)]) for k in (0, 1)
    ]
    options = {"method": "poisson"}
    together = posed(vertices, triangles, handles, motion, **options)
    for (own, own_faces), own_handles, start in zip(shapes, given, starts, strict=False):
        alone = posed(own, own_faces, own_handles, motion, **options)
        assert np.abs(together[start : start + len(own)] - alone).max() < 1e-5


@pytest.mark.parametrize("method", METHODS)
def test_a_region_on_one_side_leans_on_the_other(method):
    """A patch that is pushed in takes its rods along; what is not in the region rests to the last bit."""
    vertices, faces = prism(40, 24, length=4, square=True)
    top = vertices[:, 2] > 0.49
    region = np.flatnonzero(top & (np.abs(vertices[:, 0] - 2) < 1))
    handle = region[np.abs(vertices[region, 0] - 2) < 0.2]
    found = {}
    for solid in (False, True):
        mesh = lissom.Mesh(vertices, faces)
        pose = lissom.Pose(mesh, [handle], roi=region, method=method, solid=solid)
        assert (pose.solve([np.eye(4)]).vertices == vertices).all()
        result = pose.solve([rigid(offset=(0, 0, 0.3))]).vertices
        rest = np.setdiff1d(np.arange(len(vertices)), region)
        assert (result[rest] == vertices[rest]).all()
        free = np.setdiff1d(region, handle)
        found[solid] = np.abs(result[free, 2] - vertices[free, 2]).mean()
    assert found[True] < 0.99 * found[False], "rods to the side that rests hold it back"
