"""Discontinuities of forces at the ends of fixed steps, at times known in advance.

A step that ends at a discontinuity t_k has to use the left limit of the force, and the next step the right limit;
otherwise the method is of order 1. Therefore the end of the first step is evaluated slightly before t_k, and the
history that the method carries on is then recomputed with the forces after the discontinuity. If the discontinuity lies
within a step, the order is 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import dropwhile, groupby
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.loop.compiled_loop import controls_locally

if TYPE_CHECKING:
    from mbdsl.integrators.run import Integration

#: a jump counts as at the end of a step if it is closer than this [steps]
NEAR = 1e-9
#: distance of the left and right limits from a jump [units in the last place of the largest time]
ULPS = 64


class Jumps:
    """The discontinuities at the ends of steps, for a run with fixed steps."""

    def __init__(self, run: Integration) -> None:
        self.run = run
        self._clear = ULPS * float(np.spacing(max(abs(run.start), abs(run.stop))))
        self._known = self._at_ends()
        self._next = (np.inf, np.inf)
        self._go_on()

    def _at_ends(self) -> Iterator[tuple[float, float]]:
        """The times shortly before and after each jump."""
        run = self.run
        events = run.system.time_events(run.start, run.stop + NEAR * run.h, corners=False)
        for step, times in groupby(events, key=lambda t: round((t - run.start) / run.h)):
            end = run.start + step * run.h
            near = [t for t in times if abs(t - end) <= NEAR * run.h]
            if step > 0 and near:  # several may be meant to be there
                yield min(*near, end) - self._clear, max(*near, end) + self._clear

    def _go_on(self) -> None:
        self._next = next(self._known, (np.inf, np.inf))
        self.run.K[loop_state.NEXT_EVENT] = self._next[0]

    def rejoin(self) -> None:
        """Find the jumps still to come, after the run was restored from a checkpoint."""
        due = self.run.K[loop_state.NEXT_EVENT]
        self._known = dropwhile(lambda times: times[0] < due, self._at_ends())
        self._go_on()

    def come(self) -> None:
        """A step has ended shortly before a jump."""
        run = self.run
        if run.time < run.stop:
            with suppress(InitialisationError):  # no accelerations, as in a singular pose: steps go on as they can
                run.jump(*self._next)
            run.J[loop_state.FRESH] = 0
            if not controls_locally(run.method):
                run.J[loop_state.HISTORY] = 1
        self._go_on()
