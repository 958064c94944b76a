"""A run of an accuracy that is asked for: the cheapest method's step or tolerance is made smaller until successive runs
say that the error is small enough, and a method of another family does not contradict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from time import perf_counter
from typing import Any

from mbdsl.errors import IntegrationError, MbdslError, UsageError
from mbdsl.integrators import methods
from mbdsl.scene import Scene
from mbdsl.simulation import DEFAULT_METHOD, DEFAULT_STEP, Progress, simulate
from mbdsl.studies.cases import Case, own_step, setting
from mbdsl.studies.errors import error, quantities
from mbdsl.studies.families import EXTRAPOLATED, family, precise
from mbdsl.trajectory import Trajectory
from mbdsl.wording import together

AIM = 0.5  #: part of the accuracy that is aimed at
MOST = 12  #: runs of one method
JUMP = 1.0 / 64.0  #: from one size to the next
ROUNDING = 1e-6  #: errors below that do not fall any more have come to rounding
LONGEST = 600.0  #: seconds, or so many times as long as the first run: what takes longer is not begun
LARGEST = 0.05  #: estimates above that say little
WAVERS = 0.3  #: orders that are so much lower than they should be say that steps are still too long
CONTRADICTION = 3.0  #: times what two runs say of their own errors
WEAK = 10.0  #: times the accuracy: who errs more than that says little
PATIENCE = 20.0  #: times as long as all runs before, or so many tenths of a second, that one of another method may take


class TooLong(IntegrationError):
    """A run that is not worth its time."""


@dataclass
class Ladder:
    """Runs of one method, each more exact than the one before; ``estimates`` of their errors from the second on."""

    method: str
    fixed: bool
    sizes: list[float]  #: of the runs done, and of those to be done next
    runs: list[Trajectory] = field(default_factory=list)
    differences: list[float] = field(default_factory=list)
    estimates: list[float] = field(default_factory=list)
    problem: str = ""

    @property
    def declared(self) -> float:
        """The order with which errors should fall: with the step, or with the tolerance."""
        return float(methods()[self.method].order) if self.fixed else 1.0

    @property
    def order(self) -> float:
        """The same, less where runs say so."""
        if len(self.runs) < 3:
            return self.declared
        return min(self.declared, observed(self.sizes[len(self.runs) - 3 : len(self.runs)], self.differences[-2:]))

    @property
    def case(self) -> Case:
        size = self.sizes[len(self.runs) - 1]
        return Case(self.method, step=size) if self.fixed else Case(self.method, tol=size)

    @property
    def estimate(self) -> float:
        return self.estimates[-1] if self.estimates else math.inf

    def next(self, target: float) -> float:
        """The step or tolerance that should do; no long way where errors do not yet fall as they should."""
        change = (AIM * target / max(self.estimate, 1e-300)) ** (1.0 / self.declared)
        longest = JUMP if self.estimate < LARGEST and self.order > self.declared - WAVERS else 0.25
        return self.sizes[-1] * min(0.5, max(change, longest))

    def price(self, target: float) -> float:
        """Seconds that reaching ``target`` should take."""
        spent = self.runs[-1].stats["seconds"]["integrate"]
        power = 1.0 / self.declared if self.fixed else 1.0 / (methods()[self.method].order + 1.0)
        return spent * max(1.0, self.estimate / (AIM * target)) ** power


def difference(one: Trajectory, other: Trajectory) -> float:
    """Between positions and velocities, scaled, the largest over time."""
    wanted = [q for q in quantities(other, other) if q.key in ("q", "v")]
    return max((error(q, one, other).scaled for q in wanted), default=0.0)


def reach(
    scene: Scene,
    accuracy: float,
    *,
    method: str | None = None,
    announce: Callable[[str], None] | None = None,
    progress: Callable[[Progress], None] | None = None,
    interval: float | None = None,
    **given: Any,
) -> Trajectory:
    """The trajectory of ``scene`` with an error of ``accuracy`` at most, as far as can be told.

    The error is that of positions as part of the mechanism's size (angles in radians), and of velocities as part of the
    largest. ``stats["accuracy"]`` has what was asked for, the estimate, and how it was come by. Arguments as for
    :func:`mbdsl.simulate`.

    Raises
    ------
    ModelError, UsageError, InitialisationError
        If model or arguments make no sense, or there is no consistent initial state.
    IntegrationError
        If no method comes to it, or two contradict each other.
    """
    if not 0.0 < accuracy < 1.0:
        raise UsageError(f"an accuracy is between 0 and 1, not {accuracy:g}")
    say = announce or (lambda text: None)
    begun = perf_counter()
    runs: list[str] = []
    spent = 0.0

    def run(case: Case, fine: float | None = interval or None, limit: float = math.inf, **other: Any) -> Trajectory:
        nonlocal spent
        late = False

        def watch(p: Progress) -> None:
            nonlocal late
            late = p.seconds > limit
            if late:
                raise KeyboardInterrupt
            if progress is not None:
                progress(p)

        found = simulate(
            scene, method=case.method, step=case.step, tol=case.tol, interval=fine, progress=watch, announce=announce,
            **{**given, **other},
        )  # fmt: skip
        if found.status == "interrupted":
            if late:
                raise TooLong("it takes too long")
            raise KeyboardInterrupt
        runs.append(str(case))
        spent += found.stats["seconds"]["integrate"]
        return found

    ladders = _ladders(scene, accuracy, method, given)
    for k, ladder in enumerate(ladders):
        # the first is what would have been run anyway
        _start(ladder, partial(run, limit=PATIENCE * max(0.1, spent)) if k else run, bool(k))
    able = sorted((x for x in ladders if not x.problem), key=lambda x: x.price(accuracy))
    for ladder in able:
        say(f"{ladder.method}: about {ladder.price(accuracy):.2g} s for an error of {accuracy:g}")
        _descend(ladder, accuracy, run)
        if not ladder.problem:
            break
    else:
        told = together((x.method, x.problem) for x in ladders)
        raise IntegrationError(
            f"an accuracy of {accuracy:g} cannot be reached: {told}", hint="ask for less" if able else None
        )
    found = ladder.runs[-1]
    # what is set of the one method, or forced upon it, says nothing of another
    plain = partial(run, limit=PATIENCE * max(0.1, spent), options=None, force=False)
    second = _contradict(ladder, accuracy, plain)
    if interval == 0.0:
        found = run(ladder.case, 0.0)
    found.stats["accuracy"] = {
        "asked": accuracy,
        "estimated": ladder.estimate,
        "by": f"{ladder.case}, and the run before it",
        "checked by": second,
        "runs": runs,
        "seconds": perf_counter() - begun,
    }
    return found


def observed(sizes: Sequence[float], differences: Sequence[float]) -> float:
    """The order p of errors C h^p, from the differences of solutions at three sizes, by bisection.

    (h_1^p - h_2^p) / (h_2^p - h_3^p) grows with p.
    """
    one, two = differences
    r, s = sizes[0] / sizes[1], sizes[2] / sizes[1]
    low, high = 0.1, 12.0
    for _ in range(50):
        p = (low + high) / 2.0
        low, high = (p, high) if (r**p - 1.0) * two < one * (1.0 - s**p) else (low, p)
    return low


def _ladders(scene: Scene, accuracy: float, method: str | None, given: dict) -> list[Ladder]:
    """What is tried: the method asked for, or the default one and the best of high order, in all ways they can."""
    names = [method] if method else list(dict.fromkeys([scene.experiment.method or DEFAULT_METHOD, *precise()[:1]]))
    for name in names:
        if name not in methods():
            raise UsageError(f"there is no method `{name}`", hint=f"methods: {', '.join(methods())}")
    of = setting(scene, given.get("stop"))
    step = 2.0 * own_step(of)
    tol = min(1e-3, 100.0 * accuracy)
    found = []
    for name in names:
        for kind in methods()[name].steps:
            sizes = [step, step / 2.0] if kind == "fixed" else [tol, tol / 10.0]
            found.append(Ladder(name, kind == "fixed", sizes))
    return found


def _start(ladder: Ladder, run: Callable, may_fail: bool) -> None:
    """The first two runs, with shorter steps where it takes these to come to an end.

    Unless it ``may_fail``, as there are others, what is wrong with model or arguments is told as it is.
    """
    for _ in range(4):
        try:
            for size in ladder.sizes:
                ladder.runs.append(run(_case(ladder, size)))
        except MbdslError as problem:
            if not (may_fail or isinstance(problem, IntegrationError)):
                raise
            ladder.runs, ladder.problem = [], problem.message
            if not isinstance(problem, IntegrationError) or isinstance(problem, TooLong):
                return
            ladder.sizes = [size / (8.0 if ladder.fixed else 100.0) for size in ladder.sizes]
            continue
        ladder.problem = ""
        ladder.estimates = [_estimate(ladder)]
        return


def _descend(ladder: Ladder, accuracy: float, run: Callable) -> None:
    """Smaller and smaller, until the estimate is small enough, or stays where it is."""
    stuck, longest = 0, LONGEST * max(1.0, ladder.runs[0].stats["seconds"]["integrate"])
    while ladder.estimate > accuracy:
        if len(ladder.runs) == MOST or stuck > (ladder.estimate > ROUNDING):
            ladder.problem = f"its error stays at some {min(ladder.estimates):.1e}"
            return
        if ladder.price(accuracy) > longest:
            ladder.problem = f"it would take some {ladder.price(accuracy):.0f} s"
            return
        ladder.sizes.append(ladder.next(accuracy))
        try:
            ladder.runs.append(run(_case(ladder, ladder.sizes[-1])))
        except MbdslError as problem:
            ladder.sizes.pop()
            ladder.problem = problem.message
            return
        ladder.estimates.append(_estimate(ladder))
        stuck = stuck + 1 if ladder.estimate > 0.7 * min(ladder.estimates[:-1]) else 0


def _estimate(ladder: Ladder) -> float:
    """Of the last run's error, from how far it is from the one before."""
    differ = difference(ladder.runs[-2], ladder.runs[-1])
    ladder.differences.append(differ)
    ratio = ladder.sizes[len(ladder.runs) - 2] / ladder.sizes[len(ladder.runs) - 1]
    if not ladder.fixed:
        return differ  # errors follow tolerances loosely: that of the run before is what is known
    return differ / max(1.0, ratio**ladder.order - 1.0)


def _contradict(ladder: Ladder, accuracy: float, run: Callable) -> str:
    """Whether another family of methods comes to the same, told in words; the one that knows itself best is asked.

    Raises
    ------
    IntegrationError
        If it does not.
    """
    best: tuple[float, Ladder] | None = None
    why = "there is no method of another family"
    for other in _others(ladder, accuracy):
        try:
            other.runs = [run(_case(other, size)) for size in other.sizes]
        except MbdslError as problem:
            why = f"{other.method}: {problem.message}"
            continue
        own = _estimate(other)
        if best is None or own < best[0]:
            best = own, other
        if own < WEAK * accuracy:
            break
    if best is None:
        return f"no other method ({why})"
    own, other = best
    differ = difference(other.runs[-1], ladder.runs[-1])
    told = f"{other.case}: differs by {differ:.1e}, its own error being some {own:.1e}"
    if differ > CONTRADICTION * (own + max(ladder.estimate, accuracy)):
        raise IntegrationError(
            f"two methods contradict each other: {ladder.case} should be off by {ladder.estimate:.1e}, but {told}",
            hint="the motion may be chaotic, or jump; look at it with `mbdsl study convergence`",
        )
    return told


def _others(ladder: Ladder, accuracy: float) -> Iterator[Ladder]:
    """Methods of other families, with two tolerances or steps to tell their own errors by."""
    for name in precise():
        if family(name) != family(ladder.method):
            yield Ladder(name, False, [10.0 * accuracy, accuracy])
    experiment = ladder.runs[-1].scene.experiment
    h = ladder.case.step or (experiment.step or DEFAULT_STEP) / 4.0
    for name in EXTRAPOLATED:
        if name in methods() and family(name) != family(ladder.method):
            yield Ladder(name, True, [2.0 * h, h])


def _case(ladder: Ladder, size: float) -> Case:
    return Case(ladder.method, step=size) if ladder.fixed else Case(ladder.method, tol=size)
