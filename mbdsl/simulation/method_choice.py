"""Choice of the method of a run with a tolerance for which no method is named.

The calibration runs (:mod:`mbdsl.simulation.tolerance_calibration`) of several methods are made in turn: always the
next run of the method with the least expected cost in total, until a run is within the tolerance. The first method is
the default one. If its runs are cheap, no other is tried: code would have to be compiled or loaded for it.

Costs are counts of a run times the cost of one of them, never measured times, so that the choice is the same on all
machines and at all times. The unit is a microsecond on a typical machine. The expected cost of the runs to come follows
from the work of the last ones and from the eps that the tolerance needs: the work of steps grows at least as
eps^(-1/order), and as it grew between the last two runs, which shows the stiffness of the model; events are as many in
every run. A run that becomes more expensive than the expected cost of another method is ended.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.options import check_options
from mbdsl.simulation.calibration_runs import COSTLY, Calibrated, Trial
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.part_run import KINEMATIC
from mbdsl.simulation.plan import Plan, constrained
from mbdsl.simulation.tolerance_calibration import CalibrationLadder
from mbdsl.system.peaks_along_motion import OnTheWay

#: the methods, and the cost [us] of having to load or compile the code of the others
CANDIDATES = {"hht-si2": 0.0, "radau5": 3e4, "dop853": 2e5}
#: cost [us] of an iteration, or of an evaluation of an explicit method, for each unknown
WORK = {"hht-si2": 0.05, "radau5": 0.17, "dop853": 0.09}
#: factor on the costs of dop853 where forces depend on reactions: the whole matrix is factorised in each evaluation,
#: again and again until both agree, and friction is stiff near rest
OF_REACTIONS = 5.0
#: cost [us] of an event, at which a run restarts, and of a search for a switch within a step
EVENT, SEARCH = 3000.0, 50.0
#: cost [us] of the search for hidden peaks in a step
PEAKS = 4.0
#: iterations, or evaluations, of a typical step
TYPICAL = {"hht-si2": 2.0, "radau5": 5.0, "dop853": 18.0}
#: a run is ended if it costs this many times as much as another method is expected to cost
MARGIN = 2.0
#: least cost of a run before it is ended, and least number of its steps
LEAST, FEWEST = 2e4, 100.0
#: statuses of runs that fail because of the model; RUNNING: a state is invalid
OF_MODEL = (S.RUNNING, S.SINGULAR, S.NOT_FINITE, S.SLIDING)
#: largest exponent with which the work of a run is expected to grow with 1/eps
FASTEST = 1.0


class Cost(NamedTuple):
    """The cost [us] of a run: of its steps, and of its events, whose number does not grow with the accuracy."""

    steps: float
    events: float


@dataclass
class CalibratedMethod:
    """A method with its calibration runs; costs in microseconds."""

    method: str
    ladder: CalibrationLadder
    unknowns: int  #: of all parts that the method solves
    start: float
    spent: float = 0.0
    work: list[Cost] = field(default_factory=list)  #: of the complete runs
    ended: float = 0.0  #: the cost of the last run, if it was ended because of its cost
    out: bool = False  #: whether no further run is of use

    @property
    def best(self) -> Trial:
        return self.ladder.trials[-1]

    @property
    def expected(self) -> float:
        """The least cost of all runs, as far as the runs so far show it; 0 if no other method does better."""
        if self.ladder.trials and self.ladder.acts_without_end(self.best):
            return 0.0
        return (self.spent or self.start) + max(self._to_come(), MARGIN * self.ended)

    def _to_come(self) -> float:
        if not self.work or not self.ladder.trials:
            return 0.0
        last, exponent = self.best, 1.0 / self.ladder.order
        if len(self.work) > 1 and len(self.ladder.trials) > 1:
            ratio = self.ladder.trials[-2].eps / last.eps
            more = max(1.0, self.work[-1].steps / max(self.work[-2].steps, 1e-300))
            exponent = min(max(exponent, np.log(more) / np.log(ratio) if ratio > 1.0 else 0.0), FASTEST)
        steps, events = self.work[-1]
        return float(steps * (last.eps / self.ladder.needed()) ** exponent) + events

    def advance(self, budget: float) -> None:
        """Make the next run; it is ended if it costs more than the ``budget``."""
        each = TYPICAL[self.method] * WORK[self.method] * max(1, self.unknowns)
        most = int(max(FEWEST, budget / each)) if np.isfinite(budget) else None
        status = self.ladder.run(most)
        cost = spent(self.ladder.motion)
        self.spent += sum(cost)
        self.ended = sum(cost) if status == COSTLY else 0.0
        if status != COSTLY:
            self.work.append(cost)
            self.out = self.ladder.eps is None or status == S.STIFF

    @property
    def reached(self) -> bool:
        """Whether a run is within the tolerance."""
        return self.out and bool(self.ladder.trials) and self.best.done and self.best.error <= self.ladder.tol

    @property
    def fails_in_all_methods(self) -> bool:
        """Whether the reason why the runs failed lies in the model."""
        runs = [*self.ladder.trials, *self.ladder.failed]
        return self.ladder.rounds or any(x.status in OF_MODEL for x in runs)

    @property
    def least_error(self) -> float:
        return min((x.error for x in [*self.ladder.trials, *self.ladder.failed] if x.done), default=np.inf)


class MethodChoice:
    """The calibration runs of the candidates.

    Attributes
    ----------
    text : str
        Which method was chosen, and why.
    """

    def __init__(
        self, motion: MechanismRun, tol: float, integrate: Callable[..., int], ready: Callable[[Plan], None]
    ) -> None:
        self._motion, self._ready, self.text = motion, ready, ""
        solved = sum(p.system.unknowns for p in motion.parts if p.method != KINEMATIC)
        self._candidates, limited = [], constrained(motion.system.scene)
        friction = any(p.system.of_multipliers for p in motion.parts)
        for method, start in CANDIDATES.items():
            if method == "dop853" and friction:
                start *= OF_REACTIONS
            plan = replace(motion.plan, method=method, options=check_options(method, {}, limited))
            self._candidates.append(
                CalibratedMethod(method, CalibrationLadder(motion, tol, integrate, plan), solved, start)
            )
        self._loaded = {motion.plan.method}

    def run(self) -> tuple[int, Calibrated]:
        """Make runs until one is within the tolerance, or none can be; the status and the estimate of the result."""
        problem: InitialisationError | None = None
        while left := [x for x in self._candidates if not x.out]:
            one = min(left, key=lambda x: x.expected)
            others = [x.expected for x in left if x is not one]
            try:
                if one.method not in self._loaded:
                    self._ready(one.ladder.plan)
                    self._loaded.add(one.method)
                one.advance(max(MARGIN * min(others) - one.spent, LEAST) if others else np.inf)
            except InitialisationError as found:  # such as of a method that divides by masses where there are none
                one.out, problem = True, problem or found
            if one.ladder.interrupted or one.reached or (one.out and one.fails_in_all_methods):
                return self._end(one)
        tried = [x for x in self._candidates if x.ladder.trials]
        if not tried:
            assert problem is not None
            raise problem
        return self._end(min(tried, key=lambda x: x.least_error))

    def _end(self, one: CalibratedMethod) -> tuple[int, Calibrated]:
        ladder, others = one.ladder, [x for x in self._candidates if x is not one]
        status, found = ladder.stopped() if ladder.interrupted else ladder.finish()
        ladder.motion.trial_steps += sum(x.ladder.steps for x in others)
        self.text = self._reason(one, others)
        return status, found

    def _reason(self, one: CalibratedMethod, others: list[CalibratedMethod]) -> str:
        tried = [x for x in others if x.spent > 0.0]
        if not tried:
            return f"{one.method}, the first method, is cheap enough: no other was tried"
        said = []
        for x in tried:
            if x.out and not x.reached:
                said.append(f"{x.method} does not reach the tolerance")
            else:
                ratio = x.expected / max(one.spent, 1.0)
                said.append(f"{x.method} would cost about {max(1.1, ratio):.2g} times as much")
        return f"{one.method} was taken: {', '.join(said)}"


def spent(motion: MechanismRun) -> Cost:
    """The cost of the present run of a motion."""
    steps = events = 0.0
    for p in motion.parts:
        run = p.integration
        each = WORK.get(p.method, WORK["hht-si2"]) * p.system.unknowns
        if p.method == "dop853" and p.system.of_multipliers:
            each *= OF_REACTIONS
        steps += each * (run.count("iterations") + run.count("evaluations"))
        if p.system.kept(OnTheWay).terms:
            steps += PEAKS * run.steps
        if p.system.tables.switches:
            events += EVENT * run.count("events") + SEARCH * run.count("rejected")
    return Cost(steps, events)
