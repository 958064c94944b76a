"""Runs of a study: taken from the store, or computed on all cores; times are taken alone."""

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

#: seconds of work after which other processes are called for help: they take half a second to begin
ALONE = 1.0
#: runs of one round of timing, unless one takes long [s]
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
    """Computes cases of one setting.

    ``budget`` [s] is what may be spent from now on; what does not fit in is a problem of its case. ``tell`` is told how
    far it is, ``announce`` what takes long before it starts.
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
        self.tell = tell or (lambda told: None)
        self.begun = perf_counter()
        self.budget = math.inf if budget is None else budget
        self.computed = self.found = 0
        self.kept: set[str] = set()  #: keys of the runs of this study that are in the store
        self.session = uuid4().hex  #: times are compared with each other where they are of one

    @property
    def left(self) -> float:
        """Seconds of the budget that are left."""
        return self.budget - (perf_counter() - self.begun)

    def compute(self, cases: Sequence[Case], what: str = "", limit: float = math.inf) -> dict[Case, Computed]:
        """Every case, from the store or run, coarse ones first; each in ``limit`` seconds, or not at all."""
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
            # compiling is done once and for all; it is no part of the study
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
        """Seconds of the step loops, in ``repeats`` rounds as far as the budget goes: alone, alternately.

        A round takes the least of up to ``TRIES`` runs of what is short, as others use the machine, too.
        ``slowest(case)`` is about what a run takes, which has been done before.
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
        """Times of earlier rounds, if one session took all that are wanted: a machine is not as quick every day."""
        kept = {case: self.store.times(key_of(self.setting, case)) for case in cases}
        sessions = {session for session, _ in kept.values()}
        whole = len(sessions) == 1 and all(len(seconds) >= repeats for _, seconds in kept.values())
        own = sessions <= {self.session, ""}
        return {case: seconds[:repeats] if whole or own else [] for case, (_, seconds) in kept.items()}

    @cached_property
    def _system(self) -> System:
        return build(self.setting.scene, graph.build(self.setting.scene))

    def trajectory(self, run: Computed) -> Trajectory:
        """A run as a trajectory, to ask for its signals."""
        return Trajectory(self._system, run.t, run.q, run.v, run.lam, dict(run.stats))

    def blank(self) -> Trajectory:
        """One of no run, to ask for names and units."""
        nothing = np.zeros((0, self._system.n))
        return Trajectory(self._system, np.zeros(0), nothing, nothing, None, {"status": "done"})
