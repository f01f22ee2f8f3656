"""What a command says, and its files: those it writes are none of those it reads, nor each other."""

import math
import os
import pathlib
import stat
import time

import bpy

from ..core.files import write_json
from ..core.names import EDITED_ITEMS, EXISTS_ITEMS
from ..core.refused import Refused

DONE, BAD_INPUT, PARTLY_DONE, CANCELLED = 0, 2, 3, 130  # exit codes


def check(arguments, reads, writes):
    """Refused where a file to read is missing, or where one to write would take the place of something else.

    ``reads`` and ``writes`` are names of arguments, those of paths that were not given are None or empty. A
    file may be saved over the one that it was read from, ``--out`` over ``--file``.
    """
    given = {name: getattr(arguments, name) for name in (*reads, *writes) if getattr(arguments, name)}
    for name in filter(given.get, reads):
        if not os.path.isfile(given[name]):
            raise Refused(f"{_flag(name)}: there is no file '{given[name]}'")
    for number, name in enumerate(filter(given.get, writes)):
        path = given[name]
        if not pathlib.Path(path).resolve().parent.is_dir():
            raise Refused(f"{_flag(name)}: there is no folder for '{path}'")
        if os.path.isdir(path):
            raise Refused(f"{_flag(name)}: '{path}' is a folder")
        if name != "report" and os.path.exists(path) and not os.path.isfile(path):
            raise Refused(f"{_flag(name)}: '{path}' is no file that could be replaced")
        others = [*filter(given.get, reads), *list(filter(given.get, writes))[:number]]
        for other in others:
            if (name, other) != ("out", "file") and _same(path, given[other]):
                raise Refused(f"{_flag(name)}: '{path}' is the file of {_flag(other)}: choose another")


def check_ranges(arguments, options):
    """Refused where an argument is out of the range of its option, as a panel has it; ``options`` {argument:
    core.options.Option}.
    """
    for name, one in options.items():
        value = getattr(arguments, name)
        if isinstance(one.default, (int, float)) and not isinstance(one.default, bool):
            low, high = (
                math.inf * sign if end is None else end for sign, end in ((-1, one.low), (1, one.high))
            )
            if not low <= value <= high:
                told = f"at least {low:g}" if math.isinf(high) else f"from {low:g} to {high:g}"
                raise Refused(f"{_flag(name)}: {value:g} is out of its range, {told}")


def absolute(path):
    """The path that Blender and reports are given."""
    return str(pathlib.Path(path).resolve())


def open_file(path):
    """Opens the .blend file that a command works on, and returns its path."""
    path = absolute(path)
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    return path


def save(path):
    """Saves a copy of the scene: a link stays a link, and a file keeps its rights."""
    place = pathlib.Path(path).resolve()
    mode = stat.S_IMODE(place.stat().st_mode) if place.exists() else None
    bpy.ops.wm.save_as_mainfile(filepath=str(place), copy=True)
    if mode is not None:
        place.chmod(mode)


def add_there(add):
    """Adds what becomes of keys that are there already, by ``add_argument`` of a parser."""
    add(
        "--exists",
        choices=[item[0].lower() for item in EXISTS_ITEMS],
        default="update",
        help="what becomes of keys whose names are taken",
    )
    add(
        "--edited",
        choices=[item[0].lower() for item in EDITED_ITEMS],
        default="keep",
        help="what becomes of keys that were edited by hand since they were transferred",
    )


def add_report(add):
    """Adds ``--report`` by ``add_argument`` of a parser."""
    add("--report", help="also write what was done as JSON")


def write_report(arguments, started, told, errors=()):
    """Writes ``told``, which has ``warnings`` and where there is one the ``fit`` and its ``certainty``, to
    ``--report``, with the errors and the seconds since ``started``.
    """
    if arguments.report:
        seconds = round(time.perf_counter() - started, 3)
        write_json(arguments.report, told | {"errors": list(errors), "seconds": seconds})


def say_warnings(warnings):
    """Prints them, one a line."""
    for warning in warnings:
        print(f"Warning: {warning}")


def say_errors(errors):
    """Prints them, one a line; returns the exit code of what was done but for these."""
    for error in errors:
        print(f"Error: {error.removeprefix('Error: ').strip()}")
    return PARTLY_DONE if errors else DONE


def say_quality(rows):
    """Prints of rows of core.quality.as_dict those that are not good, and why."""
    for row in rows:
        if row["verdict"] != "good":
            print(f"{row['name']}: {row['verdict']}: {', '.join(row['reasons'])}")


def say(done):
    """Prints what a jobs.Done has to say."""
    say_warnings(done.warnings)
    say_quality(getattr(done, "quality", ()))
    print(done.summary)


def _flag(name):
    return f"--{name.replace('_', '-')}"


def _same(path, other):
    """Whether two paths are one file, also one that is not there yet."""
    if os.path.exists(path) and os.path.exists(other):
        return os.path.samefile(path, other)
    return os.path.normcase(os.path.realpath(path)) == os.path.normcase(os.path.realpath(other))
