"""The fixed steps of a run with events whose caller reads the state after each of them, and which has no stop time."""

from __future__ import annotations

import numpy as np

from mbdsl.integrators.event_set import EventSet
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun

#: number of steps over which the progress of such a run, and rounding of its times, are judged
STEPS = 2**14
#: part of a step below which the rest of it behind an event is no step of the method
SHORT = 1e-3


class SingleSteps:
    """The steps of length ``h`` of a run from ``start`` [s], which events divide.

    Attributes
    ----------
    count : int
        Number of steps done.
    """

    def __init__(self, run: MethodRun, start: float, h: float) -> None:
        self.run, self._start, self._h, self.count = run, start, h, 0
        run.set_stop(start)

    @property
    def set(self) -> EventSet:
        """What acts at events."""
        assert self.run.events.set is not None
        return self.run.events.set

    @property
    def time(self) -> float:
        """The end of the last step; the time of the event that has ended the run [s]."""
        return self.run.time if self.set.ended else self._start + self.count * self._h

    def advance(self) -> int:
        """Take one step; a status, RUNNING also if an event ends the run."""
        run, end = self.run, self._start + (self.count + 1) * self._h
        run.set_stop(end)
        while (left := end - run.time) > 4.0 * run.reals[S.LEAST_H] and not self.set.ended:
            behind = run.integers[S.HISTORY] == 1  # behind an event, or at the start
            status = run.drift(end) if behind and left < SHORT * self._h else run.advance(1)
            if status not in (S.RUNNING, S.DONE):
                return status
        if self.set.ended:
            run.set_stop(run.time)
            return S.RUNNING
        self.count += 1
        self.record()
        return S.RUNNING

    def set_value(self, name: str, value: float) -> int:
        """The event of setting a state or a discrete variable from outside; a status."""
        places = self.run.system.tables.coordinates
        given = {} if name in places else {name: value}
        status = self.run.act(places.get(name), value, given)
        self.record()
        return status

    def record(self) -> None:
        """Write the present state as the output of the last step, in a run that stores it."""
        row = np.concatenate(self.run.state())
        if self.count == 0:
            self.run.begun = tuple(x.copy() for x in self.run.state())  # type: ignore[assignment]
        elif self.count <= len(self.run.out):
            self.run.out[self.count - 1] = row
            self.run.integers[S.OUTPUT] = self.count
