"""Runs of a study: taken from the store or computed on all cores; timed runs are made alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from uuid import uuid4

import numpy as np

from mbdsl.mechanism import graph
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, Setting
from mbdsl.studies.compute import compute, simulate_case
from mbdsl.studies.store import Computed, Store, key_of
from mbdsl.system import System, build

#: seconds of work after which worker processes are started, which takes half a second
ALONE = 1.0
#: number of runs in a round of timing, and duration [s] above which one run suffices
TRIES, SHORT = 3, 0.02


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

    ``budget`` [s] limits the time from now on; a case beyond it gets a problem. ``tell`` is called with the progress,
    ``announce`` with a text before a phase that takes long.
    """

    def __init__(
        self,
        setting: Setting,
        store: Store,
        *,
        workers: int | None = None,
        budget: float | None = None,
        tell: Callable[[StudyProgress], None] | None = None,
        announce: Callable[[str], None] | None = None,
    ) -> None:
        self.setting, self.store, self.workers, self.announce = setting, store, workers, announce
        store.prune()
        self.tell = tell or (lambda progress: None)
        self.begun = perf_counter()
        self.budget = math.inf if budget is None else budget
        self.computed = self.found = 0
        self.kept: set[str] = set()  #: keys of the runs of this study that are in the store
        self.session = uuid4().hex  #: only times of one session are compared with each other

    @property
    def left(self) -> float:
        """Remaining time of the budget [s]."""
        return self.budget - (perf_counter() - self.begun)

    def compute(self, cases: Sequence[Case], what: str = "", limit: float = math.inf) -> dict[Case, Computed]:
        """All cases, from the store or computed, coarse ones first; each within ``limit`` seconds."""
        done: dict[Case, Computed] = {}
        for case in cases:
            key = key_of(self.setting, case)
            kept = self.store.get(key, case)
            if kept is not None:
                done[case] = kept
                self.kept.add(key)
        self.found += len(done)
        waiting = sorted((c for c in dict.fromkeys(cases) if c not in done), key=lambda c: -c.size)
        total, begun = len(done) + len(waiting), perf_counter()

        def add(case: Case, run: Computed) -> None:
            done[case] = run
            self.computed += not run.late
            key = key_of(self.setting, case)
            if run.lasting and self.store.has_claimed(key):
                self.kept.add(key)
            # compilation is not part of the time of the study
            self.budget += run.stats.get("seconds", {}).get("compile", 0.0)
            self._tell(len(done), total, what or str(case))

        helped = False
        while waiting:
            if perf_counter() - begun > ALONE and len(waiting) > 1 and not helped:
                from mbdsl.studies.workers import cores, side_by_side

                helped, number = True, min(cores() if self.workers is None else self.workers, len(waiting))
                if number > 1:
                    side_by_side(self.setting, self.store, waiting, number, lambda: min(self.left, limit), add)
                    if waiting and self.announce is not None:
                        self.announce(
                            "worker processes could not start, could not write their results, or found that mbdsl or "
                            "a method has changed since the study began: the remaining cases run in this process"
                        )
                    continue
            case = waiting.pop(0)
            self._tell(len(done), total, what or str(case))
            run = compute(self.setting, case, min(self.left, limit), self.announce)
            if run.lasting:
                self.store.put(key_of(self.setting, case), run)
            add(case, run)
        return done

    def _tell(self, done: int, total: int, what: str) -> None:
        self.tell(StudyProgress(done, total, what, perf_counter() - self.begun, len(self.kept)))

    def time(self, cases: Sequence[Case], repeats: int, slowest: Callable[[Case], float]) -> dict[Case, list[float]]:
        """Seconds of the step loops, in ``repeats`` rounds within the budget: one run at a time, cases in alternation.

        For short runs a round takes the shortest of up to ``TRIES``, because the machine has other work as well.
        ``slowest(case)`` is the approximate time of a run, known from a previous one.
        """
        seconds = self._times(cases, repeats)
        total, done = repeats * len(cases), sum(map(len, seconds.values()))
        for round_ in range(repeats):
            for case in cases:
                if len(seconds[case]) > round_ or self.left < slowest(case):
                    continue
                self._tell(done, total, f"timing {case}")
                tries = []
                while len(tries) < TRIES and (not tries or sum(tries) < SHORT):
                    found = simulate_case(self.setting, case)
                    if found.status == "interrupted":
                        raise KeyboardInterrupt
                    tries.append(found.stats["seconds"]["integrate"])
                seconds[case].append(min(tries))
                self.store.put_times(key_of(self.setting, case), self.session, seconds[case])
                done += 1
        return {case: found for case, found in seconds.items() if found}

    def _times(self, cases: Sequence[Case], repeats: int) -> dict[Case, list[float]]:
        """Times of earlier rounds, if one session measured all of them; the speed of a machine varies."""
        kept = {case: self.store.times(key_of(self.setting, case)) for case in cases}
        sessions = {session for session, _ in kept.values()}
        whole = len(sessions) == 1 and all(len(seconds) >= repeats for _, seconds in kept.values())
        own = sessions <= {self.session, ""}
        return {case: seconds[:repeats] if whole or own else [] for case, (_, seconds) in kept.items()}

    @cached_property
    def _system(self) -> System:
        return build(self.setting.scene, graph.build(self.setting.scene))

    def trajectory(self, run: Computed) -> Trajectory:
        """A run as a trajectory, for access to its signals."""
        return Trajectory(self._system, run.t, run.q, run.v, run.lam, dict(run.stats))

    def blank(self) -> Trajectory:
        """An empty trajectory, for names and units."""
        nothing = np.zeros((0, self._system.n))
        return Trajectory(self._system, np.zeros(0), nothing, nothing, None, {"status": "done"})
