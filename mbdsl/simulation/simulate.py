"""From a model to its Trajectory: graph, System, consistent initial state, integration, output."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING

from mbdsl.errors import Interrupted
from mbdsl.initial.redundancy import not_unique, of_attitudes, repeated
from mbdsl.integrators.event_list import groups
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import has_own_step
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation import diagnostics
from mbdsl.simulation.calibration_runs import COSTLY, Calibrated
from mbdsl.simulation.checkpoint import Keeper, of_run
from mbdsl.simulation.event_counts import of_events
from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.simulation.extremes import Gathered
from mbdsl.simulation.failure_messages import failure
from mbdsl.simulation.given_initial_values import as_mapping, with_initial
from mbdsl.simulation.interrupts import deferred
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.method_choice import MethodChoice
from mbdsl.simulation.plan import Plan, check_rounding, plan, width
from mbdsl.simulation.progress import Progress, announce_phase
from mbdsl.simulation.result_checks import check_bending, check_left_out, check_lines_of_centres, inaccurate
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.state_signals import StateSignals
from mbdsl.simulation.steady_start import settled
from mbdsl.simulation.steps import Steps
from mbdsl.simulation.streaming import Stream
from mbdsl.simulation.tolerance_calibration import calibrated
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage.compilation_notice import announce_compilation

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.simulation.run_options import GivenOptions

MOST_KEPT = 2_000_000  #: quantity of numbers above which the ends of steps are folded into ranges of signals
PART = 0.25  #: part of this quantity that is folded each time after the first one
SLICE = 64  #: number of steps before their time is measured


def simulate(model: Scene | Builder | str | PathLike, **given: Unpack[GivenOptions]) -> Trajectory:
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
    asked: RunOptions | None = None,
    *,
    inspect: Callable[[MechanismRun], None] | None = None,
    stream: Stream | None = None,
    **given: Unpack[GivenOptions],
) -> Trajectory:
    """As :func:`mbdsl.simulate` without an accuracy, but return the trajectory of a run interrupted between steps.

    The options are ``asked`` for, or given by name. ``inspect`` is called with the completed motion. A ``stream`` takes
    the rows of a long run while it goes on; the trajectory then contains only the last of them. ``signals`` are those
    whose extremes are found even if the run takes more steps than are kept; by default the coordinates and velocities
    of all bodies.

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step; the results are complete.
    """
    asked, clock = RunOptions.of(given) if asked is None else asked, Stopwatch()
    scene = with_initial(as_scene(model, asked.parameters, asked.without), asked.initial)
    clock.lap("parse")
    settings = plan(scene, asked, stream is not None)
    run = _prepared(model, scene, settings, asked, clock, stream)
    with deferred(1) as heard:
        status, found = _integrated(run, settings, clock, heard)
        _examine(run, settings, status, found, clock, inspect)
    if heard and run.done:
        raise Interrupted(run.trajectory)
    return run.trajectory


class Stopwatch:
    """Wall-clock seconds of each phase; ``lap`` is called at its end."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("parse", "build", "compile", "initialise", "integrate", "write"), 0.0)
        self._since = perf_counter()

    def lap(self, phase: str) -> None:
        now = perf_counter()
        self.seconds[phase] += now - self._since
        self._since = now


def _prepared(
    model: object, scene: Scene, settings: Plan, asked: RunOptions, clock: Stopwatch, stream: Stream | None
) -> ExaminedRun:
    """A run before its first step: its equations, compiled code and consistent initial state."""
    announce, progress = asked.announce, asked.progress
    if scene.experiment.tolerance is not None and settings.tol is None and announce is not None:
        announce(f"the model's Tolerance is not used: steps have a fixed size, {settings.h:g} s")
    scene, rest = settled(scene, settings.start, announce)
    motion = MechanismRun(scene, settings)
    if stream is not None:
        stream.settle(motion)
    run = ExaminedRun(asked, motion, rest, stream if motion.plan.streamed else None)
    clock.lap("build")
    missing = announce_compilation(announce, motion.uncompiled)
    announce_phase(progress, f"compiling {' and '.join(missing)}" if missing else "loading code")

    def ready(phase: str) -> None:
        clock.lap(phase)
        if phase == "compile":
            announce_phase(progress, "assembling the initial state")

    motion.prepare(ready)
    if settings.tol is not None and settings.asked:
        far = motion.distance
        what = f"coordinates that are {far:.2g} times the mechanism's size (or as many radians)"
        check_rounding(settings.tol, far, what)
    if announce is not None:
        _announce_redundant(motion, announce)
    run.at_start = diagnostics.warnings(run, before=True)
    if asked.checkpoint is not None:
        said, first = asked.repeatable(), asked.initial if rest is None else rest
        if first is not None:
            said["initial"] = as_mapping(scene, first)
        run.keeper = Keeper(of_run(asked.checkpoint, model, said), motion, run.stream)
    motion.watch()
    clock.lap("initialise")
    announce_phase(progress, "taking the first steps")
    return run


def _integrated(run: ExaminedRun, settings: Plan, clock: Stopwatch, heard: Sequence[int]) -> tuple[int, Calibrated]:
    """Make the run, or the runs of a tolerance; the status and the error estimate of the result."""
    motion = run.motion

    def integrate(most: float = math.inf) -> int:
        return _integrate(run, heard, most)

    def switch(other: Plan) -> None:
        clock.lap("integrate")
        motion.plan = other
        announce_compilation(run.options.announce, motion.uncompiled)
        motion.restart(other)
        clock.lap("compile")

    if settings.tol is None or not motion.parts or settings.stop == settings.start:
        status, found = integrate(), Calibrated()
    elif settings.open:
        choice = MethodChoice(motion, settings.tol, integrate, switch)
        status, found = choice.run()
        run.chosen = choice.text
    else:
        status, found = calibrated(motion, settings.tol, integrate)
    clock.lap("integrate")
    return status, found


def _examine(
    run: ExaminedRun,
    settings: Plan,
    status: int,
    found: Calibrated,
    clock: Stopwatch,
    inspect: Callable[[MechanismRun], None] | None,
) -> None:
    """Complete the results, or raise the error of a run that failed or is less accurate than it has to be."""
    motion, run.done = run.motion, status == S.DONE
    run.trajectory, run.states = trajectory, states = _collect(run, settings.tol, found, status, clock.seconds)
    complete = run.done and run.stream is None and not settings.every and not trajectory.stats.get("terminated")
    if complete and len(trajectory.t) <= settings.count:
        raise RuntimeError(f"internal error: the finished run has {len(trajectory.t)} of {settings.count + 1} outputs")
    if status not in (S.DONE, S.RUNNING):
        raise failure(motion, trajectory, status)
    if run.stream is not None:
        run.stream.check(trajectory)
    else:
        check_left_out(motion, trajectory, states)
        check_bending(trajectory)
        check_lines_of_centres(trajectory)
    warned = trajectory.stats["warnings"] = [*diagnostics.warnings(run), *run.at_start]
    if run.done and run.stream is None and motion.plan.tol is None:
        motion.outgrown()  # errors are relative to the same size as in a run with a tolerance
    if run.chosen:
        trajectory.stats["chosen"] = run.chosen
    if inspect is not None:
        inspect(motion)
    if run.keeper is not None and run.keeper.problem:
        warned.append(f"the last checkpoint is missing: {run.keeper.problem}")
    if found.horizon is not None and run.done:
        error = inaccurate(trajectory, found.reason)
        if settings.asked:
            raise error
        warned.append(f"{trajectory.message} (if the tolerance is given, this is an error)")


def _announce_redundant(motion: MechanismRun, announce: Callable[[str], None]) -> None:
    idle = {
        x
        for system, first in motion.assembled
        for x in of_attitudes(system, first.t, first.q, first.v, first.redundant)
    }
    names = [x for x in motion.redundant if x not in idle]
    if names:
        follow, be = ("follows", "is") if len(names) == 1 else ("follow", "are")
        announce(
            f"redundant: {', '.join(names)} {follow} from the other constraints and {be} left out; "
            "how the reactions share the load there is not determined"
        )
    for system, first in motion.assembled if names else ():
        for line in repeated(system, first.t, first.q, first.v, first.redundant):
            announce(f"  {line}")
        if system.scene.spatial:
            for line in not_unique(system, first.t, first.q, first.redundant):
                own = system.of_multipliers
                announce(f"  {line}, and {'are those of the run' if own else 'have the least norm'} in results")


def _integrate(run: ExaminedRun, before: Sequence[int] = (), most: float = math.inf) -> int:
    """Advance in slices of about a tenth of a second, between which progress is shown and interruptions are handled.

    Steps that need too much memory are folded into the ranges of the signals that are asked for.
    ``before`` are signals received outside of the loop: they end it after a slice. A run of more than ``most`` steps
    is ended, with the status COSTLY.
    """
    motion, keeper, progress = run.motion, run.keeper, run.options.progress
    slice_, begun, plan = SLICE, perf_counter(), motion.plan
    room = max(SLICE, int(PART * MOST_KEPT) // (1 + width(motion.system.scene)))
    stream = run.stream if plan.streamed else None
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
                    _gather(motion, run.options.signals)
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


def _collect(
    run: ExaminedRun, tol: float | None, found: Calibrated, status: int, seconds: dict[str, float]
) -> tuple[Trajectory, list[tuple[NDArray, NDArray]]]:
    """The trajectory, and q and v of every part."""
    motion, stream = run.motion, run.stream
    plan, system = motion.plan, motion.system
    events = motion.event_set
    partial = status != S.DONE or (events is not None and bool(events.ended))
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
    if events is not None:
        stats |= of_events(events)
    numbers = {} if events is None else events.at(t)
    trajectory = Trajectory(system, t, q, v, own, stats, motion.moved, motion.left_out, numbers)
    trajectory._since = None if stream is None else plan.start
    if events is not None:
        own = events
        trajectory.find_events = lambda: groups(own)
    trajectory.gathered, trajectory.find_steps = motion.gathered, _steps_of(motion)
    if trajectory.find_steps is None and plan.every and stream is None and events is None:
        trajectory.find_steps = lambda: Steps(trajectory, False)
    return trajectory, states


def _steps_of(motion: MechanismRun) -> Callable[..., Steps] | None:
    """A function that returns the steps which the present run keeps, or a slice of them; None if it keeps none."""
    ends, system, left_out = motion.ends_of_steps(), motion.system, motion.left_out
    own, precise, events = motion.own_reactions, has_own_step(motion.plan.method), motion.event_set
    if ends is None:
        return None

    def found(some: slice = slice(None)) -> Steps:
        t, q, v, lam = ends(some)
        numbers = {} if events is None else events.numbers_at(t)
        known = StateSignals(system, t, q, v, lam if own else None, {"status": "done"}, (), left_out, numbers)
        return Steps(known, precise) if events is None else Steps(known, precise, events.numbers_at, events.jumps())

    return found


def _gather(motion: MechanismRun, asked: Sequence[str] | None) -> None:
    """Fold the steps so far into ranges of signals; where angles depend on all earlier steps, keep no further ones."""
    tables = motion.system.tables
    if tables.angles or any(body.counter >= 0 for body in tables.models.values()):
        motion.forgo()
    elif motion.ends_of_steps() is not None:
        if motion.gathered is None:
            motion.gathered = Gathered(AskedSignals(motion.system.scene), asked)
        blocks = motion.blocks(motion.gathered.rows)
        find = _steps_of(motion)
        assert find is not None
        for some in blocks:
            steps = find(some)
            motion.gathered.add(steps)
        motion.release_steps(steps.ends.t[-1])
