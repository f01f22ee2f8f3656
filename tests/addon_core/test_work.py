"""Long work as a row of jobs: waited for, polled, cancelled."""

import lissom
import pytest
from lissom_addon_core.work import Block, Work


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


def test_a_block_tells_how_far_the_whole_row_is():
    def steps():
        for before, length in ((0, 4), (4, 2)):
            yield Block(Pause(0.5, "solving"), before, length, 6, "frame")

    work = Work(steps())
    assert work.progress == (pytest.approx(2 / 6), "frame 3 of 6")
    assert not work.poll()
    assert work.progress == (pytest.approx(5 / 6), "frame 6 of 6")
    assert Block(Pause(1.0, ""), 4, 2, 6, "frame").progress == (1.0, "frame 6 of 6")


def test_a_job_that_fails_has_the_steps_clean_up_at_once():
    class Failing(Pause):
        def result(self):
            raise lissom.Error("no")

    log = []

    def steps():
        try:
            yield Failing(0.0, "")
        finally:
            log.append("clean")

    work = Work(steps())
    with pytest.raises(lissom.Error):
        work.poll()
    assert log == ["clean"]


def test_what_a_job_raises_a_generator_may_go_on_from():
    class Refusing(Pause):
        def result(self):
            raise lissom.InvalidConstraint("markers: none given")

    def steps(catches):
        try:
            yield Refusing(0.0, "first")
        except catches:
            yield Pause(0.5, "second")
        return "otherwise"

    assert Work(steps(lissom.InvalidConstraint)).wait() == "otherwise"
    with pytest.raises(lissom.InvalidConstraint):
        Work(steps(lissom.InvalidMesh)).wait()
