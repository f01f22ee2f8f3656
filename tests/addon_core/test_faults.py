"""What is wrong with a fit, of fits made wrong on purpose."""

from types import SimpleNamespace

import lissom
import numpy as np
import pytest
from lissom_addon_core import faults

SIDE = 21
GRID = np.stack(np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE)), axis=-1).reshape(-1, 2)
PLANE = np.insert(GRID, 1, 0, axis=1)  # seen from the front: x and z
CORNER = np.arange(SIDE * (SIDE - 1)).reshape(-1, SIDE)[:, :-1].ravel()
FACES = np.concatenate([CORNER[:, None] + [0, 1, SIDE + 1], CORNER[:, None] + [0, SIDE + 1, SIDE]])
SHEET = faults.Side(PLANE, FACES, [0], ["foot"])


def around(x, z, radius):
    """The numbers of the faces whose corners all lie around a place."""
    near = np.linalg.norm(GRID - (x, z), axis=1) < radius
    return np.flatnonzero(near[FACES].all(axis=1))


def sheet(**changed):
    """A fit of the sheet onto itself in which all is well but what is ``changed``."""
    well = {
        "flipped": np.zeros(0, dtype=int),
        "distortion": np.ones(len(FACES)),
        "distances": np.zeros(len(GRID)),
        "image_distances": np.zeros(len(GRID)),
    }
    return SimpleNamespace(**well | changed)


def found(fit, masked=()):
    return faults.of_fit(fit, SHEET, SHEET, 0.05, 2.8, masked)


def test_a_good_fit_has_none():
    assert found(sheet()) == []


@pytest.mark.parametrize("kind", ["folded", "torn", "uncovered", "off"])
def test_each_fault_is_found_with_its_place(kind):
    region = around(0.6, 0.6, 0.4)
    distortion, apart = np.ones(len(FACES)), np.zeros(len(GRID))
    distortion[region] = 9.0
    apart[FACES[region]] = 1.0 - np.linalg.norm(GRID - 0.6, axis=1)[FACES[region]]
    bare = np.where(apart > 0, np.nan, 0.0)
    changed = {
        "folded": {"flipped": region},
        "torn": {"distortion": distortion},
        "uncovered": {"image_distances": bare},
        "off": {"distances": apart},
    }
    (fault,) = found(sheet(**changed[kind]))
    assert fault.kind == kind and fault.grave == (kind != "off")
    assert fault.side == ("target" if kind == "uncovered" else "source")
    assert set(fault.vertices) == set(FACES[region].ravel())
    assert "top left" in fault.line
    if kind == "uncovered":
        assert found(sheet(image_distances=bare), masked=np.unique(FACES[region])) == []


def test_a_few_distorted_faces_are_no_tear():
    """Of a sheet ten times as fine in either direction a single face is."""
    distortion = np.ones(len(FACES))
    distortion[100] = 9.0
    (fault,) = found(sheet(distortion=distortion))
    assert fault.kind == "torn"
    many = np.concatenate([FACES + len(PLANE) * number for number in range(9)])
    wide = np.concatenate([PLANE + [3 * number, 0, 0] for number in range(9)])
    side = faults.Side(wide, many, [], [])
    fit = sheet(
        distortion=np.tile(np.where(np.arange(len(FACES)) == 100, 9.0, 1.0), 9), distances=np.zeros(len(wide))
    )
    assert faults.of_fit(fit, side, SHEET, 0.05, 2.8) == []


def test_the_worst_comes_first():
    region = around(0.7, 0.7, 0.31)
    apart = np.zeros(len(GRID))
    apart[FACES[region]] = 0.5
    told = found(sheet(flipped=region, distances=apart))
    assert [fault.kind for fault in told] == ["folded", "off"]


def test_swapped_markers_fold_a_real_fit_and_it_is_said():
    vertices, triangles = _ball()
    turned = vertices @ np.diag([1.0, 1.1, 0.9])
    marked = np.arange(0, len(vertices), 23)
    markers = np.stack([marked, marked], axis=1)
    markers[[2, 9], 1] = markers[[9, 2], 1]
    ends = lissom.Mesh(vertices, triangles), lissom.Mesh(turned, triangles[:, [1, 2, 0]])
    names = [f"marker {number}" for number in range(len(marked))]
    for tolerance, kinds in ((0.01, set()), (0.0, {"folded"})):
        fit = lissom.fit_correspondence(*ends, markers, marker_tolerance=tolerance)
        sides = [
            faults.Side(mesh, triangles, marked.tolist(), names)
            for mesh, marked in ((vertices, markers[:, 0]), (turned, markers[:, 1]))
        ]
        told = faults.of_fit(fit, *sides, 0.01, 2.0)
        assert kinds <= {fault.kind for fault in told if fault.grave}
        assert bool(kinds) == any(fault.grave for fault in told)


def _ball(rings=24, around=32):
    """A ball of triangles."""
    heights = np.pi * (np.arange(rings) + 0.5) / rings
    angles = 2 * np.pi * np.arange(around) / around
    h, a = np.meshgrid(heights, angles, indexing="ij")
    vertices = np.stack([np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)], axis=-1).reshape(-1, 3)
    number = np.arange(rings * around).reshape(rings, around)
    here, beside = number[:-1], np.roll(number, -1, axis=1)[:-1]
    below, across = number[1:], np.roll(number, -1, axis=1)[1:]
    quads = np.stack([here, below, across, beside], axis=-1).reshape(-1, 4)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
