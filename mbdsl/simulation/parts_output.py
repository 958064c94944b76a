"""The states of a scene, from those that its parts have reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mbdsl.integrators.loop.compiled_loop import has_own_step
from mbdsl.integrators.run import MethodRun
from mbdsl.numerics.hermite import between
from mbdsl.simulation.assembled_scene import AssembledScene
from mbdsl.simulation.part_run import Array, State

#: t (N,), q, v (N, n), lam (N, m + p)
Ends = tuple[Array, Array, Array, Array]
#: times (N,), q, v (N, n), lam (N, m + p) of the scene, and q and v of each part
Rows = tuple[Array, Array, Array, Array, list[tuple[Array, Array]]]


class PartsOutput(AssembledScene):
    """The output of the parts, at output times and at the ends of steps."""

    _taken = 0  #: steps taken of a scene without parts

    def watch(self) -> None:
        """Keep the ends of all steps, and search fixed steps for peaks of laws between them.

        Called after ``prepare``, before the first step.
        """
        for p in self.parts:
            if isinstance(p.integration, MethodRun):
                p.integration.watch()

    @property
    def time(self) -> float:
        """The time that all parts have reached [s]."""
        return min((p.integration.time for p in self.parts), default=self.plan.start + self._taken * self.plan.h)

    def present(self) -> tuple[Array, Array, Array]:
        """Present q, v (n,) and lam (m + p,)."""
        q, v, lam = self.whole.state(np.array([self.time]), [p.split(p.last) for p in self.parts])
        return q[0], v[0], lam[0]

    def rows(self, times: Array, states: Sequence[State]) -> Rows:
        """The rows of the scene at ``times`` (N,), from those of its parts."""
        return times, *self.whole.state(times, states), [(q, v) for q, v, _ in states]

    def output(self, partial: bool) -> Rows:
        """Times (N,), q, v (N, n) and lam (N, m + p) from the start on, and q and v of each part.

        ``partial`` includes the last step reached, even if it is not an output time. Times that are not ``shown`` are
        left out.
        """
        plan, reached = self.plan, self.time
        if plan.every and self.parts:
            return self._output_of_every_step()
        done = min((p.integration.written for p in self.parts), default=len(plan.times))
        if not self.parts:
            done = int((plan.times <= reached + 1e-9 * plan.h).sum())
        times = np.concatenate([[plan.start], plan.times[:done]])
        extra = partial and reached > times[-1] + 1e-9 * plan.h
        if extra and any(p.integration.time != reached for p in self.parts):
            extra = False  # a part that is ahead cannot go back
        states = []
        for p in self.parts:
            rows = [p.first, p.integration.out[:done], *([p.last] if extra else [])]
            states.append(p.split(np.concatenate(rows)))
        if extra:
            times = np.append(times, reached)
        if plan.shown is not None:
            shown = np.concatenate([[True], plan.shown[:done], np.ones(int(extra), bool)])
            times, states = times[shown], [(q[shown], v[shown], lam[shown]) for q, v, lam in states]
        return self.rows(times, states)

    def states(self) -> tuple[Array, Array, Array]:
        """Times (N,), q and v (N, n) at the start and at all times of the plan that the present run has reached."""
        shown = self.plan
        self.plan = replace(shown, shown=None)
        t, q, v, *_ = self.output(False)
        self.plan = shown
        return t, q, v

    def _output_of_every_step(self) -> Rows:
        """For parts with steps of their own: at the steps of all parts, up to the time that all have reached."""
        done = [(p, p.integration, p.integration.written) for p in self.parts]
        known = [np.append(self.plan.start, run.times[:count]) for _, run, count in done]
        states = [p.split(np.concatenate([p.first, run.out[:count]])) for p, run, count in done]
        return self.rows(*self._together(known, states))

    def _together(
        self, known: Sequence[Array], states: list[State], precise: bool = False
    ) -> tuple[Array, list[State]]:
        """The states of all parts at all of their ``known`` times that all of them have reached.

        Between its own times, a part has cubic polynomials; ``precise``: of degree 5.
        """
        if all(np.array_equal(known[0], t) for t in known):
            return known[0], states
        times = np.unique(np.concatenate(known))
        times = times[(times >= max(t[0] for t in known)) & (times <= min(t[-1] for t in known))]
        found = []
        for p, t, own in zip(self.parts, known, states, strict=True):
            a = p.accelerations(t, *own[:2]) if precise else None
            found.append(between(times, t, *own, p.system.tables.rotations[:, 0], a))
        return times, found

    def kept_numbers(self) -> int:
        """Quantity of numbers in the states that the parts keep at the ends of their steps."""
        runs = [p.integration for p in self.parts]
        return sum(rows.size for run in runs if isinstance(run, MethodRun) for rows in run.ends)

    def forgo(self) -> None:
        """Keep no further ends of steps."""
        for p in self.parts:
            if isinstance(p.integration, MethodRun):
                p.integration.forgo()

    def ends_of_steps(self) -> Callable[..., Ends] | None:
        """A function that returns times (N,), q, v (N, n) and lam (N, m + p) at the ends of the steps that all parts
        have taken so far, and on both sides of jumps of forces; None if they are not kept.

        Its argument is a slice of the kept states (:meth:`blocks`).
        """
        parts: list[list[Array]] = []  # joined when they are needed
        for p in self.parts:
            run = p.integration
            if not isinstance(run, MethodRun) or not run.keeps:
                return None
            run.flush()
            parts.append(run.ends[:])
        sizes, whole, together = [p.system.n for p in self.parts], self.whole, self._together
        precise = has_own_step(self.plan.method)

        def found(some: slice = slice(None)) -> Ends:
            for of_part in parts:
                of_part[:] = [np.concatenate(of_part)] if len(of_part) > 1 else of_part
            states = [_ordered(rows[some], n) for (rows,), n in zip(parts, sizes, strict=True)]
            times, known = together([t for t, *_ in states], [(q, v, lam) for _, q, v, lam in states], precise)
            return times, *whole.state(times, known, own=False)

        return found if parts else None

    def blocks(self, rows: int) -> list[slice]:
        """Slices of about so many kept states, each with the last state of the one before; one of all, if they are
        those of several parts, or not in order."""
        run = self.parts[0].integration
        assert isinstance(run, MethodRun)
        times = run.kept[:, 0]
        if len(self.parts) > 1 or not (np.diff(times) > 0.0).all():
            return [slice(None)]
        return [slice(k, k + rows + 1) for k in range(0, len(times) - 1, rows)] or [slice(None)]

    def release_steps(self, until: float) -> None:
        """Forget the ends of steps before a time [s], but the last of each part."""
        for p in self.parts:
            run = p.integration
            assert isinstance(run, MethodRun)
            rows = run.kept
            left = rows[-1:]
            if len(self.parts) > 1 or left[0, 0] != until:
                before = rows[:, 0] <= until
                left = rows[rows[:, 0] >= rows[before, 0].max()]
            run.ends = [left.copy()]


def _ordered(rows: Array, n: int) -> tuple[Array, Array, Array, Array]:
    """t, q, v and lam of kept states at ascending times."""
    if not (np.diff(rows[:, 0]) > 0.0).all():
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        while len(same := 1 + np.flatnonzero(np.diff(rows[:, 0]) <= 0.0)):
            rows[same, 0] = np.nextafter(rows[same - 1, 0], np.inf)
    return rows[:, 0].copy(), rows[:, 1 : 1 + n], rows[:, 1 + n : 1 + 2 * n], rows[:, 1 + 2 * n :]
