"""The thin shell: exactness, dense least squares of its energy, and how it meets the rest."""

import lissom
import numpy as np
import pytest
from dense import gradient_and_areas, laplacian_and_mass, minimise, surface_diagonal, window
from shapes import diagonal, ends, grid_faces, moved, rigid, tube


def shell_rows(v, f, k_s, k_b, border, free):
    """Rows whose squares sum to k_s |grad d|^2 + k_b |Lap d|^2, both one order up for border 2."""
    g, areas = gradient_and_areas(v, f)
    laplacian, mass = laplacian_and_mass(v, f)
    area = np.sqrt(np.repeat(areas, 3))[:, None]
    membrane, plate = area * g, laplacian / np.sqrt(mass)[:, None]
    if border == 2:
        membrane, plate = plate, area * (g @ (laplacian / mass[:, None]))
    if border == 0:
        plate = plate[free]
    return np.concatenate([np.sqrt(k_s) * membrane, np.sqrt(k_b) * plate])


@pytest.mark.parametrize("border", [0, 1, 2])
@pytest.mark.parametrize(("k_s", "k_b"), [(1.0, 2.0), (1.0, 1e-3), (0.0, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("constraints", ["hard", "soft"])
def test_agrees_with_dense_least_squares(border, k_s, k_b, constraints):
    vertices, faces = tube(bumps=0.1)
    assert len(vertices) > 2000
    row = np.arange(len(vertices)) // 32
    roi, handle = np.flatnonzero((row > 33) & (row < 42)), np.flatnonzero(row == 37)
    soft = 20.0 if constraints == "soft" else None
    motion = rigid((0.2, 1, 0.3), 0.5, (0.1, 0.4, 0.2))
    targets = moved(motion, vertices[handle])
    scale = surface_diagonal(vertices, faces)

    ids, local = window(faces, roi, 4)
    inside = np.flatnonzero(np.isin(ids, handle))
    outside = np.flatnonzero(~np.isin(ids, roi))
    fixed = outside if soft else np.concatenate([outside, inside])
    free = np.setdiff1d(np.arange(len(ids)), fixed)
    lift = (targets - vertices[handle]) / scale
    rows = shell_rows(vertices[ids] / scale, local, k_s, k_b, border, free)
    rows = rows[np.abs(rows[:, free]).sum(1) > 0]
    values = np.zeros((len(fixed), 3))
    if not soft:
        values[len(outside) :] = lift
    pull = (inside, soft, lift) if soft else None
    expected = vertices[ids] + scale * minimise(rows, np.zeros((len(rows), 3)), fixed, values, pull)

    options = {"constraints": constraints} | ({"weight": soft} if soft else {})
    pose = lissom.Pose(
        lissom.Mesh(vertices, faces), [handle], roi, "thin_shell", k_s=k_s, k_b=k_b, border=border, **options
    )
    for result in (pose.solve([motion]), pose.solve_points(targets)):
        assert np.abs(result.vertices[ids] - expected).max() < 1e-8 * scale
        assert np.array_equal(np.delete(result.vertices, roi, 0), np.delete(vertices, roi, 0))


@pytest.mark.parametrize("border", [0, 1, 2])
def test_a_translation_is_reproduced(border):
    vertices, faces = tube()
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="thin_shell", border=border)
    shift = rigid(offset=(1, -2, 3))
    for result in (
        pose.solve([shift] * 2),
        pose.solve_points(np.concatenate([moved(shift, vertices[h]) for h in ends(vertices)])),
    ):
        assert np.abs(result.vertices - moved(shift, vertices)).max() < 1e-8 * diagonal(vertices)


def strip(rows=200, columns=11):
    """A flat strip along x, of length 1 and width 0.05."""
    x, y = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 0.05, columns), indexing="ij")
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    return vertices, grid_faces(rows, columns)


@pytest.mark.parametrize(
    ("border", "profile"),
    [
        (0, lambda t: t),
        (1, lambda t: t**2 * (3 - 2 * t)),
        (2, lambda t: t**3 * (10 - 15 * t + 6 * t**2)),
    ],
)
def test_a_strip_is_lifted_along_the_known_curve(border, profile):
    """Without stretching, the end that is lifted leaves d'' , d'''' or d''''''= 0 between the ends."""
    vertices, faces = strip()
    low, high = ends(vertices, 0.1)
    pose = lissom.Pose(
        lissom.Mesh(vertices, faces), [low, high], method="thin_shell", k_s=0.0, k_b=1.0, border=border
    )
    z = pose.solve([np.eye(4), rigid(offset=(0, 0, 1))]).vertices[:, 2]
    start, stop = vertices[low, 0].max(), vertices[high, 0].min()
    t = np.clip((vertices[:, 0] - start) / (stop - start), 0, 1)
    assert np.abs(z - profile(t)).max() < 0.02


def test_stretching_makes_a_shell_a_membrane():
    vertices, faces = strip()
    low, high = ends(vertices, 0.1)
    mesh = lissom.Mesh(vertices, faces)
    lift = [np.eye(4), rigid(offset=(0, 0, 1))]

    def slope(k_s, k_b):
        z = lissom.Pose(mesh, [low, high], method="thin_shell", k_s=k_s, k_b=k_b).solve(lift).vertices[:, 2]
        return np.abs(np.diff(z.reshape(-1, 11)[:, 5])).max() * 199

    # Between the ends, 0.8 apart: 1 / 0.8 for a membrane, 1.5 / 0.8 for a plate.
    assert slope(1, 0) == pytest.approx(1.25, rel=0.03)
    assert slope(0, 1) == pytest.approx(1.875, rel=0.03)
    assert slope(1, 0) < slope(1, 0.01) < slope(1, 1) < slope(0, 1)


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"k_s": -1.0}, lissom.InvalidValue, "k_s: must be 0 or more"),
        ({"k_b": np.nan}, lissom.InvalidValue, "k_b: must be 0 or more"),
        ({"k_b": np.inf}, lissom.InvalidValue, "k_b: must be 0 or more"),
        ({"k_s": 0, "k_b": 0}, lissom.InvalidValue, "k_b: must not be 0 where k_s is 0 too"),
        ({"border": 3}, lissom.InvalidValue, "border: must be 0, 1 or 2, got 3"),
        ({"border": -1}, lissom.InvalidValue, "border: must not be negative, got -1"),
        ({"border": "round"}, TypeError, "border: cannot be 'round'"),
        ({"k_s": "stiff"}, TypeError, "k_s: cannot be 'stiff'"),
        ({"weights": "uniform"}, TypeError, "'thin_shell' has no option weights; it has k_s, k_b, border"),
    ],
)
def test_options_are_checked(options, error, text):
    vertices, faces = tube()
    with pytest.raises(error, match=text):
        lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices), method="thin_shell", **options)
