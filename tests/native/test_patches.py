"""Hair over a face as a target of its own: patches 2 mm over the ICT face, with five markers each."""

import lissom
import numpy as np
import pytest
from faces import root_mean_square
from test_fit_forgives import Head

HEIGHT = 0.2  # the face is in centimetres

# What each lies over: left and right end, bottom and top, by the landmarks that bound it.
PATCHES = {
    "moustache": [((48, 54), (51, 33))],
    "beard": [((5, 11), (8, 57))],
    "brows": [((17, 21), (17, 19)), ((22, 26), (26, 24))],
}


def over(head, surface, ends, heights, columns=25, rows=9):
    """A grid over the front of a surface: vertices, faces, corners (n, 3) and weights (n, 3) of its feet."""
    left, right = surface[head.landmarks[list(ends)], 0]
    bottom, top = surface[head.landmarks[list(heights)], 1]
    x, y = np.meshgrid(np.linspace(left, right, columns), np.linspace(bottom, top, rows))
    places = np.column_stack([x.ravel(), y.ravel()])
    corners = surface[head.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    triangles, weights = np.empty(len(places), int), np.empty((len(places), 3))
    for row, place in enumerate(places):
        off = place - corners[:, 0, :2]
        u = (off[:, 0] * second[:, 1] - off[:, 1] * second[:, 0]) / area
        v = (first[:, 0] * off[:, 1] - first[:, 1] * off[:, 0]) / area
        hit = np.flatnonzero((area > 0) & (np.minimum(u, v) >= 0) & (u + v <= 1))
        depth = corners[hit, 0, 2] + u[hit] * first[hit, 2] + v[hit] * second[hit, 2]
        best = hit[np.argmax(depth)]
        triangles[row], weights[row] = best, (1 - u[best] - v[best], u[best], v[best])
    normals = np.zeros_like(surface)
    for corner in head.faces.T:
        np.add.at(normals, corner, np.cross(first, second))
    feet = head.faces[triangles]
    normals = blend(weights, normals[feet])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.column_stack([a, b, d]), np.column_stack([b, c, d])])
    return blend(weights, surface[feet]) + HEIGHT * normals, faces, feet, weights


def blend(weights, corners):
    return np.einsum("nk,...nkc->...nc", weights, corners)


def hair(head, surface, name):
    """All pieces of one of `PATCHES`: vertices, faces, corners and weights of feet, five markers of each."""
    pieces, marked, first = [], [], 0
    for ends, heights in PATCHES[name]:
        piece = over(head, surface, ends, heights)
        pieces.append((piece[0], piece[1] + first, *piece[2:]))
        marked.append(first + np.array([0, 24, 4 * 25 + 12, 8 * 25, 9 * 25 - 1]))
        first += len(piece[0])
    return *(np.concatenate(part) for part in zip(*pieces, strict=True)), np.concatenate(marked)


def patch_errors(head, surface, name, **options):
    """(k,) errors of the expressions that move it, over their motion, and the fit."""
    vertices, faces, feet, weights, marked = hair(head, surface, name)
    source = lissom.Mesh(head.rest, head.faces)
    own = blend(weights[marked], head.rest[feet[marked]])
    nearest = feet[marked, weights[marked].argmax(axis=1)]
    fit = lissom.fit_correspondence(
        source,
        lissom.Mesh(vertices, faces),
        np.column_stack([nearest, marked]),
        source_points=own,
        **options,
    )
    target = lissom.Mesh(vertices, faces)
    keys = lissom.Transfer(source, target, fit).apply(head.rest + head.offsets).vertices
    truth = blend(weights, head.offsets[:, feet])
    sizes = np.array([root_mean_square(offset) for offset in truth])
    off = np.array([root_mean_square(x - vertices - t) for x, t in zip(keys, truth, strict=True)])
    moved = sizes > 0.05
    return off[moved] / sizes[moved], fit


@pytest.mark.parametrize("name", PATCHES)
@pytest.mark.parametrize("seed", [None, 1])
def test_hair_alone_follows_the_face_under_it(data, name, seed):
    head = Head(data)
    errors, fit = patch_errors(head, head.rest if seed is None else head.person(seed), name)
    assert len(errors) > 3
    assert np.median(errors) < 0.1
    assert fit.report["flipped_triangles"] == 0
