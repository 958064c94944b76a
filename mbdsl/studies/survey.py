"""Methods at steps and tolerances, with their errors: what convergence, work-precision and the others begin with."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike

from mbdsl.errors import UsageError
from mbdsl.integrators import methods
from mbdsl.scene import Scene
from mbdsl.studies.cases import (
    POINTS,
    TOLS,
    Case,
    Setting,
    assemble,
    cases,
    chosen,
    common_points,
    own_step,
    setting,
    step_ladder,
)
from mbdsl.studies.errors import Error, Quantity, error, quantities
from mbdsl.studies.reference import Reference, automatic, file_points, from_file
from mbdsl.studies.runner import Runner, Told
from mbdsl.studies.store import Computed, Store
from mbdsl.trajectory import Trajectory

BUDGET = 120.0  #: seconds


@dataclass
class Asked:
    """What every study can be asked.

    Parameters
    ----------
    methods : sequence of str, optional
        Names; default all.
    steps, tols : sequences of float, optional
        Fixed steps [s], and tolerances of error-controlled ones; default: ladders around the model's own step.
    signals : sequence of str
        Patterns of signals to look at, beside positions, velocities, reactions, energy and constraints.
    reference : str or path
        "auto", or a result file.
    stop : float, optional [s]
    parameters, without
        As for :func:`mbdsl.simulate`.
    repeats : int
        Runs that are timed, alternately; medians are given.
    budget : float [s]
        What the whole may take; what does not fit in is not run, and said.
    workers : int, optional
        Processes for runs that are not timed; default as many as there are cores.
    store : path, optional
        Where runs are kept; default in the folder of compiled code. With ``fresh`` none is taken from there.
    tell, announce : callables, optional
        Told how far it is, and what takes long before it starts.
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
    tell: Callable[[Told], None] | None = None
    announce: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        if self.repeats < 1:
            raise UsageError(f"repeats = {self.repeats}: a time needs one run or more")
        if not self.budget > 0.0:
            raise UsageError(f"a budget of {self.budget:g} s leaves no time")


@dataclass
class Row:
    """A case, what came of it, its errors by quantity, and the seconds that runs of it took."""

    case: Case
    run: Computed
    errors: dict[str, Error] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)
    trajectory: Trajectory | None = None


@dataclass
class Survey:
    """Rows by method, coarse to fine, and what their errors are measured by."""

    setting: Setting
    asked: Asked
    runner: Runner
    rows: list[Row]
    refused: list[tuple[str, str]]  #: methods that none of the sizes fits, and why
    reference: Reference
    quantities: list[Quantity]

    @property
    def scene(self) -> Scene:
        return self.setting.scene

    def series(self) -> dict[str, list[Row]]:
        """Name of a series -> its rows, coarse to fine."""
        found: dict[str, list[Row]] = {}
        for row in self.rows:
            found.setdefault(row.case.series, []).append(row)
        return found

    def quantity(self, key: str) -> Quantity | None:
        return next((q for q in self.quantities if q.key == key), None)


def begin(
    model: Scene | str | PathLike,
    asked: Asked,
    both: bool = False,
    few: tuple[Sequence[float], Sequence[float]] | None = None,
) -> tuple[Runner, list[Case], list]:
    """A runner, the cases to run, and methods that can take none of them.

    Where neither steps nor tolerances are given: with ``both``, methods that can take both do; ``few`` are parts of the
    model's own step, and tolerances, in place of whole ladders.
    """
    names = chosen(asked.methods)
    of = setting(model, asked.stop, asked.parameters, asked.without)
    of = Setting(**{**vars(of), "points": _points(of, asked)})
    ladder = asked.steps is None and asked.tols is None
    assemble(of, asked.announce)
    runner = Runner(
        of,
        Store(asked.store, asked.fresh),
        workers=asked.workers,
        budget=asked.budget,
        tell=asked.tell,
        announce=asked.announce,
    )
    if not ladder:
        both = asked.steps is not None and asked.tols is not None
        return runner, *cases(names, asked.steps, asked.tols, both)
    if few is not None:
        each = max(1, round(of.interval / own_step(of)))
        return runner, *cases(names, [of.interval / each * part for part in few[0]], few[1])
    steps = step_ladder(of)
    fixed = [name for name in names if "fixed" in methods()[name].steps]
    if fixed:
        steps = steps[: _affordable(runner, fixed, steps)]
    return runner, *cases(names, steps, TOLS, both)


def survey(model: Scene | str | PathLike, asked: Asked, both: bool = False) -> Survey:
    """Run every case, and measure its errors.

    Raises
    ------
    UsageError, ModelError
        If model or arguments make no sense.
    IntegrationError
        If there is no reference.
    KeyboardInterrupt
        What has been computed is kept.
    """
    return measure(prepare(model, asked, both))


def prepare(
    model: Scene | str | PathLike,
    asked: Asked,
    both: bool = False,
    few: tuple[Sequence[float], Sequence[float]] | None = None,
) -> Survey:
    """The same before errors are measured."""
    runner, every, refused = begin(model, asked, both, few)
    of = runner.setting
    if asked.reference == "auto":
        finest = min((c.step for c in every if c.step is not None), default=None)
        reference = automatic(runner, [c.method for c in every], finest)
    else:
        reference = from_file(asked.reference, runner, asked.signals)
    runs = runner.compute(every)
    rows = [Row(case, runs[case]) for case in every]
    return Survey(of, asked, runner, rows, refused, reference, [])


def measure(found: Survey) -> Survey:
    """Errors of all rows that came to their end."""
    like = found.reference.solution
    names = like if isinstance(like, Trajectory) else found.runner.blank()
    found.quantities = quantities(names, like, found.asked.signals)
    for row in found.rows:
        if row.run.done:
            row.trajectory = found.runner.trajectory(row.run)
            row.errors = {q.key: error(q, row.trajectory, like) for q in found.quantities}
    return found


def _points(of: Setting, asked: Asked) -> int:
    """Output points that the steps reach, and those of a reference that is a file."""
    if asked.reference != "auto":
        return file_points(asked.reference, of)
    return common_points(of.span, list(asked.steps)) if asked.steps else POINTS


def _affordable(runner: Runner, names: Sequence[str], steps: Sequence[float], least: int = 4) -> int:
    """How many steps of a ladder fit into half of the budget, with a reference, after what the coarsest takes."""
    first = Case(names[0], step=steps[0])
    run = runner.compute([first])[first]
    if run.problem or not run.stats.get("steps"):
        return len(steps)
    each = run.stats["seconds"]["integrate"] / run.stats["steps"]
    span = runner.setting.span
    for count in range(len(steps), least, -1):
        finest = span / steps[count - 1]
        if each * finest * (2.0 * len(names) + 15.0) < runner.budget / 2:
            return count
    return min(least, len(steps))


def finite(values: Sequence[float]) -> list[float]:
    """With nan for what is no point of a logarithmic axis."""
    return [x if math.isfinite(x) and x > 0.0 else math.nan for x in values]
