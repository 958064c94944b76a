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
    method : str, optional
        Name of an integration method (`mbdsl methods` lists them). Default: the model's Method; else
        "hht-si2" with fixed steps, and with a tolerance the fastest for it of "hht-si2", "radau5" and "dop853".
    step : float or str, optional [s]
        Fixed step size, at most the duration of the run. Default: the model's Step. If the duration is not a multiple
        of it, all steps are shortened equally, so that the last one ends at ``stop``. Methods with error-controlled
        steps by default, those of high order, ignore the model's Step. Methods with fixed steps only default to 1 ms.
    tol : float or str, optional
        Limit of the global error, for error-controlled steps; excludes ``step``. The error is the maximum over all
        output times and coordinates: positions relative to the size of the mechanism, angles in radians, velocities
        relative to the largest velocity of the run (at least the size of the mechanism, or one radian, per duration
        of the run). Default, if neither the caller nor the model gives a step: the model's Tolerance, else 1e-4. With
        methods of high order and third-party integrators: the model's Tolerance, else 1e-6, even if the model has a
        Step. Calibration runs with larger tolerances come first. ``stats["error"]`` is the error estimate that they
        give; ``stats["horizon"]`` is the time up to which the tolerance holds (None: up to the end).
    accuracy : float or str, optional
        Limit of the error of positions, relative to the size of the mechanism, and of velocities, relative to the
        largest velocity; excludes ``step`` and ``tol``. Several runs determine the step and, unless it is given, the
        method. ``stats["accuracy"]`` describes the result (``mbdsl.studies.accuracy``).
    budget : float or str, optional [s]
        Time limit of the check of an ``accuracy`` by another method. Default: twenty times the duration of the runs
        before it, and at least 20 s.
    start, stop : float or str, optional [s]
        Start and stop time. Default: those of the model.
    interval : float or str, optional [s]
        Output interval. Default: (stop - start)/500; 0 stores every step.
    times : (N,) array or sequence of str, optional [s]
        Output times after the start, ascending; the last is the stop time. Excludes ``interval``.
    options : mapping, optional
        Parameters of the method, such as {"alpha": -0.1}.
    force : bool, optional
        Allow combinations that are known to fail, such as the trapezoidal rule on constrained models.
    general : bool, optional
        Solve the unreduced equations with code that contains every kind of element: no bodies are merged, no parts are
        split off or solved beforehand. For comparison with the specialised code.
    without : sequence of str, optional
        Effects to leave out ("friction", "damping", "flexibility", "gravity").
    parameters : mapping, optional
        Values that replace those of the model's parameters, as numbers in SI units or as texts with units
        ("120 N/mm").
    signals : str or sequence of str, optional
        Names and glob patterns of signals, which are checked before the run. The trajectory is then a selection: it
        lists, shows, plots and writes these signals. Default: all signals are listed, and coordinates and velocities
        are written.
    initial : mapping, Trajectory or "static", optional
        Initial values by signal, as numbers in SI units or as texts with units: ``{"crank.phi": "30 deg"}``. They are
        fixed, as in the model's ``initial equation``, and replace its values for the same signals; the other values
        remain. An entry "guess" is a mapping of values that the assembly may change. A Trajectory stands for the
        positions and velocities of all bodies at its end, which replace all initial values of the model; give its
        last time as ``start`` if forces or drivers depend on time. "static" is the equilibrium that ``mbdsl.static``
        finds at the start time: the run begins there, at rest, and the initial values of the model are where the search
        begins.
    progress : callable, optional
        Called about ten times a second with a ``Progress``.
    announce : callable, optional
        Called with a text before a phase that takes long, such as compilation. Default: in a terminal and in a
        notebook, a line on standard error announces a compilation.
    checkpoint : path or Checkpoint, optional
        Checkpoint file, written every minute and when the run is interrupted; ``mbdsl.resume`` continues from it.
        The file remains after the run. Not available with ``accuracy`` or with third-party integrators.
    inputs : mapping, optional
        Functions of time in place of inputs of the model: a pair (t, u) of arrays, linear between the points and
        constant outside of them; a function of time, which is sampled; or a number; in SI units. Others have their
        start values.

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
