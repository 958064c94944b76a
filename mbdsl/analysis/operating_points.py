"""States about which a mechanism is linearised: its equilibrium, its initial state, or the state of a run at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbdsl.analysis.equilibria import prepare, settle
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.expressions.symbolic import is_velocity_level, walk
from mbdsl.initial.consistent import initial_position, initial_state
from mbdsl.integrators.contact_set import OVERLAP
from mbdsl.integrators.friction_set import FrictionSet
from mbdsl.integrators.shared_friction import put
from mbdsl.lang.given_values import seconds
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import Array
from mbdsl.simulation.diagnostics.uncertain_turns import uncertain
from mbdsl.simulation.given_initial_values import with_initial
from mbdsl.simulation.simulate import simulate
from mbdsl.simulation.steady_start import settled
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.signals import values

OUTPUTS = (100, 2000, 40_000)  #: outputs of the run up to a state, in turn, until they show the turns of all angles

At = str | float | Mapping[str, Any]  #: a state: "static", "start", a time [s], or initial values by name

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


class OperatingPoint(NamedTuple):
    """A state with its accelerations and multipliers.

    ``at`` is "static", "start", "t = 1.5 s" or "with pin.phi = 80 deg"; ``left_out`` are indices of redundant
    constraints.
    """

    system: System
    at: str
    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    left_out: tuple[int, ...]
    notes: list[str]

    @property
    def speed(self) -> float:
        """The largest scaled velocity [1/s]."""
        bodies = self.system.n - self.system.tables.states
        return float(np.abs(self.v * self.system.tables.scale)[:bodies].max(initial=0.0))

    @property
    def rate(self) -> float:
        """The largest scaled acceleration [1/s2]."""
        return float(np.abs(self.a * self.system.tables.scale).max(initial=0.0))

    @property
    def moving(self) -> bool:
        """Whether the mechanism has velocities or accelerations."""
        return self.speed > 0.0 or self.rate > 1e-9

    def warning(self, results: str) -> list[str]:
        """A note if the state is not an equilibrium; ``results`` names the computed results."""
        if not self.rate > 1e-9 * (1.0 + self.speed**2):
            return []
        if self.speed == 0.0:
            return [f"not an equilibrium: the mechanism begins to move, and the {results} hold for that moment only"]
        return [f"the mechanism moves: the {results} are those of the equations frozen at this moment"]


def about(at: str, t: float) -> str:
    """The state of an OperatingPoint in words: "static equilibrium", "state at t = 1.5 s"."""
    if at == "static":
        return "static equilibrium"
    return f"state {at}" if at.startswith("with ") else f"state at t = {t:g} s"


def checked(at: At) -> At:
    """``at`` as "static", "start", a number of seconds, or initial values by name.

    Raises
    ------
    UsageError
        If it denotes no state.
    """
    if isinstance(at, Mapping) or at in ("static", "start"):
        return at
    try:
        time = seconds(at, "at")
    except UsageError as problem:
        raise UsageError(f"at = {at!r}: expected `static`, `start` or a time", hint=problem.message) from None
    if not np.isfinite(time):
        raise UsageError(f"at = {at} is not a finite number")
    return time


def _value(x: Any) -> str:
    """An initial value as it was written."""
    return x if isinstance(x, str) else f"{x:g}" if isinstance(x, (int, float)) else str(x)


def find(
    model: Scene | Builder | str | PathLike,
    at: At,
    without: Sequence[str],
    parameters: Mapping[str, str | float] | None,
    announce: Callable[[str], None] | None,
) -> OperatingPoint:
    """The state of a model that ``at`` denotes.

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    EquilibriumError, InitialisationError, IntegrationError
        If the state is not found.
    """
    at = checked(at)
    scene = as_scene(model, parameters, without)
    with_values = ""
    if isinstance(at, Mapping):
        with_values = "with " + ", ".join(f"{name} = {_value(x)}" for name, x in at.items()) if at else ""
        scene, at = with_initial(scene, at), "start"
    if at != "static":
        scene, _ = settled(scene, None, announce)
    start = float(scene.experiment.start)
    name = with_values or (at if isinstance(at, str) else f"t = {float(at):g} s")
    if not isinstance(at, str) and float(at) < start:
        raise UsageError(f"at: t = {float(at):g} s is before the start of the run, {start:g} s")
    if at == "static":
        system, mechanism = prepare(scene, None, (), announce)
        found = settle(system, start, initial_position(system, mechanism, start))
        rest, notes, states = np.zeros(system.n), found.notes, {c.name for c in system.scene.states()}
        given = [x for x in system.scene.initial if x.name not in states]
        speeds = [x.name for x in given if is_velocity_level(x.target) and x.value]
        if system.p and speeds:
            notes = [*notes, f"this equilibrium is at rest; `--at start` is the motion with the given {few(speeds)}"]
        v = rest if found.v is None else found.v
        return OperatingPoint(system, name, found.t, found.q, v, rest, found.lam, found.left_out, notes)
    if at == "start" or at == start:
        system, mechanism = prepare(scene.without_contacts() if scene.contacts else scene, None, (), announce)
        first = initial_state(system, mechanism, start)
        at_start = np.array([start]), first.q[None], first.v[None]
        gaps = values(system, [c.gap for c in scene.contacts], *at_start)
        _check_open(scene, [gap[0] <= OVERLAP * system.tables.size for gap in gaps])
        found = OperatingPoint(system, name, start, first.q, first.v, first.a, first.lam, tuple(first.redundant), [])
        return _with_friction(found)
    assert not isinstance(at, str)
    for outputs in OUTPUTS:  # as many as show the turns of angles
        run = simulate(scene, stop=float(at), interval=abs(float(at) - start) / outputs, announce=announce)
        if not uncertain(run):
            break
    _check_open(scene, [run[f"{c.name}.active"][-1] > 0.0 for c in scene.contacts])
    system, _ = prepare(_frozen(scene, run), None, (), announce)
    t, q, v = float(run.t[-1]), run.q[-1], run.v[-1]
    for body, angle in run.turns.items():
        system.set_turn(body, float(angle[-1]))
    counted = (node for x in system.scene.signals().values() for node in walk(x) if node.op == "angle")
    nodes = list(dict.fromkeys([*system.tables.angles, *counted])) if system.counts_angles else []
    for node, angle in zip(nodes, values(run.system, nodes, run.t, run.q, run.v), strict=True):
        system.set_first_angle(node, float(angle[-1]))
    a, lam = accelerations(system, t, q, v, run.left_out)
    return _with_friction(OperatingPoint(system, name, t, q, v, a, lam, tuple(run.left_out), []))


def _check_open(scene: Scene, closed: Sequence[bool]) -> None:
    """Refuse a state in which rigid contacts are closed: whether they open decides how the bodies move."""
    for contact, last in zip(scene.contacts, closed, strict=True):
        if last and not contact.absent:
            message = f"linear models with a rigid contact that is closed, as `{contact.name}` is, are not available"
            raise InitialisationError(
                message, contact.span, "leave contacts out by `--without contact`, or give the stop a stiffness `k`"
            )


def _frozen(scene: Scene, run: Trajectory) -> Scene:
    """The scene with open contacts, and with discrete variables as they are at the end of a run."""
    events = scene.events
    now = {name: replace(x, start=float(run[name][-1])) for name, x in events.variables.items() if name in run}
    frozen = replace(scene, events=replace(events, variables={**events.variables, **now}))
    return frozen.without_contacts() if scene.contacts else frozen


def _with_friction(point: OperatingPoint) -> OperatingPoint:
    """A state of a motion in which joints slide or are held by friction that sticks."""
    system, name, t, q, v = point[:5]
    if not system.scene.sticking:
        return point
    friction, numbers = FrictionSet(system), system.scene.discrete_starts
    friction.begin(t, 0.0, q, v, numbers)
    v = friction.act(t, q, v, point.left_out, numbers)
    left_out = friction.left_out(point.left_out, numbers)
    put(system, numbers, left_out)
    return OperatingPoint(system, name, t, q, v, *accelerations(system, t, q, v, left_out), left_out, point.notes)
