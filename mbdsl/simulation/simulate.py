"""From a model to its Trajectory: graph, System, consistent initial state, integration, output."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbdsl.errors import Interrupted, UsageError
from mbdsl.initial.redundancy import repeated
from mbdsl.integrators import declared
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.loop.compiled_loop import controls_locally
from mbdsl.integrators.options import check_options
from mbdsl.integrators.run import MOST_OUTPUT
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.tolerance import misfit, rounding
from mbdsl.simulation.checkpoint import Checkpoint, Keeper, of_run
from mbdsl.simulation.failure_messages import check_bending, check_left_out, failure, inaccurate
from mbdsl.simulation.fixed_step_warnings import doubts
from mbdsl.simulation.interrupts import deferred
from mbdsl.simulation.mechanism_run import Motion, Plan, constrained
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.tolerance_calibration import Found, calibrated
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage import cache_folder

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

SLICE = 64  #: number of steps before their time is measured
DEFAULT_METHOD = "hht-si2"
DEFAULT_STEP = 1e-3  #: [s] of methods with fixed steps only, and of Simulation
DEFAULT_TOL = 1e-6  #: default tolerance of methods that control their steps by default
DEFAULT_ERROR = 1e-4  #: default tolerance of the others, if neither a step nor a tolerance is given


def simulate(model: Scene | Builder | str | PathLike, **given: Any) -> Trajectory:
    """As :func:`simulated`, but an interrupted run raises an error.

    Raises
    ------
    Interrupted
        On Ctrl-C. It is a KeyboardInterrupt whose ``trajectory`` holds the results so far.
    """
    found = simulated(model, **given)
    if found.status == "interrupted":
        raise Interrupted(found)
    return found


@blame_model
def simulated(
    model: Scene | Builder | str | PathLike,
    *,
    method: str | None = None,
    step: float | None = None,
    tol: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    interval: float | None = None,
    times: ArrayLike | None = None,
    options: Mapping[str, float | None] | None = None,
    force: bool = False,
    general: bool = False,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    progress: Callable[[Progress], None] | None = None,
    announce: Callable[[str], None] | None = None,
    checkpoint: Checkpoint | str | PathLike | None = None,
    inspect: Callable[[Motion], None] | None = None,
) -> Trajectory:
    """As :func:`mbdsl.simulate` without an accuracy, but return the trajectory of a run interrupted between steps.

    ``inspect`` is called with the completed motion.

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step; the results are complete.
    """
    seconds = dict.fromkeys(("parse", "build", "compile", "initialise", "integrate", "write"), 0.0)
    clock = perf_counter()

    def lap(phase: str) -> None:
        nonlocal clock
        now = perf_counter()
        seconds[phase] += now - clock
        clock = now

    scene = as_scene(model, parameters, without)
    lap("parse")
    run = plan(scene, method, step, tol, start, stop, interval, options, force, general, times)
    if scene.experiment.tolerance is not None and run.tol is None and announce is not None:
        announce(f"the model's Tolerance is not used: steps have a fixed size, {run.h:g} s")
    motion = Motion(scene, run)
    lap("build")
    if announce is not None and not motion.is_compiled:
        announce(cache_folder.compiling())
    motion.prepare(lap)
    if run.tol is not None and run.asked:
        far = motion.distance
        _check_rounding(run.tol, far, f"coordinates that are {far:.2g} times the mechanism's size (or as many radians)")
    if motion.redundant and announce is not None:
        announce(
            f"redundant: {', '.join(motion.redundant)} follows from the other constraints and is left out; "
            "how the reactions share the load there is not determined"
        )
        for part in motion.parts:
            first = part.initial
            for line in repeated(part.system, first.t, first.q, first.v, first.redundant):
                announce(f"  {line}")
    keeper = None
    if checkpoint is not None:
        asked: dict[str, Any] = {"method": method, "step": step, "tol": tol, "start": start, "stop": stop}
        asked |= {"interval": interval, "options": dict(options or {})}
        asked |= {"times": None if times is None else np.asarray(times).tolist()}
        asked |= {"force": force, "general": general, "parameters": dict(parameters or {}), "without": list(without)}
        keeper = Keeper(of_run(checkpoint, model, asked), motion)
    motion.watch()
    lap("initialise")
    with deferred(1) as heard:
        if run.tol is None or not motion.parts or run.stop == run.start:
            status, found = _integrate(motion, progress, keeper, heard), Found()
        else:
            status, found = calibrated(motion, run.tol, lambda: _integrate(motion, progress, keeper, heard))
        lap("integrate")
        trajectory, states = _collect(motion, run.tol, found, status, seconds)
        if status not in (loop_state.DONE, loop_state.RUNNING):
            raise failure(motion, trajectory, status)
        check_left_out(motion, trajectory, states)
        check_bending(trajectory)
        trajectory.stats["warnings"] = doubts(motion, trajectory, states) if status == loop_state.DONE else []
        if run.tol is None and status == loop_state.DONE:
            motion.outgrown()  # errors are relative to the same size as in a run with a tolerance
        if inspect is not None:
            inspect(motion)
        if keeper is not None and keeper.problem:
            trajectory.stats["warnings"].append(f"the last checkpoint is missing: {keeper.problem}")
        if found.horizon is not None and status == loop_state.DONE:
            error = inaccurate(trajectory, found.reason)
            if run.asked:
                raise error
    if heard and status == loop_state.DONE:
        raise Interrupted(trajectory)
    return trajectory


def plan(
    scene: Scene,
    method: str | None = None,
    step: float | None = None,
    tol: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    interval: float | None = None,
    options: Mapping[str, float | None] | None = None,
    force: bool = False,
    general: bool = False,
    times: ArrayLike | None = None,
) -> Plan:
    """The settings of a run: the checked arguments, completed by those of the model and the defaults."""
    said = scene.experiment
    method = method or said.method or DEFAULT_METHOD
    can = declared(method).steps
    if tol is not None and step is not None:
        raise UsageError("found a step and a tolerance (tol), expected one of them", hint="give only one of them")
    if tol is not None and "controlled" not in can:
        raise UsageError(f"{method} has no error-controlled steps", hint="give a fixed step, or another method")
    asked = tol is not None or said.tolerance is not None
    if tol is not None and (wrong := misfit(tol)) is not None:
        raise UsageError(wrong)
    if step is not None and "fixed" not in can:
        raise UsageError(f"{method} has no fixed steps", hint="give a tolerance (tol), or take another method")
    if tol is None and step is None and can[0] == "controlled":
        tol = DEFAULT_TOL if said.tolerance is None else said.tolerance
    elif tol is None and step is None and said.step is None and "controlled" in can:
        tol = DEFAULT_ERROR if said.tolerance is None else said.tolerance
    for name, value in (("start", start), ("stop", stop), ("step", step), ("interval", interval)):
        if value is not None and not isinstance(value, (int, float, np.number)):
            raise UsageError(f"{name} is a number of seconds, not {value!r}")
    start = float(said.start if start is None else start)
    end = said.stop if stop is None else stop
    if end is None:
        raise UsageError(
            f"no stop time: {scene.name} has none in its experiment annotation", hint="give one, e.g. --stop 2s"
        )
    end = float(end)
    h = float(step if step is not None else said.step if said.step is not None else DEFAULT_STEP)
    interval = interval if interval is not None else said.interval
    for name, value in (("start", start), ("stop", end), ("step", h)):
        if not np.isfinite(value):
            raise UsageError(f"{name} = {value} is not a finite number")
    if end < start:
        raise UsageError(f"the stop time {end:g} s is before the start time {start:g} s")
    if not h > 0.0:
        raise UsageError(f"the step must be above zero, not {h:g} s")
    own = stop is None and said.stop is not None and said.step is not None  # both stop and step are the model's
    if (step is not None or own) and end > start and h > (end - start) * (1.0 + 1e-9):
        raise UsageError(
            f"a step of {h:g} s is longer than the run, from {start:g} to {end:g} s",
            hint="give a shorter step, or a tolerance (tol) instead",
        )
    if start + h == start or (end - start) / h > 1e12:
        raise UsageError(f"a step of {h:g} s is too small for times from {start:g} to {end:g} s")
    if tol is not None and end == start and controls_locally(method):
        tol = None  # a mechanism without motion has no errors
    if tol is not None and asked and end > start:
        _check_rounding(tol, max(abs(start), abs(end)) / (end - start), f"times from {start:.9g} to {end:.9g} s")
    if tol is not None:
        h = end - start or h
    steps = max(1, round((end - start) / h))
    rounding = 4.0 * np.finfo(float).eps * max(abs(start), abs(end))
    if abs(end - start - steps * h) > 1e-9 * h + rounding and end > start:
        # All steps are shortened equally to end at the stop time; a short last step would reduce the order of the
        # reactions.
        h = (end - start) / np.ceil((end - start) / h)
    if interval is not None and not 0.0 <= interval < np.inf:
        raise UsageError(f"the output interval must not be negative, not {interval:g} s")
    every = tol is not None and interval == 0.0 and times is None
    spacing = (end - start) / 500 if interval is None else interval or h
    points = np.ceil((end - start) / spacing - 1e-9) if end > start and not every else 0.0
    given = _asked(times, start, end) if times is not None else None
    points = points if given is None else len(given)
    columns = sum(2 * len(c.coordinates) + c.kind.rows for c in scene.components.values())
    if not points * columns <= MOST_OUTPUT:
        raise UsageError(
            f"{points:.3g} output points of {columns} numbers do not fit in memory",
            hint=f"give an output interval of {(end - start) * columns / MOST_OUTPUT:.2g} s or more",
        )
    count = int(points)
    due = start + spacing * np.arange(1.0, count + 1) if given is None else given
    if count:
        due[-1] = end
    chosen = check_options(method, options or {}, constrained(scene), force)
    return Plan(method, h, start, end, due, chosen, general, tol, every, asked=asked)


def _check_rounding(tol: float, magnitude: float, what: str) -> None:
    """Refuse a tolerance below the rounding errors of numbers that are ``magnitude`` times the error norm's unit."""
    least = rounding(magnitude)
    if tol < least:
        raise UsageError(
            f"a tolerance of {tol:g} is less than the rounding errors of {what}",
            hint=f"ask for {1.05 * least:.1e} or more",
        )


def _asked(times: ArrayLike, start: float, end: float) -> NDArray[np.float64]:
    """Given output times (N,) [s], checked."""
    found = np.array(times, float)
    if found.ndim != 1 or not len(found) or found[-1] != end or not (np.diff(found, prepend=start) > 0.0).all():
        raise UsageError(f"output times must ascend, after the start, {start:g} s, and up to the stop time, {end:g} s")
    return found


def _integrate(motion: Motion, progress, keeper: Keeper | None = None, before: Sequence[int] = ()) -> int:
    """Advance in slices of about a tenth of a second, between which progress is shown and interruptions are handled.

    ``before`` are signals received outside of the loop: they end it after a slice.
    """
    slice_, begun, plan = SLICE, perf_counter(), motion.plan
    if keeper is not None and (known := keeper.begin(motion)) is not None:
        return known
    try:
        with deferred() as heard:
            while not heard:
                began = perf_counter()
                status = motion.advance(slice_)
                now = perf_counter()
                if status != loop_state.RUNNING or motion.bent():
                    if keeper is not None and status == loop_state.DONE:
                        keeper.end(motion, status)
                    return status
                if keeper is not None:
                    keeper.pause(motion)
                if progress is not None:
                    iterations = motion.count("iterations")
                    spent = now - begun
                    progress(Progress(motion.time, plan.start, plan.stop, motion.h, motion.steps, iterations, spent))
                slice_ = int(min(1e9, max(1, slice_ * min(4.0, 0.1 / max(now - began, 1e-9)))))
                if before:
                    break
    except KeyboardInterrupt:  # from the progress callback
        pass
    if keeper is not None:
        keeper.write(motion)
    return loop_state.RUNNING


def _collect(motion: Motion, tol: float | None, found: Found, status: int, seconds: dict) -> tuple[Trajectory, list]:
    """The trajectory, and q and v of every part."""
    plan, system = motion.plan, motion.system
    t, q, v, lam, states = motion.output(status != loop_state.DONE)
    stats = {
        "method": plan.method,
        "h": plan.h if plan.tol is None else None,
        "tol": tol,
        "error": found.error,
        "horizon": found.horizon,
        "status": {loop_state.DONE: "done", loop_state.RUNNING: "interrupted"}.get(status, "failed"),
        "n": system.n,
        "m": system.m,
        "p": system.p,
        "solved": motion.sizes,
        "steps": motion.steps,
        "trial_steps": motion.trial_steps,
        "rejected": motion.count("rejected"),
        "events": motion.count("events"),
        "iterations": motion.count("iterations"),
        "evaluations": motion.count("evaluations"),
        "matrix_evaluations": motion.count("matrix_evaluations"),
        "factorisations": motion.count("factorisations"),
        "pivoting_from": motion.pivoting_from,
        "seconds": seconds,
        "redundant": motion.redundant,
    }
    for array in (t, q, v, lam):
        array.flags.writeable = False
    own = lam if motion.own_reactions else None
    return Trajectory(system, t, q, v, own, stats, motion.moved, motion.left_out), states
