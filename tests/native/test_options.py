"""Options: what the core says of each is what every call keeps."""

import importlib.util
from pathlib import Path

import lissom
import numpy as np
import pytest
from shapes import ends, moved, rigid, tube

ROOT = Path(__file__).parents[2]
VERTICES, FACES = tube(rows=12, columns=8)
MESH = lissom.Mesh(VERTICES, FACES)
BENT = moved(rigid((0, 0, 1), 0.3), VERTICES)
SAME = np.stack([np.arange(len(FACES))] * 2, 1)


def call(owner, **options):
    """Makes what has the options of ``owner``."""
    if owner == "pose.solve":
        return lissom.Pose(MESH, ends(VERTICES)).solve([np.eye(4)] * 2, **options)
    if owner.startswith("pose"):
        method = owner.partition(".")[2] or "arap"
        return lissom.Pose(MESH, ends(VERTICES), **{"method": method, **options})
    if owner == "fit":
        markers = np.stack([np.arange(0, len(VERTICES), 7)] * 2, 1)
        return lissom.fit_correspondence(MESH, MESH, markers, **options)
    if owner == "transfer":
        return lissom.Transfer(MESH, MESH, SAME, **options)
    if owner == "learn":
        return lissom.learn(MESH, [BENT, VERTICES], {0: VERTICES}, **options)
    if owner == "inbetween":
        return lissom.Inbetween(MESH, VERTICES, BENT, **options)
    if owner == "image_mesh":
        return lissom.image_mesh(np.ones((8, 8)), **options)
    return lissom.Blend(MESH, VERTICES, [BENT], **options)


ALL = [pytest.param(option, id=f"{option.owner}-{option.name}") for option in lissom.options()]
NUMBERS = [param for param in ALL if param.values[0].kind in ("int", "float")]


@pytest.mark.parametrize("option", ALL)
def test_defaults_and_choices_are_taken_and_help_is_one_line(option):
    assert option.help and "\n" not in option.help and not option.help.endswith(".")
    assert option.owner in lissom.OPTION_OWNERS and option in lissom.options(option.owner)
    if option.default is not None:
        call(option.owner, **{option.name: option.default})
    if option.kind == "choice":
        assert option.default in [value for value, _ in option.choices]
        assert all(text for _, text in option.choices)
        for value, _ in option.choices:
            call(option.owner, **{option.name: value})
        with pytest.raises(lissom.InvalidValue, match=rf"^{option.name}: .*'nothing'"):
            call(option.owner, **{option.name: "nothing"})


@pytest.mark.parametrize("option", NUMBERS)
def test_row_03_numbers_out_of_range_are_refused_by_name(option):
    inside = 1 if option.kind == "int" else 1e-9
    refused = [] if option.kind == "int" else [np.nan, -np.inf]
    if option.low is not None:
        refused += [option.low] if option.low_open else [option.low - inside]
    if option.high is not None and np.isfinite(option.high):
        refused += [option.high] if option.high_open else [option.high + inside]
    elif option.high is None and option.kind == "float":
        refused += [np.inf]
    if option.kind == "int":
        refused += [2**70, -(2**70)]
    assert refused
    for value in refused:
        with pytest.raises(lissom.InvalidValue, match=rf"^{option.name}: ") as error:
            call(option.owner, **{option.name: value})
        assert error.value.argument == option.name


@pytest.mark.parametrize("option", ALL)
def test_other_types_are_refused_by_name(option):
    wrong = ["\0much", object(), [None]] if option.kind != "choice" else [object(), 3, [None]]
    if option.kind in ("int", "float"):
        wrong += [True, np.True_]
    for value in wrong:
        with pytest.raises(TypeError, match=rf"^{option.name}(\[0\])?: "):
            call(option.owner, **{option.name: value})


@pytest.mark.parametrize("owner", lissom.OPTION_OWNERS)
def test_unknown_names_are_refused_with_the_known_ones(owner):
    known = [option.name for option in lissom.options(owner) if option.name not in ("method", "rotation")]
    with pytest.raises(TypeError, match="has no option colour; it has ") as error:
        call(owner, colour=1)
    assert all(name in str(error.value) for name in known)


def test_owners():
    assert {f"pose.{method}" for method in lissom.POSE_METHODS} < set(lissom.OPTION_OWNERS)
    with pytest.raises(lissom.InvalidValue, match="owner: 'paint' is none of pose, "):
        lissom.options("paint")
    by_hand = {option.name: option for option in lissom.options("pose.arap")}["smoothness"]
    assert (by_hand.kind, by_hand.default, by_hand.low, by_hand.high, by_hand.high_open) == (
        "float",
        0,
        0,
        1,
        True,
    )


def test_what_is_written_from_the_options_is_up_to_date():
    spec = importlib.util.spec_from_file_location("options_doc", ROOT / "tools/options_doc.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.stale() == [], "run tools/options_doc.py"
