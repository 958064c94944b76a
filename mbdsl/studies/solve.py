"""Solve: the values of parameters for which measures of a model have given values.

    f(x) = y,   x within a range

One unknown: f is computed at a few points of the range, and each change of the sign of f - y is a bracket of a root,
which is found by algorithm 748 (Alefeld, Potra and Shi 1995). Without a change of sign, the least |f - y| is sought
between the neighbours of the closest point, which finds pairs of roots. Two unknowns: least squares from the closest
points of a grid, by the trust-region reflective method (Branch, Coleman and Li 1999).

The error of an answer follows from a run with half of the step, or a tenth of the tolerance, and half of the output
interval: |dx| = 2 |f'(x)^-1 (f_fine - f)|, to which the width of the bracket is added.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise, product
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.analysis.operating_points import At
from mbdsl.display_unit import DisplayUnit, UnitsOfSignals
from mbdsl.errors import UsageError
from mbdsl.lang.display_units import asked as asked_units
from mbdsl.lang.display_units import factor, only_asked
from mbdsl.lang.given_values import mapping
from mbdsl.lang.units import measure as measured
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count
from mbdsl.studies.measures import Measure
from mbdsl.studies.runner import StudyProgress
from mbdsl.studies.store import Computed, Store
from mbdsl.studies.sweep import setting, time_limit, with_unit
from mbdsl.studies.sweep_results import Sweep
from mbdsl.studies.sweep_runs import Point, PointRunner, SweepSetting, times
from mbdsl.studies.sweep_values import RANGES, Varied, number_text
from mbdsl.studies.sweep_values import interval as range_of

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

Array = NDArray[np.float64]
Place = Sequence[float] | Array  #: a point of the unit interval or square
SCAN, GRID = 11, 5  #: points of the range of one unknown; points of each range of two
WIDTH = 1e-8  #: width of a bracket, relative to the range
DIFFERENCE = 1e-4  #: length of a difference quotient, relative to the range
STARTS = 2  #: points of the grid from which two unknowns are sought
MET = 1e-4  #: largest deviation of an answer, relative to the differences of the measure over the range
_EQUATION = re.compile(r"(.*[^<>=!:])={1,2}([^=]*)", re.DOTALL)


@dataclass(frozen=True)
class Condition:
    """A measure and the value that it should have, as ``max(shaft.w) = 160 rpm``.

    Attributes
    ----------
    measure : Measure
        The measure.
    value : float
        The value, in the SI unit of the measure.
    unit : str
        The unit in which the value was given; "" if it has none.
    """

    measure: Measure
    value: float
    unit: str = ""

    def shown(self, value: float, digits: int = 6) -> str:
        """Return a value of the measure in the unit of the condition.

        Parameters
        ----------
        value : float
            The value in the SI unit of the measure.
        digits : int, optional
            Significant digits.

        Returns
        -------
        str
        """
        return DisplayUnit(self.unit, factor(self.unit, self.measure.unit)).text(value, digits)

    def __str__(self) -> str:
        return f"{self.measure} = {self.shown(self.value)}"


@dataclass(frozen=True)
class Answer:
    """Values of the parameters that meet all conditions.

    Attributes
    ----------
    values, errors : tuple of float
        Values of the parameters and estimates of their errors, in the units of their ranges; an error is nan if the run
        that it is estimated by has failed.
    measures : tuple of float
        Values of the measures, in SI units.
    """

    values: tuple[float, ...]
    errors: tuple[float, ...]
    measures: tuple[float, ...]


class Solution:
    """The answers of ``solve``. ``print(solution)`` shows them; without an answer, what was reached.

    ``solution["m"]`` is the value of a parameter in the first answer, in the unit of its range.

    Attributes
    ----------
    name : str
        Name of the model.
    parameters : tuple of Varied
        Parameters and the ends of their ranges.
    conditions : tuple of Condition
        Conditions.
    answers : tuple of Answer
        Those that were found, by ascending values; empty if there is none.
    sweep : Sweep
        All runs that were made, by ascending values of the first parameter.
    notes : tuple of str
        Remarks, such as a jump of the measure over its value.
    """

    def __init__(
        self,
        name: str,
        parameters: Sequence[Varied],
        conditions: Sequence[Condition],
        answers: Sequence[Answer],
        sweep: Sweep,
        notes: Sequence[str] = (),
    ) -> None:
        self.name, self.parameters, self.conditions = name, tuple(parameters), tuple(conditions)
        self.answers, self.sweep, self.notes = tuple(answers), sweep, tuple(notes)

    def __bool__(self) -> bool:
        return bool(self.answers)

    def __getitem__(self, name: str) -> float:
        return self._of(name, [answer.values for answer in self.answers[:1]])

    def error(self, name: str) -> float:
        """Return the estimated error of a parameter in the first answer.

        Parameters
        ----------
        name : str
            The parameter.

        Returns
        -------
        float
            In the unit of its range.
        """
        return self._of(name, [answer.errors for answer in self.answers[:1]])

    def _of(self, name: str, found: Sequence[tuple[float, ...]]) -> float:
        names = [p.name for p in self.parameters]
        if name not in names:
            raise UsageError(f"`{name}` was not sought", hint=f"sought: {', '.join(names)}")
        if not found:
            title, *reached = self._lacking()
            raise UsageError(title, hint="; ".join(line.strip() for line in reached))
        return found[0][names.index(name)]

    def __repr__(self) -> str:
        return f"<Solution of {self.name}: {count(len(self.answers), 'answer')}>"

    def __str__(self) -> str:
        if not self.answers:
            lines = self._lacking()
        else:
            lines = [self._line(answer) for answer in self.answers]
        runs = count(len(self.sweep), "run")
        failed = f", {len(self.sweep.failed)} of them failed" if self.sweep.failed else ""
        return "\n".join(
            [f"{self.name}: {lines[0]}", *lines[1:], *(f"note: {x}" for x in self.notes), f"{runs}{failed}"]
        )

    def _line(self, answer: Answer) -> str:
        found = zip(self.parameters, answer.values, answer.errors, strict=True)
        display = only_asked(self.sweep.display)
        units = [display.of(p.unit, p.name) for p in self.parameters]
        shown = zip(units, found, strict=True)
        values = ", ".join(
            f"{p.name} = {_with_error(x / unit.factor, error / unit.factor, unit.symbol)}"
            for unit, (p, x, error) in shown
        )
        reached = zip(self.conditions, answer.measures, strict=True)
        return f"{values}, where {' and '.join(f'{c.measure} = {c.shown(self._reached(c, y))}' for c, y in reached)}"

    def _reached(self, c: Condition, y: float) -> float:
        """The value of a measure in an answer; the required one but for the width of the last bracket."""
        spread = _spread(self.sweep[str(c.measure)], c.value)
        return c.value if math.isclose(y, c.value, rel_tol=0.0, abs_tol=1e-6 * spread) else y

    def _lacking(self) -> list[str]:
        """That there is no answer, and what the measures reach over the range."""
        limits = [p.displayed(only_asked(self.sweep.display)) for p in self.parameters]
        ranges = " and ".join(f"{p.said(0)} to {p.shown(1)}{f' {p.unit}' if p.unit else ''}" for p in limits)
        lines = [f"no answer for {' and '.join(map(str, self.conditions))} from {ranges}"]
        columns = [self.sweep[str(c.measure)] for c in self.conditions]
        for c, y in zip(self.conditions, columns, strict=True):
            known = np.flatnonzero(np.isfinite(y))
            low, high = (known[int(of(y[known]))] for of in (np.argmin, np.argmax))
            ends = [f"{c.shown(y[k])} ({self.sweep.point(k)})" for k in (low, high)]
            same = math.isclose(y[low], y[high], rel_tol=1e-9)
            reached = f"{c.shown(y[low])} at all of these values" if same else f"from {ends[0]} to {ends[1]}"
            lines.append(f"  {c.measure} is {reached}")
        if len(columns) > 1:
            far = [np.abs(y - c.value) / _spread(y, c.value) for c, y in zip(self.conditions, columns, strict=True)]
            k = int(np.nanargmin(np.sum(np.square(far), axis=0)))
            both = " and ".join(f"{c.measure} = {c.shown(y[k])}" for c, y in zip(self.conditions, columns, strict=True))
            lines.append(f"  closest: {both} ({self.sweep.point(k)})")
        return lines


def _with_error(x: float, error: float, unit: str) -> str:
    """``431.72 kg +- 0.03 kg``, with the digits that the error leaves."""
    after = f" {unit}" if unit else ""
    if not math.isfinite(error):
        return f"{x:.6g}{after} (error not known)"
    places = math.floor(math.log10(abs(x))) - math.floor(math.log10(error)) + 1 if error and x else 6
    digits = min(12, max(2, places))
    return f"{x:.{digits}g}{after} +- {error:.1g}{after}"


def solve(
    model: Scene | Builder | str | PathLike,
    vary: Mapping[str, str | Iterable],
    conditions: str | Sequence[str],
    *,
    after: float | str | None = None,
    method: str | None = None,
    step: float | str | None = None,
    tol: float | str | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    interval: float | str | None = None,
    at: At = "static",
    options: Mapping[str, float | None] | None = None,
    parameters: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    limit: float | str | None = None,
    workers: int | None = None,
    store: str | PathLike | None = None,
    fresh: bool = False,
    units: str | Iterable[str] | None = None,
    tell: Callable[[StudyProgress], None] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Solution:
    """Find the value of a parameter, or of two, for which a measure, or two, have given values.

    Runs are stored as those of ``mbdsl.sweep``.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism, as for ``mbdsl.sweep``.
    vary : mapping
        Parameter -> the range in which it is sought: a text "100:1000 kg", "1:1000:log N/mm", or the two ends.
    conditions : str or sequence of str
        As many as parameters: a measure and its value, such as ``max(shaft.w) = 160 rpm``, ``static(boom.phi) = 30
        deg`` or ``frequency(1) = 2 Hz``; the measures are those of ``mbdsl.sweep``.
    after, method, step, tol, start, stop, interval, at, options, parameters, without : optional
        As for ``mbdsl.sweep``.
    limit, workers, store, fresh, units, tell, announce : optional
        As for ``mbdsl.sweep``; measures are printed in the units of their conditions, unless others are asked for.

    Returns
    -------
    Solution
        All answers for one parameter that eleven points of the range tell apart, and at most one for two. Without an
        answer it is false, and its text says what was reached.

    Raises
    ------
    UsageError, ModelError
        If the arguments are invalid, or no run of the range succeeds.
    KeyboardInterrupt
        If it is interrupted; completed runs are stored.
    """
    asked_units(units)  # raises its errors before the runs
    ranges = [range_of(name, given) for name, given in mapping(vary, "vary", f"write {RANGES}").items()]
    texts = [conditions] if isinstance(conditions, str) else list(conditions)
    if not ranges or len(ranges) != len(texts) or len(ranges) > 2:
        raise UsageError(
            f"{count(len(ranges), 'parameter')} and {count(len(texts), 'condition')}: expected one of each, or two",
            hint='e.g. --vary m=100:1000kg --for "max(shaft.w) = 160 rpm"',
        )
    sides = [_sides(text) for text in texts]
    corners = [
        tuple(zip([p.name for p in ranges], values, strict=True)) for values in product(*(p.texts for p in ranges))
    ]
    given: dict[str, Any] = {"after": after, "method": method, "step": step, "tol": tol, "start": start, "stop": stop}
    given |= {"interval": interval, "at": at, "options": options, "parameters": parameters, "without": without}
    of, case, plan = setting(model, corners, [left for left, _ in sides], **given)
    if len(of.measures) != len(sides):
        shown = ", ".join(map(str, of.measures))
        raise UsageError(f"{count(len(sides), 'condition')} with {count(len(of.measures), 'measure')}: {shown}",
                         hint="each condition has one signal of its own")  # fmt: skip
    display = asked_units(units, of.scene.display)
    asked = [_condition(m, right, display) for m, (_, right) in zip(of.measures, sides, strict=True)]
    runner = PointRunner(of, Store(store, fresh), time_limit(limit), workers=workers, tell=tell, announce=announce)
    runs = _Runs(of, runner, case, [with_unit(p, of.scene) for p in ranges], display)
    target = np.array([c.value for c in asked])
    roots, notes = (_one if len(ranges) == 1 else _two)(runs, target, asked)
    finer: PointRunner | None = None
    if plan is not None and roots:
        half = times(of, of.scene).get("interval")
        halved = replace(of, times_asked={**of.times_asked, "interval": half / 2.0 if half else half})
        finer = PointRunner(halved, runner.store, math.inf, workers=workers, tell=tell, announce=announce)
        case = replace(case, tol=plan.tol / 10.0) if plan.tol is not None else replace(case, step=plan.h / 2.0)
    answers = [_answer(runs, target, root, finer, case) for root in roots]
    return Solution(of.scene.name, runs.ranges, asked, sorted(answers, key=lambda x: x.values), runs.sweep(), notes)


def _sides(text: str) -> tuple[str, str]:
    """The measure and the value of a condition."""
    example = "a condition is an equation: max(shaft.w) = 160 rpm"
    if not isinstance(text, str):
        raise UsageError(f"conditions: found {text!r}, expected a text", hint=example)
    match = _EQUATION.fullmatch(text)
    if match is None or not match[1].strip() or not match[2].strip():
        raise UsageError(f"`{text}` is not a condition", hint=example)
    return match[1].strip(), match[2].strip()


def _condition(measure: Measure, text: str, display: UnitsOfSignals) -> Condition:
    unit = re.sub(r"^\s*[-+.\d]+([eE][-+]?\d+)?\s*", "", text).strip()
    example = f"write its value, e.g. {measure} = 2 {measure.unit}".rstrip()
    try:
        value = measured(text, measure.unit or "1")
        if {_turning(unit), _turning(measure.unit)} == {True, False} and "Hz" in unit + measure.unit:
            raise ValueError(f"`{text}` has the wrong unit: one turn in a second is 1 Hz, or 2 pi rad/s")
        if not math.isfinite(value):
            raise ValueError(f"`{text}` is not a finite number")
    except ValueError as problem:
        raise UsageError(f"{measure}: {problem}", hint=example) from None
    other = only_asked(display).of(measure.unit, measure.signal)
    return Condition(measure, value, unit or measure.unit if other.symbol == measure.unit else other.symbol)


def _turning(unit: str) -> bool:
    """Whether a unit contains an angle, so that it does not count cycles."""
    return any(symbol in re.findall("[A-Za-z]+", unit) for symbol in ("rad", "deg", "rev", "rpm"))


class _Runs:
    """Measures at points of the ranges, which are mapped to [0, 1]; each point is computed once."""

    def __init__(
        self,
        of: SweepSetting,
        runner: PointRunner,
        case: Point,
        ranges: Sequence[Varied],
        display: UnitsOfSignals,
    ) -> None:
        self.of, self.runner, self.case, self.ranges, self.display = of, runner, case, tuple(ranges), display
        self.done: dict[tuple[float, ...], Computed] = {}  #: by the values of the parameters

    def values(self, u: Place) -> tuple[float, ...]:
        """The values of the parameters at a point of the unit square, in their units."""
        return tuple(float(number_text(_mapped(p, float(x)))) for p, x in zip(self.ranges, u, strict=True))

    def point(self, values: Sequence[float], case: Point) -> Point:
        texts = ((p.name, f"{number_text(x)} {p.unit}".strip()) for p, x in zip(self.ranges, values, strict=True))
        return replace(case, values=tuple(texts))

    def __call__(self, *us: Place) -> Array:
        """The measures (N, number of measures) at N points; nan where the run has failed."""
        wanted = {x: self.point(x, self.case) for x in map(self.values, us) if x not in self.done}
        if wanted:
            runs = self.runner.runs(wanted.values())
            self.done |= {x: runs[point] for x, point in wanted.items()}
        return np.array([self._measures(self.done[self.values(u)]) for u in us])

    def finer(self, u: Place, runner: PointRunner, case: Point) -> Array:
        """The measures (number of measures,) at a point with other settings of the run."""
        point = self.point(self.values(u), case)
        return self._measures(runner.runs([point])[point])

    def _measures(self, run: Computed) -> Array:
        return np.array([run.stats["values"][str(m)] if run.done else math.nan for m in self.of.measures], float)

    def sweep(self) -> Sweep:
        """All runs, by ascending values."""
        rows = sorted(self.done)
        columns = []
        for p, values in zip(self.ranges, zip(*rows, strict=True), strict=True):
            texts = tuple(f"{number_text(x)} {p.unit}".strip() for x in values)
            columns.append(Varied(p.name, texts, tuple(values), p.unit, p.log))
        indices = [(k,) * len(columns) for k in range(len(rows))]
        runs = [self.done[row] for row in rows]
        name, measures, runner = self.of.scene.name, self.of.measures, self.runner
        return Sweep(name, columns, measures, indices, runs, True, runner.limit, runner.found, (), self.display)

    def check(self, y: Array) -> None:
        """Raise a UsageError if no run of the first points has a value."""
        if not np.isfinite(y).all(axis=1).any():
            run = next(iter(self.done.values()))
            said = self.sweep()
            lacking = f"{self.of.measures[0]} has no value"
            lacking += f", {self.of.measures[0].lacking}" if self.of.measures[0].lacking else ""
            reason = said.reason(0) if not run.done else lacking
            raise UsageError(f"no run of the range gives a value; {said.point(0)}: {reason}")


def _mapped(p: Varied, u: float) -> float:
    """The value at u in [0, 1] of a range, evenly spaced or by logarithms."""
    assert p.numbers is not None
    a, b = p.numbers
    if u in (0.0, 1.0):
        return b if u else a
    return a * (b / a) ** u if p.log else a + (b - a) * u


def _spread(y: Array, target: float) -> float:
    """The differences of a measure over the range and to its target, as a scale."""
    known = y[np.isfinite(y)]
    return float(max(np.ptp(np.append(known, target)), 1e-12 * abs(target), 1e-300))


# -- one unknown -------------------------------------------------------------------------------------------------------


def _one(runs: _Runs, target: Array, asked: Sequence[Condition]) -> tuple[list[Array], list[str]]:
    """The roots in the range of one parameter, as points (1,), and notes."""
    from scipy.optimize import toms748

    u = np.linspace(0.0, 1.0, SCAN)
    y = runs(*([x] for x in u))
    runs.check(y)
    f = y[:, 0] - target[0]
    small = 1e-10 * _spread(y[:, 0], target[0])
    if not _brackets(u, f):
        u, f = _closer(runs, target[0], u, f)
    roots, notes = [np.array([x]) for x in u[np.abs(f) <= small]], []

    def residual(x: float) -> float:
        found = float(runs([x])[0, 0] - target[0])
        if math.isnan(found):
            raise _Failed
        return 0.0 if abs(found) <= small else found

    for a, b, fa, fb in _brackets(u, f):
        if min(abs(fa), abs(fb)) <= small:
            continue
        try:
            root = float(toms748(residual, a, b, xtol=WIDTH, rtol=4 * np.finfo(float).eps))
        except _Failed:
            notes.append(f"runs fail between {_said(runs, a)} and {_said(runs, b)}, where {asked[0]} is passed")
            continue
        if abs(residual(root)) > 0.01 * abs(fb - fa):
            notes.append(f"{asked[0].measure} jumps over {asked[0].shown(asked[0].value)} at {_said(runs, root)}")
        else:
            roots.append(np.array([root]))
    return roots, notes


class _Failed(Exception):
    """A run within a bracket has failed."""


def _said(runs: _Runs, u: float) -> str:
    (p,), (x,) = runs.ranges, runs.values([u])
    return f"{p.name} = {x:.6g} {p.unit}".rstrip()


def _brackets(u: Array, f: Array) -> list[tuple[float, float, float, float]]:
    """Neighbours between which f changes its sign."""
    known = np.isfinite(f)
    pairs = zip(pairwise(u), pairwise(f), pairwise(known), strict=True)
    return [(a, b, fa, fb) for (a, b), (fa, fb), (ka, kb) in pairs if ka and kb and fa * fb <= 0.0]


def _closer(runs: _Runs, target: float, u: Array, f: Array) -> tuple[Array, Array]:
    """The points with those of a search for the least |f| between the neighbours of the closest one, which ends where
    f changes its sign."""
    from scipy.optimize import minimize_scalar

    k = int(np.nanargmin(np.abs(f)))
    if k in (0, len(u) - 1):
        return u, f
    sign, found = math.copysign(1.0, f[k]), {}

    def distance(x: float) -> float:
        value = float(runs([x])[0, 0] - target)
        found[x] = value
        if math.isnan(value) or value * sign <= 0.0:
            raise _Failed
        return abs(value)

    with suppress(_Failed):
        minimize_scalar(distance, bounds=(u[k - 1], u[k + 1]), method="bounded", options={"xatol": 1e-4})
    u, f = np.append(u, list(found)), np.append(f, list(found.values()))
    order = np.argsort(u)
    return u[order], f[order]


# -- two unknowns ------------------------------------------------------------------------------------------------------


def _two(runs: _Runs, target: Array, asked: Sequence[Condition]) -> tuple[list[Array], list[str]]:
    """A point (2,) of the ranges of two parameters that meets both conditions, and notes."""
    from scipy.optimize import least_squares

    points = np.array(list(product(np.linspace(0.0, 1.0, GRID), repeat=2)))
    y = runs(*points)
    runs.check(y)
    scale = np.array([_spread(y[:, k], target[k]) for k in range(2)])
    far = np.linalg.norm((y - target) / scale, axis=1)
    for k in np.argsort(far)[:STARTS]:  # nan is last
        if not np.isfinite(far[k]):
            break
        try:
            found = least_squares(
                lambda u: (runs(u)[0] - target) / scale,
                np.clip(points[k], 1e-3, 1.0 - 1e-3),
                lambda u: _slopes(runs, u) / scale[:, None],
                bounds=(0.0, 1.0),
                xtol=WIDTH / 100.0,
                ftol=1e-15,
                gtol=1e-15,
                max_nfev=20,
            )
        except (_Failed, ValueError, np.linalg.LinAlgError):  # runs fail there
            continue
        if np.abs(found.fun).max() <= MET:
            return [found.x], []
    return [], []


def _slopes(runs: _Runs, u: Array) -> Array:
    """The derivatives (number of measures, number of parameters) of the measures on the unit square, by differences.

    Raises
    ------
    _Failed
        If a run fails.
    """
    steps = np.where(u < 0.5, DIFFERENCE, -DIFFERENCE) * np.eye(len(u))
    here, *there = runs(u, *(u + step for step in steps))
    found = np.array([(x - here) / step.sum() for x, step in zip(there, steps, strict=True)]).T
    if not np.isfinite(found).all():
        raise _Failed
    return found


# -- answers -----------------------------------------------------------------------------------------------------------


def _answer(runs: _Runs, target: Array, u: Array, finer: PointRunner | None, case: Point) -> Answer:
    """The values at a point, with their errors."""
    x, y = runs.values(u), runs(u)[0]
    off = np.abs(y - target)
    if finer is not None:
        off = off + 2.0 * np.abs(runs.finer(u, finer, case) - y)
    try:
        inverse = np.abs(np.linalg.inv(_slopes(runs, u)))
    except (_Failed, np.linalg.LinAlgError):
        inverse = np.full((len(u), len(u)), math.nan)
    du = inverse @ off + WIDTH
    errors = []
    for p, at, d in zip(runs.ranges, u, du, strict=True):
        a, b = (_mapped(p, min(1.0, max(0.0, at + s))) for s in (-1e-6, 1e-6))
        width = min(1.0, at + 1e-6) - max(0.0, at - 1e-6)
        errors.append(float(abs(b - a) / width * d))
    return Answer(x, tuple(errors), tuple(float(v) for v in y))
