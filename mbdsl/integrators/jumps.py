"""Jumps at the ends of fixed steps, at times that are known beforehand.

A force that jumps at t_k belongs with its left limit to the step that ends there, and with its right limit to the next
one: else the step's end sees what acts only later, and the method is of order 1. So that step is evaluated slightly
before t_k, and what is kept of the past is then made that of a motion with the forces behind the jump. Where a jump is
within a step, order 1 remains.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import dropwhile
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.integrators import state
from mbdsl.integrators.step_loop import controls_locally

if TYPE_CHECKING:
    from mbdsl.integrators.run import Integration

#: how far from a step's end, in steps, a jump may be that is meant to be there
NEAR = 1e-9
#: units in the last place of the largest time by which a jump is stepped clear of
ULPS = 64


class Jumps:
    """Those of a run with fixed steps."""

    def __init__(self, run: Integration) -> None:
        self.run = run
        self._clear = ULPS * float(np.spacing(max(abs(run.start), abs(run.stop))))
        self._known = self._at_ends()
        self._next = (np.inf, np.inf)
        self._go_on()

    def _at_ends(self) -> Iterator[tuple[float, float]]:
        """The times shortly before and behind each."""
        run = self.run
        for t in run.system.time_events(run.start, run.stop + NEAR * run.h, corners=False):
            end = run.start + round((t - run.start) / run.h) * run.h
            if end > run.start and abs(t - end) <= NEAR * run.h:
                yield min(t, end) - self._clear, max(t, end) + self._clear

    def _go_on(self) -> None:
        self._next = next(self._known, (np.inf, np.inf))
        self.run.K[state.NEXT_EVENT] = self._next[0]

    def rejoin(self) -> None:
        """After the run has been put where a checkpoint was: the jumps still to come."""
        due = self.run.K[state.NEXT_EVENT]
        self._known = dropwhile(lambda times: times[0] < due, self._at_ends())
        self._go_on()

    def come(self) -> None:
        """A step has ended shortly before a jump."""
        run = self.run
        if run.time < run.stop:
            with suppress(InitialisationError):  # no accelerations, as in a singular pose: steps go on as they can
                run.jump(*self._next)
            run.J[state.FRESH] = 0
            if not controls_locally(run.method):
                run.J[state.HISTORY] = 1
        self._go_on()
