"""The table of pose options against lissom.Pose, which says by its errors what it takes."""

from types import SimpleNamespace

import lissom
import numpy as np
import pytest
import shapes
from lissom_addon_core.pose_options import METHODS, OPTIONS, Asked, by_name, options_of
from numpy.testing import assert_array_equal

OF_THE_OBJECT = ("mirror", "symmetry", "mirror_tolerance")  # not the artist's numbers: planes of the scene
BASES = [name for name, _, _ in METHODS if name != "multiresolution"]
CASES = [(name, "poisson") for name in BASES] + [("multiresolution", base) for base in BASES]
VERTICES, TRIANGLES = shapes.prism(rows=20, columns=12)
VERTICES[:, 1:] *= 1 + 0.1 * np.sin(
    [3, 5] * VERTICES[:, [0, 0]]
)  # bumpy, and closed, so that it has a volume
# A loose part beside it, that no handle holds.
TRIANGLES = np.vstack([TRIANGLES, len(VERTICES) + np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])])
VERTICES = np.vstack([VERTICES, (3, 0.6, 0) + 0.1 * np.vstack([np.zeros(3), np.eye(3)])])
TURN = shapes.rigid([0.3, 1.0, 0.2], 1.1, [0.4, -0.2, 0.3]) @ np.diag([1.2, 1.2, 1.2, 1.0])


def bind(method, **options):
    """Both ends of a bumpy bar as handles."""
    return lissom.Pose(lissom.Mesh(VERTICES, TRIANGLES), shapes.ends(VERTICES), method=method, **options)


def solved(method, **options):
    return bind(method, **options).solve([np.eye(4), TURN]).vertices


def defaults(method, base):
    wanted = options_of(method, base)
    return {name: option.default for (_, name), option in wanted.items()} | (
        {"base": base} if method == "multiresolution" else {}
    )


def test_the_methods_are_those_of_the_core_in_its_order():
    assert tuple(name for name, _, _ in METHODS) == lissom.POSE_METHODS
    assert list(OPTIONS) == ["common", *lissom.POSE_METHODS]


def test_every_option_of_the_core_has_a_label():
    for owner, options in OPTIONS.items():
        known = lissom.options("pose" if owner == "common" else f"pose.{owner}")
        assert set(options) == {option.name for option in known} - {"method", *OF_THE_OBJECT}
        for option in known:
            if option.choices and option.name != "method":
                items = options[option.name].items
                assert {value for value, _, _ in items} == {value for value, _ in option.choices}


def test_files_keep_their_meaning():
    """A file stores the place in a list: what stands here may only grow."""
    places = {name: [value for value, _, _ in option.items] for name, option in by_name().items()}
    methods = [
        "laplacian",
        "laplacian_fitted",
        "rotation_invariant",
        "thin_shell",
        "poisson",
        "multiresolution",
        "arap",
    ]
    assert [name for name, _, _ in METHODS] == [*methods, "laplacian_rotated"]
    methods.remove("multiresolution")
    assert places["base"] == [*methods, "laplacian_rotated"]
    assert places["constraints"] == ["hard", "soft"]
    assert places["weights"] == ["cotangent", "uniform"]
    assert places["frames"] == ["uniform", "principal"]
    assert places["interpolation"] == ["rotation_vector", "matrix"]
    assert places["details"] == ["gradients", "offsets"]
    assert places["cells"] == ["spokes_and_rims", "spokes"]


@pytest.mark.parametrize(("method", "base"), CASES)
def test_the_defaults_are_those_of_the_core_but_for_one(method, base):
    given = defaults(method, base)
    if "scale" in given:
        assert given["scale"] is False  # the published energy swells
        given["scale"] = True
    only_base = {"base": base} if method == "multiresolution" else {}
    assert_array_equal(solved(method, **given), solved(method, **only_base))


def changes(method):
    """(name, value) of every choice, switch and end of a range."""
    for name, option in OPTIONS[method].items():
        if option.items:
            yield from ((name, value) for value, _, _ in option.items)
        elif isinstance(option.default, bool):
            yield name, not option.default
        else:
            yield from ((name, value) for value in (option.low, option.soft_high or option.high, option.high))


@pytest.mark.parametrize(
    ("method", "name", "value"),
    [(owner, *change) for owner in OPTIONS if owner != "common" for change in changes(owner)]
    + [(method, *change) for method in lissom.POSE_METHODS for change in changes("common")],
)
def test_the_core_takes_every_choice_and_both_ends_of_every_range(method, name, value):
    posed = solved(method, **{name: value})
    assert np.isfinite(posed).all()
    option = (OPTIONS[method] | OPTIONS["common"])[name]
    if not option.when:
        same = np.array_equal(posed, solved(method, **{name: option.default}))
        assert same == (value == option.default)


@pytest.mark.parametrize(
    ("method", "name", "value"), [("arap", "weight", 3.0), ("rotation_invariant", "project", False)]
)
def test_an_option_does_nothing_without_the_one_it_needs(method, name, value):
    needed, choice = by_name()[name].when
    assert_array_equal(solved(method, **{name: value}), solved(method))
    with_it = [solved(method, **{needed: choice, name: given}) for given in (by_name()[name].default, value)]
    assert not np.allclose(*with_it, atol=1e-6)


def test_options_of_one_name_differ_in_nothing_but_their_default():
    for options in OPTIONS.values():
        for name, option in options.items():
            assert option._replace(default=None) == by_name()[name]._replace(default=None)


def test_what_single_precision_has_kept_is_the_decimal_that_was_meant():
    single = float(np.float32(0.2))
    settings = SimpleNamespace(
        method="laplacian", use_weights=False, weld=False, stays="FAR", reach=single, symmetry="OFF"
    )
    asked = Asked.of(settings, "", lambda owner, name: single)
    names = {name for _, name in options_of("laplacian", "")}
    assert asked.options == dict.fromkeys(names, 0.2)
    assert asked.reach == 0.2
    assert float(np.float32(0.2)) != 0.2
