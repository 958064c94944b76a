"""Steps that end in the zones around peaks of laws, so that no step passes over a peak.

Zones are defined in :mod:`mbdsl.system.peaks_in_time`. Those of functions of time are generated as the run proceeds;
the compiled loop holds the next ones. A zone is not an event: the integration is not restarted there, a step only ends
in it, so that its error estimate contains the force.

Peaks of laws of the state within a step (:mod:`mbdsl.system.peaks_along_motion`) are searched after a number of steps,
for all of them at once. If a step has passed over a peak, the run returns to the state of the last search, with the new
zone added.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.expressions.symbolic import leaves
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.switch_location import MIDDLE
from mbdsl.integrators.run_state import RECORDED, RunState
from mbdsl.system.close_approaches import Approach, Approaches
from mbdsl.system.peaks_along_motion import OnTheWay
from mbdsl.system.peaks_in_time import Zone, time_zones
from mbdsl.system.switches import within

if TYPE_CHECKING:
    from mbdsl.expressions.symbolic import Expr
    from mbdsl.integrators.event_set import EventSet
    from mbdsl.system.switches import Switch

#: t (N,), q and v (N, n), lam (N, m + p)
States = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]

#: longest controlled step, relative to the run
LONGEST = 0.02
#: largest number of steps that are searched together, and of floats recorded for them
BATCH, NUMBERS = 1024, 400_000
#: a motion slides if MANY successive steps advance the run by less than STANDSTILL of its length, and a switch changes
#: in more than the fraction OFTEN of them
MANY, STANDSTILL, OFTEN = 256, 1e-6, 0.125
#: number of operations of a search after which the run returns to its caller, which handles interruptions: 0.1 s
PAUSE = 3e6
#: number of steps searched together at first, and after a peak was found; it then doubles with each search
FEW = 8
#: largest number of returns for peaks within one interval, and its length relative to the run; the number has a limit
#: because a force may change sign with the velocity that it causes in every step, however short
MOST, PLACE = 40, 1e-9
#: order of a method up to which steps end in the middle of zones
ORDINARY = 5
#: no zones are due
NOTHING: tuple[int, list[Zone]] = 0, []


def landing_part(order: int, tol: float) -> float:
    """The part of a zone after which a step of a method of this order ends.

    The long steps of high order are given by zones alone, as in a contact: two runs with the same steps have the same
    errors, and their difference shows none. The part therefore depends on the tolerance: consecutive multiples of the
    golden ratio are far from each other after whole numbers are removed.
    """
    golden = 0.6180339887498949
    return MIDDLE if order <= ORDINARY else 0.35 + 0.3 * (golden * math.log2(tol) % 1.0)


class Landings:
    """The zones of a run with controlled steps.

    ``blame`` is called with the switches that change in step after step, if the run stops for that; ``events`` are the
    when-equations, whose ticks are undone with the steps.
    """

    def __init__(self, run: RunState, blame: Callable[[list[Switch]], None], events: EventSet | None) -> None:
        self._run, self._blame, self._events = run, blame, events
        self._zones: Iterator[Zone] = iter(())
        self._pending: list[tuple[float, float]] = []
        self._looks, self._approaches = run.system.kept(OnTheWay), run.system.kept(Approaches)
        run.approaches, run.approaching = [], np.zeros((5, len(self._approaches.arguments)))
        self._searching = run.grid == 0.0 and bool(self._looks.terms or self._approaches.arguments)
        self.record()
        self._together = (
            FEW,
            FEW,
        )  #: steps that the next searches take together, which may double; those of the next one
        self._tries, self._from = 0, -np.inf
        self.unresolved: Expr | None = None  #: the law or condition in which every step, however short, may hide a peak
        #: number of steps that come before zones that were found, and these zones
        self._due = NOTHING

    def record(self) -> None:
        """Record the states at the ends of steps if they are searched, or if the run keeps them."""
        run, width = self._run, 1 + self._run.system.n + self._run.system.unknowns
        if self._searching:
            run.record(min(BATCH * width, NUMBERS), False)
        else:
            run.record(RECORDED if run.keeps else 0, run.keeps)

    def begin(self, t: float) -> None:
        """Generate the zones from t on, at the start of the run."""
        self._zones = self._all(t)
        self.refill()

    def _all(self, t: float) -> Iterator[Zone]:
        """The zones from t on; of fixed steps that end at events, those of conditions, so that none is passed over."""
        run = self._run
        if not run.grid:
            return run.system.time_zones(t, run.stop, LONGEST * run.span)
        laws = run.system.laws
        found = [laws[x] for x in run.system.scene.conditions if x in laws]
        found = [x for x in found if leaves(x) and all(leaf.op == "time" for leaf in leaves(x))]
        return self._of_conditions(found, t) if found else iter(())

    def _of_conditions(self, found: Sequence[Expr], t: float) -> Iterator[Zone]:
        """The zones of conditions that depend on time alone; a run without a stop time has one at the end of each span
        as well, so that the search goes no further than the run."""
        run, longest = self._run, 1.1 * self._run.grid
        while run.stop - t > 2.0 * run.span:
            begin, t = t, t + run.span
            over = 16.0 * longest  # pulses at the end of a span have neighbours
            zones = time_zones(found, begin - over, t + over, longest)
            yield from (zone for zone in zones if begin <= zone.start < t)
            yield Zone(t - 0.1 * run.grid, t + 0.1 * run.grid, found[0])
        yield from time_zones(found, t, run.stop, longest)

    def rejoin(self) -> None:
        """Restore the zones that the compiled loop does not hold, after the run was restored from a checkpoint."""
        run, self._pending = self._run, []
        run.approaches = [Approach(*x) for x in run.approaches]
        held = {tuple(zone) for zone in run.reals[S.ZONE : S.ZONE + 2 * run.integers[S.ZONES]].reshape(-1, 2).tolist()}
        every = self._all(run.start) if held else ()
        self._zones = (zone for zone in every if (zone.start, zone.end) not in held)

    def refill(self) -> None:
        """Write the next zones into ``reals`` for the compiled loop."""
        run = self._run
        ahead = ((z.start, z.end) for z in self._zones if z.start > run.time)
        self._pending += islice(ahead, max(0, S.ROOM - len(self._pending)))
        now = sorted((zone for zone in self._pending if zone[0] > run.time), key=lambda zone: zone[1])
        run.reals[S.ZONE : S.ZONE + 2 * len(now[: S.ROOM])] = np.ravel(now[: S.ROOM])
        run.integers[S.NEXT_ZONE], run.integers[S.ZONES], self._pending = 0, len(now[: S.ROOM]), now[S.ROOM :]

    def insert(self, zones: Iterable[Zone]) -> None:
        """Add further zones."""
        reals, integers = self._run.reals, self._run.integers
        known = reals[S.ZONE + 2 * integers[S.NEXT_ZONE] : S.ZONE + 2 * integers[S.ZONES]].reshape(-1, 2)
        self._pending += [(a, b) for a, b in known.tolist()] + [(z.start, z.end) for z in zones]
        self.refill()

    def _insert_due(self, taken: int) -> int:
        """Add the zones that were found, if the steps before them have been taken again; else their number.

        A zone that is known earlier may shorten an attempt of one of these steps. The steps would then depend on how
        many of them are searched together, and thus on the clock.
        """
        left, zones = self._due
        self._due = max(0, left - taken), zones
        if self._due[0] == 0 and zones:
            self.insert(zones)
            self._due = NOTHING
        return self._due[0]

    def advance(self, steps: int, call: Callable[[int], int]) -> int:
        """Take at most ``steps`` steps in the compiled loop, search them for hidden peaks, and return a status."""
        run = self._run
        if not self._searching:
            while (status := self._recorded(steps, call)) == S.LOOK:
                self.refill()
            return status
        status, begun = S.RUNNING, self._looks.spent
        most, batch = self._together
        while steps > 0 and status == S.RUNNING and self._looks.spent - begun < PAUSE:
            spent = self._looks.spent
            before, t = [x.copy() for x in run.state_of_steps()], run.time
            ticked = self._events.taken() if self._events is not None else None
            first = np.concatenate([[t], *run.state()])
            run.integers[S.NOTED] = 0
            status = call(min(steps, batch))
            rows = run.recorded
            states = self._states(np.vstack([first, rows]))
            zones = self._unseen(states)
            if zones:
                passed = int((rows[:, 0] <= zones[0].start).sum())  # steps that are taken again as they were
                for x, kept in zip(run.state_of_steps(), before, strict=True):
                    x[...] = kept
                if self._events is not None and ticked is not None:
                    self._events.give_back(ticked)
                if zones[0].start - self._from > PLACE * run.span:
                    self._tries, self._from = 0, zones[0].start
                self._tries += 1
                if self._tries > MOST:
                    self.unresolved = zones[0].term
                    changing = within(zones[0].term, run.system.tables.switches)
                    self._blame(changing)
                    return S.SLIDING if changing else S.TOO_SMALL
                self._due = passed, zones
                status, batch = S.RUNNING, self._insert_due(0) or FEW
                most = batch + FEW  # where there is one peak, another may follow
                self._together = most, batch
                continue
            self._note_approaches(states)
            run.keep_ends(rows)
            if changing := self._chattering(rows):
                self._blame(changing)
                return S.SLIDING
            quick = self._looks.spent - spent < PAUSE
            most = min(2 * most, int(run.integers[S.NOTES])) if quick else max(1, most // 4)
            steps, batch = steps - max(1, len(rows)), self._insert_due(len(rows)) or most
            self._together = most, batch
            if status == S.LOOK:
                self.refill()
                status = S.RUNNING
            if status == S.DONE:
                return status
        return status

    def _recorded(self, steps: int, call: Callable[[int], int]) -> int:
        """Take at most ``steps`` steps, and keep their ends; a status."""
        run, status = self._run, S.RUNNING
        if not run.integers[S.NOTES]:
            return call(steps)
        while steps > 0 and status == S.RUNNING:
            if 2 * run.integers[S.NOTED] > run.integers[S.NOTES]:
                run.drain()
            some = min(steps, int(run.integers[S.NOTES] - run.integers[S.NOTED]))  # attempts count as well
            status, steps = call(some), steps - some
        return status

    def _chattering(self, rows: np.ndarray) -> list[Switch]:
        """The switches that change in many of the recorded steps, if these advance the run by almost no time."""
        run, n = self._run, self._run.system.n
        if len(rows) < MANY or rows[-1, 0] - rows[0, 0] > STANDSTILL * run.span:
            return []
        cut = np.cumsum([1, n, n])
        states = np.array([run.system.switches(t[0], *rest) for t, *rest in (np.split(x, cut) for x in rows)])
        changes = (states[1:] != states[:-1]).sum(axis=0)
        return [x for x, count in zip(run.system.tables.switches, changes, strict=True) if count > OFTEN * len(rows)]

    def _states(self, rows: np.ndarray) -> States:
        """Split recorded rows into t, q, v and lam."""
        n = self._run.system.n
        return rows[:, 0], rows[:, 1 : 1 + n], rows[:, 1 + n : 1 + 2 * n], rows[:, 1 + 2 * n :]

    @property
    def _inputs(self) -> dict[str, float]:
        run = self._run
        return {name: float(run.numbers[at]) for name, at in run.system.tables.inputs.items()}

    def _unseen(self, states: States) -> list[Zone]:
        run = self._run
        if len(states[0]) < 2 or not self._looks.terms:
            return []
        given = float(run.reals[S.LEAST_H]), run.seen, run.searched, run.turns
        return self._looks.first(states, self._inputs, *given)

    def _note_approaches(self, states: States) -> None:
        run = self._run
        if len(states[0]) > 1 and self._approaches.arguments:
            run.synchronise()
            self._approaches.add(run.approaches, run.approaching, states, self._inputs, run.left_out)
