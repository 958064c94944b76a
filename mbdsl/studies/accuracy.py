"""Runs with a given accuracy.

The step or tolerance of the fastest method is reduced until the error estimate from successive runs is small enough and
a method of another family agrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from numbers import Real
from time import perf_counter
from typing import Any

from mbdsl.errors import IntegrationError, MbdslError, UsageError
from mbdsl.integrators import available, compiled
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean, once, together
from mbdsl.numerics.tolerance import misfit, rounding
from mbdsl.simulation.error_growth import along
from mbdsl.simulation.ladder_constants import LADDER
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import DEFAULT_METHOD
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, own_step, setting
from mbdsl.studies.cross_check import Verdict, ask
from mbdsl.studies.families import family, precise
from mbdsl.studies.ladder import Ladder
from mbdsl.studies.time_limits import allowance, limited
from mbdsl.system.state_sizes import weights

#: accuracy from which on radau5 is as fast as the methods of its family with higher order (docs/methods.md)
FINE = 1e-7
PATIENCE = 20.0  #: most time of a first run, relative to all runs before it, or in tenths of a second
HINT = "the motion may be chaotic or jump (see `mbdsl study convergence`), or the check needs more time (--budget)"


def reach(
    scene: Scene,
    accuracy: float,
    *,
    method: str | None = None,
    announce: Callable[[str], None] | None = None,
    progress: Callable[[Progress], None] | None = None,
    interval: float | None = None,
    budget: float | None = None,
    **given: Any,
) -> Trajectory:
    """The trajectory of ``scene`` with an error of at most ``accuracy``.

    The error is that of positions, relative to the mechanism's size (angles in radians), and of velocities, relative to
    the largest. ``stats["accuracy"]`` holds the requested accuracy, the error estimate and its source: "checked by" is
    the method of another family that agrees (None if no method could check), "not checked" the reason. ``budget`` [s]
    limits the time of the check; the default is twenty times that of all previous runs, and at least 20 s. The other
    arguments are those of :func:`mbdsl.simulate`.

    Raises
    ------
    ModelError, UsageError, InitialisationError
        If the model or the arguments are invalid, or there is no consistent initial state.
    IntegrationError
        If no method reaches the accuracy, or two methods contradict each other; ``trajectory`` is the best result.
    """
    if (wrong := misfit(accuracy, "an accuracy")) is not None:
        raise UsageError(wrong)
    if budget is not None and (isinstance(budget, bool) or not isinstance(budget, Real) or not budget > 0.0):
        raise UsageError(f"budget is a number of seconds above zero, not {budget!r}")
    search = _AccuracySearch(scene, accuracy, {**given, "interval": interval or None}, progress, once(announce, set()))
    try:
        ladder = search.descend(_ladders(scene, accuracy, method, given))
        search.amplify(ladder)
        verdict = search.check(ladder, budget)
        if interval == 0.0:
            search.begin("every step of the result")
            search.result = search.run(ladder.case(), interval=0.0)
    except KeyboardInterrupt:
        if search.result is None:
            raise
        search.result.stats["status"] = "interrupted"
        return search.tell(search.estimate, "it was interrupted")
    return search.judge(ladder, verdict)


class _AccuracySearch:
    """Runs of a scene: ``result`` is the best so far, ``estimate`` its error estimate, ``by`` the runs used."""

    def __init__(
        self,
        scene: Scene,
        accuracy: float,
        given: dict[str, Any],
        progress: Callable[[Progress], None] | None,
        announce: Callable[[str], None] | None,
    ) -> None:
        self.scene, self.accuracy, self.given = scene, accuracy, given
        self.progress, self.announce = progress, announce
        self.begun, self.spent = perf_counter(), 0.0
        self.runs: list[str] = []
        self.known: dict[tuple, Trajectory] = {}  #: complete runs; a check often needs a run of the comparison again
        self.result: Trajectory | None = None
        self.estimate, self.by = math.inf, ""
        self.motions: dict[tuple[str, bool], MechanismRun] = {}  #: newest, by method and whether steps are fixed
        self.stage, self.made, self.planned = "", 0, 0  #: purpose of the present runs, and their number if it is known
        self.rounding = 0.0  #: error due to amplified rounding, which all runs may have in common

    def run(self, case: Case, limit: float = math.inf, **other: Any) -> Trajectory:
        """One run of at most ``limit`` seconds."""
        how = {"method": case.method, "step": case.step, "tol": case.tol}
        inspect = partial(self.motions.__setitem__, (case.method, case.tol is None))
        given = {**self.given, **how, **other, "inspect": inspect}
        key = case, str(given.get("options") or {}), bool(given.get("force")), given.get("interval")
        if key in self.known:
            return self.known[key]
        begun, self.made = perf_counter(), self.made + 1
        of = f" of {self.planned}" if self.made <= self.planned else ""
        purpose = f"{self.stage} {self.made}{of}: {case}"
        try:
            found = limited(self.scene, limit, self.progress, purpose, announce=self.announce, **given)
        except MbdslError:
            self.spent += min(limit, perf_counter() - begun)
            raise
        self.runs.append(str(case))
        self.spent += found.stats["seconds"]["integrate"]
        self.known[key] = found
        return found

    def begin(self, stage: str, planned: int = 0) -> None:
        """Name the purpose of the next runs, and their number if it is known."""
        self.stage, self.made, self.planned = stage, 0, planned

    def keep(self, ladder: Ladder) -> None:
        """Take the last run of a ladder as the result if it is the best so far."""
        if ladder.runs and (self.result is None or ladder.estimate < self.estimate):
            self.result, self.estimate, self.by = ladder.last, ladder.estimate, f"{ladder.case()}, and runs before it"

    def descend(self, ladders: list[Ladder]) -> Ladder:
        """The fastest ladder that reaches the accuracy.

        Raises
        ------
        IntegrationError
            If none does.
        """
        self.begin("comparison", 2 * len(ladders))
        for k, ladder in enumerate(ladders):
            # the first run would have been made in any case
            limit = PATIENCE * max(0.1, self.spent) if k else math.inf
            ladder.start(partial(self.run, limit=limit), may_fail=bool(k))
            self.keep(ladder)
        able = sorted((x for x in ladders if not x.problem), key=lambda x: x.price(self.accuracy))
        for ladder in able:
            if self.announce is not None:
                text = f"{ladder.method}: about {ladder.price(self.accuracy):.2g} s"
                self.announce(f"{text} for an error of {self.accuracy:g}")
            self.begin("refinement")
            ladder.descend(self.accuracy, self.run)
            self.keep(ladder)
            if not ladder.problem:
                return ladder
        reasons = together((x.method, x.problem) for x in ladders)
        if self.result is not None:
            self.tell(self.estimate, "the accuracy was not reached")
        raise self.failure(
            f"an accuracy of {self.accuracy:g} cannot be reached: {reasons}", "try a larger one" if able else None
        )

    def amplify(self, ladder: Ladder) -> None:
        """Estimate the error due to amplified rounding in the last run.

        Raises
        ------
        IntegrationError
            If it exceeds the accuracy.
        """
        self.rounding, known = self._amplified(ladder)
        if self.rounding > self.accuracy:  # between outputs, rates may be large for a short time, as in a contact
            motion = self.motions[ladder.method, ladder.fixed]
            numbers = motion.steps * sum(p.system.n + p.system.unknowns for p in motion.parts)
            with suppress(MbdslError):
                if numbers <= LADDER.most_numbers:
                    self.begin("sensitivity to rounding")
                    self.run(ladder.case(), interval=0.0)
                    for finer in LADDER.finer:
                        found, examined = self._amplified(ladder, finer)
                        if examined < known or self.rounding <= self.accuracy:
                            break  # there are no tangent equations at some steps, or their result suffices
                        self.rounding = min(self.rounding, found)
        if self.rounding > self.accuracy:
            self.tell(self.estimate, "the accuracy was not reached")
            raise self.failure(
                f"an accuracy of {self.accuracy:g} cannot be reached: the motion amplifies rounding to an error of "
                f"about {self.rounding:.1e}",
                "try a shorter run (--stop), or a larger accuracy",
            )

    def _amplified(self, ladder: Ladder, finer: int = 1) -> tuple[float, int]:
        """Error due to amplified rounding at the end of the newest run, and the number of parts with a known one."""
        motion = self.motions[ladder.method, ladder.fixed]
        t, _, v = motion.states()
        speed = weights(motion.system.tables, v, float(t[-1] - t[0])).speed
        grown, known = along(motion.parts_of(motion.keep()), t, speed, finer)
        return rounding(1.0) * math.exp(min(grown.log.max(), 700.0)), known

    def check(self, ladder: Ladder, budget: float | None) -> Verdict:
        """The verdict of methods of other families; if none can check, runs of the ladder itself have to agree."""
        self.begin("check")
        end = self.spent + allowance(self.spent, budget, 2.0)  # without compilation

        def judge(case: Case, limit: float) -> Trajectory:
            # options and force apply to the first method only
            return self.run(case, limit, options=None, force=False)

        verdict = ask(ladder, self.accuracy, self.run, judge, lambda: end - self.spent)
        if not verdict.checked and not verdict.against:
            self.result = ladder.last
            while ladder.differences[-1] > self.accuracy and not ladder.problem:
                ladder.refine(partial(self.run, limit=PATIENCE * self.spent), ladder.sizes[-1] / 2.0)
            verdict.estimate = max(ladder.estimate, ladder.differences[-1] if ladder.problem else 0.0)
        self.result, self.estimate = ladder.last, verdict.estimate
        self.by = f"{ladder.case()}, and runs before it"
        return verdict

    def judge(self, ladder: Ladder, verdict: Verdict) -> Trajectory:
        """The result, with its stats completed.

        Raises
        ------
        IntegrationError
            If another method contradicts, or if the error estimate exceeds the accuracy.
        """
        checked, against = verdict.checked, verdict.against
        if checked:
            outvoted = "".join(f"; against {x.verdict}" for x in against)
            return self.tell(verdict.estimate, None, checked.verdict + outvoted)
        if against:
            against_it = "; ".join(x.verdict + (f" ({x.stopped})" if x.stopped else "") for x in against)
            self.tell(max(ladder.estimate, *(x.differs for x in against)), f"contradicted by {against_it}")
            what = "two methods contradict each other"
            if all(x.stopped for x in against):
                what = f"an accuracy of {self.accuracy:g} was not reached"
            own = min(ladder.estimate, ladder.differences[-1])
            raise self.failure(f"{what}: {ladder.case()} has an error estimate of {own:.1e}, but {against_it}", HINT)
        found = self.tell(verdict.estimate, verdict.unable)
        if verdict.estimate > self.accuracy:
            why = f"runs of {ladder.method} differ by {ladder.differences[-1]:.1e}"
            raise self.failure(
                f"an accuracy of {self.accuracy:g} cannot be confirmed: {why}, and no other method could check: "
                f"{verdict.unable}",
                HINT,
            )
        return found

    def tell(self, estimate: float, unchecked: str | None, checked: str | None = None) -> Trajectory:
        """The result, with its error estimate and check in its stats."""
        assert self.result is not None
        self.result.stats["accuracy"] = {
            "asked": self.accuracy,
            "estimated": max(estimate, self.rounding),
            "by": self.by if estimate >= self.rounding else "rounding, as the motion amplifies it",
            "checked by": checked,
            "not checked": unchecked,
            "runs": self.runs,
            "seconds": perf_counter() - self.begun,
        }
        return self.result

    def failure(self, message: str, hint: str | None) -> IntegrationError:
        error = IntegrationError(message, hint=hint)
        if self.result is not None:
            self.result.stats["status"], self.result.message = "failed", message
            error.trajectory = self.result
        return error


def _ladders(scene: Scene, accuracy: float, method: str | None, given: dict) -> list[Ladder]:
    """(Method, kind of steps) to try: the given method, or the default method and our own methods of high order, for
    accuracies from ``FINE`` on only the first one of each family."""
    own = [name for name in precise(scene.spatial) if name in compiled()]
    if accuracy >= FINE:
        own = [name for name in own if name == next(other for other in own if family(other) == family(name))]
    names = [method] if method else list(dict.fromkeys([scene.experiment.method or DEFAULT_METHOD, *own]))
    for name in names:
        if name not in available():
            raise UsageError(f"there is no method `{name}`", hint=did_you_mean(name, available(), "methods"))
    step = 2.0 * own_step(setting(scene, given.get("stop")))
    tol = min(1e-3, 100.0 * accuracy)
    found = []
    for name in names:
        for kind in available()[name].steps:
            sizes = [step, step / 2.0] if kind == "fixed" else [tol, tol / 10.0]
            found.append(Ladder(name, kind == "fixed", sizes))
    return found
