"""Simulation: a run that the caller advances step by step, setting inputs and reading signals between the steps.

For controllers and optimisers::

    sim = mbdsl.Simulation("arm.mbd", step=1e-3)
    while sim.time < 2.0:
        sim.inputs["u"] = -20.0 * sim["pin.phi"] - 3.0 * sim["pin.w"]
        sim.step()
    trajectory = sim.trajectory()
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import Expr
from mbdsl.integrators import backend, declared
from mbdsl.integrators.event_list import groups
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.options import check_options
from mbdsl.integrators.run import MOST_OUTPUT, MethodRun
from mbdsl.integrators.single_steps import SingleSteps
from mbdsl.kernels.arrays import Array
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.given_values import mapping
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean
from mbdsl.simulation.event_counts import of_events
from mbdsl.simulation.failure_messages import failure
from mbdsl.simulation.given_initial_values import with_initial
from mbdsl.simulation.input_values import Inputs
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import DEFAULT_METHOD, DEFAULT_STEP, Plan, constrained
from mbdsl.simulation.present_signals import PresentSignals, Values
from mbdsl.simulation.reader import Reader
from mbdsl.simulation.result_checks import check_bending
from mbdsl.simulation.run_options import RunOptions, takes_options
from mbdsl.simulation.saved_state import SavedState, restore, snapshot
from mbdsl.simulation.steady_start import settled
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.simulation.turn_counters import TurnCounter
from mbdsl.storage.compilation_notice import announce_compilation
from mbdsl.system import System
from mbdsl.system.signals import values

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbdsl.lang.builder import Builder
    from mbdsl.simulation.run_options import GivenOptions

#: number of rows by which the record grows at least
ROWS = 1024
#: part of a step by which times of events may differ from the end of the step
NEAR = 1e-8
#: what values of discrete variables have to be
TYPES = {"Real": "a number", "Integer": "an integer", "Boolean": "true or false"}
UNCOUNTED = 0.5  #: largest rotation of an angle in space until its turns are counted [rad]
MOST_UNCOUNTED = 50  #: steps, because rates may grow meanwhile


class Simulation:
    """A run with fixed steps that the caller advances by ``step``.

    ``simulation["pin.phi"]`` is the present value of a signal in SI units. A Simulation can be copied and pickled.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    step : float or str, optional [s]
        Fixed step size; a number or a text such as "1 ms". Default: the model's Step, else 1 ms. The model's Tolerance
        is not used.
    record : bool, optional
        Whether to store every state for ``trajectory``. Otherwise only the present state is stored.
    method, start, options, force, general, without, contacts, parameters, initial : optional
        As for ``mbdsl.simulate``; the method has to support fixed steps.

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    InitialisationError
        If no consistent initial state is found.
    """

    # A misspelt attribute that is assigned is an error.
    __slots__ = (
        *("_bends", "_call", "_changes", "_first", "_functions", "_h", "_in_force", "_inputs", "_known", "_method"),
        *("_motion", "_point", "_record", "_room", "_signals", "_start", "_steps", "_stopped", "_system"),
        *("_count", "_count_in", "_single", "_turns", "_vectors"),
    )

    @takes_options("method step start options force general without contacts parameters initial".split())
    @blame_model
    def __init__(
        self, model: Scene | Builder | str | PathLike, *, record: bool = True, **given: Unpack[GivenOptions]
    ) -> None:
        asked = RunOptions.of(given)
        scene = with_initial(as_scene(model, asked.parameters, asked.without), asked.initial)
        said, step = scene.experiment, asked.step
        self._method = asked.method or said.method or DEFAULT_METHOD
        if "fixed" not in declared(self._method).steps or backend(self._method) is not None:
            hint = f"take one of mbdsl's own methods with fixed steps, such as {DEFAULT_METHOD}"
            raise UsageError(f"{self._method} cannot be run step by step", hint=hint)
        self._h = float(step if step is not None else said.step if said.step is not None else DEFAULT_STEP)
        if not 0.0 < self._h < np.inf:
            raise UsageError(f"the step must be above zero, not {self._h:g} s")
        begin = float(said.start if asked.start is None else asked.start)
        options = check_options(self._method, asked.options or {}, constrained(scene), asked.force)
        # no stop time: it lies 2^52 steps ahead
        end = begin + self._h * 2.0**52
        plan = Plan(self._method, self._h, begin, end, np.array([]), options, asked.general, single=True)
        scene, _ = settled(scene, begin)
        self._motion = motion = MechanismRun(scene, plan)
        announce_compilation(None, motion.uncompiled)
        motion.prepare()
        self._system = self._motion.system
        self._single = self._single_steps()  #: the steps of a model with events
        self._record = record
        self._inputs = Inputs(scene)
        self._in_force = list(self._inputs.values())  #: read by the functions of signals
        self._changes: list[tuple[int, tuple[float, ...]]] = []  #: steps done, and the inputs from then on
        self._known: AskedSignals | None = None
        self._call: Callable[[int], int] | None = None  #: the step loop of all parts
        self._steps: memoryview | None = None  #: integers of the first part's run
        self._point: Trajectory | None = None  #: the present state, if a signal has needed it
        self._turns: dict[Expr, TurnCounter] = {}  #: of the angles in space that were asked for
        self._count: Values | None = None  #: counts their turns
        self._count_in = 0  #: steps until they are counted
        self._bind()
        self._first = self.state

    def __reduce__(self) -> tuple:
        """Pickled as the arguments and the state; compiled code is loaded or compiled again."""
        plan = self._motion.plan
        arguments = {"method": self._method, "step": self._h, "start": plan.start, "options": dict(plan.options)}
        arguments |= {"force": True, "general": plan.general, "record": self._record}
        return _restored, (self.scene, arguments, self.state)

    def __copy__(self) -> Simulation:
        return self.copy()

    def __deepcopy__(self, memo: dict) -> Simulation:
        return self.copy()

    def __repr__(self) -> str:
        return f"<Simulation of {self.scene.name} by {self._method}: t = {self.time:g} s>"

    @property
    def system(self) -> System:
        """The equations of motion of the model as written."""
        return self._system

    @property
    def method(self) -> str:
        """Name of the integration method."""
        return self._method

    @property
    def h(self) -> float:
        """Step size [s]."""
        return self._h

    @property
    def inputs(self) -> Inputs:
        """Values of the model's inputs, constant during a step; a mapping that is assigned sets those that it has."""
        return self._inputs

    @inputs.setter
    def inputs(self, values: Mapping[str, float]) -> None:
        for name, value in mapping(values, "inputs", 'give them by name: `{"u": 2.0}`').items():
            self._inputs[name] = value

    @property
    def scene(self) -> Scene:
        """The model."""
        return self._system.scene

    # -- the present state -------------------------------------------------------------------------------------
    @property
    def time(self) -> float:
        """Time reached [s]."""
        if self._single is not None:
            return self._single.time
        return self._motion.time if self._steps is None else self._start + self._steps[S.STEP] * self._h

    @property
    def terminated(self) -> str:
        """The text of `terminate`, after which no step is possible; "" before it has acted."""
        return "" if self._single is None else self._single.set.ended

    @property
    def q(self) -> Array:
        """Present generalised coordinates (n,) [m, rad], in the order of ``system.names()``; a copy, not writeable."""
        return _fixed(self._motion.present()[0])

    @q.setter
    def q(self, value: object) -> NoReturn:
        raise _not_set("q")

    @property
    def v(self) -> Array:
        """Present generalised velocities (n,) [m/s, rad/s]; a copy, not writeable."""
        return _fixed(self._motion.present()[1])

    @v.setter
    def v(self, value: object) -> NoReturn:
        raise _not_set("v")

    @property
    def lam(self) -> Array:
        """Present multipliers (m + p,), in the order of ``system.constraint_names()``; a copy, not writeable."""
        return _fixed(self._now().lam[0].copy())

    def __getitem__(self, name: str) -> float:
        """The present value of a signal, in SI units."""
        function = self._functions.get(name)
        if function is None:
            function = self._functions[name] = self._reading().function((name,))
        return function()[0]

    def __setitem__(self, name: str, value: float) -> None:
        """Set a state, such as the current of a motor, or a discrete variable; the motion continues with it from the
        present time on. When-equations act at once on what this makes true.

        Parameters
        ----------
        name : str
            Name of the state or of the discrete variable.
        value : float
            Its value in SI units; true or false of a Boolean.

        Raises
        ------
        UsageError
            If it is neither of them, or the value is not a finite number of its type.
        IntegrationError
            If the event fails.
        """
        states, discrete = [c.name for c in self.scene.states()], self.scene.events.variables
        own = [x for x, variable in discrete.items() if variable.type]
        if name not in [*states, *own]:
            hint = did_you_mean(name, [*states, *own], "states and discrete variables")
            hint = hint or "the model has no states and no discrete variables; inputs are set by `inputs`"
            raise UsageError(f"`{name}` is not a state and cannot be set", hint=hint)
        if not np.isfinite(number := float(value)):
            raise UsageError(f"{name} = {value}: expected a finite number")
        if name in own and not _fits(discrete[name].type, number):
            raise UsageError(f"{name} = {value}: expected {TYPES[discrete[name].type]}")
        if self._single is not None:
            self._point = None
            self._ended(self._single.set_value(name, number))
            return
        part = next(p for p in self._motion.parts if name in p.system.tables.coordinates)
        assert isinstance(part.integration, MethodRun)
        part.integration.set_velocity(part.system.tables.coordinates[name], number)
        self._bind()

    def reader(self, *names: str) -> Reader:
        """Choose signals that are read together.

        Parameters
        ----------
        *names : str
            Names of signals, and patterns as in ``Trajectory.select``.

        Returns
        -------
        Reader
            A function without arguments that returns the present values (k,) in SI units.

        Raises
        ------
        UsageError
            If a pattern matches no signal.
        """
        return Reader(self._reading().known.select(names), self._reading)

    def writer(self, *names: str) -> Callable[[Sequence[float]], None]:
        """Choose inputs that are set together.

        Parameters
        ----------
        *names : str
            Names of inputs. Default: all inputs, in the order of the model.

        Returns
        -------
        callable
            A function of a sequence of values (k,) in SI units, which sets the inputs.

        Raises
        ------
        UsageError
            If there is no such input, or one is named twice.
        """
        return self._inputs.writer(names or self._inputs.names)

    # -- steps -------------------------------------------------------------------------------------------------
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
        if type(count) is not int or count < 1:
            count = _checked(count)
        if not self._turns:
            return self._advance(count)
        while count > self._count_in:
            count -= self._count_in
            if self._count_in:
                self._advance(self._count_in)
            self._count_turns()
        self._count_in -= count
        return self._advance(count)

    def _count_turns(self) -> None:
        """Count the turns of angles in space up to the present state, and the steps until they are counted again."""
        if self._count is None:
            self._count = self._reading().count(tuple(self._turns))
        if self._count is None:  # its frames are not in the buffers: arrays of all states count
            self._turns, self._count_in = {}, sys.maxsize
            return
        self._count()
        fastest = max(abs(x.rate) for x in self._turns.values()) * self._h
        self._count_in = max(1, min(MOST_UNCOUNTED, int(UNCOUNTED / fastest))) if fastest else MOST_UNCOUNTED

    def _advance(self, count: int) -> float:
        """Advance by ``count`` steps."""
        if count > 1 and len(self._motion.parts) > 1:  # if one part fails, the others end at the same step
            for _ in range(count - 1):
                self._advance(1)
            count = 1
        if self._single is not None and (text := self._single.set.ended):
            hint = "`reset()`, or assign an earlier `state`; `terminated` is the text"
            raise UsageError(f"the run has ended at t = {self.time:.9g} s: {text}", hint=hint)
        if self._inputs._changed:
            self._change_inputs()
        if count > self._room:
            self._make_room(count)
        self._point = None
        if self._single is not None:
            return self._step_singly(count)
        steps = self._steps
        if self._call is None or steps is None:
            return self._step_slowly(count)
        most = steps[S.STEP] + count
        self._room -= count
        status = self._call(count)
        if status != S.RUNNING:
            self._check(self._motion.continued(self._stopped, status, most))
        return self._start + most * self._h

    def _step_singly(self, count: int) -> float:
        """Steps of a model with events, up to one that ends the run."""
        assert self._single is not None
        for _ in range(count):
            self._ended(self._single.advance())
            self._room -= 1
            if self._bends and self._motion.invalid():
                check_bending(self.trajectory() if self._record else self._now())
            if not self._record:
                self._single.set.forget()
            if self._single.set.ended:
                break
        return self.time

    def _ended(self, status: int) -> None:
        """Go on after something has happened in a model with events, unless the run has failed."""
        run = self._motion.parts[0].integration
        assert isinstance(run, MethodRun)
        if self._motion.ended(status) not in (S.RUNNING, S.DONE) or run.vectors is not self._vectors:
            self._check(status)

    def _single_steps(self) -> SingleSteps | None:
        """The steps of the run of a model with events, which is one part."""
        if not self.scene.has_events:
            return None
        run = self._motion.parts[0].integration
        assert isinstance(run, MethodRun)
        return SingleSteps(run, self._motion.plan.start, self._h)

    @property
    def _done(self) -> int:
        """Number of steps done."""
        return self._motion.steps if self._single is None else self._single.count

    def _step_slowly(self, count: int) -> float:
        """Steps of models with bodies that bend, whose range is checked at every step, and of those without parts."""
        motion = self._motion
        for _ in range(count if self._bends else 1):
            self._check(motion.advance(1 if self._bends else count))
            if self._bends and motion.invalid():
                check_bending(self.trajectory() if self._record else self._now())
        return self.time

    def _check(self, status: int) -> None:
        self._bind()
        if status not in (S.RUNNING, S.DONE):
            self._call = self._steps = None  # the motion remains failed, at the last step of all parts
            trajectory = self.trajectory()
            trajectory.stats["status"] = "failed"
            raise failure(self._motion, trajectory, status)

    def _change_inputs(self) -> None:
        numbers = self._inputs._take()
        if numbers is None or list(numbers) == self._in_force:
            return
        self._point = None
        self._in_force[:] = numbers
        self._changes.append((self._done, numbers))
        status = self._motion.change_inputs(dict(zip(self._inputs.names, numbers, strict=True)))
        if self._single is not None:
            self._ended(status)

    # -- state -------------------------------------------------------------------------------------------------
    @property
    def state(self) -> SavedState:
        """The complete state, with the stored states; assign it to return to it, bit for bit.

        It may be assigned to other simulations of the same model with the same method, options and step.
        """
        inputs, in_force = tuple(self._inputs.values()), tuple(self._in_force)
        changes = self._changes, len(self._changes)
        motion = self._motion
        turns = {node: x.state for node, x in self._turns.items()}
        taken = motion._taken if self._single is None else self._single.count
        return SavedState(
            self.time, self.scene, self._settings, taken, snapshot(motion), inputs, in_force, changes, turns
        )

    @state.setter
    def state(self, state: SavedState) -> None:
        if not isinstance(state, SavedState):
            raise UsageError(f"found {state!r}, expected a state from the attribute `state` of a Simulation")
        same = state.scene is self.scene or state.scene == self.scene
        if not same or state.settings != self._settings:
            raise UsageError(
                f"this state of {state.scene.name} belongs to another model or to other settings",
                hint="it fits simulations of the same model with the same method, options, step and record",
            )
        restore(self._motion, state.taken, state.runs)
        self._in_force[:] = state.in_force
        if self._single is not None:
            self._single.count = state.taken
            self._single.set.inputs |= dict(zip(self._inputs.names, state.in_force, strict=True))
        self._inputs._put(state.inputs, state.inputs != state.in_force)
        changes, count = state.changes
        self._changes = changes[:count]
        self._turns, self._count_in = {node: TurnCounter(*x) for node, x in state.turns.items()}, 0
        self._bind()

    @property
    def _settings(self) -> tuple:
        plan = self._motion.plan
        return plan.method, plan.h, plan.start, tuple(sorted(plan.options.items())), plan.general, self._record

    def reset(self) -> None:
        """Return to the start: the initial state, start values of the inputs, and nothing stored."""
        self.state = self._first

    def copy(self) -> Simulation:
        """Return a copy that continues from the present state independently.

        Returns
        -------
        Simulation
            It shares the equations and the compiled code with this one.
        """
        other = object.__new__(type(self))
        for name in Simulation.__slots__:
            if hasattr(self, name):
                setattr(other, name, getattr(self, name))
        other._motion = self._motion.copied()
        other._single = other._single_steps()
        other._inputs, other._in_force = Inputs(self.scene), list(self._in_force)
        other.state = self.state
        return other

    def trajectory(self) -> Trajectory:
        """Return the stored states.

        Returns
        -------
        Trajectory
            The initial state and the state after every step; only the present state if ``record`` is False.
        """
        motion = self._motion
        if not self._record:
            return self._at_present(self._stats())
        times = motion.parts[0].integration.times if motion.parts else self._own_times(motion.steps)
        motion.plan = replace(motion.plan, times=times)
        t, q, v, lam, _ = motion.output(bool(self.terminated))
        rows = np.searchsorted([k for k, _ in self._changes], np.arange(len(t)))  # the changes before step k
        values = np.array([list(self._first.inputs), *(numbers for _, numbers in self._changes)])
        inputs = {name: values[rows, k] for k, name in enumerate(self._inputs.names)}
        return self._trajectory(t, q, v, lam, self._stats(), inputs)

    def _stats(self) -> dict[str, Any]:
        counted = ("iterations", "evaluations", "matrix_evaluations", "factorisations")
        counts = {key: self._motion.count(key) for key in counted}
        stats = {"method": self._method, "h": self._h, "status": "done", "steps": self._motion.steps, **counts}
        return stats if self._single is None else stats | of_events(self._single.set)

    def _trajectory(self, t, q, v, lam, stats: dict, inputs: dict) -> Trajectory:
        motion = self._motion
        found = lam if motion.own_reactions else None
        if self._single is not None:
            inputs = inputs | self._single.set.at(t + NEAR * self._h)
        trajectory = Trajectory(self._system, t, q, v, found, stats, motion.moved, motion.left_out, inputs)
        if self._single is not None:
            found = groups(self._single.set)
            trajectory.find_events = lambda: found
        return trajectory

    def _at_present(self, stats: dict) -> Trajectory:
        q, v, lam = self._motion.present()
        inputs = {name: np.array([x]) for name, x in zip(self._inputs.names, self._in_force, strict=True)}
        return self._trajectory(np.array([self.time]), q[None], v[None], lam[None], stats, inputs)

    def _now(self) -> Trajectory:
        """The present state as a trajectory of one point, where all signals are defined."""
        if self._point is None:
            self._point = self._at_present({})
        return self._point

    def _recorded(self) -> Trajectory:
        """The stored states, from which angles in space are known with their turns."""
        if not self._record:
            raise UsageError(
                "angles in space that count turns follow from all states, and this simulation does not store them",
                hint="ask for the angle before the first step, or leave out `record=False`",
            )
        return self.trajectory()

    def _counter(self, node: Expr) -> TurnCounter:
        """The counter of an angle in space, from the start or from the stored states on."""
        if node not in self._turns:
            if self._done == 0:
                first = self._motion.system.tables.first_angles.get(node, 0.0)
            else:
                past = self._recorded()
                (angles,) = values(past.system, [node], past.t, past.q, past.v, None, past.inputs)
                first = float(angles[-1])
            self._turns[node], self._count, self._count_in = TurnCounter(first, self.time), None, 0
        return self._turns[node]

    # -- buffers -----------------------------------------------------------------------------------------------
    def _bind(self) -> None:
        """Set what depends on the buffers of the runs; called whenever one of them may have been replaced."""
        motion = self._motion
        runs = [p.integration for p in motion.parts if isinstance(p.integration, MethodRun)]  # all of them
        tables = [p.system.tables for p in motion.parts]
        self._bends = any(model.deforms for own in tables for model in own.models.values())
        self._start = motion.plan.start
        self._vectors = runs[0].vectors if runs else None
        self._steps = runs[0].integers.data if runs and self._single is None else None
        self._room = len(runs[0].times) - runs[0].written if runs and self._record else sys.maxsize
        quick = bool(runs) and not self._bends and motion.failed is None and self._single is None
        self._call = None
        if quick:
            self._call = self._together([run.prepared() for run in runs])
        self._functions: dict[str, Values] = {}
        self._signals: PresentSignals | None = None
        self._point = self._count = None

    def _together(self, calls: Sequence[Callable[[int], int]]) -> Callable[[int], int]:
        """The step loops of all parts in one function, which ends at the first status other than RUNNING."""
        self._stopped = 0  #: the part with that status
        if len(calls) == 1:
            return calls[0]

        def call(count: int) -> int:
            for k, one in enumerate(calls):
                status = one(count)
                if status != S.RUNNING:
                    self._stopped = k
                    return status
            return S.RUNNING

        return call

    def _make_room(self, count: int) -> None:
        """Add rows to the record for ``count`` steps and some more."""
        for p in self._motion.parts:
            run = p.integration
            assert isinstance(run, MethodRun)
            rows = run.written + max(count, ROWS, run.written // 2)
            if rows * run.out.shape[1] > MOST_OUTPUT:
                raise UsageError(
                    f"the states of {run.written + count} steps do not fit in memory",
                    hint="`record=False` stores the present state only",
                )
            out = np.empty((rows, run.out.shape[1]))
            out[: run.written] = run.out[: run.written]
            run.times, run.out = self._own_times(rows), out
        self._bind()

    def _own_times(self, steps: int) -> Array:
        return self._motion.plan.start + self._h * np.arange(1.0, steps + 1)

    def _reading(self) -> PresentSignals:
        """The functions of signals for the present buffers."""
        if self._signals is None:
            if self._known is None:
                self._known = AskedSignals(self.scene)
            past = self._now, self._recorded
            self._signals = PresentSignals(self._motion, self._known, self._in_force, *past, self._counter)
        return self._signals


def _restored(scene: Scene, arguments: dict[str, Any], state: SavedState) -> Simulation:
    """A pickled Simulation."""
    simulation = Simulation(scene, **arguments)
    simulation.state = state
    return simulation


def _fits(type_: str, value: float) -> bool:
    """Whether a number is one of a type."""
    return value in (0.0, 1.0) if type_ == "Boolean" else type_ == "Real" or value == round(value)


def _checked(count: object) -> int:
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise UsageError(f"found {count!r} steps, expected an integer of 1 or more")
    return int(count)


def _fixed(x: Array) -> Array:
    x.flags.writeable = False
    return x


def _not_set(name: str) -> UsageError:
    hint = "the initial equations of the model set the start, and `state` returns to a saved state"
    return UsageError(f"`{name}` follows from the motion and cannot be set", hint=hint)
