"""Discontinuities of forces at the ends of fixed steps, at times known in advance.

A step that ends at a discontinuity t_k has to use the left limit of the force, and the next step the right limit;
otherwise the method is of order 1. Therefore the end of the first step is evaluated slightly before t_k, and the
history that the method carries on is then recomputed with the forces after the discontinuity. If the discontinuity lies
within a step, the order is 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import dropwhile, groupby

import numpy as np

from mbdsl.system import System

#: largest distance of a jump from the end of a step at which it counts as being there [steps], in addition to ROUNDED
NEAR = 1e-9
#: rounding error of the times of jumps and of ends of steps [units in the last place of the largest time]
ROUNDED = 16
#: distance of the left and right limits from a jump [units in the last place of the largest time]
ULPS = 64


def behind_a_jump(system: System, t: float, stop: float) -> float:
    """``t``, or the time shortly behind it if forces jump there, as those of `time > 0 s` at the start [s]."""
    clear = ULPS * float(np.spacing(max(abs(t), abs(stop))))
    there = next(iter(system.time_events(t - clear, t + clear, corners=False)), None)
    return t if there is None else t + clear


class Jumps:
    """The discontinuities at the ends of the steps of length ``h`` from ``start`` to ``stop`` [s].

    Attributes
    ----------
    next : (float, float)
        The times shortly before and after the next jump [s]; infinite if there is none.
    """

    def __init__(self, system: System, start: float, stop: float, h: float) -> None:
        self._system, self._start, self._stop, self._h = system, start, stop, h
        self._known = self._at_ends()
        self.next = (np.inf, np.inf)
        self.go_on()

    def _at_ends(self) -> Iterator[tuple[float, float]]:
        """The times shortly before and after each jump."""
        start, h, ulp = self._start, self._h, float(np.spacing(max(abs(self._start), abs(self._stop))))
        clear, close = ULPS * ulp, NEAR * h + ROUNDED * ulp
        events = self._system.time_events(start, self._stop + close, corners=False)
        for step, times in groupby(events, key=lambda t: round((t - start) / h)):
            end = start + step * h
            near = [t for t in times if abs(t - end) <= close]
            if step > 0 and near:  # several jumps may lie at the same end
                yield min(*near, end) - clear, max(*near, end) + clear

    def go_on(self) -> None:
        """Move on to the next jump."""
        self.next = next(self._known, (np.inf, np.inf))

    def rejoin(self, due: float) -> None:
        """Generate the jumps still to come, after a run was restored; the first is that with ``next[0]`` = ``due``."""
        self._known = dropwhile(lambda times: times[0] < due, self._at_ends())
        self.go_on()
