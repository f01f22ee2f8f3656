"""lissom.Mesh: what it keeps and what it says."""

import lissom
import numpy as np
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
