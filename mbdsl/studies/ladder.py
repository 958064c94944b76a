"""Runs of one method with decreasing steps or tolerances, and the error estimate of the last.

A run may have a lower order than its method because of a corner in a law, friction or rounding. Therefore the estimate
follows from observed differences. With two runs it is their difference; with three runs the order p is observed, and
the estimate is the difference of the last two divided by r^p - 1, where r is the ratio of their steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from mbdsl.errors import IntegrationError, MbdslError
from mbdsl.integrators import available
from mbdsl.simulation.ladder_constants import LADDER, order_bounds
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case
from mbdsl.studies.error_measures import error, of_motion, worst
from mbdsl.studies.time_limits import TooLong

Run = Callable[[Case], Trajectory]


@dataclass
class Ladder:
    """Runs of one method; ``estimates`` are their error estimates, from the second run on."""

    method: str
    fixed: bool
    sizes: list[float]  #: sizes of completed runs, and of those to come
    runs: list[Trajectory] = field(default_factory=list)
    differences: list[float] = field(default_factory=list)
    estimates: list[float] = field(default_factory=list)
    problem: str = ""

    @property
    def declared(self) -> float:
        """The nominal order of the errors in the step or the tolerance."""
        return float(available()[self.method].order) if self.fixed else 1.0

    @property
    def order(self) -> float | None:
        """The observed order, at most the declared one; None with fewer than three runs."""
        if len(self.differences) < 2:
            return None
        count = len(self.runs)
        if self.fixed:
            seen = observed(self.sizes[count - 3 : count], self.differences[-2:])
        else:  # a difference is about the error of the previous run
            one, two = self.differences[-2:]
            ratio = math.log(self.sizes[count - 3] / self.sizes[count - 2])
            seen = math.log(max(one, 1e-300) / max(two, 1e-300)) / ratio
        return max(0.0, min(self.declared, seen))

    def case(self, size: float | None = None) -> Case:
        """The case of the last run, or of another step or tolerance."""
        size = self.sizes[len(self.runs) - 1] if size is None else size
        return Case.of(self.method, self.fixed, size)

    @property
    def last(self) -> Trajectory:
        return self.runs[-1]

    @property
    def estimate(self) -> float:
        return self.estimates[-1] if self.estimates else math.inf

    @property
    def seconds(self) -> float:
        return self.last.stats["seconds"]["integrate"]

    @property
    def blind(self) -> bool:
        """Whether two tolerances have led to identical runs, whose difference is not an error estimate."""
        same = len(self.runs) > 1 and self.runs[-2].stats["steps"] == self.last.stats["steps"]
        return not self.fixed and same and self.differences[-1] == 0.0

    def add(self, run: Run, size: float) -> None:
        """Add a run and its estimate."""
        self.sizes[len(self.runs) :] = [size]
        try:
            self.runs.append(run(self.case(size)))
        except MbdslError:
            self.sizes.pop()
            raise
        if len(self.runs) > 1:
            self.differences.append(difference(self.runs[-2], self.runs[-1]))
            self.estimates.append(self._estimate())

    def refine(self, run: Run, size: float) -> bool:
        """Add a run if it is possible; else False, and ``problem`` is the reason."""
        try:
            self.add(run, size)
        except MbdslError as problem:
            self.problem = problem.message
        return not self.problem

    def _estimate(self) -> float:
        differ, order = self.differences[-1], self.order
        ratio = self.sizes[len(self.runs) - 2] / self.sizes[len(self.runs) - 1]
        if self.fixed:
            return differ if order is None else differ / max(ratio**order - 1.0, 1.0 / 3.0)
        before, own = (run.stats["error"] for run in self.runs[-2:])
        if before and own:  # the estimate of the run itself, raised if runs differ by more
            return own * max(1.0, differ / (before + own))
        if self.blind:
            return self.estimates[-1] if self.estimates else self.sizes[len(self.runs) - 1]
        # errors follow tolerances only roughly
        return differ if order is None else differ / ratio**order

    def next(self, target: float) -> float:
        """The step or tolerance expected to reach ``target``; closer to the last one if errors decrease irregularly."""
        if self.blind:
            return self.sizes[-1] / 10.0
        change = (LADDER.aim * target / max(self.estimate, 1e-300)) ** (1.0 / self.declared)
        order = self.declared if self.order is None else self.order
        falling = self.estimate < LADDER.saturated and order > self.declared - LADDER.wavers
        longest = max(LADDER.credit ** (-1.0 / self.declared), 1.0 / 64.0) if falling else 0.25
        return self.sizes[-1] * min(0.5, max(change, longest))

    def price(self, target: float) -> float:
        """The expected time to reach ``target`` [s]."""
        power = 1.0 / self.declared if self.fixed else self.case().growth
        return self.seconds * max(1.0, self.estimate / (LADDER.aim * target)) ** power

    def start(self, run: Run, may_fail: bool) -> None:
        """The first two runs, with shorter steps if longer ones fail.

        Errors of the model or the arguments are raised, unless the method ``may_fail`` because there are others.
        """
        sizes = list(self.sizes)
        for _ in range(4):
            self.runs, self.differences, self.estimates, self.problem = [], [], [], ""
            try:
                for size in sizes:
                    self.add(run, size)
                return
            except MbdslError as problem:
                if not (may_fail or isinstance(problem, IntegrationError)):
                    raise
                self.runs, self.problem = [], problem.message
                if not isinstance(problem, IntegrationError) or isinstance(problem, TooLong):
                    return
                if problem.trajectory is not None and problem.trajectory.stats.get("horizon") is not None:
                    return  # the end is unknown
                if problem.trajectory is not None and problem.trajectory.stats.get("stiff"):
                    return  # stable steps take far longer than those of implicit methods
            sizes = [size / (8.0 if self.fixed else 100.0) for size in sizes]

    def descend(self, target: float, run: Run) -> None:
        """Reduce the step until the error estimate is small enough or does not decrease any more."""
        stuck, longest = 0, LADDER.most_seconds * max(1.0, self.runs[0].stats["seconds"]["integrate"])
        while self.estimate > target or (self.blind and len(self.runs) < LADDER.most_blind):
            if len(self.runs) >= LADDER.most_of_accuracy or stuck > (self.estimate > LADDER.rounding):
                self.problem = f"its error stays at about {min(self.estimates):.1e}"
                return
            if self.price(target) > longest:
                self.problem = f"it would take about {self.price(target):.0f} s"
                return
            if not self.refine(run, self.next(target)):
                return
            worse = self.estimate > LADDER.falls * min(self.estimates[:-1]) and not self.blind
            stuck = stuck + 1 if worse else 0


def difference(one: Trajectory, other: Trajectory) -> float:
    """The largest scaled difference of positions and velocities over time."""
    return worst(error(q, one, other) for q in of_motion(other, other))


def observed(sizes: Sequence[float], differences: Sequence[float]) -> float:
    """The order p of errors C h^p, from the differences of solutions at three sizes; at least 0.1."""
    return order_bounds(sizes, differences, 0.1, 12.0, halvings=50)[0]
