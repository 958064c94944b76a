"""Simulation with a step, a tolerance or an accuracy: the one place that knows both simulation and studies."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING
from warnings import warn

from mbdsl.errors import AccuracyWarning, IntegrationError, Interrupted, UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation import simulate as simulation
from mbdsl.simulation.given_initial_values import with_initial
from mbdsl.simulation.prescribed_inputs import with_inputs
from mbdsl.simulation.run_options import RunOptions, takes_options
from mbdsl.simulation.steady_start import settled, warnings
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.simulation.run_options import GivenOptions
    from mbdsl.simulation.streaming import Stream

#: options that are those of the runs of an accuracy, too
OF_ACCURACY = ("method", "budget", "start", "stop", "interval", "options", "force", "general", "progress", "announce")


@takes_options()
def simulate(model: Scene | Builder | str | PathLike, **given: Unpack[GivenOptions]) -> Trajectory:
    """Integrate the equations of motion of a model.

    Times are numbers in seconds, or texts with units as on the command line: ``step="1 ms"``.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism; a path is that of a ``.mbd`` file. ``mbdsl.parse`` reads a text.
    **given
        The options of the run, which are the attributes of ``mbdsl.simulation.run_options.RunOptions``.

    Returns
    -------
    Trajectory
        The states at the output times, and all signals by name.

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    InitialisationError
        If no consistent initial state is found.
    IntegrationError
        If the integration fails or misses the requested tolerance. Its ``trajectory`` holds the results so far, or
        the complete results of the best run. If the default tolerance is missed, there is an AccuracyWarning instead,
        and its text is in ``stats["warnings"]``.
    Interrupted
        On Ctrl-C. It is a KeyboardInterrupt whose ``trajectory`` holds the results so far.
    """
    asked = RunOptions.of(given)
    if asked.inputs:
        model, asked = _with_inputs(model, asked)
    if asked.signals is not None:
        known = AskedSignals(as_scene(model, asked.parameters, asked.without))
        asked = replace(asked, signals=known.select(asked.signals))
    chosen = asked.signals
    try:
        found = simulated(model, asked)
        if found.status == "interrupted":
            raise Interrupted(found)
    except (IntegrationError, Interrupted) as problem:
        if chosen is not None and problem.trajectory is not None:
            problem.trajectory = problem.trajectory[chosen]
        raise
    if found.status == "inaccurate":
        warn(found.stats["warnings"][-1], AccuracyWarning, stacklevel=3)
    return found if chosen is None else found[chosen]


def _with_inputs(model: Scene | Builder | str | PathLike, asked: RunOptions) -> tuple[Scene, RunOptions]:
    """The model with functions of time in place of inputs, and the options of its run."""
    if asked.checkpoint is not None:
        raise UsageError("runs with given inputs have no checkpoints", hint="write the inputs as tables of the model")
    scene = as_scene(model, asked.parameters, asked.without)
    start = scene.experiment.start if asked.start is None else asked.start
    stop = scene.experiment.stop if asked.stop is None else asked.stop
    scene = with_inputs(scene, asked.inputs or {}, start, stop)
    return scene, replace(asked, parameters=None, without=(), inputs=None)


def simulated(model: Scene | Builder | str | PathLike, asked: RunOptions, stream: Stream | None = None) -> Trajectory:
    """As :func:`simulate`, but return the trajectory of a run that is interrupted between steps.

    The ``status`` of that trajectory is "interrupted".

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step; the results are complete.
    """
    if asked.accuracy is None:
        return simulation.simulated(model, asked, stream=stream)
    return _accurate(model, asked, asked.accuracy)


@blame_model
def _accurate(model: Scene | Builder | str | PathLike, asked: RunOptions, accuracy: float) -> Trajectory:
    from mbdsl.studies.accuracy import reach

    if asked.step is not None or asked.tol is not None:
        raise UsageError("an accuracy finds its own step or tolerance", hint="give one of them alone")
    if asked.checkpoint is not None:
        raise UsageError("runs with an accuracy have no checkpoints", hint="give a tolerance (tol) instead")
    if asked.times is not None:
        raise UsageError("an accuracy needs evenly spaced output times", hint="give an interval")
    scene = with_initial(as_scene(model, asked.parameters, asked.without), asked.initial)
    scene, rest = settled(scene, asked.start)
    given = {name: getattr(asked, name) for name in OF_ACCURACY}
    found = reach(scene, accuracy, **given)
    found.stats["warnings"] += warnings(rest)
    return found
