"""From a model to its Trajectory: graph, System, consistent initial state, integration, output."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbdsl import cache_folder
from mbdsl.calibration import Found, calibrated
from mbdsl.checkpoint import Checkpoint, Keeper, of_run
from mbdsl.doubts import doubts
from mbdsl.errors import Interrupted, UsageError
from mbdsl.extremes import blame_extremes
from mbdsl.failures import check_bending, check_left_out, failure, inaccurate
from mbdsl.integrators import declared, state
from mbdsl.integrators.options import check_options
from mbdsl.integrators.run import MOST_OUTPUT
from mbdsl.integrators.step_loop import controls_locally
from mbdsl.interrupts import deferred
from mbdsl.motion import Motion, Plan, constrained
from mbdsl.scene import Scene
from mbdsl.system.dependence import repeated
from mbdsl.tolerance import misfit, rounding
from mbdsl.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.builder import Builder

SLICE = 64  #: steps before their time is first measured
DEFAULT_METHOD = "hht-si2"
DEFAULT_STEP = 1e-3  #: [s] of methods with fixed steps only, and of Simulation
DEFAULT_TOL = 1e-6  #: default tolerance of methods that control their steps by default
DEFAULT_ERROR = 1e-4  #: default tolerance of the others, if neither a step nor a tolerance is given


@dataclass(frozen=True)
class Progress:
    """How far an integration is; given to the callback some ten times a second."""

    t: float
    start: float
    stop: float
    h: float
    steps: int
    iterations: int
    seconds: float


def as_scene(
    model: Scene | Builder | str | PathLike, parameters: Mapping | None = None, without: Sequence[str] = ()
) -> Scene:
    """A Scene from whatever stands for a model: itself, a Builder, or the path of a ``.mbd`` file."""
    if (parameters or without) and not isinstance(model, (str, PathLike)):
        what = "parameters" if parameters else "effects to leave out"
        raise UsageError(f"only a model given by its path takes {what}", hint="give them to load or Builder")
    if isinstance(model, Scene):
        return model
    if isinstance(model, (str, PathLike)):
        from mbdsl.lang.load import load

        return load(cast("str | PathLike[str]", model), parameters or {}, without=without)
    if not hasattr(model, "scene"):
        raise UsageError(f"a model is a path, a Scene or a Builder, not {type(model).__name__}")
    return model.scene()


def simulate(
    model: Scene | Builder | str | PathLike,
    *,
    method: str | None = None,
    step: float | None = None,
    tol: float | None = None,
    accuracy: float | None = None,
    budget: float | None = None,
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
) -> Trajectory:
    """Integrate ``model`` and return its trajectory.

    Parameters
    ----------
    model : Scene, Builder or path
    method : str, optional
        Name of an integrator; default the model's, else "hht-si2".
    step : float, optional [s]
        Fixed step, not longer than the run; default the model's. Where it does not divide the time, all steps are a
        little shorter, so that the last ends at ``stop``. Methods that control their steps by default, such as
        "radau5", ignore the model's Step. The default of methods that have fixed steps only is 1 ms.
    tol : float, optional
        Instead of a step: the limit of the global error, with error-controlled steps. The error is the largest over all
        outputs and coordinates: positions relative to the mechanism's size, angles in radians, velocities relative to
        the largest one of the run (at least the mechanism's size, or a radian, per duration of the run). Default, if
        neither caller nor model gives a step: the model's Tolerance, else 1e-4; with "radau5" and backends, the model's
        Tolerance, else 1e-6, even if the model has a Step. Calibration runs with larger tolerances come first;
        ``stats["error"]`` is the error estimate from them, and ``stats["horizon"]`` the time until which the tolerance
        is kept (None: to the end).
    accuracy : float, optional
        In place of a step or tolerance: the largest error in positions, as part of the mechanism's size, and in
        velocities, as part of the largest. Method (where none is given) and step are found by several runs;
        ``stats["accuracy"]`` says what came of it (:mod:`mbdsl.studies.accuracy`).
    budget : float, optional [s]
        Time for the check of an accuracy by another method; default twenty times that of the runs before it, and at
        least 20 s.
    start, stop : float, optional [s]
        Default the model's.
    interval : float, optional [s]
        Output interval; default (stop - start)/500; 0 stores every step.
    times : (N,) array, optional [s]
        Instead, the times of output after the start, in order; the last is ``stop``.
    options : mapping, optional
        Parameters of the method, such as {"alpha": -0.1}.
    force : bool, optional
        Allow what is known to fail, such as the trapezoidal rule on constrained models.
    general : bool, optional
        Solve the equations as they are, with the code for every kind of element that there is and nothing merged, split
        or solved beforehand: what specialisation is compared with.
    without : sequence of str, optional
        Effects to leave out, of "friction", "damping", "flexibility", "gravity", for a model given by path.
    parameters : mapping, optional
        Overrides of the model's parameters, as numbers or texts with units ("120 N/mm"), for a model given by path.
    progress, announce : callables, optional
        Told how far it is, and what takes long before it starts.
    checkpoint : path or Checkpoint, optional
        File for checkpoints, written every minute and when the run is interrupted; :func:`mbdsl.resume` continues from
        it. It is kept when the run is done. Not available with an ``accuracy``, nor with backends.

    Raises
    ------
    ModelError, UsageError
        If model or arguments make no sense.
    InitialisationError
        If no consistent initial state is found.
    IntegrationError
        If the integration fails, or does not reach a tolerance that caller or model gives; its ``trajectory`` holds the
        results so far, or the complete results of the best run.
    Interrupted
        On Ctrl-C: a KeyboardInterrupt whose ``trajectory`` holds the results so far.
    """
    given = locals()
    found = simulated(**given)
    if found.status == "interrupted":
        raise Interrupted(found)
    return found


@blame_extremes
def simulated(
    model: Scene | Builder | str | PathLike,
    *,
    method: str | None = None,
    step: float | None = None,
    tol: float | None = None,
    accuracy: float | None = None,
    budget: float | None = None,
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
    """As :func:`simulate`, but a run that is interrupted between steps is a result: its status says so.

    ``inspect`` gets the motion, run to its end.

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step: the results are complete.
    """
    if accuracy is not None:
        from mbdsl.studies.accuracy import reach

        if step is not None or tol is not None:
            raise UsageError("an accuracy finds its own step or tolerance", hint="give one of them alone")
        if checkpoint is not None:
            raise UsageError("runs with an accuracy have no checkpoints", hint="give a tolerance (tol) instead")
        if times is not None:
            raise UsageError("an accuracy is found at even times", hint="give an interval")
        given = {"start": start, "stop": stop, "options": options, "force": force, "general": general}
        found = as_scene(model, parameters, without)
        told = {"progress": progress, "announce": announce}
        return reach(found, accuracy, method=method, interval=interval, budget=budget, **told, **given)  # type: ignore[arg-type]
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
        if status not in (state.DONE, state.RUNNING):
            raise failure(motion, trajectory, status)
        check_left_out(motion, trajectory, states)
        check_bending(trajectory)
        trajectory.stats["warnings"] = doubts(motion, trajectory, states) if status == state.DONE else []
        if run.tol is None and status == state.DONE:
            motion.outgrown()  # errors are relative to the same size as in a run with a tolerance
        if inspect is not None:
            inspect(motion)
        if keeper is not None and keeper.problem:
            trajectory.stats["warnings"].append(f"the last checkpoint is missing: {keeper.problem}")
        if found.horizon is not None and status == state.DONE:
            error = inaccurate(trajectory, found.reason)
            if run.asked:
                raise error
    if heard and status == state.DONE:
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
    """What was asked for, checked, with what the model says and the defaults in place of what was not."""
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
    own = stop is None and said.stop is not None and said.step is not None  # stop and step are both the model's
    if (step is not None or own) and end > start and h > (end - start) * (1.0 + 1e-9):
        raise UsageError(
            f"a step of {h:g} s is longer than the run, from {start:g} to {end:g} s",
            hint="give a shorter step, or a tolerance (tol) instead",
        )
    if start + h == start or (end - start) / h > 1e12:
        raise UsageError(f"a step of {h:g} s is too small for times from {start:g} to {end:g} s")
    if tol is not None and end == start and controls_locally(method):
        tol = None  # there is nothing to err in
    if tol is not None and asked and end > start:
        _check_rounding(tol, max(abs(start), abs(end)) / (end - start), f"times from {start:.9g} to {end:.9g} s")
    if tol is not None:
        h = end - start or h
    steps = max(1, round((end - start) / h))
    rounding = 4.0 * np.finfo(float).eps * max(abs(start), abs(end))
    if abs(end - start - steps * h) > 1e-9 * h + rounding and end > start:
        # Steps of one size, a little shorter than asked for, end at the stop time; a short last step would spoil the
        # order of the reactions.
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
    """Times of output that are given (N,) [s], checked."""
    found = np.array(times, float)
    if found.ndim != 1 or not len(found) or found[-1] != end or not (np.diff(found, prepend=start) > 0.0).all():
        raise UsageError(f"times of output come one after the other, from behind {start:g} s up to the stop, {end:g} s")
    return found


def _integrate(motion: Motion, progress, keeper: Keeper | None = None, before: Sequence[int] = ()) -> int:
    """Advance in slices of about a tenth of a second, so that progress shows and an interruption is heard.

    ``before`` are signals that came outside of the loop: they end it after a slice.
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
                if status != state.RUNNING or motion.bent():
                    if keeper is not None and status == state.DONE:
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
    return state.RUNNING


def _collect(motion: Motion, tol: float | None, found: Found, status: int, seconds: dict) -> tuple[Trajectory, list]:
    """The trajectory, and q and v of every part."""
    plan, system = motion.plan, motion.system
    t, q, v, lam, states = motion.output(status != state.DONE)
    stats = {
        "method": plan.method,
        "h": plan.h if plan.tol is None else None,
        "tol": tol,
        "error": found.error,
        "horizon": found.horizon,
        "status": {state.DONE: "done", state.RUNNING: "interrupted"}.get(status, "failed"),
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
