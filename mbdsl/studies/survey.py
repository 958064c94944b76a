"""Methods at steps and tolerances, with their errors: the common part of all studies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.integrators import available
from mbdsl.lang.given_values import seconds, values
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.cases import (
    POINTS,
    TOLS,
    Case,
    Setting,
    assemble,
    cases,
    chosen,
    common_points,
    longer_steps,
    own_step,
    reaches,
    setting,
    step_ladder,
    taken,
)
from mbdsl.studies.error_measures import Error, ErrorQuantity, error, quantities
from mbdsl.studies.reference_solution import FileSignals, ReferenceSolution, automatic, file_points, from_file
from mbdsl.studies.runner import Runner, StudyProgress
from mbdsl.studies.slopes import Fit, fit
from mbdsl.studies.store import Computed, Store

BUDGET = 120.0  #: seconds
CONSERVED = 1e-9  #: largest change of a conserved energy, relative to the energy exchanged between its kinds
TIMING = 0.25  #: part of the remaining budget that is kept for timing runs
TWICE = 0.25  #: part of the remaining budget that is kept for second runs, at the ends of steps
#: number of steps above which not all are stored: the interpolation error of such short steps is negligible
MANY = 100_000
COUNTS = ("steps", "rejected", "iterations", "matrix_evaluations", "factorisations")  #: of a run, in its record


@dataclass
class Asked:
    """The options of a study.

    Parameters
    ----------
    methods : sequence of str, optional
        Names of integration methods. Default: all.
    steps : sequence of float or str, optional [s]
        Fixed step sizes, as numbers or as texts such as "1 ms". Default: a ladder around the model's own step.
    tols : sequence of float or str, optional
        Tolerances of runs with error-controlled steps. Default: a ladder.
    signals : sequence of str, optional
        Patterns of signals to measure, in addition to positions, velocities, reactions, energy and constraints.
    reference : str or path, optional
        "auto" to compute the reference solution, or a result file.
    stop : float or str, optional [s]
        Stop time. Default: the model's.
    parameters, without : optional
        As for ``mbdsl.simulate``.
    repeats : int, optional
        Number of timed runs of each case, in alternation; their median is reported.
    budget : float or str, optional [s]
        Time limit of the study, compilation included. Runs beyond it are ended or skipped, and reported as such.
    workers : int, optional
        Number of processes for runs that are not timed. Default: the number of cores.
    store : path, optional
        Folder of stored runs. Default: a subfolder of mbdsl's cache folder.
    fresh : bool, optional
        Whether to ignore stored runs.
    tell : callable, optional
        Called with the progress of the study.
    announce : callable, optional
        Called with a text before a phase that takes long.
    """

    methods: Sequence[str] | None = None
    steps: Sequence[float] | None = None
    tols: Sequence[float] | None = None
    signals: Sequence[str] = ()
    reference: str | PathLike = "auto"
    stop: float | None = None
    parameters: Mapping[str, str | float] | None = None
    without: Sequence[str] = ()
    repeats: int = 5
    budget: float = BUDGET
    workers: int | None = None
    store: str | PathLike | None = None
    fresh: bool = False
    tell: Callable[[StudyProgress], None] | None = None
    announce: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        self.stop, self.budget = seconds(self.stop, "stop"), seconds(self.budget, "budget")
        self.steps = values(self.steps, "s", "steps")
        self.tols = values(self.tols, "1", "tols")
        if self.repeats < 1:
            raise UsageError(f"repeats = {self.repeats}: a time needs one run or more")
        if not self.budget > 0.0:
            raise UsageError(f"a budget of {self.budget:g} s leaves no time")
        for name, sizes, example in (("steps", self.steps, "2ms,1ms"), ("tols", self.tols, "1e-4,1e-6")):
            if sizes is not None and not len(sizes):
                raise UsageError(f"{name} without any", hint=f"give some, e.g. --{name} {example}, or leave it out")


@dataclass
class SurveyRow:
    """A case with its run, its errors by quantity, and the times of its timed runs [s].

    ``trajectory`` is at the common times of all runs, ``own`` at the ends of steps; they are the same if the steps
    reach the common times.
    """

    case: Case
    run: Computed
    errors: dict[str, Error] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)
    trajectory: Trajectory | None = None
    own: Trajectory | None = None

    def record(self) -> dict:
        """A run: its settings, costs and errors."""
        case, stats = self.case, self.run.stats
        found = {
            "method": case.method,
            **{f"option {name}": value for name, value in case.options},
            "step": case.step,
            "tol": case.tol,
            "outcome": self.run.problem or "done",
            **{key: stats.get(key) for key in COUNTS},
        }
        if self.seconds:
            found |= {
                "rounds": " ".join(f"{x:.6g}" for x in self.seconds),
                "seconds": float(np.median(self.seconds)),
                "seconds least": min(self.seconds),
                "seconds most": max(self.seconds),
                "timed runs": len(self.seconds),
            }
        for key, e in self.errors.items():
            found |= {
                key: e.largest,
                f"{key} scaled": e.scaled,
                f"{key} at end": e.end,
                f"{key} at end scaled": e.scaled_end,
            }
        return found


@dataclass
class Survey:
    """Rows by method, coarse to fine, with the reference and the quantities of their errors."""

    setting: Setting
    asked: Asked
    runner: Runner
    rows: list[SurveyRow]
    refused: list[tuple[str, str]]  #: methods without a case, and the reasons
    reference: ReferenceSolution
    quantities: list[ErrorQuantity]

    @property
    def scene(self) -> Scene:
        return self.setting.scene

    def series(self) -> dict[str, list[SurveyRow]]:
        """Name of a series -> its rows, coarse to fine."""
        found: dict[str, list[SurveyRow]] = {}
        for row in self.rows:
            found.setdefault(row.case.series, []).append(row)
        return found

    def fitted(self, rows: Sequence[SurveyRow], value: Callable[[SurveyRow], float], floor: float = 0.0) -> Fit | None:
        """The slope of a value of complete runs over their sizes, as far as it is above the ``floor``."""
        done = [row for row in rows if row.run.done]
        return fit([row.case.size for row in done], [value(row) for row in done], floor)

    def quantity(self, key: str) -> ErrorQuantity | None:
        return next((q for q in self.quantities if q.key == key), None)

    @property
    def conserved(self) -> bool:
        """Whether the energy of the reference is constant."""
        q = self.quantity("energy")
        if q is None or len(self.reference.solution.t) < 3:
            return False
        E = self.reference.solution["energy.total"]
        return bool(np.ptp(E) <= max(CONSERVED / q.weights[0], 10.0 * self.reference.floor(q).largest))


def begin(
    model: Scene | str | PathLike,
    asked: Asked,
    both: bool = False,
    few: tuple[Sequence[float], Sequence[float]] | None = None,
) -> tuple[Runner, list[Case], list]:
    """A runner, the cases to run, and methods without a case.

    If neither steps nor tolerances are given, ``both`` selects both kinds for methods that support them, and ``few``
    (factors of the model's step, and tolerances) replaces the ladders. Steps are those actually taken, each once.

    Raises
    ------
    UsageError
        If a step is longer than the run, or no method supports the given steps and tolerances.
    """
    of = setting(model, asked.stop, asked.parameters, asked.without)
    names = chosen(asked.methods, of.scene)
    SignalNames(of.scene).select(asked.signals)
    of = replace(of, points=_points(of, asked))
    runner = Runner(
        of,
        Store(asked.store, asked.fresh),
        workers=asked.workers,
        budget=asked.budget,
        tell=asked.tell,
        announce=asked.announce,
    )
    runner.compiling = max(runner.compiling, assemble(of, asked.announce))
    if asked.steps is not None or asked.tols is not None:
        both = asked.steps is not None and asked.tols is not None
        steps = None if asked.steps is None else _steps(of, asked.steps)
        found, refused = cases(names, steps, None if asked.tols is None else list(dict.fromkeys(asked.tols)), both)
        if not found:
            reasons = "; ".join(f"{name}: {why}" for name, why in refused)
            other = "tolerances (--tols)" if asked.tols is None else "steps (--steps)"
            raise UsageError(f"nothing to run: {reasons}", hint=f"give {other}, or other methods")
        return runner, found, refused
    if few is not None:
        parts = few[0]
        each = max(1, round(of.interval / (parts[0] * own_step(of))))  # all steps reach the output times
        return runner, *cases(names, [of.interval / each * part / parts[0] for part in parts], few[1])
    steps = step_ladder(of)
    fixed = [name for name in names if "fixed" in available()[name].steps]
    if fixed:
        steps = steps[: _affordable(runner, fixed, steps)]
    return runner, *cases(names, steps, TOLS, both, longer_steps(of, steps))


def _steps(of: Setting, asked: Sequence[float]) -> list[float]:
    """The steps actually taken, which may coincide for several requested ones."""
    for h in asked:
        if h > of.span * (1.0 + 1e-9):
            raise UsageError(
                f"a step of {h:g} s is longer than the studied time, {of.span:g} s",
                hint="give shorter steps, or a later stop time",
            )
    return list(dict.fromkeys(taken(of.span, h) if h > 0.0 else h for h in asked))


def survey(model: Scene | str | PathLike, asked: Asked, both: bool = False, timed: bool = False) -> Survey:
    """Run every case and measure its errors; ``timed`` keeps a part of the budget for timing.

    Raises
    ------
    UsageError, ModelError
        If the model or the arguments are invalid.
    IntegrationError
        If there is no reference.
    KeyboardInterrupt
        If it is interrupted; completed runs are stored.
    """
    return measure(prepare(model, asked, both, timed=timed))


def prepare(
    model: Scene | str | PathLike,
    asked: Asked,
    both: bool = False,
    few: tuple[Sequence[float], Sequence[float]] | None = None,
    timed: bool = False,
) -> Survey:
    """The survey before errors are measured."""
    runner, every, refused = begin(model, asked, both, few)
    of = runner.setting
    if asked.reference == "auto":
        finest = min((c.step for c in every if c.step is not None), default=None)
        reference = automatic(runner, [c.method for c in every], finest)
    else:
        reference = from_file(asked.reference, runner, asked.signals)
    with runner.reserving(TIMING * max(0.0, runner.left) if timed else 0.0):
        rows = rows_of(runner, every)
    return Survey(of, asked, runner, rows, refused, reference, [])


def rows_of(runner: Runner, every: Sequence[Case]) -> list[SurveyRow]:
    """Runs of all cases, at common times and at the ends of their steps.

    If steps do not reach the common times, output there is interpolated, and its constraint residuals are not those of
    the method. Such cases are run again with other output. Without time for this, or with very short steps, ``own`` is
    the interpolated run.
    """
    of, runs, others = runner.setting, {}, {}
    between = [case for case in every if not reaches(of, case)]
    ends: dict[Case, Case] = {}
    for _ in range(2):  # the second time, cases that did not fit into their part of the budget
        with runner.reserving(max(0.0, TWICE * runner.left) if between else 0.0):
            runs |= runner.compute([case for case in every if case not in runs or runs[case].late])
        ends = {
            case: replace(case, ends=True)
            for case in between
            if runs[case].done and (case.tol is None or runs[case].stats["steps"] <= MANY)
        }
        missing = [case for case in ends.values() if case not in others or others[case].late]
        others |= runner.compute(missing, "the same at the ends of steps")
        if not any(run.late for run in runs.values()):
            break
    rows = []
    for case in every:
        row = SurveyRow(case, runs[case])
        if row.run.done:
            row.trajectory = row.own = runner.trajectory(row.run)
            if case in ends and others[ends[case]].done:
                row.own = runner.trajectory(others[ends[case]])
        rows.append(row)
    return rows


def measure(found: Survey) -> Survey:
    """Errors of all complete runs."""
    like = found.reference.solution
    names = like if isinstance(like, Trajectory) else found.runner.blank()
    found.quantities = quantities(names, like, found.asked.signals)
    for row in found.rows:
        row.errors = {q.key: _error(found, q, row) for q in found.quantities if row.own is not None}
    return found


def _error(found: Survey, q: ErrorQuantity, row: SurveyRow) -> Error:
    """At the ends of steps if no reference is necessary, else at common times."""
    assert row.trajectory is not None and row.own is not None
    like = found.reference.solution
    if q.key == "energy" and found.conserved:
        E = like["energy.total"]
        return error(q, row.own, FileSignals(row.own.t, {"energy.total": np.full(len(row.own.t), E[0])}))
    return error(q, row.own if q.itself else row.trajectory, like)


def _points(of: Setting, asked: Asked) -> int:
    """Number of output points that the steps reach, and of a reference file."""
    if asked.reference != "auto":
        return file_points(asked.reference, of)
    return common_points(of.span, [h for h in asked.steps if h > 0.0]) if asked.steps else POINTS


def _affordable(runner: Runner, names: Sequence[str], steps: Sequence[float], least: int = 4) -> int:
    """Number of steps of a ladder that fit into half of the budget, with a reference, from the time of the coarsest."""
    each, span = runner.step_time(Case(names[0], step=steps[0])), runner.setting.span
    if each is None:
        return len(steps)
    for count in range(len(steps), least, -1):
        finest = span / steps[count - 1]
        if each * finest * (2.0 * len(names) + 15.0) < runner.budget / 2:
            return count
    return min(least, len(steps))


def error_in(key: str, which: str) -> Callable[[SurveyRow], float]:
    """The error of a row in a quantity: a field of :class:`mbdsl.studies.error_measures.Error`."""
    return lambda row: getattr(row.errors[key], which)


def finite(values: Sequence[float]) -> list[float]:
    """With nan for values that are not points on a logarithmic axis."""
    return [x if math.isfinite(x) and x > 0.0 else math.nan for x in values]
