"""The search, among many methods, for the case that reaches an error in the least time.

Every candidate is a method with fixed or with error-controlled steps. One cheap run with long steps, or a loose
tolerance, shows its error and its cost. From there the order of the method gives the step that the target needs, and
the time of that run: the promise of the candidate. The search goes in rounds. In each round, candidates whose promise
is within a few times the best time so far (or the best promise) make one more run, the most promising one first, and a
run that takes longer than that is ended. It is complete when no candidate is left that can be the fastest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

AIM = 0.8  #: part of the target that runs aim at, because errors scatter
RUNS = 12  #: largest number of runs of a candidate
FAILURES = 4  #: largest number of failed runs before the first complete one
JUMP = {"fixed": 32.0, "controlled": 1e4}  #: largest ratio of successive sizes: errors at long steps predict little
NEAR = 3.0  #: a candidate that promises a longer time, relative to the best one, is not pursued
VAGUE = 7.0  #: the same for a candidate whose promise follows from one run
SLACK = 1.4  #: a run may take this many times as long as the longest promise that is pursued
SHORT = 0.03  #: times [s] below this are not distinguished during the search
PART = 0.25  #: part of the remaining time for a first run
AGAIN = 1.25  #: a run that was ended for lack of time is repeated if it can have this many times as long
GAIN = 1.15  #: least expected ratio of times for a further run of a candidate that has reached the target
STUCK = 0.9  #: an error above this part of the last one does not decrease
SATURATED = 1e-2  #: errors above this may not decrease yet


@dataclass(frozen=True)
class SearchRun:
    """One run: its error and the seconds it took; a ``problem`` if it failed; ``late`` if it was ended."""

    error: float = math.nan
    seconds: float = 0.0
    problem: str = ""
    late: bool = False


@dataclass(frozen=True)
class TimedRun:
    """A complete run with a step [s] or a tolerance."""

    size: float
    error: float
    seconds: float


@dataclass
class Candidate:
    """A method with one kind of steps, and its runs so far.

    ``size`` is that of the first run, ``longest`` the largest one; ``prior`` orders the first runs.
    """

    method: str
    kind: str  #: "fixed" or "controlled"
    order: float
    size: float
    longest: float
    prior: float = 0.0
    trials: list[TimedRun] = field(default_factory=list)
    runs: int = 0
    ended: float = 0.0  #: size of the run that was ended last
    least: float = 0.0  #: the longest time after which a run was ended [s]: the target takes longer
    pressed: float = 0.0  #: such a time, if the run was ended for lack of time only
    skipped: bool = False  #: there was no time for its next run
    failed: list[float] = field(default_factory=list)  #: sizes
    reason: str = ""  #: why its last failed run did
    problem: str = ""  #: why it makes no further runs

    @property
    def best(self) -> TimedRun | None:
        """The fastest run that reaches the target; None before :meth:`judge` has seen one."""
        return min(self._reaching, key=lambda trial: trial.seconds, default=None)

    _reaching: list[TimedRun] = field(default_factory=list)

    def promise(self, target: float) -> float:
        """The expected time to reach the target [s]."""
        if not self.trials:
            return self.least
        base = self._base(target)
        return max(self.least, base.seconds * (base.size / self._wanted(target)) ** self.growth)

    @property
    def growth(self) -> float:
        """The exponent r of the time, which is proportional to size^(-r)."""
        return 1.0 if self.kind == "fixed" else 1.0 / (self.order + 1.0)

    def next(self, target: float) -> float | None:
        """The size of the next run; None if none is expected to be faster."""
        if not self.trials:
            return self.size
        reach = max((trial.size for trial in self._reaching), default=0.0)
        short = min((x for x in (*self._missing(), *self.failed) if x > reach), default=math.inf)
        size = self._wanted(target)
        if reach:
            most = min(self.longest, short, JUMP[self.kind] * reach)
            if size >= short:
                size = math.sqrt(reach * short)
            size = rounded(min(size, most))
            return size if size < short and (size / reach) ** self.growth >= GAIN else None
        return rounded(max(min(size, 0.7 * short), short / JUMP[self.kind]))

    @property
    def tried(self) -> bool:
        return self.runs > 0 or self.least > 0.0

    def see(self, size: float, result: SearchRun, target: float, enough: float) -> None:
        """Add the result of a run; one that was ended after ``enough`` seconds is too slow."""
        if result.late:
            self.skipped = not result.seconds
            if result.seconds > self.least:
                self.ended, self.least = size, result.seconds
            if result.seconds < enough:
                self.pressed = max(self.pressed, result.seconds)
                return
        self.runs += 1
        if result.late:
            return
        self.pressed = 0.0
        if result.problem:
            self._see_failure(size, result.problem)
        else:
            self._see_error(TimedRun(size, result.error, result.seconds), target)
        if self.runs >= RUNS and not self.problem and not self._reaching:
            self.problem = f"not in {RUNS} runs"

    def _see_failure(self, size: float, problem: str) -> None:
        self.failed.append(size)
        self.reason = problem
        longer = self._reaching and size > max(trial.size for trial in self._reaching)
        if longer:
            return
        if self.trials or len(self.failed) >= FAILURES:
            self.problem = problem
        self.size = rounded(size / (4.0 if self.kind == "fixed" else 10.0))

    def _see_error(self, trial: TimedRun, target: float) -> None:
        before = self.trials[-1] if self.trials else None
        self.trials.append(trial)
        if trial.error <= target:
            self._reaching.append(trial)
        elif before is not None and trial.size < before.size and not self._reaching:
            stuck = trial.error > STUCK * before.error and trial.error < SATURATED
            if stuck and len(self.trials) > 2:
                least = min(trial.error for trial in self.trials)
                self.problem = f"does not come below {least:.1e}".replace("e-0", "e-")

    def _missing(self) -> list[float]:
        return [trial.size for trial in self.trials if trial not in self._reaching]

    def _base(self, target: float) -> TimedRun:
        """The run whose error is closest to the target."""
        return min(self.trials, key=lambda trial: abs(math.log(max(trial.error, 1e-300) / target)))

    def _slope(self) -> float:
        """The exponent q of the error, which is proportional to size^q: the nominal one, or the observed one."""
        nominal = self.order if self.kind == "fixed" else 1.0
        if len(self.trials) < 2:
            return nominal
        one, two = sorted(self.trials, key=lambda trial: trial.size)[:2]
        if not 0.0 < one.error < two.error:
            return nominal
        return min(max(math.log(two.error / one.error) / math.log(two.size / one.size), 0.5), 2.0 * nominal)

    def _wanted(self, target: float) -> float:
        """The size whose error is expected to be just small enough."""
        base, slope = self._base(target), self._slope()
        size = base.size * (AIM * target / max(base.error, 1e-300)) ** (1.0 / slope)
        last = self.trials[-1]
        if len(self.trials) > 1 and not self._reaching and last.error > STUCK * self.trials[-2].error:
            size = min(size, 0.1 * last.size)  # runs of many tolerances may be the same run
        return min(size, self.longest)


def search(
    candidates: Sequence[Candidate],
    target: float,
    attempt: Callable[[Candidate, float, float], SearchRun],
    left: Callable[[], float],
) -> bool:
    """Run candidates until the fastest one is known, or until there is no time left.

    Parameters
    ----------
    candidates : sequence of Candidate
        Their runs are added.
    target : float
        Limit of the error.
    attempt : callable
        ``attempt(candidate, size, cap)`` makes a run of at most ``cap`` [s].
    left : callable
        Returns the remaining time [s].

    Returns
    -------
    bool
        Whether the search is complete.
    """
    turn = sorted(candidates, key=lambda c: c.prior)
    while turn:
        for candidate in turn:
            if left() <= 0.0:
                return False
            level = max(SHORT, best_time(candidates, target))
            if candidate.runs and not pursued(candidate, level, target):
                continue
            size = candidate.next(target)
            if size is None:
                continue
            longest = SLACK * _margin(candidate) * level
            cap = min(longest, max(PART * left(), 2.0 * candidate.pressed), left())
            if cap < AGAIN * candidate.pressed:
                candidate.skipped = True
                continue
            candidate.see(size, attempt(candidate, size, cap), target, longest / AGAIN)
        level = max(SHORT, best_time(candidates, target))
        turn = sorted((c for c in candidates if pursued(c, level, target)), key=lambda c: c.promise(target))
    return not any(c.skipped for c in candidates)


def best_time(candidates: Sequence[Candidate], target: float) -> float:
    """The least time that reaches the target, or, before that, the least promise [s]."""
    reached = [c.best.seconds for c in candidates if c.best is not None]
    promised = [c.promise(target) for c in candidates if c.trials and not c.problem]
    return min(reached or promised, default=math.inf)


def pursued(candidate: Candidate, level: float, target: float) -> bool:
    """Whether a further run of a candidate may lead to a time near ``level`` [s]."""
    if candidate.problem or candidate.skipped or candidate.runs >= RUNS or candidate.next(target) is None:
        return False
    return candidate.promise(target) < _margin(candidate) * level


def _margin(candidate: Candidate) -> float:
    return VAGUE if len(candidate.trials) < 2 else NEAR


def rounded(x: float) -> float:
    """``x`` rounded down to two digits."""
    digit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return float(f"{math.floor(x / digit * (1 + 1e-9)) * digit:.2g}")
