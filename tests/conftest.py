"""The folder of measured data that does not ship with the project."""

import os
from pathlib import Path

import numpy as np
import pytest

DATA = Path(os.environ.get("LISSOM_DATA", Path(__file__).parents[1] / "../shared/data")).resolve()


def load(name: str):
    """An archive of the measuring data; the test is left out, and says so, where it is not there."""
    file = DATA / f"{name}.npz"
    if not file.is_file():
        pytest.skip(f"left out: no {file.name} in {DATA}; set LISSOM_DATA to the folder that has it")
    return np.load(file)


@pytest.fixture
def data():
    return load
