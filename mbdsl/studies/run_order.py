"""The order of the runs of a study: short ones first, so that a limited time completes as many as possible.

The expected time of a run follows from a completed run of the same series: it grows as 1/h with fixed steps, and as
tol^(-1/(p + 1)) with a tolerance, where p is the order of the method.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mbdsl.studies.cases import Case
from mbdsl.studies.store import Computed

UNKNOWN = 1e-9  #: expected time of the first run of a series [s]: it comes before all others
ONCE_MORE = 2.0  #: least expected time of a run, relative to the time after which it was ended


@dataclass
class Order:
    """Sizes and times of completed runs, and times after which runs were ended."""

    done: dict[tuple[str, bool], list[tuple[float, float]]] = field(default_factory=dict)
    ended: dict[Case, float] = field(default_factory=dict)

    def add(self, run: Computed) -> None:
        """Learn from a run."""
        seconds = run.stats.get("seconds", {}).get("integrate", 0.0)
        if run.late and seconds:
            self.ended[run.case] = max(seconds, self.ended.get(run.case, 0.0))
        elif run.done:
            self.done.setdefault(_line(run.case), []).append((run.case.size, seconds))

    def expected(self, case: Case) -> float:
        """The expected time of a run [s]."""
        known = self.done.get(_line(case))
        least = ONCE_MORE * self.ended.get(case, 0.0)
        if not known:
            return max(least, UNKNOWN / case.size)
        size, seconds = min(known, key=lambda one: abs(one[0] - case.size))
        return max(least, seconds * (size / case.size) ** case.growth)

    def sort(self, cases: list[Case]) -> None:
        """Sort cases in place by their expected times."""
        cases.sort(key=lambda case: (self.expected(case), -case.size))


class AsGiven(Order):
    """The order in which runs are given, for those that have no common budget."""

    def add(self, run: Computed) -> None:
        pass

    def expected(self, case: Case) -> float:
        return 0.0

    def sort(self, cases: list[Case]) -> None:
        pass


def _line(case: Case) -> tuple[str, bool]:
    return case.series, case.ends
