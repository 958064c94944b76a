"""Peaks of laws that fixed steps have passed over: a pulse, or a window of position, between the ends of a step.

The compiled loop records the states at the ends of steps. Many steps are searched together, as controlled steps are
(:mod:`mbdsl.system.peaks_along_motion`), and functions of time are searched as well. The step size does not change: the
first peak that the ends of its step do not show is kept for a warning, and the search ends. The records remain if the
run keeps its steps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.thinned_records import LEAST
from mbdsl.integrators.run_state import RECORDED, RunState
from mbdsl.system.peaks_along_motion import GIVEN_UP, not_searched
from mbdsl.system.peaks_in_fixed_steps import InFixedSteps

if TYPE_CHECKING:
    from mbdsl.expressions.symbolic import Expr

#: largest number of steps that are searched together, and of floats recorded for them
BATCH, NUMBERS = 4096, 400_000
#: width of the narrowest peak that is certainly found, relative to the step
SHORTEST = 1e-8


class MissedPeak(NamedTuple):
    """A peak of an expression at ``time``, within the step from ``start`` to ``end``; steps of ``h`` show it; [s]."""

    root: Expr
    time: float
    start: float
    end: float
    h: float


class Overlooked:
    """The search of a run with fixed steps. Its results are stored in the run, and in its checkpoints."""

    def __init__(self, run: RunState) -> None:
        system, self._run = run.system, run
        self._looks = InFixedSteps(system, run.h)
        run.seen, run.searched, run.missed = np.zeros(len(self._looks.terms)), not_searched(), []
        self._least = max(SHORTEST * run.h, 16.0 * float(np.spacing(max(abs(run.start), abs(run.stop)))))
        if self._looks.terms or run.keeps:
            searching, width = bool(self._looks.terms), 1 + system.n + system.unknowns
            run.record(min(BATCH * width, NUMBERS) if searching else RECORDED, not searching)
            run.record_from(np.concatenate([[run.start], *run.state()]))

    def advance(self, steps: int, call: Callable[[int], int]) -> int:
        """Take at most ``steps`` steps in the compiled loop; return a status."""
        run, status = self._run, S.RUNNING
        while steps > 0 and status == S.RUNNING and run.integers[S.NOTES] > 0:
            before = run.steps
            status = call(steps)
            steps -= run.steps - before
            if 0 < run.integers[S.NOTES] <= run.integers[S.NOTED]:
                self._search()
        return call(steps) if steps > 0 and status == S.RUNNING else status

    def finish(self) -> None:
        """Search the steps since the last search."""
        if self._run.integers[S.NOTES] > 0:
            self._search()

    def peak(self) -> MissedPeak | None:
        """The first peak so far that the ends of its step do not show."""
        run = self._run
        self.finish()
        if not run.missed:
            return None
        number, *times = run.missed
        return MissedPeak(run.system.tables.values[int(number)], *times)

    def _search(self) -> None:
        """Search the steps recorded; the end of the last one is kept as the start of the next."""
        run = self._run
        if self._searching and len(run.recorded) > 1:
            self._look(run.recorded)
        run.drain()
        if not self._searching:  # record only what a run keeps
            run.integers[S.NOTES] *= run.keeps
            run.integers[S.THIN] = max(run.integers[S.THIN], LEAST) if run.keeps else 0

    @property
    def _searching(self) -> bool:
        """Whether there is something to be found, no peak was found yet, and the search was not given up."""
        run = self._run
        return bool(self._looks.terms) and not run.missed and run.searched[GIVEN_UP] == np.inf

    def _look(self, noted: np.ndarray) -> None:
        """Search the steps between recorded states."""
        run, n = self._run, self._run.system.n
        inputs = {name: float(run.numbers[at]) for name, at in run.system.tables.inputs.items()}
        t, q, v, lam = noted[:, 0], noted[:, 1 : 1 + n], noted[:, 1 + n : 1 + 2 * n], noted[:, 1 + 2 * n :]
        found = self._looks.first((t, q, v, lam), inputs, self._least, run.seen, run.searched, run.turns)
        if found:
            k = int(np.searchsorted(t, found[0].start, side="right")) - 1
            shortest = min(zone.end - zone.start for zone in found)
            number = run.system.tables.values.index(found[0].term)
            middle = 0.5 * (found[0].start + found[-1].end)
            run.missed = [number, float(middle), float(t[k]), float(t[k + 1]), float(shortest)]
