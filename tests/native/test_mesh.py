"""lissom.Mesh: what it keeps and what it says."""

import lissom
import numpy as np
import pytest
from lissom import data
from shapes import tube


def test_vertices_come_back_to_the_last_bit():
    vertices, faces = tube()
    mesh = lissom.Mesh(vertices, faces)
    assert np.array_equal(mesh.vertices, vertices)
    assert mesh.warnings == []
    assert repr(mesh) == f"lissom.Mesh({len(vertices)} vertices, {len(faces)} triangles)"


def test_the_diagonal_is_that_of_the_box():
    vertices, faces = tube()
    assert np.isclose(lissom.Mesh(vertices, faces).diagonal, np.linalg.norm(np.ptp(vertices, axis=0)))


def test_components_are_counted():
    vertices, faces = tube()
    three = np.concatenate([vertices, vertices + 10, vertices + 20])
    n = len(vertices)
    assert lissom.Mesh(three, np.concatenate([faces, faces + n, faces + 2 * n])).components == 3


def test_each_vertex_knows_its_component():
    vertices, faces = tube()
    n = len(vertices)
    two = np.concatenate([vertices, vertices + 10, [[0, 0, 99.0]]])
    of_vertex = lissom.Mesh(two, np.concatenate([faces, faces + n])).component_of_vertex
    assert of_vertex.tolist() == [0] * n + [1] * n + [-1]


def test_the_border_is_where_faces_end_and_no_welded_seam():
    vertices, faces = tube()
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    found, counts = np.unique(edges, axis=0, return_counts=True)
    expected = np.unique(found[counts == 1])
    assert 0 < len(expected) < len(vertices)
    assert lissom.Mesh(vertices, faces).border.tolist() == expected.tolist()
    soup = vertices[faces].reshape(-1, 3)  # every triangle has its own vertices
    own = np.arange(len(soup)).reshape(-1, 3)
    assert len(lissom.Mesh(soup, own).border) == len(soup)
    welded = lissom.Mesh(soup, own, weld=0.0).border
    assert welded.tolist() == np.flatnonzero(np.isin(faces.ravel(), expected)).tolist()


def test_real_meshes_are_accepted_whole(data):
    face = data("ict_face")
    counts, loops = face["counts"], face["loops"]
    starts = np.cumsum(counts) - counts
    fans = [np.stack([loops[starts], loops[starts + 1], loops[starts + 2]], 1)]
    quads = starts[counts == 4]
    fans.append(np.stack([loops[quads], loops[quads + 2], loops[quads + 3]], 1))
    mesh = lissom.Mesh(face["neutral"], np.concatenate(fans))
    assert mesh.components == 56


def test_edges_are_brought_within_a_limit_and_the_rest_stays():
    x, y = np.meshgrid(np.arange(12.0), np.arange(4.0), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    corner = (np.arange(11)[:, None] * 4 + np.arange(3)).ravel()
    faces = np.concatenate([np.c_[corner, corner + 4, corner + 1], np.c_[corner + 1, corner + 4, corner + 5]])
    mesh = lissom.Mesh(vertices, faces)
    bent = vertices + 0.5 * np.sin(vertices[:, :1]) * [0, 0, 1]
    torn = vertices + 5 * (vertices[:, :1] > 5.5) * [1, 0, 0]
    held = np.flatnonzero((vertices[:, 0] == 0) | (vertices[:, 0] == 11))
    found = mesh.limit_stretch([bent, torn], 2.0, held)
    assert np.array_equal(found[0], bent) and np.array_equal(found[1, held], torn[held])
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    length = np.linalg.norm(np.diff(found[1][ends], axis=1), axis=2) / np.linalg.norm(
        np.diff(vertices[ends], axis=1), axis=2
    )
    assert length.max() < 2.003
    with pytest.raises(lissom.InvalidConstraint, match="held"):
        mesh.limit_stretch([torn], held=[48])
    with pytest.raises(lissom.Error, match="limit: must be at least 1"):
        mesh.limit_stretch([torn], 0.5)


def test_linings_of_a_face_are_its_mouth_bag_and_sockets_and_what_lies_inside_of_lips_and_nostrils():
    parts = ("face", "head_and_neck", "mouth_socket", "eye_sockets", "eyeball_left", "eyeball_right")
    face = data.face().only(*parts)
    lines = np.isin(np.arange(len(face.triangles)), lissom.Mesh(face.neutral, face.triangles).linings())
    share = {name: lines[np.isin(face.triangles, face.regions[name]).all(axis=1)].mean() for name in parts}
    assert share["mouth_socket"] > 0.99 and share["eye_sockets"] > 0.99
    assert share["head_and_neck"] == 0 and share["face"] < 0.15
    assert np.isin(face.landmarks, face.triangles[~lines]).sum() >= 66


def test_linings_do_not_depend_on_how_a_mesh_lies_is_wound_or_how_large_it_is():
    face = data.face().only("face", "head_and_neck", "mouth_socket", "eye_sockets")
    found = lissom.Mesh(face.neutral, face.triangles).linings()
    assert 100 < len(found) < 0.4 * len(face.triangles)
    again = lissom.Mesh(1e-3 * face.neutral + 5.0, face.triangles[:, ::-1]).linings()
    assert len(np.setxor1d(found, again)) <= 0.01 * len(found)


def test_nothing_lines_a_pocket_where_all_is_seen():
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    found = lissom.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).linings()
    assert found.shape == (0,) and found.dtype == np.int64
