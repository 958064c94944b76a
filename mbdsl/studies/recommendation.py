"""The method, with its step or tolerance, that reaches an error in the least time on this machine."""

from __future__ import annotations

import math
import shlex
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from statistics import median
from typing import Any

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.integrators import available, compiled
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count, duration, together
from mbdsl.plotting.figures import TextTable
from mbdsl.simulation.diagnostics.fixed_steps import unseen_peak
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, assemble, chosen, own_step, setting
from mbdsl.studies.effects import tolerance
from mbdsl.studies.error_measures import ErrorQuantity, error, of_motion, quantities
from mbdsl.studies.method_search import NEAR, Candidate, SearchRun, rounded, search
from mbdsl.studies.reference_solution import ReferenceSolution, automatic, file_points, from_file
from mbdsl.studies.report import as_text, number, ratio, size
from mbdsl.studies.runner import Runner
from mbdsl.studies.slopes import CLEAR
from mbdsl.studies.store import Store
from mbdsl.studies.survey import Asked

SHORT = 0.1  #: times [s] below this are measured in several rounds before methods are compared
TIMING = 0.25  #: part of the remaining budget for timing the cases that were found
PYTHON = 30.0  #: cost of a step of a third-party integrator, relative to a compiled method, before it is measured
LOOSEST = 1e-3  #: largest tolerance of a first run
WIDTH = 80  #: of a line in a terminal
ASKED = "the error asked for"
BUDGET = 120.0  #: seconds


@dataclass(frozen=True)
class RecommendedCase:
    """A case that reaches the error, with its own error and the run times [s] that were measured."""

    case: Case
    error: float
    seconds: list[float]

    @property
    def time(self) -> float:
        return median(self.seconds)


@dataclass(frozen=True)
class Recommendation:
    """Methods that reach an error, with their run times; ``str()`` returns a table.

    Attributes
    ----------
    model, path : str
        Name of the model, and its file.
    what : str
        The quantity whose error is limited.
    error : float
        Limit of the error.
    unit : str
        Unit of the error; "" for a relative error.
    choices : tuple of Choice
        Cases that reach the error, the fastest first.
    others : tuple of (str, str)
        Other methods that were tried, and the reason why each is not a choice.
    reference : Reference
        The reference solution.
    extra : tuple of str
        Options of the command line that set the model's parameters and effects.
    note : str
        A remark on the times.
    left_out : tuple of str
        Methods that were not tried, as the budget was spent.
    complete : bool
        Whether the search has ended before the budget was spent.
    budget : float
        Time limit of the search [s].
    """

    model: str
    path: str
    what: str
    error: float
    unit: str
    choices: tuple[RecommendedCase, ...]
    others: tuple[tuple[str, str], ...]
    reference: ReferenceSolution
    extra: tuple[str, ...] = ()
    note: str = ""
    left_out: tuple[str, ...] = ()
    complete: bool = True
    budget: float = math.inf

    @property
    def tried(self) -> int:
        """Number of candidates that were tried; a method with fixed and with controlled steps counts twice."""
        return len(self.choices) + len(self.others)

    @property
    def best(self) -> RecommendedCase:
        """The fastest case."""
        return self.choices[0]

    @property
    def command(self) -> str:
        """The shell command of the fastest case."""
        return shlex.join(["mbdsl", "simulate", self.path, *shlex.split(self.best.case.arguments), *self.extra])

    def _head(self) -> str:
        return f"{self.model}: an error of {self.error:.3g}{f' {self.unit}' if self.unit else ''} in {self.what}"

    def _answer(self) -> list[str]:
        every = self.tried + len(self.left_out)
        which = f"all {every}" if self.tried == every else f"the {self.tried} of {every}"
        best, others = self.best, "candidates (methods with fixed or controlled steps)"
        lines = [
            f"{best.case.series} with {'h' if best.case.tol is None else 'tol'} = {size(best.case)} takes "
            f"{duration(best.time)}, the least time of {which} {others} that were tried."
        ]
        if self.left_out:
            lines.append(f"Not tried, as the budget of {self.budget:g} s was spent: {', '.join(self.left_out)}.")
        if not self.complete:
            lines.append("The search is not complete: run the same command again to continue.")
        return lines

    def _table(self) -> TextTable:
        unit = f" {self.unit}" if self.unit else ""
        rows = []
        for c in self.choices:
            times = ratio(c.time, self.best.time)
            rows.append((c.case.series, size(c.case), number(c.error) + unit, duration(c.time), times))
        return TextTable("", ("method", "step or tol", "error", "time", "to the best"), rows)

    def _rest(self) -> list[str]:
        lines = [f"{name}: {why}" for name, why in self.others] + ([self.note] if self.note else [])
        return [*lines, f"reference: {self.reference}"]

    def __str__(self) -> str:
        def wrapped(lines: Sequence[str]) -> str:
            every = (textwrap.wrap(line, WIDTH, subsequent_indent="  ", break_on_hyphens=False) for line in lines)
            return "\n".join(part for parts in every for part in parts)

        parts = [wrapped([self._head()]), wrapped(self._answer()), as_text(self._table()), wrapped(self._rest())]
        return "\n\n".join([*parts, f"cheapest here:  {self.command}"])

    def __repr__(self) -> str:
        return f"<Recommendation for {self._head()}: {self.best.case}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        notes = [*self._rest(), f"cheapest here:  {self.command}"]
        return fragment(self._head(), self._answer(), [self._table()], notes)


def recommend(
    model: Scene | str | PathLike, target: float | str, signal: str | None = None, **asked: Any
) -> Recommendation:
    """Find the methods that reach an error in the least time.

    Parameters
    ----------
    model : Scene or path
        The mechanism.
    target : float or str
        Limit of the error, as maximum over time. With a ``signal``: in the signal's SI unit, or a text with a unit
        ("1 mm") or relative to the signal's range ("1 %"). Without: of positions and velocities, relative to the size
        of the mechanism and to the largest speed.
    signal : str, optional
        Name of a signal.
    **asked
        Fields of ``Asked``: methods, reference, stop, parameters, without, repeats, budget, ... The budget [s] is that
        of the whole search, compilation included; runs are stored, and a repeated call continues with them.

    Returns
    -------
    Recommendation

    Raises
    ------
    IntegrationError
        If no method reaches the error, or the reference solution is not accurate enough.
    """
    given = Asked(**{"budget": BUDGET, "repeats": 3, **asked})
    of = setting(model, given.stop, given.parameters, given.without)
    names = chosen(given.methods, of.scene)
    if given.reference != "auto":
        of = replace(of, points=file_points(given.reference, of))
    runner = Runner(of, Store(given.store, given.fresh), budget=given.budget, tell=given.tell, announce=given.announce)
    runner.compiling = max(runner.compiling, assemble(of, given.announce))
    reference, aim = _aim(runner, names, given, target, signal)
    candidates = [_candidate(name, kind, aim) for name in names for kind in available()[name].steps]
    with runner.reserving(TIMING * max(0.0, runner.left)):
        complete = search(candidates, aim.target, aim.attempt, lambda: runner.left)
    found = [
        RecommendedCase(_case(c, c.best.size), c.best.error, [c.best.seconds]) for c in candidates if c.best is not None
    ]
    if not found:
        raise _nothing(candidates, aim, complete, given.budget)
    timed, note = _timed(runner, found, given)
    best = timed[0].time
    slow = [c for c in found if c.case not in {t.case for t in timed}]
    others = [(c.case.series, f"takes {_relative(c.time, best)}") for c in slow]
    rest = sorted((c for c in candidates if c.best is None), key=lambda c: (c.problem != "", c.promise(aim.target)))
    others += [(_series(c), _why(c, best, aim.target)) for c in rest if c.tried]
    left_out = tuple(_series(c) for c in rest if not c.tried)
    words = (*of.words, *(["--stop", repr(of.stop)] if given.stop is not None else []))
    what = (of.scene.name, of.path or of.scene.name, aim.what, aim.target, aim.unit)
    return Recommendation(*what, tuple(timed), tuple(others), reference, words, note, left_out, complete, given.budget)


def _nothing(candidates: Sequence[Candidate], aim: Aim, complete: bool, budget: float) -> IntegrationError:
    """The error if no candidate reaches the target."""
    reasons = together((_series(c), _why(c, math.inf, aim.target)) for c in candidates if c.tried)
    target = aim.wording(aim.target)
    if complete:
        return IntegrationError(f"no method reaches an error of {target}: {reasons}")
    tried = f"{sum(c.tried for c in candidates)} of {len(candidates)} candidates were tried"
    return IntegrationError(
        f"no method has reached an error of {target} within the budget of {budget:g} s; {tried}"
        + (f": {reasons}" if reasons else ""),
        hint="run the same command again to continue, or give it more time (--budget)",
    )


def _timed(runner: Runner, found: Sequence[RecommendedCase], given: Asked) -> tuple[list[RecommendedCase], str]:
    """The choices that are about as fast as the fastest one, with times of alternating runs; and a remark."""
    quickest = min(c.time for c in found)
    near = [c for c in found if c.time <= max(NEAR * quickest, SHORT)]
    times = runner.time([c.case for c in near], given.repeats, {c.case: c.time for c in near}.__getitem__)
    note = ""
    if len(times) < len(near):  # medians of several runs and single runs are not comparable
        times, note = {}, f"times are of one run each, as the budget of {given.budget:g} s was spent"
    timed = [RecommendedCase(c.case, c.error, times.get(c.case, c.seconds)) for c in near]
    return sorted(timed, key=lambda c: c.time), note


def _why(c: Candidate, best: float, target: float) -> str:
    """Why a candidate that was tried is not a choice; ``best`` is the time of the fastest one [s]."""
    if c.problem:
        return c.problem
    last = c.trials[-1] if c.trials else None
    expected = c.promise(target)
    if c.least and expected <= c.least:
        return f"over {_relative(c.least, best)} (ended at {size(_case(c, c.ended))})"
    if last is None:
        return f"{count(c.runs, 'run')} failed: {c.reason}"
    return f"about {_relative(expected, best)} (error {number(last.error)} at {size(_case(c, last.size))})"


def _relative(seconds: float, best: float) -> str:
    return duration(seconds) + (f", {ratio(seconds, best)} times as long" if seconds > best else "")


@dataclass
class Aim:
    """The target, and the measurement of errors."""

    runner: Runner
    reference: ReferenceSolution
    wanted: Sequence[ErrorQuantity]
    target: float
    unit: str
    what: str
    scaled: bool

    def error(self, trajectory: Trajectory) -> float:
        found = (error(q, trajectory, self.reference.solution) for q in self.wanted)
        return max(e.scaled if self.scaled else e.largest for e in found)

    def wording(self, x: float) -> str:
        return f"{x:.2g} {self.unit}".rstrip()

    def attempt(self, candidate: Candidate, size: float, cap: float) -> SearchRun:
        """One run of at most ``cap`` [s], from the store or computed."""
        case = _case(candidate, size)
        run = self.runner.compute([case], limit=cap)[case]
        if run.late:
            return SearchRun(seconds=run.stats.get("seconds", {}).get("integrate", 0.0), late=True)
        if problem := run.problem or unseen_peak(run.stats):  # its states may be right at the ends of steps only
            return SearchRun(problem=problem)
        return SearchRun(self.error(self.runner.trajectory(run)), self.runner.seconds(run))

    @property
    def target_part(self) -> float:
        """The target relative to the scale."""
        return self.target if self.scaled else self.target * self.wanted[0].weights[0]


def _candidate(name: str, kind: str, aim: Aim) -> Candidate:
    """A method with its first step or tolerance; methods that need few steps for the target come first."""
    order, own, part = float(available()[name].order), own_step(aim.runner.setting), aim.target_part
    prior = (1.0 if name in compiled() else PYTHON) * part ** (-1.0 / order)
    if kind == "fixed":
        return Candidate(name, kind, order, rounded(4.0 * own), 10.0 * aim.runner.setting.interval, prior)
    return Candidate(name, kind, order, rounded(min(LOOSEST, max(10.0 * part, part**0.5))), 1e-2, prior)


def _aim(
    runner: Runner, names: Sequence[str], given: Asked, target: float | str, signal: str | None
) -> tuple[ReferenceSolution, Aim]:
    """A sufficiently accurate reference, and the target."""
    if given.reference == "auto":
        reference = automatic(runner, names, None)
    else:
        reference = from_file(given.reference, runner, [signal] if signal else ())
    aim = _by(runner, reference, target, signal)
    floor = max(f.scaled if aim.scaled else f.largest for f in map(reference.floor, aim.wanted))
    if floor < aim.target / CLEAR or reference.check is None:
        return reference, aim
    raise IntegrationError(
        f"an error of {aim.wording(aim.target)} cannot be resolved: references agree to {aim.wording(floor)} only",
        hint=f"{reference}; allow a larger error, or give --reference FILE",
    )


def _by(runner: Runner, reference: ReferenceSolution, target: float | str, signal: str | None) -> Aim:
    solution = reference.solution
    like = solution if isinstance(solution, Trajectory) else runner.blank()
    if signal is None:
        wanted = of_motion(like, solution)
        if not wanted:
            text = f"{reference.how} has no positions and velocities"
            raise UsageError(text, hint="name the signal to compare: --signal NAME")
        number_ = tolerance(target, "", 1.0, ASKED)
        return Aim(runner, reference, wanted, number_, "", "positions and velocities, scaled", True)
    (name,) = like.select([signal]) if signal in like else [signal]
    wanted = [q for q in quantities(like, solution, [name]) if q.key == name]
    if not wanted:
        raise UsageError(f"the reference has no signal `{name}`")
    allowed = tolerance(target, like.unit(name), 1.0 / wanted[0].weights[0], ASKED)
    return Aim(runner, reference, wanted, allowed, like.unit(name), name, False)


def _case(c: Candidate, size: float) -> Case:
    return Case.of(c.method, c.kind == "fixed", size)


def _series(c: Candidate) -> str:
    return _case(c, c.size).series
