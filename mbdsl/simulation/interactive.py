"""Simulation: a run that the caller advances step by step, setting inputs and reading signals between the steps.

For controllers and optimisers::

    sim = mbdsl.Simulation("arm.mbd", step=1e-3)
    while sim.time < 2.0:
        sim.inputs["u"] = -20.0 * sim["pin.phi"] - 3.0 * sim["pin.w"]
        sim.step()
    trajectory = sim.trajectory()
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.integrators import backend, declared
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.options import check_options
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.failure_messages import check_bending, failure
from mbdsl.simulation.mechanism_run import Motion
from mbdsl.simulation.plan import DEFAULT_METHOD, DEFAULT_STEP, Plan, constrained
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

Array = NDArray[np.float64]


class Inputs(MutableMapping[str, float]):
    """The inputs of a model by name, in SI units; a change takes effect in the next step.

    Parameters
    ----------
    scene : Scene
        The model.
    """

    def __init__(self, scene: Scene) -> None:
        self._values = {name: x.start for name, x in scene.inputs.items()}
        self._scene = scene

    def __getitem__(self, name: str) -> float:
        if name not in self._values:
            raise self._unknown(name)
        return self._values[name]

    def __setitem__(self, name: str, value: float) -> None:
        if name not in self._values:
            raise self._unknown(name)
        value = float(value)
        if not np.isfinite(value):
            raise UsageError(f"the input {name} is set to {value}, which is not a finite number")
        self._values[name] = value

    def __delitem__(self, name: str) -> None:
        raise UsageError("inputs of a model cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def _unknown(self, name: str) -> UsageError:
        has = ", ".join(self._values) or "none"
        return UsageError(f"{self._scene.name} has no input `{name}`", hint=f"its inputs: {has}")


class Simulation:
    """A run with fixed steps that the caller advances by ``step``.

    ``simulation["pin.phi"]`` is the present value of a signal in SI units.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    step : float, optional [s]
        Fixed step size. Default: the model's Step, else 1 ms. The model's Tolerance is not used.
    record : bool, optional
        Whether to store every state for ``trajectory``. Otherwise only the present state is stored.
    method, start, options, force, general, without, parameters : optional
        As for ``mbdsl.simulate``; the method has to support fixed steps.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    method : str
        Name of the integration method.
    h : float [s]
        Step size.
    inputs : Inputs
        Values of the model's inputs; constant during a step.

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    InitialisationError
        If no consistent initial state is found.
    """

    @blame_model
    def __init__(
        self,
        model: Scene | Builder | str | PathLike,
        *,
        method: str | None = None,
        step: float | None = None,
        start: float | None = None,
        options: Mapping[str, float | None] | None = None,
        force: bool = False,
        general: bool = False,
        without: Sequence[str] = (),
        parameters: Mapping[str, str | float] | None = None,
        record: bool = True,
    ) -> None:
        scene = as_scene(model, parameters, without)
        said = scene.experiment
        self.method = method or said.method or DEFAULT_METHOD
        if "fixed" not in declared(self.method).steps or backend(self.method) is not None:
            hint = f"take one of mbdsl's own methods with fixed steps, such as {DEFAULT_METHOD}"
            raise UsageError(f"{self.method} cannot be run step by step", hint=hint)
        self.h = float(step if step is not None else said.step if said.step is not None else DEFAULT_STEP)
        if not 0.0 < self.h < np.inf:
            raise UsageError(f"the step must be above zero, not {self.h:g} s")
        begin = float(said.start if start is None else start)
        given = check_options(self.method, options or {}, constrained(scene), force)
        # no stop time: it lies 2^52 steps ahead
        plan = Plan(self.method, self.h, begin, begin + self.h * 2.0**52, np.array([]), given, general)
        self._motion = Motion(scene, plan)
        self._motion.prepare()
        self.system = self._motion.system
        self.inputs = Inputs(scene)
        self._in_force = dict(self.inputs)
        self._record = record
        self._states: list[tuple[float, Array, Array, Array, dict[str, float]]] = []
        self._keep()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a Simulation holds compiled code and cannot be pickled; its scene and its trajectory() can")

    def __repr__(self) -> str:
        return f"<Simulation of {self.system.scene.name} by {self.method}: t = {self.time:g} s>"

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self._motion.time

    @property
    def q(self) -> Array:
        """Present generalised coordinates (n,) [m, rad], in the order of ``system.names()``; a copy."""
        return self._motion.present()[0]

    @property
    def v(self) -> Array:
        """Present generalised velocities (n,) [m/s, rad/s]; a copy."""
        return self._motion.present()[1]

    @property
    def lam(self) -> Array:
        """Present multipliers (m + p,), in the order of ``system.constraint_names()``."""
        return self._now().lam[0].copy()

    def __getitem__(self, name: str) -> float:
        """The present value of a signal, in SI units."""
        return float(self._now()[name][0])

    def step(self, count: int = 1) -> float:
        """Advance by a number of steps with the present inputs.

        Parameters
        ----------
        count : int, optional
            Number of steps, at least 1.

        Returns
        -------
        float [s]
            Time reached.

        Raises
        ------
        UsageError
            If ``count`` is not a positive integer.
        IntegrationError
            If the integration fails; its ``trajectory`` holds the stored states.
        """
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
            raise UsageError(f"found {count!r} steps, expected an integer of 1 or more")
        if dict(self.inputs) != self._in_force:
            self._motion.change_inputs(self.inputs)
            self._in_force = dict(self.inputs)
        for _ in range(count):
            status = self._motion.advance(1)
            if status not in (loop_state.RUNNING, loop_state.DONE):
                trajectory = self.trajectory()
                trajectory.stats["status"] = "failed"
                raise failure(self._motion, trajectory, status)
            self._keep()
            if self._motion.bent():
                check_bending(self.trajectory() if self._record else self._now())
        return self.time

    def trajectory(self) -> Trajectory:
        """Return the stored states.

        Returns
        -------
        Trajectory
            The initial state and the state after every step; only the present state if ``record`` is False.
        """
        t = np.array([s[0] for s in self._states])
        q, v, lam = (np.array([s[k] for s in self._states]) for k in (1, 2, 3))
        inputs = {name: np.array([s[4][name] for s in self._states]) for name in self.inputs}
        stats = {
            "method": self.method,
            "h": self.h,
            "status": "done",
            "steps": self._motion.steps,
            "iterations": self._motion.count("iterations"),
            "matrix_evaluations": self._motion.count("matrix_evaluations"),
            "factorisations": self._motion.count("factorisations"),
        }
        return self._trajectory(t, q, v, lam, stats, inputs)

    def _trajectory(self, t, q, v, lam, stats: dict, inputs: dict) -> Trajectory:
        motion = self._motion
        found = lam if motion.own_reactions else None
        return Trajectory(self.system, t, q, v, found, stats, motion.moved, motion.left_out, inputs)

    def _state(self) -> tuple[float, Array, Array, Array, dict[str, float]]:
        return self.time, *self._motion.present(), self._in_force

    def _keep(self) -> None:
        if not self._record:
            self._states.clear()
        self._states.append(self._state())

    def _now(self) -> Trajectory:
        """The present state as a trajectory of one point, where all signals are defined."""
        t, q, v, lam, inputs = self._state()
        values = {name: np.array([value]) for name, value in inputs.items()}
        return self._trajectory(np.array([t]), q[None], v[None], lam[None], {}, values)
