"""The folder of measured data that does not ship with the project."""

import measured
import pytest


def load(name: str):
    """An archive of the measuring data; the test is left out, and says so, where it is not there."""
    try:
        return measured.load(name)
    except measured.Missing as missing:
        pytest.skip(f"left out: {missing}")


@pytest.fixture
def data():
    return load
