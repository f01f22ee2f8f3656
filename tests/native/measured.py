"""The folder of measured data that does not ship with the project; CONTRIBUTING.md says what is in it."""

import os
from pathlib import Path

import numpy as np

FOLDER = Path(os.environ.get("LISSOM_DATA") or Path(__file__).parents[2] / "build" / "data").resolve()


class Missing(SystemExit):
    """There is no such archive: a script ends with its text, which says what to do."""


def load(name):
    """The archive ``name``.npz of the folder; raises Missing."""
    file = FOLDER / f"{name}.npz"
    if not file.is_file():
        raise Missing(f"no {file.name} in {FOLDER}: set LISSOM_DATA to the folder that has it")
    return np.load(file)
