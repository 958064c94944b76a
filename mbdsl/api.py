"""Simulation with a step, a tolerance or an accuracy: the one place that knows both simulation and studies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from mbdsl.errors import Interrupted, UsageError
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation import simulate as simulation
from mbdsl.simulation.checkpoint import Checkpoint
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


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


def simulated(
    model: Scene | Builder | str | PathLike,
    *,
    accuracy: float | None = None,
    budget: float | None = None,
    parameters: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    **given: Any,
) -> Trajectory:
    """As :func:`simulate`, but a run that is interrupted between steps is a result: its status says so.

    Raises
    ------
    Interrupted
        On Ctrl-C after the last step: the results are complete.
    """
    if accuracy is None:
        return simulation.simulated(model, parameters=parameters, without=without, **given)
    return _accurate(model, parameters, without, accuracy, budget, **given)


@blame_model
def _accurate(
    model: Scene | Builder | str | PathLike,
    parameters: Mapping[str, str | float] | None,
    without: Sequence[str],
    accuracy: float,
    budget: float | None,
    *,
    step: float | None = None,
    tol: float | None = None,
    times: ArrayLike | None = None,
    checkpoint: Checkpoint | str | PathLike | None = None,
    **given: Any,
) -> Trajectory:
    from mbdsl.studies.accuracy import reach

    if step is not None or tol is not None:
        raise UsageError("an accuracy finds its own step or tolerance", hint="give one of them alone")
    if checkpoint is not None:
        raise UsageError("runs with an accuracy have no checkpoints", hint="give a tolerance (tol) instead")
    if times is not None:
        raise UsageError("an accuracy is found at even times", hint="give an interval")
    return reach(as_scene(model, parameters, without), accuracy, budget=budget, **given)
