"""Writes what is made of lissom.options(): docs/options.md and the types in python/lissom/_option_types.py.

python tools/options_doc.py             writes both
python tools/options_doc.py --check     says whether both are as they would be written
"""

import pathlib
import sys
import textwrap

import lissom

ROOT = pathlib.Path(__file__).resolve().parents[1]

# The calls that take them, in words.
TITLES = {
    "pose": "`Pose`: every method",
    "pose.solve": "`Pose.solve`, `Pose.solve_points`: iterative methods",
    "fit": "`fit_correspondence`",
    "transfer": "`Transfer`",
    "learn": "`learn`",
    "inbetween": "`Inbetween`",
    "blend": "`Blend`",
    "image_mesh": "`image_mesh`",
}
KINDS = {
    "bool": "True or False",
    "int": "whole number",
    "float": "number",
    "choice": "one of",
    "vertices": "(k,) vertex indices",
    "points": "(k, 3) positions",
    "curves": "list of (source vertices, target vertices)",
    "mesh": "a Mesh",
    "shapes": "list of (time, (n, 3) positions)",
    "planes": "list of (point, normal)",
    "modes": "(k, n, 3) offsets",
}
TYPES = {
    "bool": "bool",
    "int": "int",
    "float": "float",
    "vertices": "ArrayLike | None",
    "points": "ArrayLike | None",
    "curves": "Sequence[tuple[ArrayLike, ArrayLike]] | None",
    "mesh": "Mesh | None",
    "shapes": "Sequence[tuple[float, ArrayLike]] | None",
    "planes": "Sequence[tuple[ArrayLike, ArrayLike]] | None",
    "modes": "ArrayLike | None",
}
# Class of the types, whose options it holds, and what the call names itself.
CLASSES = (
    ("PoseOptions", ["pose", *(f"pose.{method}" for method in lissom.POSE_METHODS)], {"method"}),
    ("SolveOptions", ["pose.solve"], set()),
    ("FitOptions", ["fit"], {"points"}),
    ("TransferOptions", ["transfer"], set()),
    ("LearnOptions", ["learn"], set()),
    ("PathOptions", ["inbetween"], {"rotation"}),
    ("BlendOptions", ["blend"], set()),
    ("ImageMeshOptions", ["image_mesh"], set()),
)


def takes(option):
    """What an option takes, in words."""
    if option.kind == "choice":
        return "".join(f"<br>`{value!r}`: {help}" for value, help in option.choices).removeprefix("<br>")
    text = KINDS[option.kind]
    if option.kind == "int" and option.low == 0 and option.high is None:
        return f"{text}, 0 or more"
    if option.low is not None:
        text += f", {'above' if option.low_open else 'at least'} {option.low:g}"
    if option.high is not None:
        text += f", {'below' if option.high_open else 'at most'} {option.high:g}"
    return text


def row(option):
    """A line of the table."""
    text = f"{option.help}."
    if option.unit:
        text += f" In: {option.unit}." if not option.unit.startswith("of ") else f" As a part {option.unit}."
    if option.when:
        text += " Only with `{}={!r}`.".format(*option.when)
    default = "" if option.default is None else f"`{option.default!r}`"
    return f"| `{option.name}` | {default} | {takes(option)} | {text} |"


def manual():
    """The text of docs/options.md."""
    lines = [
        "# Options",
        "",
        "Written by `tools/options_doc.py` from `lissom.options()`, which scripts may ask too.",
    ]
    helps = dict(lissom.options("pose")[0].choices)
    for owner in lissom.OPTION_OWNERS:
        method = owner.removeprefix("pose.")
        lines += ["", f"## {TITLES.get(owner) or f'`Pose(method={method!r})`'}", ""]
        if method in helps:
            lines += [f"{helps[method]}.", ""]
        lines += ["| option | default | takes | |", "|---|---|---|---|", *map(row, lissom.options(owner))]
    return "\n".join(lines) + "\n"


def types():
    """The text of _option_types.py."""
    lines = [
        '"""Types of the options, for editors and type checkers. Written by tools/options_doc.py."""',
        "",
        "from collections.abc import Sequence",
        "from typing import Literal, TypedDict",
        "",
        "from numpy.typing import ArrayLike",
        "",
        "from ._native import Mesh",
    ]
    for name, owners, named in CLASSES:
        found = {}
        for option in (option for owner in owners for option in lissom.options(owner)):
            found.setdefault(option.name, option)
        lines += ["", "", f"class {name}(TypedDict, total=False):"]
        lines += [f'    """Options of {owners[0]}{", pose.*" * (len(owners) > 1)}."""', ""]
        for option in found.values():
            if option.name not in named:
                choices = ", ".join(f'"{value}"' for value, _ in option.choices)
                kind = f"Literal[{choices}]" if choices else TYPES[option.kind]
                lines += (
                    [f"    {option.name}: {kind}"]
                    if len(kind) < 90
                    else [
                        f"    {option.name}: Literal[",
                        *(f'        "{value}",' for value, _ in option.choices),
                        "    ]",
                    ]
                )
                lines += textwrap.indent(textwrap.fill(f'"""{option.help}."""', 106), "    ").splitlines()
    return "\n".join(lines) + "\n"


FILES = {ROOT / "docs/options.md": manual, ROOT / "python/lissom/_option_types.py": types}


def stale():
    """The files that are not as they would be written."""
    return [path for path, text in FILES.items() if path.read_text(encoding="utf-8") != text()]


def main():
    if sys.argv[1:] == ["--check"]:
        sys.exit("".join(f"{path}: run tools/options_doc.py\n" for path in stale()) or 0)
    for path, text in FILES.items():
        path.write_text(text(), encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
