"""Peaks of laws that the steps of a solver would pass over."""

from __future__ import annotations

import numpy as np

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem
from mbdsl.kernels.arrays import Array
from mbdsl.system.close_approaches import Approaches
from mbdsl.system.index1 import Index1
from mbdsl.system.peaks_along_motion import Turns
from mbdsl.system.peaks_in_time import Zone
from mbdsl.system.switches import law_of

State = tuple[float, Array, Array]


#: bound of the rounding error of a known time [units in the last place of the largest time]
ULPS = 64


#: largest number of repetitions of a step that passes over a peak
TRIES = 100


UNSEEN = "a force acts for so short a time that no step can end within it"


UNSEEN_HINT = "try a wider window, or another method; see `mbdsl methods`"


#: largest number of steps that are searched for peaks together
TOGETHER = 32
#: number of steps beyond a peak in the search after it was found, which doubles with each search
FEW = 2


class Peaks:
    """The zones in which steps have to end: :mod:`mbdsl.system.peaks_in_time`."""

    def __init__(self, problem: Problem) -> None:
        self._system, self._f = problem.system, Index1(problem.system, problem.left_out)
        self._left_out = problem.left_out
        self._zones = iter(problem.zones)
        self._ahead: list[Zone] = []  #: known zones of functions of time, and zones found on the path
        self._least = ULPS * float(np.finfo(float).eps) * max(abs(problem.start), abs(problem.stop))
        self._inputs = {name: x.start for name, x in problem.system.scene.inputs.items()}
        self._last = self._from = -np.inf
        self._tries = 0
        self._peaks = problem.peaks
        self._seen, self._searched = np.zeros(len(self._peaks.terms)), problem.searched
        self._approaches, self._found = problem.system.kept(Approaches), problem.approaches
        self._approaching = np.zeros((5, len(self._approaches.arguments)))
        tables = problem.system.tables
        counted = bool(tables.angles) or any(body.counter >= 0 for body in tables.models.values())
        #: largest number of steps searched together; 1 if turns are counted, because the last accepted state is needed
        self.most = 1 if counted or not len(self._seen) else TOGETHER

    def passed(self, t: float, end: float) -> float | None:
        """The middle of the first known zone that a step from t to ``end`` passes over."""
        while self._last < end and (zone := next(self._zones, None)) is not None:
            self._ahead.append(zone)
            self._last = zone.start
        first = min((x for x in self._ahead if t < x.start and x.end < end), key=lambda x: x.end, default=None)
        return None if first is None else 0.5 * (first.start + first.end)

    def unseen(self, states: list[State]) -> int:
        """Number of steps between ``states`` to keep: all, or those before the first peak that no state shows.

        Raises
        ------
        IntegrationError
            If a peak is still passed over after ``TRIES`` repetitions.
        """
        last = len(states) - 1
        if last and self._peaks.terms:
            t, q, v = (np.array(x) for x in zip(*states, strict=True))
            lam = np.zeros((len(t), self._system.m + self._system.p))
            if self._system.of_multipliers:
                lam = np.array([self._f.motion(*x)[1] for x in states])
            turns = Turns(0, self._system.counted_angles())
            if found := self._peaks.first((t, q, v, lam), self._inputs, self._least, self._seen, self._searched, turns):
                last = int(np.searchsorted(t, found[0].start, side="right")) - 1
                if last:  # update self._seen by the steps that are kept
                    kept = slice(last + 1)
                    part = t[kept], q[kept], v[kept], lam[kept]
                    self._peaks.first(part, self._inputs, self._least, self._seen, self._searched, turns)
                self._ahead += found
                self._tries, self._from = (self._tries + 1 if self._from == t[last] else 0), t[last]
                if self._tries > TRIES:
                    law = law_of(self._system.scene, [found[0].term])
                    raise IntegrationError(UNSEEN, None if law is None else law.span, hint=UNSEEN_HINT)
        self._ahead = [zone for zone in self._ahead if zone.start > states[last][0]]
        if last and self._approaches.arguments:
            t, q, v = (np.array(x) for x in zip(*states[: last + 1], strict=True))
            lam = np.zeros((len(t), self._system.m + self._system.p))
            if self._system.tables.switches_of_multipliers:
                lam = np.array([self._f.motion(*x)[1] for x in states[: last + 1]])
            self._approaches.add(self._found, self._approaching, (t, q, v, lam), self._inputs, self._left_out)
        return last
