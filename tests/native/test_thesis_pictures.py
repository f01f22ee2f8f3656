"""The thesis's pictures: a cylinder bent by 180 degrees, a box twisted by two turns, a head turned by 90.

`make gallery` draws them. The bounds are what each method's energy makes of the pose, as the thesis and the
survey (Botsch & Sorkine 2008) describe it: plain Laplacians do not turn and pinch, fitted ones swell or fold
on large turns, frames and gradient fields bend evenly, ARAP keeps lengths best.
"""

import lissom
import numpy as np
import pytest
from figures import closed_volume, dihedral_change, edge_error, ring_twist, smallest_dihedral
from shapes import bend, ends, prism, rigid

TURNING = ("rotation_invariant", "poisson", "multiresolution")


def cylinder():
    vertices, faces = prism(rows=100, columns=32, length=6)
    return vertices, faces, ends(vertices), bend(vertices, np.pi)


def head():
    """The skin of the face that comes with the project, in centimetres, y up: shoulders held, head turned."""
    face = lissom.data.face().only("face", "head_and_neck")
    vertices, faces = face.neutral[:, [0, 2, 1]] * (1, 1, -1), face.triangles
    y, z = vertices[:, 1], vertices[:, 2]
    chest = np.flatnonzero(y < -14.2)
    top = np.flatnonzero(y > -5.2 - 0.7 * z)
    turn = rigid((0, 1, 0), np.pi / 2)
    spine = np.array([0, -4.5, -2.5])
    turn[:3, 3] = spine - turn[:3, :3] @ spine
    return vertices, faces, (chest, top), turn


@pytest.mark.parametrize(
    ("method", "edges", "volume", "fold"),
    [
        ("laplacian", (0.15, 0.25), (0.35, 0.5), 0),
        ("thin_shell", (0.15, 0.25), (0.35, 0.5), 0),
        ("laplacian_fitted", (0.2, 0.35), (0.3, 0.5), 0),
        ("rotation_invariant", (0.10, 0.13), (0.90, 0.96), 89),
        ("multiresolution", (0.10, 0.13), (0.90, 0.96), 89),
        ("poisson", (0.10, 0.13), (0.90, 0.97), 89),
        ("arap", (0.10, 0.12), (0.90, 0.96), 89),
        ("plain arap", (0.0, 0.06), (0.75, 0.90), 80),
    ],
)
def test_a_cylinder_bent_by_half_a_turn(method, edges, volume, fold):
    vertices, faces, handles, motion = cylinder()
    assert len(vertices) > 2000
    options = {"method": "arap", "rotation_smoothing": 0} if method == "plain arap" else {"method": method}
    pose = lissom.Pose(lissom.Mesh(vertices, faces), handles, **options)
    posed = pose.solve([np.eye(4), motion]).vertices
    assert edges[0] <= edge_error(vertices, posed, faces) <= edges[1]
    assert volume[0] <= closed_volume(posed, faces) / closed_volume(vertices, faces) <= volume[1]
    assert smallest_dihedral(posed, faces) >= fold
    if method in TURNING:  # evenly: no neighbours bend much against each other
        assert dihedral_change(vertices, posed, faces) < 1.5
    if method in ("laplacian", "thin_shell"):  # pinched flat half way
        assert smallest_dihedral(posed, faces) < 10


@pytest.mark.parametrize("method", TURNING)
def test_a_box_twisted_by_two_turns(method):
    rows, columns = 200, 24
    vertices, faces = prism(rows, columns, length=12, square=True)
    pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices, 0.05), method=method)
    posed = pose.solve([np.eye(4)] * 2, turns=[(0, 0, 0), (4 * np.pi, 0, 0)]).vertices
    twist = ring_twist(vertices, posed, rows, columns)
    assert np.isclose(twist[-1] - twist[0], 4 * np.pi, rtol=0, atol=1e-6)
    assert np.diff(twist).min() > -1e-6, "never back"
    assert 0.45 < closed_volume(posed, faces) / closed_volume(vertices, faces) < 0.65
    assert smallest_dihedral(posed, faces) > 30


def test_arap_keeps_two_turns_where_rotations_are_smooth():
    """Without, a twisted box unwinds through its own neck: its surface alone does not resist."""
    rows, columns = 200, 24
    vertices, faces = prism(rows, columns, length=12, square=True)
    twists = {}
    for smoothing in (0.0, 0.001):
        pose = lissom.Pose(lissom.Mesh(vertices, faces), ends(vertices, 0.05), rotation_smoothing=smoothing)
        result = pose.solve([np.eye(4)] * 2, turns=[(0, 0, 0), (4 * np.pi, 0, 0)], max_iterations=300)
        twist = ring_twist(vertices, result.vertices, rows, columns)
        twists[smoothing] = twist[-1] - twist[0]
    assert np.isclose(twists[0.001], 4 * np.pi, rtol=0, atol=1e-6)
    assert np.isclose(twists[0.0], 0, rtol=0, atol=1e-3)


@pytest.mark.parametrize("method", lissom.POSE_METHODS)
def test_a_head_turned_by_a_quarter(method):
    vertices, faces, handles, motion = head()
    assert len(vertices) > 10_000
    posed = (
        lissom.Pose(lissom.Mesh(vertices, faces), handles, method=method).solve([np.eye(4), motion]).vertices
    )
    assert 0.05 < edge_error(vertices, posed, faces) < 0.125
    assert 0.98 < closed_volume(posed, faces) / closed_volume(vertices, faces) < 1.06
    # The neck: half way between chest and head it has turned by about half.
    neck = np.setdiff1d(np.arange(len(vertices)), np.concatenate(handles))
    throat = neck[np.abs(vertices[neck, 1] - np.median(vertices[neck, 1])) < 0.5]
    about = vertices[throat][:, [0, 2]] - vertices[throat][:, [0, 2]].mean(0)
    now = posed[throat][:, [0, 2]] - posed[throat][:, [0, 2]].mean(0)
    angle = np.degrees(
        np.arctan2((about[:, 1] * now[:, 0] - about[:, 0] * now[:, 1]).sum(), (about * now).sum())
    )
    assert 20 < angle < 75
