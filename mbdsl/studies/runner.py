"""Runs of a study: taken from the store or computed on all cores; timed runs are made alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from time import perf_counter
from uuid import uuid4

import numpy as np

from mbdsl.mechanism import graph
from mbdsl.simulation.stored_events import of_meta
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, Setting
from mbdsl.studies.compute import compute, simulate_case
from mbdsl.studies.run_order import AsGiven, Order
from mbdsl.studies.store import OUT_OF_TIME, Computed, Store
from mbdsl.studies.time_limits import Deadline, TooLong
from mbdsl.system import System, build

#: seconds of work after which worker processes are started, which takes half a second
ALONE = 1.0
#: number of runs in a round of timing, and duration [s] above which one run suffices
TRIES, SHORT = 3, 0.02
#: expected time of a compilation [s] before the first one
COMPILING = 5.0
#: largest part of the remaining time for a run while others wait
PART = 0.25
#: a run that was ended is repeated if its time limit is larger than before by this factor
AGAIN = 1.25
#: a run is begun if its expected time is at most this part of the remaining time
HOPE = 2.0
#: largest ratio of run times in two sessions whose times are compared with each other
SPEED = 1.5


@dataclass(frozen=True)
class StudyProgress:
    """Progress of a study: completed runs, all runs, the present run, elapsed time [s], and stored runs."""

    done: int
    total: int
    what: str
    seconds: float
    kept: int = 0


class Runner:
    """Computes the cases of one setting.

    ``budget`` [s] limits the time from now on, with compilation; a case beyond it gets a problem. ``reserved`` [s] is
    the part of it that later phases need. Runs are ``ordered`` by their expected times; those of a sweep, without a
    common budget, need not be. ``tell`` is called with the progress, ``announce`` with a text before a phase
    that takes long.
    """

    def __init__(
        self,
        setting: Setting,
        store: Store,
        *,
        workers: int | None = None,
        budget: float | None = None,
        ordered: bool = True,
        tell: Callable[[StudyProgress], None] | None = None,
        announce: Callable[[str], None] | None = None,
    ) -> None:
        self.setting, self.store, self.workers, self.announce = setting, store, workers, announce
        store.prune()
        self.tell = tell or (lambda progress: None)
        self.begun = perf_counter()
        self.budget, self.reserved = math.inf if budget is None else budget, 0.0
        self.compiling = COMPILING  #: the longest compilation so far [s]
        self.computed = self.found = 0
        self.kept: set[str] = set()  #: keys of the runs of this study that are in the store
        self.session = uuid4().hex
        self.ordered = ordered
        self.order = Order() if ordered else AsGiven()

    @property
    def left(self) -> float:
        """Remaining time of the budget for the present phase [s]."""
        return self.budget - self.reserved - (perf_counter() - self.begun)

    @contextmanager
    def reserving(self, seconds: float) -> Iterator[None]:
        """Keep so much of the budget for later phases."""
        kept = seconds if math.isfinite(seconds) else 0.0
        self.reserved += kept
        try:
            yield
        finally:
            self.reserved -= kept

    def compute(self, cases: Sequence[Case], what: str = "", limit: float = math.inf) -> dict[Case, Computed]:
        """All cases, from the store or computed, short ones first; each within ``limit`` seconds.

        While others wait, a case may take a part of the remaining time only.
        """
        keys = {case: self.store.key(self.setting, case) for case in cases}
        done, waiting = self._stored(keys)
        total, begun = len(keys), perf_counter()

        def add(case: Case, run: Computed) -> None:
            done[case] = run
            self.computed += not run.late
            if run.lasting and self.store.has_claimed(keys[case]):
                self.kept.add(keys[case])
            self.compiling = max(self.compiling, run.stats.get("seconds", {}).get("compile", 0.0))
            self.order.add(run)
            if run.late and 0.0 < AGAIN * self.order.ended.get(case, math.inf) < min(limit, self.left):
                waiting.append(case)  # it was ended because others waited
            self.order.sort(waiting)
            self._tell(len(done), total, what or str(case))

        def limits(case: Case) -> tuple[float, float, float]:
            left = self.left
            longest = min(limit, left)
            if waiting:
                longest = min(longest, max(PART * left, 2.0 * self.order.expected(case)))
            enough = longest > AGAIN * self.order.ended.get(case, 0.0) and self.order.expected(case) < HOPE * left
            return longest if enough else 0.0, left, self.compiling

        helped = False
        while waiting:
            if perf_counter() - begun > ALONE and len(waiting) > 1 and not helped:
                from mbdsl.studies.workers import cores, side_by_side

                helped, number = True, min(cores() if self.workers is None else self.workers, len(waiting))
                if number > 1:
                    side_by_side(self.setting, self.store, waiting, number, limits, add)
                    if waiting and self.announce is not None:
                        self.announce(
                            "worker processes could not start, could not write their results, or found that mbdsl or "
                            "a method has changed since the study began: the remaining cases run in this process"
                        )
                    continue
            case = waiting.pop(0)
            self._tell(len(done), total, what or str(case))
            longest, left, compiling = limits(case)
            if longest <= 0.0:
                add(case, _ended(case, self.order.ended.get(case, 0.0)))
                continue
            run = compute(self.setting, case, longest, self.announce, left, compiling)
            if self.ordered:
                self.store.put_spent(keys[case], run)
            if run.lasting:
                self.store.put(keys[case], run)
            add(case, run)
        return done

    def step_time(self, case: Case, what: str = "") -> float | None:
        """The time of a step [s] in a run of ``case``; None if the run fails, or takes no steps."""
        run = self.compute([case], what)[case]
        return run.stats["seconds"]["integrate"] / run.stats["steps"] if run.done and run.stats.get("steps") else None

    def _stored(self, keys: Mapping[Case, str]) -> tuple[dict[Case, Computed], list[Case]]:
        """The runs that are in the store, and the other cases in the order in which they are run."""
        done: dict[Case, Computed] = {}
        for case, key in keys.items():
            kept = self.store.get(key, case)
            if kept is not None:
                done[case] = kept
                self.order.add(kept)
                self.kept.add(key)
        self.found += len(done)
        waiting = [case for case in keys if case not in done]
        for case in waiting if self.ordered else ():
            if seconds := self.store.spent(keys[case]):
                self.order.add(_ended(case, seconds))
        self.order.sort(waiting)
        return done, waiting

    def _tell(self, done: int, total: int, what: str) -> None:
        self.tell(StudyProgress(done, total, what, perf_counter() - self.begun, len(self.kept)))

    def seconds(self, run: Computed) -> float:
        """The time of a run; the shortest of a few if it is short, because the machine has other work as well."""
        tries = [run.stats["seconds"]["integrate"]]
        while len(tries) < TRIES and sum(tries) < SHORT and self.left > tries[0]:
            tries.append(self._timed(run.case) or tries[0])
        return min(tries)

    def time(self, cases: Sequence[Case], repeats: int, slowest: Callable[[Case], float]) -> dict[Case, list[float]]:
        """Seconds of the step loops, in ``repeats`` rounds within the budget: one run at a time, cases in alternation.

        For short runs a round takes the shortest of up to ``TRIES``, because the machine has other work as well.
        ``slowest(case)`` is the approximate time of a run, known from a previous one; short ones come first. Rounds
        that are stored are not repeated, unless the speed of the machine has changed.
        """
        seconds = self._times(cases, repeats)
        total, done = repeats * len(cases), sum(map(len, seconds.values()))
        for round_ in range(repeats):
            for case in sorted(cases, key=slowest):
                if len(seconds[case]) > round_ or self.left < slowest(case):
                    continue
                self._tell(done, total, f"timing {case}")
                found = self._round(case)
                if found is None:
                    continue
                seconds[case].append(found)
                self.store.put_times(self.store.key(self.setting, case), self.session, seconds[case])
                done += 1
        return {case: found for case, found in seconds.items() if found}

    def _round(self, case: Case) -> float | None:
        """The shortest of up to ``TRIES`` runs [s]; None if the budget was spent before the first was complete."""
        tries: list[float] = []
        while len(tries) < TRIES and (not tries or sum(tries) < SHORT):
            one = self._timed(case)
            if one is None:
                break
            tries.append(one)
        return min(tries, default=None)

    def _timed(self, case: Case) -> float | None:
        """Seconds of the step loop of one run; None if the budget was spent first."""
        deadline = Deadline(math.inf, self.left)
        try:
            found = deadline.run(lambda: simulate_case(self.setting, case, deadline))
        except TooLong:
            return None
        return found.stats["seconds"]["integrate"]

    def _times(self, cases: Sequence[Case], repeats: int) -> dict[Case, list[float]]:
        """Stored times of earlier rounds, by session: those of all cases from one session, or from sessions in which
        the machine had its present speed."""
        kept = {case: self.store.times(self.store.key(self.setting, case)) for case in cases}
        sessions = {session for session, _ in kept.values()} - {""}
        whole = len(sessions) == 1 and all(len(seconds) >= repeats for _, seconds in kept.values())
        if not whole:
            sessions = {s for s in sessions if s == self.session or self._as_fast(s, kept)}
        return {case: seconds[:repeats] if session in sessions else [] for case, (session, seconds) in kept.items()}

    def _as_fast(self, session: str, kept: Mapping[Case, tuple[str, list[float]]]) -> bool:
        """Whether the shortest run of a session takes the same time now, to a factor of ``SPEED``."""
        before = {case: min(seconds) for case, (own, seconds) in kept.items() if own == session}
        case = min(before, key=before.__getitem__)
        now = self._round(case) if self.left > before[case] else None
        return now is not None and 1.0 / SPEED < now / before[case] < SPEED

    @cached_property
    def _system(self) -> System:
        return build(self.setting.scene, graph.build(self.setting.scene))

    def trajectory(self, run: Computed) -> Trajectory:
        """A run as a trajectory, for access to its signals."""
        found = Trajectory(self._system, run.t, run.q, run.v, run.lam, dict(run.stats), inputs=run.numbers)
        found.find_events = partial(of_meta, run.stats)
        return found

    def blank(self) -> Trajectory:
        """An empty trajectory, for names and units."""
        nothing = np.zeros((0, self._system.n))
        return Trajectory(self._system, np.zeros(0), nothing, nothing, None, {"status": "done"})


def _ended(case: Case, seconds: float) -> Computed:
    """A run that was ended after ``seconds`` of its step loop."""
    return Computed(case, stats={"seconds": {"integrate": seconds}} if seconds else {}, problem=OUT_OF_TIME)
