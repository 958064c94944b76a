"""From a model to its Trajectory: graph, System, consistent initial state, integration, output."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mbdsl.errors import Interrupted
from mbdsl.initial.mirrored_poses import MIRRORED
from mbdsl.initial.misfits import misfits
from mbdsl.initial.redundancy import not_unique, repeated
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import has_own_step
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.calibration_runs import COSTLY, Found
from mbdsl.simulation.checkpoint import Checkpoint, Keeper, of_run
from mbdsl.simulation.extremes import Gathered
from mbdsl.simulation.failure_messages import check_bending, check_left_out, check_lines_of_centres, failure, inaccurate
from mbdsl.simulation.fixed_step_warnings import doubts
from mbdsl.simulation.given_initial_values import as_mapping, with_initial
from mbdsl.simulation.interrupts import deferred
from mbdsl.simulation.large_tilts import large_tilts
from mbdsl.simulation.mechanism_run import Motion
from mbdsl.simulation.method_choice import Choice
from mbdsl.simulation.plan import Plan, check_rounding, plan, width
from mbdsl.simulation.progress import Progress, announce_phase
from mbdsl.simulation.ropes_off_discs import ropes_off_discs
from mbdsl.simulation.shared_friction import shared_friction
from mbdsl.simulation.state_signals import StateSignals
from mbdsl.simulation.steady_start import settled, warnings
from mbdsl.simulation.steps import Steps
from mbdsl.simulation.streaming import Stream
from mbdsl.simulation.tolerance_calibration import calibrated
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.simulation.uncertain_turns import uncertain_turns
from mbdsl.storage.compilation_notice import announce_compilation

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

MOST_KEPT = 2_000_000  #: quantity of numbers above which the ends of steps are folded into ranges of signals
PART = 0.25  #: part of this quantity that is folded each time after the first one
SLICE = 64  #: number of steps before their time is measured


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
    initial: Mapping[str, Any] | Trajectory | str | None = None,
    progress: Callable[[Progress], None] | None = None,
    announce: Callable[[str], None] | None = None,
    checkpoint: Checkpoint | str | PathLike | None = None,
    inspect: Callable[[Motion], None] | None = None,
    stream: Stream | None = None,
    signals: Sequence[str] | None = None,
) -> Trajectory:
    """As :func:`mbdsl.simulate` without an accuracy, but return the trajectory of a run interrupted between steps.

    ``inspect`` is called with the completed motion. A ``stream`` takes the rows of a long run while it goes on; the
    trajectory then contains only the last of them. ``signals`` are those whose extremes are found even if the run takes
    more steps than are kept; by default the coordinates and velocities of all bodies.

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step; the results are complete.
    """
    seconds, lap = _stopwatch()
    scene = with_initial(as_scene(model, parameters, without), initial)
    lap("parse")
    run = plan(scene, method, step, tol, start, stop, interval, options, force, general, times, stream is not None)
    if scene.experiment.tolerance is not None and run.tol is None and announce is not None:
        announce(f"the model's Tolerance is not used: steps have a fixed size, {run.h:g} s")
    scene, rest = settled(scene, run.start, announce)
    motion = Motion(scene, run)
    if stream is not None:
        stream.settle(motion)
    if not motion.plan.streamed:
        stream = None
    lap("build")
    missing = announce_compilation(announce, motion.uncompiled)
    announce_phase(progress, f"compiling {' and '.join(missing)}" if missing else "loading code")

    def ready(phase: str) -> None:
        lap(phase)
        if phase == "compile":
            announce_phase(progress, "assembling the initial state")

    motion.prepare(ready)
    if run.tol is not None and run.asked:
        far = motion.distance
        check_rounding(run.tol, far, f"coordinates that are {far:.2g} times the mechanism's size (or as many radians)")
    if announce is not None:
        _announce_redundant(motion, announce)
    loose = warnings(rest)
    loose += [text for p in motion.parts for text in misfits(p.system, p.initial.t, p.initial.q, p.initial.v)]
    loose += [MIRRORED.format(name) for _, first in motion.assembled for name in first.mirrored]
    loose += [note for _, first in motion.assembled for note in first.notes]
    keeper = None
    if checkpoint is not None:
        asked: dict[str, Any] = {"method": method, "step": step, "tol": tol, "start": start, "stop": stop}
        asked |= {"interval": interval, "options": dict(options or {})}
        asked |= {"times": None if times is None else np.asarray(times).tolist()}
        if (first_state := initial if rest is None else rest) is not None:
            asked["initial"] = as_mapping(scene, first_state)
        asked |= {"force": force, "general": general, "parameters": dict(parameters or {}), "without": list(without)}
        keeper = Keeper(of_run(checkpoint, model, asked), motion, stream)
    motion.watch()
    lap("initialise")
    announce_phase(progress, "taking the first steps")
    chosen = ""
    with deferred(1) as heard:
        if run.tol is None or not motion.parts or run.stop == run.start:
            status, found = _integrate(motion, progress, keeper, heard, stream, asked=signals), Found()
        else:

            def integrate(most: float = math.inf) -> int:
                return _integrate(motion, progress, keeper, heard, stream, most, signals)

            def switch(other: Plan) -> None:
                lap("integrate")
                motion.plan = other
                announce_compilation(announce, motion.uncompiled)
                motion.restart(other)
                lap("compile")

            if run.open:
                choice = Choice(motion, run.tol, integrate, switch)
                status, found = choice.run()
                chosen = choice.text
            else:
                status, found = calibrated(motion, run.tol, integrate)
        lap("integrate")
        trajectory, states = _collect(motion, run.tol, found, status, seconds, stream)
        if status == S.DONE and stream is None and not run.every and len(trajectory.t) <= run.count:
            raise RuntimeError(f"internal error: the finished run has {len(trajectory.t)} of {run.count + 1} outputs")
        _check(motion, trajectory, states, status, stream)
        trajectory.stats["warnings"] += loose
        if chosen:
            trajectory.stats["chosen"] = chosen
        if inspect is not None:
            inspect(motion)
        if keeper is not None and keeper.problem:
            trajectory.stats["warnings"].append(f"the last checkpoint is missing: {keeper.problem}")
        if found.horizon is not None and status == S.DONE:
            error = inaccurate(trajectory, found.reason)
            if run.asked:
                raise error
            trajectory.stats["warnings"].append(f"{trajectory.message} (if the tolerance is given, this is an error)")
    if heard and status == S.DONE:
        raise Interrupted(trajectory)
    return trajectory


def _stopwatch() -> tuple[dict[str, float], Callable[[str], None]]:
    """Wall-clock seconds of each phase, and a function to be called at the end of a phase."""
    seconds = dict.fromkeys(("parse", "build", "compile", "initialise", "integrate", "write"), 0.0)
    clock = perf_counter()

    def lap(phase: str) -> None:
        nonlocal clock
        now = perf_counter()
        seconds[phase] += now - clock
        clock = now

    return seconds, lap


def _announce_redundant(motion: Motion, announce: Callable[[str], None]) -> None:
    if motion.redundant:
        follow, be = ("follows", "is") if len(motion.redundant) == 1 else ("follow", "are")
        announce(
            f"redundant: {', '.join(motion.redundant)} {follow} from the other constraints and {be} left out; "
            "how the reactions share the load there is not determined"
        )
    for system, first in motion.assembled if motion.redundant else ():
        for line in repeated(system, first.t, first.q, first.v, first.redundant):
            announce(f"  {line}")
        if system.scene.spatial:
            for line in not_unique(system, first.t, first.q, first.redundant):
                own = system.of_multipliers
                announce(f"  {line}, and {'are those of the run' if own else 'have the least norm'} in results")


def _integrate(
    motion: Motion,
    progress,
    keeper: Keeper | None = None,
    before: Sequence[int] = (),
    stream=None,
    most: float = math.inf,
    asked: Sequence[str] | None = None,
) -> int:
    """Advance in slices of about a tenth of a second, between which progress is shown and interruptions are handled.

    Steps that need too much memory are folded into the ranges of the signals ``asked`` for.
    ``before`` are signals received outside of the loop: they end it after a slice. A run of more than ``most`` steps
    is ended, with the status COSTLY.
    """
    slice_, begun, plan = SLICE, perf_counter(), motion.plan
    room = max(SLICE, int(PART * MOST_KEPT) // (1 + width(motion.system.scene)))
    stream = stream if plan.streamed else None
    if keeper is not None and (known := keeper.begin(motion)) is not None:
        return known
    if stream is not None:
        stream.begin(motion)
    try:
        with deferred() as heard:
            while not heard:
                began, before_it = perf_counter(), motion.steps
                status = motion.advance(int(min(slice_, room, most - before_it)))
                now = perf_counter()
                if status != S.RUNNING or motion.invalid():
                    if keeper is not None and status == S.DONE:
                        keeper.end(motion, status)
                    return status
                if motion.steps >= most:
                    if keeper is not None:
                        keeper.end(motion, COSTLY)
                    return COSTLY
                if motion.kept_numbers() > (MOST_KEPT if motion.gathered is None else PART * MOST_KEPT):
                    _gather(motion, asked)
                if stream is not None:
                    stream.pause(motion)
                    if stream.problem:
                        break
                if keeper is not None:
                    keeper.pause(motion)
                if progress is not None:
                    iterations = motion.count("iterations")
                    spent = now - begun
                    reached = Progress(motion.time, plan.start, plan.stop, motion.h, motion.steps, iterations, spent)
                    progress(replace(reached, what=motion.purpose))
                # a slice may end early, at an event: its time is that of the steps taken
                taken = min(slice_, max(1, motion.steps - before_it))
                slice_ = int(min(1e9, 4.0 * slice_, max(1.0, taken * 0.1 / max(now - began, 1e-9))))
                if before:
                    break
    except KeyboardInterrupt:  # from the progress callback
        pass
    if keeper is not None:
        keeper.write(motion)
    return S.RUNNING


def _check(motion: Motion, trajectory: Trajectory, states: list, status: int, stream: Stream | None) -> None:
    """Raise the error of a run that failed; else complete its statistics."""
    if status not in (S.DONE, S.RUNNING):
        raise failure(motion, trajectory, status)
    if stream is not None:
        stream.check(trajectory)
        trajectory.stats["warnings"] = stream.watched(motion).doubts() if status == S.DONE else []
        return
    check_left_out(motion, trajectory, states)
    check_bending(trajectory)
    check_lines_of_centres(trajectory)
    trajectory.stats["warnings"] = doubts(motion, trajectory, states) if status == S.DONE else []
    for doubt in (uncertain_turns, large_tilts, ropes_off_discs, shared_friction):
        trajectory.stats["warnings"] += doubt(trajectory)
    if motion.plan.tol is None and status == S.DONE:
        motion.outgrown()  # errors are relative to the same size as in a run with a tolerance


def _collect(
    motion: Motion, tol: float | None, found: Found, status: int, seconds: dict, stream: Stream | None
) -> tuple[Trajectory, list]:
    """The trajectory, and q and v of every part."""
    plan, system = motion.plan, motion.system
    partial = status != S.DONE
    t, q, v, lam, states = motion.output(partial) if stream is None else stream.end(motion, partial)
    stats = {
        "method": plan.method,
        "options": dict(plan.options),
        "h": plan.h if plan.tol is None else None,
        "tol": tol,
        "error": found.error,
        "horizon": found.horizon,
        "status": {S.DONE: "done", S.RUNNING: "interrupted"}.get(status, "failed"),
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
    if system.scene.spatial:
        stats["not unique"] = motion.not_unique
    for array in (t, q, v, lam):
        array.flags.writeable = False
    own = lam if motion.own_reactions else None
    trajectory = Trajectory(system, t, q, v, own, stats, motion.moved, motion.left_out)
    trajectory._since = None if stream is None else plan.start
    trajectory.gathered, trajectory.find_steps = motion.gathered, _steps_of(motion)
    if trajectory.find_steps is None and plan.every and stream is None:
        trajectory.find_steps = lambda: Steps(trajectory, False)
    return trajectory, states


def _steps_of(motion: Motion) -> Callable[..., Steps] | None:
    """A function that returns the steps which the present run keeps, or a slice of them; None if it keeps none."""
    ends, system, left_out = motion.ends_of_steps(), motion.system, motion.left_out
    own, precise = motion.own_reactions, has_own_step(motion.plan.method)
    if ends is None:
        return None

    def found(some: slice = slice(None)) -> Steps:
        t, q, v, lam = ends(some)
        return Steps(StateSignals(system, t, q, v, lam if own else None, {"status": "done"}, (), left_out), precise)

    return found


def _gather(motion: Motion, asked: Sequence[str] | None) -> None:
    """Fold the steps so far into ranges of signals; where angles depend on all earlier steps, keep no further ones."""
    find = _steps_of(motion)
    tables = motion.system.tables
    if tables.angles or any(body.counter >= 0 for body in tables.models.values()):
        motion.forgo()
    elif find is not None:
        if motion.gathered is None:
            motion.gathered = Gathered(AskedSignals(motion.system.scene), asked)
        for some in motion.blocks(motion.gathered.rows):
            steps = find(some)
            motion.gathered.add(steps)
        motion.release_steps(steps.ends.t[-1])
