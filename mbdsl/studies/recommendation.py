"""The method, with its step or tolerance, that reaches an error in the least time on this machine."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from statistics import median
from typing import Any

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.integrators import available
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import duration, together
from mbdsl.plotting.figures import Table
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import Case, assemble, chosen, own_step, setting
from mbdsl.studies.effects import tolerance
from mbdsl.studies.error_measures import Quantity, error, quantities
from mbdsl.studies.families import precise
from mbdsl.studies.reference_solution import Reference, automatic, file_points, from_file
from mbdsl.studies.report import as_text, number, size
from mbdsl.studies.runner import Runner
from mbdsl.studies.slopes import CLEAR
from mbdsl.studies.store import Store
from mbdsl.studies.survey import Asked

AIM = 0.8  #: part of the error that is the target, to avoid trials for small improvements
RUNS = 8  #: largest number of runs of one method
FAR = 3.0  #: a method that is this many times as slow as the fastest one is not tried further
SHORT = 0.1  #: duration [s] below which a single run is too short to time
ASKED = "the error asked for"
SHARE = 0.7  #: part of the remaining budget for finding cases; the rest is for timing them
JUMP = 32.0  #: largest ratio of successive steps, because errors at long steps predict little


@dataclass(frozen=True)
class Choice:
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
        Other methods, and the reason why each is not a choice.
    reference : Reference
        The reference solution.
    extra : tuple of str
        Options of the command line that set the model's parameters and effects.
    note : str
        A remark on the times.
    """

    model: str
    path: str
    what: str
    error: float
    unit: str
    choices: tuple[Choice, ...]
    others: tuple[tuple[str, str], ...]
    reference: Reference
    extra: tuple[str, ...] = ()
    note: str = ""

    @property
    def best(self) -> Choice:
        """The fastest case."""
        return self.choices[0]

    @property
    def command(self) -> str:
        """The shell command of the fastest case."""
        return shlex.join(["mbdsl", "simulate", self.path, *shlex.split(self.best.case.arguments), *self.extra])

    def _head(self) -> str:
        return f"{self.model}: an error of {self.error:.3g}{f' {self.unit}' if self.unit else ''} in {self.what}"

    def _table(self) -> Table:
        unit = f" {self.unit}" if self.unit else ""
        rows = []
        for c in self.choices:
            ratio = f"{c.time / self.best.time:.2g}"
            rows.append((c.case.series, size(c.case), number(c.error) + unit, duration(c.time), ratio))
        return Table("", ("method", "step or tol", "error", "time", "to the best"), rows)

    def _rest(self) -> list[str]:
        lines = [f"{name}: {why}" for name, why in self.others] + ([self.note] if self.note else [])
        return [*lines, f"reference: {self.reference}", f"cheapest here:  {self.command}"]

    def __str__(self) -> str:
        return "\n".join([self._head(), "", as_text(self._table()), "", *self._rest()])

    def __repr__(self) -> str:
        return f"<Recommendation for {self._head()}: {self.best.case}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        return fragment(self._head(), (), [self._table()], self._rest())


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
        Fields of ``Asked``: methods, reference, stop, parameters, without, repeats,
        budget, ...

    Returns
    -------
    Recommendation

    Raises
    ------
    IntegrationError
        If no method reaches the error, or the reference solution is not accurate enough.
    """
    given = Asked(**{"budget": 60.0, "repeats": 3, **asked})
    names = chosen(given.methods)
    of = setting(model, given.stop, given.parameters, given.without)
    assemble(of, given.announce)
    if given.reference != "auto":
        of = replace(of, points=file_points(given.reference, of))
    store = Store(given.store, given.fresh)
    runner = Runner(of, store, budget=given.budget, tell=given.tell, announce=given.announce)
    reference, search = _search(runner, names, given, target, signal)
    choices: list[Choice] = []
    others: list[tuple[str, str]] = []
    quickest = math.inf
    ways = _promising(names)
    for k, (name, kind) in enumerate(ways):
        # no method may use the time of the others
        share = runner.left * max(SHARE / (len(ways) - k), 0.25)
        found, why = search.reach(name, kind, quickest, share)
        if found is None:
            others.append((_case(name, kind, 0.1).series, why))
        else:
            choices.append(found)
            quickest = min(quickest, found.time)
    if not choices:
        raise IntegrationError(f"no method reaches an error of {search.wording(search.target)}: {together(others)}")
    near = [c for c in choices if c.time <= max(FAR * quickest, SHORT)]
    times = runner.time([c.case for c in near], given.repeats, {c.case: c.time for c in near}.__getitem__)
    note = ""
    if len(times) < len(near):  # medians of several runs and single runs are not comparable
        times, note = {}, f"times are of one run each, as the budget of {given.budget:g} s was spent"
    timed = [Choice(c.case, c.error, times.get(c.case, c.seconds)) for c in near]
    others += [(c.case.series, f"takes {c.time / quickest:.0f} times as long") for c in choices if c not in near]
    extra = ["--model", of.model_name] if of.model_name else []
    extra += [word for name, value in of.parameters.items() for word in ("--set", f"{name}={value}")]
    extra += ["--without", ",".join(of.without)] if of.without else []
    extra += ["--stop", repr(of.stop)] if given.stop is not None else []
    timed.sort(key=lambda c: c.time)
    path = of.path or of.scene.name
    return Recommendation(
        of.scene.name,
        path,
        search.what,
        search.target,
        search.unit,
        tuple(timed),
        tuple(others),
        reference,
        tuple(extra),
        note,
    )


@dataclass
class Search:
    """Search for the longest step or tolerance with a small enough error."""

    runner: Runner
    reference: Reference
    wanted: Sequence[Quantity]
    target: float
    unit: str
    what: str
    scaled: bool

    def error(self, trajectory: Trajectory) -> float:
        found = (error(q, trajectory, self.reference.solution) for q in self.wanted)
        return max(e.scaled if self.scaled else e.largest for e in found)

    def wording(self, x: float) -> str:
        return f"{x:.2g} {self.unit}".rstrip()

    def reach(
        self, name: str, kind: str, quickest: float = math.inf, share: float = math.inf
    ) -> tuple[Choice | None, str]:
        """The case of a method that reaches the target with the longest step tried, or the reason why there is none.

        Runs that take far longer than the ``quickest`` known one, or in sum longer than ``share`` [s], are stopped.
        """
        fixed = kind == "fixed"
        order = float(available()[name].order) if fixed else 1.0
        at = 4.0 * own_step(self.runner.setting) if fixed else min(1e-3, 10.0 * self.target_part)
        tried: list[tuple[float, float]] = []
        best: Choice | None = None
        why = ""
        slow, spent = max(FAR * quickest, SHORT), 0.0
        for _ in range(RUNS):
            case = _case(name, kind, _rounded(at))
            limit = min(4.0 * slow, share - spent)  # a slow complete run gives more information than a stopped one
            run = self.runner.compute([case], limit=limit)[case]
            spent += min(limit, run.stats.get("seconds", {}).get("integrate", limit if run.late else 0.0))
            if run.late and best is None and limit >= 4.0 * slow:
                return None, f"takes more than {FAR:g} times as long"
            if run.problem:
                why = run.problem
                if tried or run.late:
                    break
                at /= 4.0 if fixed else 10.0
                continue
            e, seconds = self.error(self.runner.trajectory(run)), run.stats["seconds"]["integrate"]
            if e <= self.target:
                best = Choice(case, e, [seconds])  # errors increase from here on
                if e > self.target / 4.0 or any(size <= 2.5 * at for size, _ in tried):
                    break
            elif best is not None:
                break
            elif seconds > slow:
                return None, f"takes more than {FAR:g} times as long"
            elif len(tried) > 1 and e > 0.9 * tried[-1][1] and e < 1e-2:
                return None, f"does not come below {min(e, *(x for _, x in tried)):.1e}"
            if tried and 0.0 < e < tried[-1][1] and tried[-1][0] > at:
                seen = math.log(tried[-1][1] / e) / math.log(tried[-1][0] / at)
                order = min(max(seen, 0.5), 2.0 * order)
            change = (AIM * self.target / max(e, 1e-300)) ** (1.0 / order)
            if best is None and tried and e > 0.9 * tried[-1][1]:
                change = min(change, 0.1)  # over a range of tolerances a single run may be the result of all of them
            tried.append((at, e))
            at *= min(max(change, 1.0 / JUMP), 0.7 if best is None else JUMP)
            if at >= (10.0 * self.runner.setting.interval if fixed else 1e-2):
                break
        return best, why or f"not in {RUNS} runs"

    @property
    def target_part(self) -> float:
        """The target relative to the scale."""
        return self.target if self.scaled else self.target * self.wanted[0].weights[0]


def _promising(names: Sequence[str]) -> list[tuple[str, str]]:
    """Methods with their kinds of steps, high orders first: if these are fast, others can be stopped early."""
    high = precise()
    ordered = sorted(names, key=lambda name: high.index(name) if name in high else len(high))
    return [(name, kind) for name in ordered for kind in available()[name].steps]


def _search(
    runner: Runner, names: Sequence[str], given: Asked, target: float | str, signal: str | None
) -> tuple[Reference, Search]:
    """A sufficiently accurate reference, and the search based on it."""
    if given.reference == "auto":
        reference = automatic(runner, names, None)
    else:
        reference = from_file(given.reference, runner, [signal] if signal else ())
    search = _by(runner, reference, target, signal)
    floor = max(f.scaled if search.scaled else f.largest for f in map(reference.floor, search.wanted))
    if floor < search.target / CLEAR or reference.check is None:
        return reference, search
    raise IntegrationError(
        f"an error of {search.wording(search.target)} cannot be resolved: references agree to "
        f"{search.wording(floor)} only",
        hint=f"{reference}; allow a larger error, or give --reference FILE",
    )


def _by(runner: Runner, reference: Reference, target: float | str, signal: str | None) -> Search:
    solution = reference.solution
    like = solution if isinstance(solution, Trajectory) else runner.blank()
    if signal is None:
        wanted = [q for q in quantities(like, solution) if q.key in ("q", "v")]
        if not wanted:
            text = f"{reference.how} has no positions and velocities"
            raise UsageError(text, hint="name the signal to compare: --signal NAME")
        number_ = tolerance(target, "", 1.0, ASKED)
        return Search(runner, reference, wanted, number_, "", "positions and velocities, scaled", True)
    (name,) = like.select([signal]) if signal in like else [signal]
    wanted = [q for q in quantities(like, solution, [name]) if q.key == name]
    if not wanted:
        raise UsageError(f"the reference has no signal `{name}`")
    allowed = tolerance(target, like.unit(name), 1.0 / wanted[0].weights[0], ASKED)
    return Search(runner, reference, wanted, allowed, like.unit(name), name, False)


def _case(method: str, kind: str, size: float) -> Case:
    return Case(method, step=size) if kind == "fixed" else Case(method, tol=size)


def _rounded(x: float) -> float:
    """``x`` rounded down to two digits."""
    digit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return float(f"{math.floor(x / digit * (1 + 1e-9)) * digit:.2g}")
