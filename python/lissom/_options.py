"""The options of every call, as the core knows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import _native

if TYPE_CHECKING:
    from typing import Literal


@dataclass(frozen=True)
class Option:
    """One option of a call: everything there is to say about it.

    ``kind`` is "bool", "int", "float", "choice" (one of a few strings), "vertices" ((k,) indices), "points"
    ((k, 3) positions), "curves" (a list of (source vertices, target vertices)), "mesh" (a Mesh), "shapes" (a
    list of (time, (n, 3) positions)), "planes" (a list of (point, normal)) or "modes" ((k, n, 3) offsets).
    """

    name: str
    kind: Literal[
        "bool",
        "int",
        "float",
        "choice",
        "vertices",
        "points",
        "curves",
        "mesh",
        "shapes",
        "planes",
        "modes",
    ]
    default: bool | int | float | str | None
    """What it is where it is not given; None for nothing."""
    low: int | float | None
    high: int | float | None
    """The range of a number; None for no bound. Infinite numbers are refused unless ``high`` is inf."""
    low_open: bool
    high_open: bool
    """Whether the end of the range is itself refused."""
    choices: tuple[tuple[str, str], ...]
    """(value, one line of help) of each value that a choice may have."""
    unit: str
    """Of what it is a number; empty for plain numbers."""
    help: str
    """One line, without a full stop at its end."""
    when: tuple[str, str] | None
    """(name, value) of the option without which, at that value, this one does nothing."""
    owner: str
    """Whose option it is, as given to :func:`options`."""


def _table() -> dict[str, tuple[Option, ...]]:
    table: dict[str, tuple[Option, ...]] = {}
    for row in _native.options():
        table[row["owner"]] = (*table.get(row["owner"], ()), Option(**row))
    return table


_TABLE = _table()


def options(owner: str | None = None) -> tuple[Option, ...]:
    """The options of ``owner``, one of OPTION_OWNERS, in order; of all owners where None is given.

    "pose" are those of every method, and the choice of the ``method`` itself; "pose.<method>" those of one
    method besides; "pose.solve" those of Pose.solve and Pose.solve_points; "fit" those of
    fit_correspondence; "transfer", "inbetween" and "blend" those of the classes; "learn" and "image_mesh"
    those of the calls. The method multiresolution takes the options of its ``base`` too.

    Raises InvalidValue for any other owner.
    """
    if owner is None:
        return tuple(option for options in _TABLE.values() for option in options)
    if owner not in _TABLE:
        error = _native.InvalidValue(f"owner: '{owner}' is none of {', '.join(_TABLE)}")
        error.argument, error.indices, error.count = "owner", [], 0
        raise error
    return _TABLE[owner]


OPTION_OWNERS: tuple[str, ...] = tuple(_TABLE)
"""Whose options there are."""

POSE_METHODS: tuple[str, ...] = tuple(value for value, _ in options("pose")[0].choices)
"""The methods of Pose."""
