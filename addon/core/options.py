"""Options as the artist meets them: labels, and the ends of sliders; all else is that of lissom.options()."""

import argparse
from typing import NamedTuple

import lissom

_KNOWN = {(option.owner, option.name): option for option in lissom.options()}


class Option(NamedTuple):
    """One option; the type of ``default`` is its kind: str (one of ``items``), bool, int or float."""

    label: str
    line: str
    default: object
    items: tuple = ()  # (value, label, one line); a file stores the place in this list: only append
    low: float | None = None
    high: float | None = None
    soft_high: float | None = None
    precision: int | None = None  # digits that a slider shows; None: as Blender does
    when: tuple = ()  # (name, value) of the option without which this one does nothing


def option(owner, name, label, labels=None, **ends):
    """The option ``name`` of ``owner`` under a ``label``.

    ``labels`` is {value: label} of a choice, in the order of the places that files store. ``ends`` are
    ``low``, ``high``, ``soft_high`` and ``precision`` of a slider where the core's range is open or endless,
    or a ``default`` that differs on purpose.
    """
    known = _KNOWN[owner, name]
    lines = dict(known.choices)
    unit = f", as a part {known.unit}" if known.unit.startswith("of ") else ""
    settings = {
        "default": known.default,
        "items": tuple((value, label, lines[value]) for value, label in (labels or {}).items()),
        "low": known.low,
        "high": known.high,
        "when": known.when or (),
    }
    return Option(label, known.help + unit, **(settings | ends))


def argument(owner, name):
    """Keyword arguments of argparse for an option of the core."""
    known = _KNOWN[owner, name]
    if known.kind == "bool":
        return {"action": argparse.BooleanOptionalAction, "default": known.default, "help": known.help}
    if known.kind == "choice":
        choices = [value for value, _ in known.choices]
        return {"choices": choices, "default": known.default, "help": known.help}
    unit = f" ({known.unit})" if known.unit else ""
    kind = {"int": int, "float": float}[known.kind]
    return {"type": kind, "default": known.default, "help": known.help + unit}


def default(owner, name):
    """The core's default of an option."""
    return _KNOWN[owner, name].default
