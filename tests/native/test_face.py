"""A face is found and fitted without any marker: random people, by the modes that people differ by.

People are random sums of all modes, of which the fit is given the first only.
"""

import lissom
import numpy as np
import pytest
from faces import diagonal
from test_fit_forgives import SKIN, Head, part, shuffled

SHIPPED = 22  # of 37 modes


def turned(degrees, axis):
    a = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    t = np.radians(degrees)
    return np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross


@pytest.mark.parametrize(("seed", "cut"), [(11, "skin"), (12, "face"), (13, "neck")])
def test_people_are_found_without_markers(data, seed, cut):
    head = Head(data, SKIN)
    person = head.person(seed)
    kept = {
        "skin": np.full(SKIN, True),
        "face": np.arange(SKIN) < 9409,
        "neck": person[:, 1] > -15,
    }[cut]
    vertices, faces, place, used = part(person, head.faces, kept)
    turn = turned(25, np.random.default_rng(seed).normal(size=3))
    vertices, faces, moved, order = shuffled(3 * vertices @ turn.T, faces)
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(vertices, faces)
    fit = lissom.fit_correspondence(source, target, modes=head.modes[:SHIPPED])
    assert fit.report["certainty"] > 0.75 and not fit.report["warnings"]
    off = np.linalg.norm(fit.fitted_vertices[head.landmarks] - vertices[moved[place[head.landmarks]]], axis=1)
    assert off.mean() < 0.003 * diagonal(vertices) and off.max() < 0.008 * diagonal(vertices)

    # Whoever is laid there before the fit is free has that person's gradients, unlike the mean.
    vertex = used[order]
    on = vertex < 9409
    errors = {}
    for name, rest in (("mean", head.rest), ("person", fit.rest)):
        transfer = lissom.Transfer(lissom.Mesh(rest, head.faces), target, fit)
        keys = transfer.apply(rest + head.offsets).vertices
        errors[name] = np.median(head.errors(keys, vertices, 3 * head.offsets[:, vertex] @ turn.T, on))
    assert errors["person"] < 0.8 * errors["mean"]
    assert errors["person"] < 1.0 * Head(data).best(person[:9409])


def test_a_person_of_the_same_faces_is_told_by_its_coefficients(data):
    head = Head(data)
    amounts = np.random.default_rng(3).normal(size=SHIPPED)
    person = head.rest + np.tensordot(amounts, head.modes[:SHIPPED], 1)
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(2 * person + 5, head.faces)
    fit = lissom.fit_correspondence(source, target, modes=head.modes[:SHIPPED])
    assert np.abs(fit.coefficients - amounts).max() < 1e-3
    assert fit.rest.shape == head.rest.shape


def test_without_modes_the_source_is_itself(data):
    head = Head(data)
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(head.person(1), head.faces[::-1])
    fit = lissom.fit_correspondence(source, target)
    assert np.array_equal(fit.rest, head.rest) and fit.coefficients.size == 0


def test_modes_that_do_not_fit_the_source_are_refused(data):
    head = Head(data)
    source, target = lissom.Mesh(head.rest, head.faces), lissom.Mesh(head.person(1), head.faces[::-1])
    modes = head.modes[:3].copy()
    with pytest.raises(lissom.InvalidValue, match="modes: not of the source's 9409 vertices") as error:
        lissom.fit_correspondence(source, target, modes=modes[:, 1:])
    assert error.value.indices == [0, 1, 2]
    modes[2, 7] = np.nan
    with pytest.raises(lissom.InvalidValue, match="modes: not finite") as error:
        lissom.fit_correspondence(source, target, modes=modes)
    assert error.value.indices == [2]
    for wrong in (modes[0], modes[..., :2]):
        with pytest.raises(ValueError, match=r"modes: expected shape \(n, m, 3\)"):
            lissom.fit_correspondence(source, target, modes=wrong)
