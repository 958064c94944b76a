"""The reference of a study: a solution by one family of methods, checked by a solution of another family.

Methods of high order at a tight tolerance are preferred. If there are too few of them, solutions of methods of order 2
at steps h, h/2, h/4 and h/8 are extrapolated to h = 0, with the error as a series c_2 h^2 + c_3 h^3 + ...
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from os import PathLike
from pathlib import Path
from time import perf_counter

import numpy as np

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.integrators import available
from mbdsl.integrators.event_list import EventGroup
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import ENERGIES
from mbdsl.messages import duration, few, together
from mbdsl.simulation import result_units
from mbdsl.simulation.diagnostics.fixed_steps import unseen_peak
from mbdsl.simulation.event_sequences import apart
from mbdsl.simulation.stored_events import of_meta
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import POINTS, Case, Setting, own_step
from mbdsl.studies.error_measures import NEAR, ComparedSolution, Error, ErrorQuantity, error, matching, reactions
from mbdsl.studies.families import EXTRAPOLATED, family, precise
from mbdsl.studies.ladder import difference
from mbdsl.studies.runner import Runner
from mbdsl.studies.store import OUT_OF_TIME, Computed

TIGHT = (1e-12, 1e-10, 1e-8)  #: tolerances of a reference; the first that succeeds is used
POWERS = (2, 3, 4)  #: powers of h that the extrapolation removes
GOOD = 1e-9  #: scaled difference of two references above which further ones are computed
FINER = 3  #: how often steps are divided by four
FEWEST = 20  #: largest number of output points used of a file


@dataclass
class ReferenceSolution:
    """A ``solution`` and its method ``how``, with the solution ``check`` by ``checked_by``; None without a check."""

    solution: ComparedSolution
    how: str
    check: ComparedSolution | None = None
    checked_by: str = ""
    _floors: dict[str, Error] = field(default_factory=dict)

    @classmethod
    def none(cls) -> ReferenceSolution:
        """No reference, for studies that need none."""
        return cls(FileSignals(np.empty(0), {}), "none")

    def floor(self, quantity: ErrorQuantity) -> Error:
        """The resolution of the reference: smaller errors cannot be determined."""
        if quantity.itself or self.check is None:
            return Error(0.0, 0.0, 0.0, 0.0)
        if quantity.key not in self._floors:
            self._floors[quantity.key] = error(quantity, self.check, self.solution)
        return self._floors[quantity.key]

    def digits(self, quantity: ErrorQuantity) -> float | None:
        """Number of trusted decimal digits, relative to the scale of the quantity; None without a check."""
        if self.check is None or quantity.itself:
            return None
        return max(0.0, float(-np.log10(max(self.floor(quantity).scaled, 1e-17))))

    def __str__(self) -> str:
        return self.how + (f", checked by {self.checked_by}" if self.checked_by else ", unchecked")


@dataclass
class FileSignals:
    """Signals of a file, at those of its times that are output times of the study, and its events."""

    t: Array
    columns: dict[str, Array]
    find_events: Callable[[], Sequence[EventGroup]] = list

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]


def from_file(path: str | PathLike, runner: Runner, signals: Sequence[str] = ()) -> ReferenceSolution:
    """The signals of a result file as reference; ``signals`` are patterns of requested signals.

    Raises
    ------
    UsageError
        If the file cannot be read, ends before the stop time of the study, lacks the requested signals or all signals
        of the study, or has nan values in them.
    """
    columns, meta = result_units.read(path)
    file, of, like = Path(path).name, runner.setting, runner.blank()
    limits = [] if meta.get("complete", True) else ["incomplete"]
    t, times = _times(file, columns, of), of.times
    rows = matching(t, times)
    there = np.abs(t[rows] - times) <= 1e-6 * of.interval
    if not there[-1]:
        before = t[np.searchsorted(t, of.stop) - 1]
        raise UsageError(
            f"`{file}` has no values at the stop time, {of.stop:g} s",
            hint=f"a reference has the interval {of.interval:g} s, or a part of it, or the stop time alone; "
            f"its last time before: --stop {before:.9g}",
        )
    if not there[1:].all():
        limits.append(f"at {there[1:].sum()} of {of.points} times")
    kept = {name: np.asarray(x)[rows[there]] for name, x in columns.items() if np.shape(x) == t.shape}
    moving = [name for name in like.motion_names if name in kept]
    if len(moving) < len(like.motion_names):
        limits.append(f"{len(moving)} of {len(like.motion_names)} positions and velocities")
    asked = [name for name in like.select(signals) if name != "time"] if signals else []
    _check_asked(file, kept, like, signals)
    if missing := [name for name in asked if name not in kept]:
        limits.append(f"without {few(missing)}")
    energies = [name for name in ENERGIES if name in kept]
    others = [name for name in dict.fromkeys((*reactions(like), *asked)) if name in kept]
    if not (moving or energies or others):
        raise UsageError(
            f"`{file}` has no signal of {of.scene.name}: it has {few(kept)}",
            hint="a reference is a result file of the same model",
        )
    # a signal that is undetermined in some poses, as reactions may be, is not compared there
    gaps = [name for name in others if not np.isfinite(kept[name]).all()]
    wrong = [name for name in (*moving, *energies) if not np.isfinite(kept[name]).all()]
    wrong += [name for name in gaps if not np.isfinite(kept[name]).any()]
    if wrong:
        raise UsageError(
            f"`{file}` has no numbers (nan) in {few(wrong)}", hint="remove these columns, or use another file"
        )
    if gaps:
        limits.append(f"at some times without {few(gaps)}")
    how = f"`{file}`" + (f" ({', '.join(limits)})" if limits else "")
    return ReferenceSolution(FileSignals(times[there], kept, partial(of_meta, meta)), how)


def _times(file: str, columns: Mapping[str, Array], of: Setting) -> Array:
    """The times of a file (N,) [s], checked."""
    t = np.asarray(columns.get("time", ()), float)
    if t.ndim != 1 or not len(t):
        raise UsageError(f"`{file}` has no rows", hint="a reference is a result file with the stop time, or many times")
    if not (np.isfinite(t).all() and (np.diff(t) >= 0.0).all()):
        raise UsageError(f"`{file}` is not a result file: its times are not ascending")
    if t[-1] < of.stop - 1e-6 * of.interval:
        text = f"`{file}` ends at {t[-1]:.9g} s, the study at {of.stop:.9g} s"
        hint = f"compare up to there (--stop {t[-1]:.9g}), or use a longer reference"
        raise UsageError(text, hint=hint if t[-1] > of.start else "use a longer reference")
    return t


def _check_asked(file: str, kept: Mapping[str, Array], like: Trajectory, signals: Sequence[str]) -> None:
    for pattern in signals:
        if not any(name in kept for name in like.select([pattern])):
            raise UsageError(f"`{file}` has no signal `{pattern}`", hint=f"it has {few(kept)}")


def file_points(path: str | PathLike, of: Setting) -> int:
    """Number of output points of a study whose times are in the file, as far as these are evenly spaced.

    It is at most twice the usual number, unless the number in the file has no suitable divisor.

    Raises
    ------
    UsageError
        If the file cannot be read.
    """
    t = np.asarray(result_units.read(path)[0].get("time", ()), float)
    inside = t[(t > of.start + 1e-9 * of.span) & (t <= of.stop + 1e-9 * of.span)]
    count, spacing = len(inside), np.diff(inside)
    even = count > 1 and np.allclose(spacing, spacing[0], rtol=1e-6) and abs(inside[-1] - of.stop) < spacing[0] / 2
    if not even:
        return POINTS
    divisors = [n for n in range(min(FEWEST, count), count + 1) if count % n == 0]
    return max((n for n in divisors if n <= 2 * POINTS), default=divisors[0])


def automatic(runner: Runner, studied: Sequence[str], finest: float | None) -> ReferenceSolution:
    """A reference of a family that is not studied if there is one, checked by a second family.

    ``finest`` is the shortest step of the study [s], if it has any.

    Raises
    ------
    IntegrationError
        If no reference can be computed.
    """
    own = {family(name) for name in studied}
    high = sorted(precise(runner.setting.scene.spatial), key=lambda name: family(name) in own)
    found, problems = _candidates(runner, high)
    best = _closest(found)
    h = 2.0 * finest if finest else own_step(runner.setting) / 4.0
    h = h if best is not None and best[0] < GOOD else _affordable(runner, h)
    low = [name for name in EXTRAPOLATED if name in available() and family(name) not in {family(x[0]) for x in found}]
    for _ in range(FINER):
        if (best is not None and best[0] < GOOD) or not low:
            break
        begun = perf_counter()
        more, why = _candidates(runner, low, h)
        problems += why
        better = _closest([*found, *more])
        if better is not None and (best is None or better[0] < best[0]):
            best = better
        if 5.0 * (perf_counter() - begun) > runner.left / 4.0:
            break
        h /= 4.0
    if best is None:
        late = any(why == OUT_OF_TIME for _, why in problems)
        raise IntegrationError(
            f"no reference solution was found: {together(problems) or 'there are too few methods'}",
            hint="give it more time (--budget), or a reference: --reference FILE"
            if late
            else "give one: --reference FILE",
        )
    _, (_, how, solution), (_, other, check) = best
    return ReferenceSolution(solution, how, check, other)


Found = tuple[str, str, Trajectory]  #: method, its settings, and its solution


def _candidates(
    runner: Runner, names: Sequence[str], longest: float | None = None
) -> tuple[list[Found], list[tuple[str, str]]]:
    """Solutions by at most three families, and why others failed; extrapolated from ``longest`` [s] if it is given."""
    found: list[Found] = []
    problems = []
    for name in names:
        if family(name) in {family(other) for other, _, _ in found}:
            continue
        how, run = _precise(runner, name) if longest is None else _extrapolated(runner, name, longest)
        if run.problem:
            problems.append((name, run.problem))
            continue
        found.append((name, how, runner.trajectory(run)))
        if len(found) == 3 or ((best := _closest(found)) is not None and best[0] < GOOD):
            break
    return found, problems


def _closest(found: Sequence[Found]) -> tuple[float, Found, Found] | None:
    """The two solutions that differ least, and their difference."""
    pairs = [(difference(two[2], one[2]), one, two) for one, two in combinations(found, 2)]
    return min(pairs, key=lambda pair: pair[0], default=None)


def _affordable(runner: Runner, h: float) -> float:
    """The longest step [s] from which to extrapolate: ``h``, or longer, to take at most a third of the budget."""
    case = Case(EXTRAPOLATED[0], step=4.0 * own_step(runner.setting))
    if each := runner.step_time(case, "how long a step takes"):
        runs = len(EXTRAPOLATED) * sum(2**k for k in range(len(POWERS) + 1))
        while runs * each * runner.setting.span / h > runner.left / 3.0 and h < runner.setting.interval:
            h *= 2.0
    return h


def _precise(runner: Runner, name: str) -> tuple[str, Computed]:
    """A solution by a method of high order, at the tightest tolerance that succeeds."""
    for tol in TIGHT:
        case = Case(name, tol=tol)
        run = runner.compute([case], f"reference by {case}", limit=runner.left / 12.0)[case]
        if run.done:
            return f"{name}, tol = {tol:g}", run
        if run.late:
            break
    return name, run


def _extrapolated(runner: Runner, name: str, longest: float) -> tuple[str, Computed]:
    """A solution by a method of order 2 at short steps, extrapolated to zero."""
    of = runner.setting
    each = max(1, round(of.interval / longest))  # steps in an output interval
    steps = [of.interval / (each * 2**k) for k in range(len(POWERS) + 1)]
    cases = [Case(name, step=h) for h in steps]
    runs = runner.compute(cases, f"reference by {name}", limit=runner.left / 3.0)
    missing = next((run for run in runs.values() if run.problem), None)
    how = f"{name} extrapolated from {duration(steps[0])} to {duration(steps[-1])}"
    if missing is not None:
        return how, missing
    if problem := unseen_peak(runs[cases[-1]].stats):  # all of them may have missed it
        return how, Computed(cases[-1], problem=problem)
    weights, last = extrapolation(steps), runs[cases[-1]]

    def limit(found: Sequence[Array]) -> Array:
        same = np.all([x == found[-1] for x in found], axis=0)  # as modes of contacts are
        return np.where(same, found[-1], sum(w * x for w, x in zip(weights, found, strict=True)))

    q, v, lam = (limit([getattr(runs[case], x) for case in cases]) for x in ("q", "v", "lam"))
    numbers = {name: limit([runs[case].numbers[name] for case in cases]) for name in last.numbers}
    events = of_meta(last.stats)
    for case in cases[:-1] if events else ():  # runs behind and before a jump have no common value
        jumps = apart(last.t, of_meta(runs[case].stats), events, NEAR * of.span) > 0.0
        for x, own in ((q, last.q), (v, last.v), (lam, last.lam), *((numbers[n], last.numbers[n]) for n in numbers)):
            x[jumps] = own[jumps]
    return how, Computed(last.case, last.t, q, v, lam, last.stats, numbers=numbers)


def extrapolation(steps: Sequence[float]) -> Array:
    """Weights of solutions at ``steps`` in the extrapolated one, free of errors of orders ``POWERS``; the sum is 1."""
    h = np.asarray(steps) / steps[0]
    powers = POWERS[: len(h) - 1]
    A = np.array([np.ones(len(h)), *(h**p for p in powers)])
    return np.linalg.solve(A, np.eye(len(h))[0])
