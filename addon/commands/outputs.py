"""What a command says, and its files: those it writes are none of those it reads, nor each other."""

import os
import pathlib
import stat

import bpy

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
