"""The plan of a run: method, step or tolerance, times and options, completed by the model's experiment and defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.errors import UsageError
from mbdsl.integrators import declared, modules
from mbdsl.integrators.loop.compiled_loop import controls_locally
from mbdsl.integrators.options import check_options
from mbdsl.integrators.output_times import OutputTimes
from mbdsl.integrators.run import MOST_OUTPUT
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Experiment, Scene
from mbdsl.numerics.tolerance import misfit, rounding
from mbdsl.simulation.run_options import UNASKED, RunOptions

DEFAULT_METHOD = "hht-si2"
NO_STOP = "give one, e.g. --stop 2s, or write `annotation(experiment(StopTime = 2 s));` in the model"
MOST_ROWS = 1e10  #: of a streamed run
DEFAULT_STEP = 1e-3  #: [s] of methods with fixed steps only, and of Simulation
DEFAULT_TOL = 1e-6  #: default tolerance of methods that control their steps by default
DEFAULT_ERROR = 1e-4  #: default tolerance of the others, if neither a step nor a tolerance is given


@dataclass(frozen=True)
class Plan:
    """The settings of a run: method, step, options, times, and whether the scene is reduced."""

    method: str
    h: float
    start: float
    stop: float
    times: Array  #: output times after the start
    options: Mapping[str, float | None]
    general: bool = False  #: no reduction
    tol: float | None = None  #: tolerance of controlled steps; ``h`` is then the whole duration
    every: bool = False  #: with a tolerance: every step is output, and ``times`` is empty
    longest: float = np.inf  #: with a tolerance: the longest step, which is at most a fiftieth of the run
    asked: bool = True  #: whether the caller or the model gave the tolerance; else it is the default
    shown: NDArray[np.bool_] | None = None  #: which of ``times`` were requested; None: all
    streamed: bool = False  #: rows are taken from the run while it goes on; only a window of them is in memory
    open: bool = False  #: whether the method is only the default, and the runs may choose another one
    single: bool = False  #: steps are taken one by one, and no stop time is known
    rows: OutputTimes | None = None  #: with ``streamed``: the output times, unless every step is output

    @property
    def count(self) -> int:
        """The number of output times after the start; 0 if every step is output."""
        return len(self.times) if self.rows is None else self.rows.count


def plan(scene: Scene, asked: RunOptions = UNASKED, streamed: bool = False) -> Plan:
    """The settings of a run: the options that are asked for, completed by those of the model and the defaults.

    ``streamed``: rows are taken from the run while it goes on.
    """
    said, step, interval = scene.experiment, asked.step, asked.interval
    named = asked.method or said.method
    method = named or DEFAULT_METHOD
    given = asked.tol is not None or said.tolerance is not None
    tol = _tolerance(method, step, asked.tol, said)
    start, end = _span(scene, asked)
    h = float(step if step is not None else said.step if said.step is not None else DEFAULT_STEP)
    interval = interval if interval is not None else said.interval
    own = asked.stop is None and said.stop is not None and said.step is not None  # both stop and step are the model's
    _check_step(h, start, end, at_most_the_run=step is not None or own)
    if tol is not None and end == start and controls_locally(method):
        tol = None  # a mechanism without motion has no errors
    if tol is not None and given and end > start:
        check_rounding(tol, max(abs(start), abs(end)) / (end - start), f"times from {start:.9g} to {end:.9g} s")
    h = _whole_fraction(h, start, end) if tol is None else end - start or h
    if interval is not None and not 0.0 <= interval < np.inf:
        raise UsageError(f"the output interval must not be negative, not {interval:g} s")
    every = tol is not None and interval == 0.0 and asked.times is None
    spacing, rows = np.inf if every else _spacing(interval, h, start, end), None
    if streamed and asked.times is None:
        due, rows = np.zeros(0), None if every else _streamed_times(start, end, spacing)
    else:
        due = _output_times(scene, start, end, spacing, asked.times)
    return Plan(
        method=method,
        h=h,
        start=start,
        stop=end,
        times=due,
        options=check_options(method, asked.options or {}, constrained(scene), asked.force),
        general=asked.general,
        tol=tol,
        every=every,
        asked=given,
        streamed=streamed,
        open=named is None and tol is not None and not asked.options,
        rows=rows,
    )


def _span(scene: Scene, asked: RunOptions) -> tuple[float, float]:
    """Start and stop time [s]."""
    said, times = scene.experiment, asked.times
    end = said.stop if asked.stop is None else asked.stop
    if asked.stop is None and times is not None and np.ndim(times) == 1 and len(np.asarray(times)):
        end = float(np.asarray(times)[-1])
    if end is None:
        raise UsageError(f"no stop time: {scene.name} has none in its experiment annotation", hint=NO_STOP)
    return float(said.start if asked.start is None else asked.start), float(end)


def check_space(method: str, scene: Scene) -> None:
    """Check that a method solves the equations of ``scene``, a model in space.

    Raises
    ------
    UsageError
        If the method serves the plane only.
    """
    if method not in modules() and not declared(method).spatial:
        raise UsageError(
            f"{method} is not available for models in space, and {scene.name} is one",
            hint="take another method, or declare `spatial=True` in its METHOD",
        )


def check_events(method: str, scene: Scene) -> None:
    """Check that a method knows the events of ``scene``: when-equations, rigid contacts, friction that sticks.

    Raises
    ------
    UsageError
        If it is a third-party integrator or kinematic, or does not know a kind of events.
    """
    compiled, knows = method in modules() and declared(method).order > 0, declared(method).knows
    for kind, (what, span) in scene.kinds_of_events.items():
        if not compiled and kind not in knows:
            hint = "take one of mbdsl's own methods: hht-si2, ..."
            raise UsageError(f"{method} does not know {what}", span, hint)


def _tolerance(method: str, step: float | None, tol: float | None, said: Experiment) -> float | None:
    """The tolerance of the run; None with a fixed step."""
    can = declared(method).steps
    if tol is not None and step is not None:
        raise UsageError("found a step and a tolerance (tol), expected one of them", hint="give only one of them")
    if tol is not None and "controlled" not in can:
        raise UsageError(f"{method} has no error-controlled steps", hint="give a fixed step, or another method")
    if tol is not None and (wrong := misfit(tol)) is not None:
        raise UsageError(wrong)
    if step is not None and "fixed" not in can:
        raise UsageError(f"{method} has no fixed steps", hint="give a tolerance (tol), or take another method")
    if tol is None and step is None and can[0] == "controlled":
        return DEFAULT_TOL if said.tolerance is None else said.tolerance
    if tol is None and step is None and said.step is None and "controlled" in can:
        return DEFAULT_ERROR if said.tolerance is None else said.tolerance
    return tol


def _check_step(h: float, start: float, end: float, at_most_the_run: bool) -> None:
    for name, value in (("start", start), ("stop", end), ("step", h)):
        if not np.isfinite(value):
            raise UsageError(f"{name} = {value} is not a finite number")
    if end < start:
        raise UsageError(f"the stop time {end:g} s is before the start time {start:g} s")
    if not h > 0.0:
        raise UsageError(f"the step must be above zero, not {h:g} s")
    if at_most_the_run and end > start and h > (end - start) * (1.0 + 1e-9):
        raise UsageError(
            f"a step of {h:g} s is longer than the run, from {start:g} to {end:g} s",
            hint="give a shorter step, or a tolerance instead",
        )
    if start + h == start or (end - start) / h > 1e12:
        raise UsageError(f"a step of {h:g} s is too small for times from {start:g} to {end:g} s")


def _whole_fraction(h: float, start: float, end: float) -> float:
    """The largest step up to h, but for rounding, of which the run is a multiple.

    All steps are shortened equally; a short last step would reduce the order of the reactions.
    """
    steps = max(1, round((end - start) / h))
    rounding = 4.0 * np.finfo(float).eps * max(abs(start), abs(end))
    if abs(end - start - steps * h) > 1e-9 * h + rounding and end > start:
        return float((end - start) / np.ceil((end - start) / h))
    return h


def _spacing(interval: float | None, h: float, start: float, end: float) -> float:
    return (end - start) / 500 if interval is None else interval or h


def _output_times(scene: Scene, start: float, end: float, spacing: float, times: ArrayLike | None) -> Array:
    """Output times (N,) after the start [s]: the given ones, else at this spacing; none if it is infinite."""
    given = _asked(times, start, end) if times is not None else None
    points = _points(start, end, spacing) if given is None else float(len(given))
    columns = width(scene)
    if not points * columns <= MOST_OUTPUT:
        raise UsageError(
            f"{points:.3g} output points of {columns} numbers do not fit in memory",
            hint=f"give an output interval of {(end - start) * columns / MOST_OUTPUT:.2g} s or more",
        )
    return OutputTimes(start, end, spacing, int(points)).part(0, int(points)) if given is None else given


def _streamed_times(start: float, end: float, spacing: float) -> OutputTimes:
    points = _points(start, end, spacing)
    if not points <= MOST_ROWS:
        least = (end - start) / MOST_ROWS
        raise UsageError(f"{points:.3g} output points are too many", hint=f"give an output interval of {least:.2g} s")
    return OutputTimes(start, end, spacing, int(points))


def _points(start: float, end: float, spacing: float) -> float:
    """The number of output times."""
    return float(np.ceil((end - start) / spacing - 1e-9)) if end > start and np.isfinite(spacing) else 0.0


def width(scene: Scene) -> int:
    """The number of coordinates, velocities and multipliers, which are the columns of the output of a run."""
    return sum(2 * len(c.coordinates) + c.kind.rows for c in scene.components.values())


def in_memory(plan: Plan, scene: Scene) -> Plan:
    """A plan that is not streamed, with all its output times.

    Raises
    ------
    UsageError
        If the output does not fit in memory.
    """
    if plan.rows is None:
        return replace(plan, streamed=False)
    due = _output_times(scene, plan.start, plan.stop, plan.rows.spacing, None)
    return replace(plan, streamed=False, rows=None, times=due)


def check_rounding(tol: float, magnitude: float, what: str) -> None:
    """Refuse a tolerance below the rounding errors of numbers that are ``magnitude`` times the error norm's unit."""
    least = rounding(magnitude)
    if tol < least:
        raise UsageError(
            f"a tolerance of {tol:g} is less than the rounding errors of {what}",
            hint=f"ask for {1.05 * least:.1e} or more",
        )


def _asked(times: ArrayLike, start: float, end: float) -> Array:
    """Given output times (N,) [s], checked."""
    found = np.array(times, float)
    if found.ndim != 1 or not len(found) or found[-1] != end or not (np.diff(found, prepend=start) > 0.0).all():
        raise UsageError(f"output times must ascend, after the start, {start:g} s, and up to the stop time, {end:g} s")
    return found


def constrained(scene: Scene) -> bool:
    """Whether there is a holonomic constraint."""
    return any(isinstance(c.kind, JointKind) and c.kind.rows for c in scene.components.values())
