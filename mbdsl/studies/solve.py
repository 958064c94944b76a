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
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise, product
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang.display_units import asked as asked_units
from mbdsl.lang.display_units import only_asked
from mbdsl.lang.given_values import mapping
from mbdsl.lang.units import measure as measured
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import UnitsOfSignals, count
from mbdsl.simulation.plan import Plan
from mbdsl.simulation.run_options import takes_options
from mbdsl.studies.measures import Measure
from mbdsl.studies.solution import Answer, Condition, Solution, spread
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep import made, setting, with_unit
from mbdsl.studies.sweep_options import SweepOptions
from mbdsl.studies.sweep_results import Sweep
from mbdsl.studies.sweep_runs import PointRunner, SweepPoint, SweepSetting, times
from mbdsl.studies.sweep_values import RANGES, Varied, number_text
from mbdsl.studies.sweep_values import interval as range_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.studies.sweep_options import GivenSweepOptions

Place = Sequence[float] | Array  #: a point of the unit interval or square
SCAN, GRID = 11, 5  #: points of the range of one unknown; points of each range of two
WIDTH = 1e-8  #: width of a bracket, relative to the range
DIFFERENCE = 1e-4  #: length of a difference quotient, relative to the range
STARTS = 2  #: points of the grid from which two unknowns are sought
MET = 1e-4  #: largest deviation of an answer, relative to the differences of the measure over the range
_EQUATION = re.compile(r"(.*[^<>=!:])={1,2}([^=]*)", re.DOTALL)


@takes_options(table=SweepOptions)
def solve(
    model: Scene | Builder | str | PathLike,
    vary: Mapping[str, str | Iterable],
    conditions: str | Sequence[str],
    **given: Unpack[GivenSweepOptions],
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
    after, method, step, tol, start, stop, interval, at, options, parameters, without, contacts : optional
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
    options = SweepOptions.of(given)
    ranges, texts = _asked(vary, conditions)
    sides = [_sides(text) for text in texts]
    corners = [
        tuple(zip([p.name for p in ranges], values, strict=True)) for values in product(*(p.texts for p in ranges))
    ]
    of, case, plan = setting(model, corners, [left for left, _ in sides], options)
    if len(of.measures) != len(sides):
        shown = ", ".join(map(str, of.measures))
        raise UsageError(f"{count(len(sides), 'condition')} with {count(len(of.measures), 'measure')}: {shown}",
                         hint="each condition has one signal of its own")  # fmt: skip
    display = asked_units(options.units, of.scene.display)
    asked = [_condition(m, right, display) for m, (_, right) in zip(of.measures, sides, strict=True)]
    runs = _Runs(of, options, case, [with_unit(p, of.scene) for p in ranges])
    target = np.array([c.value for c in asked])
    roots, notes = (_one if len(ranges) == 1 else _two)(runs, target, asked)
    finer = _finer(of, options, case, plan) if plan is not None and roots else None
    answers = [_answer(runs, target, root, finer) for root in roots]
    answers.sort(key=lambda x: x.values)
    return Solution(of.scene.name, runs.ranges, tuple(asked), tuple(answers), runs.sweep(), tuple(notes))


def _asked(vary: Mapping[str, str | Iterable], conditions: str | Sequence[str]) -> tuple[list[Varied], list[str]]:
    """The ranges, and as many texts of conditions."""
    ranges = [range_of(name, given) for name, given in mapping(vary, "vary", f"write {RANGES}").items()]
    texts = [conditions] if isinstance(conditions, str) else list(conditions)
    if not ranges or len(ranges) != len(texts) or len(ranges) > 2:
        raise UsageError(
            f"{count(len(ranges), 'parameter')} and {count(len(texts), 'condition')}: expected one of each, or two",
            hint='e.g. --vary m=100:1000kg --for "max(shaft.w) = 160 rpm"',
        )
    return ranges, texts


def _finer(of: SweepSetting, options: SweepOptions, case: SweepPoint, plan: Plan) -> tuple[PointRunner, SweepPoint]:
    """The runs with half of the step, or a tenth of the tolerance, and half of the output interval."""
    half = times(of, of.scene).get("interval")
    halved = replace(of, times_asked={**of.times_asked, "interval": half / 2.0 if half else half})
    case = replace(case, tol=plan.tol / 10.0) if plan.tol is not None else replace(case, step=plan.h / 2.0)
    return replace(options, limit=None).runner(halved), case


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

    def __init__(self, of: SweepSetting, options: SweepOptions, case: SweepPoint, ranges: Sequence[Varied]) -> None:
        self.of, self.options, self.case, self.ranges = of, options, case, tuple(ranges)
        self.runner = options.runner(of)
        self.done: dict[tuple[float, ...], Computed] = {}  #: by the values of the parameters

    def values(self, u: Place) -> tuple[float, ...]:
        """The values of the parameters at a point of the unit square, in their units."""
        return tuple(float(number_text(_mapped(p, float(x)))) for p, x in zip(self.ranges, u, strict=True))

    def point(self, values: Sequence[float], case: SweepPoint) -> SweepPoint:
        texts = ((p.name, f"{number_text(x)} {p.unit}".strip()) for p, x in zip(self.ranges, values, strict=True))
        return replace(case, values=tuple(texts))

    def __call__(self, *us: Place) -> Array:
        """The measures (N, number of measures) at N points; nan where the run has failed."""
        wanted = {x: self.point(x, self.case) for x in map(self.values, us) if x not in self.done}
        if wanted:
            runs = self.runner.runs(wanted.values())
            self.done |= {x: runs[point] for x, point in wanted.items()}
        return np.array([self._measures(self.done[self.values(u)]) for u in us])

    def finer(self, u: Place, runner: PointRunner, case: SweepPoint) -> Array:
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
        return made(self.of, self.runner, self.options, columns, indices, runs)

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


# -- one unknown -------------------------------------------------------------------------------------------------------


def _one(runs: _Runs, target: Array, asked: Sequence[Condition]) -> tuple[list[Array], list[str]]:
    """The roots in the range of one parameter, as points (1,), and notes."""
    from scipy.optimize import toms748

    u = np.linspace(0.0, 1.0, SCAN)
    y = runs(*([x] for x in u))
    runs.check(y)
    f = y[:, 0] - target[0]
    small = 1e-10 * spread(y[:, 0], target[0])
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
    scale = np.array([spread(y[:, k], target[k]) for k in range(2)])
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


def _answer(runs: _Runs, target: Array, u: Array, finer: tuple[PointRunner, SweepPoint] | None) -> Answer:
    """The values at a point, with their errors."""
    x, y = runs.values(u), runs(u)[0]
    off = np.abs(y - target)
    if finer is not None:
        off = off + 2.0 * np.abs(runs.finer(u, *finer) - y)
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
