"""Integration of a motion in smooth pieces: a solver stops where the equations jump, and a new one starts behind it.

Steps end at known times of jumps. The states of other switches (:mod:`mbdsl.system.switches`) are compared in the
middle and at the end of every step. If a switch has changed and accelerations jump, the step ends at that time, which
is found by bisection on the solver's own interpolant. If accelerations have a corner and no jump, the step is kept,
because the solver's error estimate has covered it - unless the velocities of the step do not change as the
accelerations behind the corner say: explicit methods have stages without weight, and the estimate is zero if only these
meet a contact. Such a step is repeated up to shortly before the corner, and a new piece starts behind it.

A step across a jump may have no solution; a solver then takes shorter and shorter steps until it fails. The remaining
time to the jump is bridged with constant acceleration. If forces drive the motion back from both sides of a switch, as
sign(v) does at rest, no piece can start, and the run stops with the message ``SLIDING``.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from itertools import chain, islice
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem
from mbdsl.integrators.events import CROWD, HARDLY, LEFT, MANY, STANDSTILL, sliding
from mbdsl.integrators.external._peaks import FEW, ULPS, Array, Peaks, State
from mbdsl.integrators.loop.switch_location import JUMP
from mbdsl.system.index1 import Index1
from mbdsl.system.switches import law_of

NOT_FINITE = "the equations give values that are not finite"
DOMAIN = "an expression leaves its domain, as sqrt at 0 or a table at its end"
#: part of the change of a velocity that a step across a corner has to contain
MISSED = 0.5
#: largest number of corners located within one step; more are not searched for jumps
CORNERS = 10


class Solver(Protocol):
    """The interface of an integrator within one piece."""

    @property
    def t(self) -> float:
        """The time reached [s]."""

    def step(self) -> None:
        """Take one step.

        Raises
        ------
        IntegrationError
            If no step is possible.
        """

    def at(self, t: float) -> tuple[Array, Array]:
        """q and v (n,) at a time within the last step, on the constraints."""


def solve(problem: Problem, begin: Callable[[float, Array, Array, float], Solver]) -> Iterator[State]:
    """Yield the states at all steps and outputs; ``begin(t, q, v, stop)`` returns a solver for the time until ``stop``.

    Several steps are taken, then all of them are searched for peaks of laws at once. If a step has passed over a peak,
    the run returns to the start of that step.
    """
    switches, peaks = _Switches(problem), Peaks(problem)
    start = problem.start, problem.q, problem.v
    walk = _Walk(problem, begin, switches, peaks).states(*start)
    batch = peaks.most
    while True:
        taken, stopped = [_Taken(BEHIND, problem.counts.copy(), start)], None
        try:
            for x in islice(walk, batch):
                taken.append(x)
                while x.kind == OUTPUT:  # within a step: take the end of the step, too
                    taken.append(x := next(walk))
        except IntegrationError as failure:
            stopped = failure
        searched = [n for n, x in enumerate(taken) if x.kind != OUTPUT]
        kept = peaks.unseen([taken[n].state for n in searched])
        last = searched[kept]
        yield from (x.state for x in taken[1 : last + 1] if x.kind != BEHIND)
        start = taken[last].state
        batch = min(2 * batch, peaks.most)
        if kept < len(searched) - 1:
            for what in ("steps", "events"):
                problem.counts[what] = taken[last].counts[what]
            switches.return_to(start[0])
            walk = _Walk(problem, begin, switches, peaks).states(*start)
            batch = min(kept + FEW, peaks.most)
        elif stopped is not None:
            raise stopped
        elif last == 0:
            return


#: kinds of states: the end of a step; an output within a step; the state behind a jump
STEP, OUTPUT, BEHIND = range(3)


class _Taken(NamedTuple):
    """A state of the run, not yet accepted."""

    kind: int
    counts: Counter[str]  #: numbers of events and steps up to this state
    state: State


class _Walk:
    """The states from a state on; the steps between them are not yet searched for peaks."""

    def __init__(
        self,
        problem: Problem,
        begin: Callable[[float, Array, Array, float], Solver],
        switches: _Switches,
        peaks: Peaks,
    ) -> None:
        self.problem, self.begin, self.switches, self.peaks = problem, begin, switches, peaks

    def states(self, t: float, q: Array, v: Array) -> Iterator[_Taken]:
        """Yield them."""
        problem, near = self.problem, self.switches.near
        self.t, self.q, self.v = t, q, v
        self.due = iter([*problem.times[np.searchsorted(problem.times, t, side="right") :], np.inf])
        self.output = next(self.due)
        for known in chain((x for x in problem.breaks if self.t < x < problem.stop - 2.0 * near), (None,)):
            stop = problem.stop if known is None else known - near
            while self.t < stop:
                yield from self._piece(stop)
            if known is not None:
                self._set(self.switches.move(*self._state, known + near - self.t))
                problem.counts["events"] += 1
                yield from self._behind()

    def _piece(self, stop: float) -> Iterator[_Taken]:
        """The states up to a jump or to the time ``stop``."""
        self.switches.begin(*self._state)
        solver, jumped, goal = self.begin(*self._state, stop), False, stop
        while self.t < goal and not jumped:
            try:
                solver.step()
                if (peak := self.peaks.passed(self.t, solver.t)) is not None:
                    solver, goal = self.begin(*self._state, peak), peak
                    continue
                if (corner := self.switches.overlooked(solver, *self._state)) is not None:
                    if corner - self.t <= LEFT * (solver.t - self.t):
                        self._set(self.switches.move(*self._state, corner + self.switches.near - self.t))
                        jumped = True
                        break
                    goal = corner - 0.5 * LEFT * (corner - self.t)
                    solver = self.begin(*self._state, goal)
                    continue
            except IntegrationError as failure:
                self._set(self.switches.pass_over(*self._state, stop, failure))
                jumped = True
                break
            end = self.switches.first_jump(solver, self.t)
            while self.output < end:
                yield self._taken(OUTPUT, self.output, *solver.at(self.output))
                self.output = next(self.due)
            jumped = end < solver.t
            self._set((end, *solver.at(end)))
            if self.t == self.output:
                self.output = next(self.due)
            self.problem.counts["steps"] += 1
            yield self._taken(STEP, *self._state)
        if jumped:
            self._set(self.switches.leave(*self._state, stop))
            yield from self._behind()

    def _behind(self) -> Iterator[_Taken]:
        """The state behind a jump, after output times that were passed over."""
        while self.output <= self.t:
            yield self._taken(OUTPUT, self.output, self.q, self.v)
            self.output = next(self.due)
        yield self._taken(BEHIND, *self._state)

    @property
    def _state(self) -> State:
        return self.t, self.q, self.v

    def _set(self, state: State) -> None:
        self.t, self.q, self.v = state

    def _taken(self, kind: int, *state) -> _Taken:
        return _Taken(kind, self.problem.counts.copy(), state)


class _Switches:
    """The switches of a problem, with their states in the present piece."""

    def __init__(self, problem: Problem) -> None:
        self._system, self._counts, self._span = problem.system, problem.counts, problem.stop - problem.start
        self._f = Index1(problem.system, problem.left_out)
        self.near = ULPS * float(np.finfo(float).eps) * max(abs(problem.start), abs(problem.stop))
        self._any = bool(problem.system.tables.switches)
        self._times: deque[float] = deque(maxlen=MANY)
        self._noticed = problem.tolerances()[1] if problem.tol is not None else np.zeros(problem.system.n)

    def return_to(self, t: float) -> None:
        """Forget the jumps after t."""
        while self._times and self._times[-1] > t:
            self._times.pop()

    def states(self, t: float, q: Array, v: Array) -> NDArray[np.int64]:
        lam = self._f.motion(t, q, v)[1] if self._any and self._system.of_multipliers else None
        return self._system.switches(t, q, v, lam)

    def begin(self, t: float, q: Array, v: Array) -> None:
        """Set the states of the switches at the start of a piece.

        Raises
        ------
        IntegrationError
            If accelerations do not exist there.
        """
        if not np.isfinite(self._f(t, self._f.join(q, v))).all():
            raise IntegrationError(NOT_FINITE, hint=DOMAIN)
        self._old = self.states(t, q, v)

    def move(self, t: float, q: Array, v: Array, s: float) -> State:
        """The state after a short time s with constant acceleration, projected onto the constraints.

        Raises
        ------
        IntegrationError
            If it has values that are not finite.
        """
        a = self._f.motion(t, q, v)[0]
        y = self._f.project(t + s, self._f.join(self._system.moved(q, s * (v + s / 2 * a)), v + s * a))
        if not np.isfinite(y).all():
            raise IntegrationError(NOT_FINITE, hint=DOMAIN)
        return t + s, *self._f.split(y)

    def first_jump(self, solver: Solver, start: float) -> float:
        """The time in the last step of ``solver`` at which the equations first jump; its end if they do not."""
        if not self._any:
            return solver.t
        left = CORNERS
        for end in (0.5 * (start + solver.t), solver.t):
            while left and not self._same(end, *solver.at(end)):
                low, high = self._bisect(lambda t: (t, *solver.at(t)), start, end)
                if self._jumps(*((x, *solver.at(x)) for x in (low, high, end))):
                    return high
                self._old, start, left = self.states(high, *solver.at(high)), high, left - 1
            start = end
        self._old = self.states(start, *solver.at(start))
        return start

    def _same(self, t: float, q: Array, v: Array) -> bool:
        return bool((self.states(t, q, v) == self._old).all())

    def _bisect(self, at: Callable[[float], State], low: float, high: float) -> tuple[float, float]:
        """Narrow the interval from low to high, in which a switch changes, by bisection of the states ``at(t)``."""
        while high - low > self.near / ULPS and low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if self._same(*at(middle)) else (low, middle)
        return low, high

    def _jumps(self, before: State, behind: State, further: State) -> bool:
        """Whether accelerations jump from ``before`` to ``behind``, relative to these and to those at ``further``."""
        a, b, c = (self._f.motion(*x)[0] for x in (before, behind, further))
        return not (np.abs(a - b) <= JUMP * np.abs([a, b, c]).max(axis=0)).all()

    def overlooked(self, solver: Solver, t: float, q: Array, v: Array) -> float | None:
        """The time of a corner if the last step, from t, does not contain the accelerations behind it."""
        end = solver.t
        middle = 0.5 * (t + end)
        if not self._any or (self._same(middle, *solver.at(middle)) and self._same(end, *solver.at(end))):
            return None
        a = [self._f.motion(x, *solver.at(x))[0] for x in (t, middle, end)]
        gained, change = (end - t) / 6.0 * (a[0] + 4.0 * a[1] + a[2]), solver.at(end)[1] - v
        missed = (np.abs(change - gained) > MISSED * np.abs(gained)) & (np.abs(gained) > self._noticed)
        if not missed.any():
            return None

        def on(x: float) -> State:
            return self.move(t, q, v, x - t)

        if self._same(*on(end)):
            return None
        corner, behind = self._bisect(on, t, end)
        return None if self._jumps(on(corner), on(behind), on(end)) else corner

    def pass_over(self, t: float, q: Array, v: Array, stop: float, failure: IntegrationError) -> State:
        """The state behind a switch, shortly before which a solver has failed.

        Raises
        ------
        IntegrationError
            The solver's ``failure``, if there is no switch within reach.
        """
        found = self._next(t, q, v, stop)
        if found is None:
            raise failure
        return found

    def _next(self, t: float, q: Array, v: Array, stop: float) -> State | None:
        """The state behind the next switch, or None if none changes within STANDSTILL of the run."""
        most = min(STANDSTILL * self._span, stop - t)
        if not self._any or self._same(*self.move(t, q, v, most)):
            return None
        _, end = self._bisect(lambda x: self.move(t, q, v, x - t), t, t + most)
        return self.move(t, q, v, end - t)

    def leave(self, t: float, q: Array, v: Array, stop: float) -> State:
        """The state from which the next piece starts, after a switch has changed at t.

        Switches that change within STANDSTILL of the run are passed over.

        Raises
        ------
        IntegrationError
            If the motion does not get away from the switches.
        """
        for _ in range(CROWD):
            self._counts["events"] += 1
            self._times.append(t)
            before, self._old = self._old, self.states(t, q, v)
            found = self._next(t, q, v, stop)
            if found is None:
                if len(self._times) < MANY or t - self._times[0] > HARDLY * self._span:
                    return t, q, v
                break
            t, q, v = found
        changed = [s for s, a, b in zip(self._system.tables.switches, before, self._old, strict=True) if a != b]
        law = law_of(self._system.scene, [s.node for s in changed])
        reason, hint = sliding(changed)
        worst = "" if law is None else f"; worst: the law of {law.kind.name} {law.name}"
        raise IntegrationError(f"{reason}{worst}", None if law is None else law.span, hint=hint)
