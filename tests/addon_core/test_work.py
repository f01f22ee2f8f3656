import lissom
import pytest
from lissom_addon_core.work import Work


class Pause:
    """A job that is done at once."""

    done = True

    def __init__(self, fraction, stage):
        self.progress = (fraction, stage)

    def cancel(self):
        pass

    def result(self):
        return None


def three_pauses(log):
    for number in range(3):
        log.append(number)
        yield Pause(number / 3, f"piece {number}")
    return "all"


def test_waiting_runs_every_piece():
    log = []
    assert Work(three_pauses(log)).wait() == "all"
    assert log == [0, 1, 2]


def test_a_job_that_has_not_said_its_stage_is_starting():
    def steps():
        yield Pause(0.0, "")

    assert Work(steps()).progress == (0.0, "starting")


def test_each_poll_does_one_piece():
    log = []
    work = Work(three_pauses(log))
    assert log == [0]
    assert work.progress == (0.0, "piece 0")
    assert not work.poll()
    assert log == [0, 1]
    while not work.poll():
        pass
    assert work.result == "all"


def test_row_40_cancelling_ends_before_the_next_piece():
    log = []
    work = Work(three_pauses(log))
    work.cancel()
    with pytest.raises(lissom.Cancelled):
        work.poll()
    assert log == [0]


def test_what_a_piece_raises_comes_out():
    def steps():
        yield Pause(0, "")
        raise lissom.SolveFailed("why")

    with pytest.raises(lissom.SolveFailed, match="why"):
        Work(steps()).wait()
