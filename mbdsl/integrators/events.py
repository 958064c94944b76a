"""Events: the exact time at which a switch changes, and the new beginning behind it.

A step has ended shortly before (:mod:`mbdsl.integrators.loop.switch_location`), or at a time that was known beforehand.
The little that is left goes with the acceleration there: q + s v + s^2/2 a, v + s a. What its third power leaves of the
constraints is taken out, in the metric of M. Behind the switch a and lam are found anew; q and v go on.

Where forces drive the motion back from both sides of a switch, as sign(v) does at rest, events follow one another and
time does not go on. No step has a solution then, however short, and the run stops and says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import dropwhile
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators import declared
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.switches import Switch, combined

if TYPE_CHECKING:
    from mbdsl.integrators.run import Integration

Array = NDArray[np.float64]
States = NDArray[np.int64]

#: part of the last step that may be left to a switch
LEFT = 1e-3
#: so many events within this part of the whole time are no progress
CROWD, STANDSTILL = 10, 1e-5
#: nor are so many within this part: they would take hours
MANY, HARDLY = 200, 1e-4
#: what is then said
SLIDING = "a condition changes to and fro without end: on both sides of it forces drive the motion back"
SLIDING_HINT = "let the force pass steadily from one side to the other, as tanh(v/v_s) in place of sign(v)"


class Events:
    """The switches of a run with controlled steps.

    Attributes
    ----------
    times : list of float
        When switches have changed so far [s], as far as they are stepped onto.
    """

    def __init__(self, run: Integration) -> None:
        self.run = run
        self.system: System = run.system
        self.times: list[float] = []
        self._known: Iterator[float] = iter(())
        self._recent: list[tuple[float, States]] = []
        self._cut: list[float] = []
        self._hidden: list[Switch] = []

    @property
    def changing(self) -> list[Switch]:
        """The switches that have changed without progress."""
        if not self._recent:
            return self._hidden
        states = np.array([s for _, s in self._recent])
        return _changed(self.system, states.min(axis=0), states.max(axis=0)) or self._hidden

    def blame(self, switches: list[Switch]) -> None:
        """Name ``switches`` that keep changing within steps, however short."""
        self._hidden = switches

    def begin(self, t: float, q: Array, v: Array, lam: Array) -> None:
        """At the start of the run."""
        run, reals, integers, switches = self.run, self.run.reals, self.run.integers, self.system.tables.switches
        if switches:
            integers[loop_state.WATCHING] = True
            integers[loop_state.CORNERS] = all(switch.of_force for switch in switches)
            integers[loop_state.SIGNATURE] = combined(self.system.switches(t, q, v, lam))
            self._known = self.system.time_events(t, run.stop, corners=declared(run.method).order > 2)
            self._next(t)
            reals[loop_state.STEP_SIZE] = run.h = min(run.h, reals[loop_state.NEXT_EVENT] - t)

    def _next(self, t: float) -> None:
        """Steps are to end before the next event that is known: as far before as rounding may matter."""
        before = self.run.reals[loop_state.LEAST_H]
        later = (x - before for x in self._known)
        self.run.reals[loop_state.NEXT_EVENT] = next((x for x in later if x > t + before), np.inf)

    def rejoin(self) -> None:
        """Find the times of events still to come, after the run was restored from a checkpoint."""
        run, before, due = self.run, self.run.reals[loop_state.LEAST_H], self.run.reals[loop_state.NEXT_EVENT]
        if due < np.inf:
            known = self.system.time_events(run.start, run.stop, corners=declared(run.method).order > 2)
            self._known = dropwhile(lambda x: x - before <= due, known)

    def resume(self) -> None:
        """After inputs have changed."""
        run = self.run
        q, v, lam = run.state()
        run.integers[loop_state.SIGNATURE] = combined(self.system.switches(run.time, q, v, lam))

    def come(self) -> int:
        """A step was cut short, or ended at a known time: begin anew if a switch changes here; a status."""
        run, reals, integers, system = self.run, self.run.reals, self.run.integers, self.system
        t, (q, v, lam) = run.time, run.state()
        least, known, cut = (
            reals[loop_state.LEAST_H],
            run.time >= reals[loop_state.NEXT_EVENT],
            integers[loop_state.CUT] > 0,
        )
        at_once = not (known or cut)  # there was no room for a step
        h, integers[loop_state.CUT] = reals[loop_state.STEP_SIZE] if known else reals[loop_state.UNCUT], 0
        if not known:  # without an event, too: a step may be cut short again and again
            self._cut = [*self._cut[1 - 2 * MANY :], t]
            if len(self._cut) == 2 * MANY and t - self._cut[0] < HARDLY * (run.stop - run.start):
                self._recent = self._recent or [(t, system.switches(t, q, v, lam))]
                return loop_state.SLIDING
        run.synchronise()
        old, s = system.switches(t, q, v, lam), 2 * least  # over what a known time may be off by
        if known:
            self._next(t + s)
        try:
            a, lam = accelerations(system, t, q, v, run.left_out)
            if not known:
                most = 4 * least if at_once else LEFT * reals[loop_state.LAST_H]
                found = self._distance(t, q, v, a, lam, old, most)
                if found is None:
                    return self._progress(t, old) if at_once else loop_state.RUNNING
                s = found
            t, q, v = t + s, q + s * (v + s / 2 * a), v + s * a
            q, v = onto_constraints(system, t, q, v, run.left_out)
            a, lam = accelerations(system, t, q, v, run.left_out)
            new = system.switches(t, q, v, lam)
            integers[loop_state.SIGNATURE] = combined(new)
            integers[loop_state.EVENTS] += 1
            self.times.append(t)
            run.begin(q, v, a, lam, run.left_out, t=t, longest=min(h, min(run.stop, reals[loop_state.NEXT_EVENT]) - t))
            return self._progress(t, new)
        except InitialisationError:
            return loop_state.NOT_FINITE if not np.isfinite(system.Q(t, q, v)).all() else loop_state.SINGULAR

    def _distance(self, t: float, q: Array, v: Array, a: Array, lam: Array, old: States, most: float) -> float | None:
        """The time to where a switch has just changed, if that is not further than ``most``."""
        if combined(old) != self.run.integers[loop_state.SIGNATURE]:
            return 0.0  # by what Newton's last correction did

        def same(s: float) -> bool:
            return bool((self.system.switches(t + s, q + s * (v + s / 2 * a), v + s * a, lam) == old).all())

        if same(most):
            return None
        low, high = 0.0, most
        while high - low > max(1e-9 * high, 0.01 * self.run.reals[loop_state.LEAST_H]):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if same(middle) else (low, middle)
        return high

    def _progress(self, t: float, states: States) -> int:
        """Whether time goes on; a status."""
        if self._recent and t - self._recent[0][0] > STANDSTILL * (self.run.stop - self.run.start):
            self._recent = []
        self._recent.append((t, states))
        span = self.run.stop - self.run.start
        if len(self.times) > MANY and t - self.times[-MANY] < HARDLY * span:
            return loop_state.SLIDING
        return loop_state.SLIDING if len(self._recent) > CROWD else loop_state.RUNNING


def _changed(system: System, old: States, new: States) -> list[Switch]:
    return [switch for switch, a, b in zip(system.tables.switches, old, new, strict=True) if a != b]
