"""Long work as a generator of jobs, which a timer polls or a script waits for.

A generator yields one job after the other (anything with the ``progress``, ``done``, ``cancel()`` and
``result()`` of the native jobs), is sent each job's result, and returns the result of the whole::

    def steps():
        fit = yield lissom.start_fit(source, target, markers)
        transfer = yield lissom.start_transfer(source, target, fit)
        return fit, (yield transfer.start_apply(keys))

What a job raises is raised there, where it was yielded: a generator may go on in another way.
"""

import lissom


class Block:
    """A job that is one block of a longer row, with the progress of the whole row."""

    def __init__(self, job, before, length, count, stage):
        """``length`` things in this block, after ``before`` others, of ``count``; ``stage``: what one is."""
        self._job, self._before, self._length, self._count, self._stage = job, before, length, count, stage
        self.cancel, self.result = job.cancel, job.result

    @property
    def done(self):
        """True once ``result()`` does not wait."""
        return self._job.done

    @property
    def progress(self):
        """(fraction of the row in [0, 1], stage)."""
        place = self._before + self._job.progress[0] * self._length
        return place / self._count, f"{self._stage} {min(int(place) + 1, self._count)} of {self._count}"


class Work:
    """Drives one such generator. ``result`` holds what it returned once ``finished`` is True."""

    def __init__(self, steps, count=None, stage=None):
        """``count`` and ``stage``, where it is a row of jobs alike: how many, and what one is called."""
        self._steps = steps
        self._count, self._stage, self._place = count, stage, -1
        self._job = None
        self._cancelled = False
        self.finished = False
        self.result = None
        self._advance(None)

    def _advance(self, value, error=None):
        try:
            self._job = self._steps.send(value) if error is None else self._steps.throw(error)
            self._place += 1
        except StopIteration as stop:
            self._job = None
            self.finished = True
            self.result = stop.value

    @property
    def progress(self):
        """(fraction in [0, 1], stage) of the job that runs now."""
        fraction, stage = self._job.progress if self._job else (1.0, "done")
        if self._count and self._job:
            place = min(self._place, self._count - 1)
            return (place + fraction) / self._count, f"{self._stage} {place + 1} of {self._count}"
        return fraction, stage or "starting"

    def poll(self):
        """Goes on if the running job is done; True once all is finished. Raises what the job raised."""
        if self._cancelled:  # a job that cannot stop at once is left behind, its result is dropped
            self._steps.close()
            raise lissom.Cancelled("cancelled: nothing was changed")
        if not self.finished and self._job.done:
            self._go_on()
        return self.finished

    def wait(self):
        """Runs to the end and returns the result."""
        while not self.finished:
            self._go_on()
        return self.result

    def _go_on(self):
        try:
            result = self._job.result()
        except lissom.Error as error:
            self._advance(None, error)
            return
        except BaseException:
            self._steps.close()  # now, not when the garbage is collected: it may have files open
            raise
        self._advance(result)

    def cancel(self):
        """Asks the running job to stop; the next poll() raises lissom.Cancelled."""
        self._cancelled = True
        if self._job:
            self._job.cancel()
