"""The binding check of a result by a method of another family.

If the two differ by more than the accuracy, the one with the larger error estimate is refined until they agree. A
method that fails, takes too long or has too large an error cannot check, and the next one is tried. If a method that
can check contradicts, a method of a third family decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

from mbdsl.integrators import available
from mbdsl.simulation.plan import DEFAULT_STEP
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case
from mbdsl.studies.families import EXTRAPOLATED, family, precise
from mbdsl.studies.ladder import Ladder, Run, difference

FINER = 3.0  #: a difference this many times the error of one method measures the error of the other
ROUNDS = 10  #: largest number of runs of both methods in a check
#: a difference above this part of the previous one is persistent; how many times this is allowed
SAME, PERSISTS = 0.7, 2


@dataclass
class Opinion:
    """The result of a check by one method: ``agrees`` is None if it could not check."""

    method: str
    agrees: bool | None
    verdict: str
    differs: float = math.inf
    own: float = math.inf
    stopped: str = ""  #: reason why the result was not refined although it differs


@dataclass
class Verdict:
    """The results of all checks; ``estimate`` is the error estimate of the result after them."""

    estimate: float
    opinions: list[Opinion] = field(default_factory=list)

    @property
    def checked(self) -> Opinion | None:
        """The verdict that agrees."""
        return next((x for x in self.opinions if x.agrees), None)

    @property
    def against(self) -> list[Opinion]:
        return [x for x in self.opinions if x.agrees is False]

    @property
    def unable(self) -> str:
        """Reasons why no method could check."""
        lines = [f"{x.method} {x.verdict}" for x in self.opinions if x.agrees is None]
        return "; ".join(lines) or "there is no method of another family"


Limited = Callable[[Case, float], Trajectory]  #: runs a case within a number of seconds


def ask(ladder: Ladder, accuracy: float, run: Limited, judge: Limited, left: Callable[[], float]) -> Verdict:
    """Check the result of ``ladder`` by methods of other families, and refine the ladder if necessary.

    ``run`` makes runs of the method itself, ``judge`` those of the other methods, ``left()`` is the remaining time [s].
    """
    verdict = Verdict(ladder.estimate)
    waiting = list(_others(ladder, accuracy))
    while waiting:
        other = waiting.pop(0)
        others = left() * len(waiting) / (1 + len(waiting))  # they may be needed
        runs = partial(_within, run, left, 0.0), partial(_within, judge, left, others)
        found = _confront(ladder, other, accuracy, *runs)
        verdict.opinions.append(found)
        if found.agrees is not None:
            waiting = [x for x in waiting if family(x.method) != family(other.method)]
        if found.agrees or len(verdict.against) > 1:
            break
    agrees = verdict.checked
    verdict.estimate = _claim(ladder.estimate, accuracy, agrees) if agrees else ladder.estimate
    return verdict


def _within(run: Limited, left: Callable[[], float], kept: float, case: Case) -> Trajectory:
    """A run within the remaining time without what is ``kept`` [s]."""
    return run(case, left() - kept)


def _confront(ladder: Ladder, other: Ladder, accuracy: float, run: Run, judge: Run) -> Opinion:
    """Refine both until they agree or one cannot continue; ``judge`` makes runs of ``other``."""
    if not all(other.refine(judge, size) for size in list(other.sizes)):
        return Opinion(other.method, None, f"failed: {other.problem}")
    before, still = math.inf, 0
    for _ in range(ROUNDS):
        differs, own = difference(other.last, ladder.last), other.estimate
        finer = own <= differs / FINER
        known = ladder.estimate <= accuracy and (own <= accuracy or differs <= FINER * ladder.estimate)
        if differs <= accuracy and (finer or known):
            break
        if finer:
            still = still + 1 if differs > SAME * before else 0
            before = differs
            if still > PERSISTS:
                break
        elif len(other.estimates) > PERSISTS and own > SAME * min(other.estimates[-1 - PERSISTS : -1]):
            break  # it does not improve
        if not finer or still == PERSISTS:
            refined = other.refine(judge, other.next(max(differs, accuracy) / FINER))
        else:
            ladder.estimates[-1] = max(ladder.estimate, differs)
            refined = ladder.refine(run, ladder.next(accuracy))
        if not refined:
            break
    stopped, ladder.problem = other.problem or ladder.problem, ""
    differs, own = difference(other.last, ladder.last), other.estimate
    finer = own <= differs / FINER
    verdict = f"{other.case()}: differs by {differs:.1e}, with an error estimate of {own:.1e}"
    if differs <= accuracy and (finer or ladder.estimate <= accuracy):
        return Opinion(other.method, True, verdict, differs, own)
    if finer:
        return Opinion(other.method, False, verdict, differs, own, stopped)
    verdict = f"differs by {differs:.1e}, but has an error of about {own:.1e}" + (f" ({stopped})" if stopped else "")
    return Opinion(other.method, None, verdict, differs, own)


def _claim(estimate: float, accuracy: float, found: Opinion) -> float:
    """The error of a result from its own ``estimate`` and from a method that agrees: the larger one.

    The difference from a far more accurate method measures the error; a far larger estimate is then too large.
    """
    if found.own <= found.differs / FINER:
        return max(found.differs, min(estimate, FINER * found.differs, accuracy))
    return max(estimate, found.differs)


def _others(ladder: Ladder, accuracy: float) -> Iterator[Ladder]:
    """Methods of other families, each with two tolerances or steps, from which its own error is estimated."""
    for name in precise(ladder.last.scene.spatial):
        if family(name) != family(ladder.method):
            yield Ladder(name, False, [10.0 * accuracy, accuracy])
    experiment = ladder.last.scene.experiment
    h = ladder.case().step or (experiment.step or DEFAULT_STEP) / 4.0
    for name in EXTRAPOLATED:
        if name in available() and family(name) != family(ladder.method):
            yield Ladder(name, True, [2.0 * h, h])
