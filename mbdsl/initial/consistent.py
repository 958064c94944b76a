"""Consistent initial values: assembled positions, then velocities, then accelerations and multipliers.

Fixed values are kept exactly; guesses change as little as possible, and coordinates without an initial value change
before guesses do: see :mod:`mbdsl.initial.pose_search` and :mod:`mbdsl.initial.start_velocities`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import is_velocity_level
from mbdsl.initial.assembly import Notes, PoseAssembly
from mbdsl.initial.dependent_rows import redundant_rows, without_units
from mbdsl.initial.least_steps import stack
from mbdsl.initial.mass_check import singular_mass
from mbdsl.initial.mirrored_poses import mirrored
from mbdsl.initial.misfits import check_tangents
from mbdsl.initial.pose_search import Task
from mbdsl.initial.start_velocities import velocities
from mbdsl.initial.steady_states import steady
from mbdsl.initial.undeformed import AsIs
from mbdsl.initial.weights import Metric
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.given_attitudes import for_assembly
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import InitialValue
from mbdsl.messages import DisplayUnit, UnitsOfSignals
from mbdsl.numerics.saddle_point import row_size, scaled
from mbdsl.storage.garbage_collection import uncollected
from mbdsl.system.accelerations import accelerations
from mbdsl.system.signals import begin, values
from mbdsl.system.system import System, build

SI = DisplayUnit()


@dataclass(frozen=True)
class Moved:
    """A guess, and the value after assembly."""

    name: str
    guess: float
    value: float
    unit: DisplayUnit = SI

    def shown(self, display: UnitsOfSignals) -> Moved:
        """The same in the unit in which it is displayed."""
        unit = display.of(self.unit.symbol, self.name)
        return replace(self, unit=DisplayUnit(unit.symbol, unit.factor * self.unit.factor))

    def texts(self, digits: int) -> tuple[str, str]:
        """Guess and value with their unit, by at least ``digits`` digits, and by so many that they differ."""
        shown = ((self.unit.text(self.guess, d), self.unit.text(self.value, d)) for d in range(digits, 18))
        return next((pair for pair in shown if pair[0] != pair[1]), (f"{self.guess!r}", f"{self.value!r}"))

    def change(self, digits: int = 4) -> str:
        """``pin.phi from 30 deg to 31.2 deg``."""
        return f"{self.name} from {' to '.join(self.texts(digits))}"


@dataclass(frozen=True)
class InitialState:
    """Consistent q, v, a (n,) and lam (m + p,) at time t."""

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    moved: tuple[Moved, ...] = ()
    redundant: tuple[int, ...] = ()  #: constraint rows that depend on others in all poses
    mirrored: tuple[str, ...] = ()  #: joints in space whose axes have opposite senses
    notes: tuple[str, ...] = ()  #: about telescopic legs and bodies of which another assembly exists
    turned: tuple[str, ...] = ()  #: about bodies that turned far from where they were placed


@uncollected
def initial_state(
    system: System,
    graph: MechanismGraph,
    t: float,
    members: Mapping[str, Sequence[str]] = {},
    relax: Callable[[Array], Array] | None = None,
    static: bool = False,
    until: float = np.inf,
) -> InitialState:
    """Assemble ``system`` at time ``t``; ``members`` of welded bodies: see :class:`Metric`.

    ``relax`` maps positions (n,) to positions with bodies in elastic equilibrium. It is called if bodies have to deform
    to be assembled, and always if ``static``. The search for positions ends at the time ``until`` of ``process_time``,
    with positions that close all joints if it has met some, though not the nearest to the guesses.

    Raises
    ------
    TimeoutError
        If positions were not found by then; its argument is the InitialisationError of the best ones.
    InitialisationError
        If no state satisfies the constraints and fixed values, or none was found; it names them.
    """
    if system.scene.contacts:
        return _without_contacts(system, graph, t, members, relax, static, until)
    task = Task(system, t, for_assembly(system.scene, _positions(system)), Metric(system, members), until)
    q, v, (notes, turned) = _assembled(task, graph, relax, static)
    if system.scene.states():
        begin(system, t, q, v)
        v = steady(system, t, q, v)
    return replace(state_at(system, t, q, v), notes=notes, turned=turned)


def _without_contacts(system: System, graph: MechanismGraph, t: float, *given) -> InitialState:
    """The state of a scene with rigid contacts, all of which are open until the run begins."""
    graph = graph.without_contacts()
    free = build(graph.scene, graph, size=system.tables.size)
    found = initial_state(free, graph, t, *given)
    begin(system, t, found.q, found.v)
    system.tables.first_angles |= free.tables.first_angles
    names = {name: k for k, name in enumerate(system.constraint_names())}
    redundant = tuple(sorted(names[free.constraint_names()[k]] for k in found.redundant))
    contacts = (row for rows in system.tables.contact_rows for row in rows)
    a, lam = accelerations(system, t, found.q, found.v, tuple(sorted({*redundant, *contacts})))
    return replace(found, a=a, lam=lam, redundant=redundant)


def state_at(system: System, t: float, q: Array, v: Array) -> InitialState:
    """The state with consistent q and v (n,) at time t, completed by accelerations and multipliers.

    Raises
    ------
    InitialisationError
        If they do not exist.
    """
    begin(system, t, q, v)
    check_tangents(system, t, q, v)
    redundant = redundant_rows(system, t, q, v)
    try:
        a, lam = accelerations(system, t, q, v, redundant)
    except InitialisationError as problem:
        if (singular := singular_mass(system, t, q, v)) is not None:
            raise singular from problem
        raise
    if system.scene.spatial and (singular := singular_mass(system, t, q, v, lam)) is not None:
        raise singular  # hidden by accelerations of least norm
    turned = tuple(mirrored(system, t, q)) if system.scene.spatial else ()
    return InitialState(t, q, v, a, lam, _moved(system, t, q, v), redundant, turned)


def _moved(system: System, t: float, q: Array, v: Array) -> tuple[Moved, ...]:
    """The guesses that assembly has changed."""
    guesses = [x for x in for_assembly(system.scene, list(system.scene.initial)) if not x.fixed]
    found = values(system, [x.target for x in guesses], np.array([t]), q[None], v[None])
    pairs = [
        (x, float(value[0]))
        for x, value in zip(guesses, found, strict=True)
        if abs(value[0] - x.value) > 1e-9 * abs(x.value)
    ]
    sizes = _sizes(system, [x for x, _ in pairs], t, q, v)
    return tuple(
        Moved(x.name, x.value, value, x.unit)
        for (x, value), size in zip(pairs, sizes, strict=True)
        if abs(value - x.value) > 1e-9 * size
    )


def _assembled(
    task: Task, graph: MechanismGraph, relax: Callable[[Array], Array] | None, static: bool
) -> tuple[Array, Array, Notes]:
    """q and v, and notes about what was turned round; flexible bodies deform only if necessary."""
    system, t = task.system, task.t
    velocity_level = [x for x in system.scene.initial if is_velocity_level(x.target)]
    assembly = PoseAssembly(task, graph)
    for shape in assembly.shapes(_positions(system)):
        try:
            pose, notes = assembly.meant(shape)
            q = pose.q
            if relax is not None and (static or isinstance(shape, AsIs)) and not system.scene.deformed:
                q = relax(q)
            return q, velocities(system, t, q, pose.y, pose.shape, velocity_level, task.metric), notes
        except InitialisationError:
            if isinstance(shape, AsIs):
                raise
    raise AssertionError("the last attempt returns or raises")


def _positions(system: System) -> list[InitialValue]:
    """The initial values of positions."""
    return [x for x in system.scene.initial if not is_velocity_level(x.target)]


def initial_position(system: System, graph: MechanismGraph, t: float, metric: Metric | None = None) -> Array:
    """Assembled positions q (n,) alone, without velocities.

    Raises
    ------
    InitialisationError
        As :func:`initial_state` does.
    """
    if system.scene.contacts:
        message = "equilibria and linear models with rigid contacts are not available"
        raise InitialisationError(
            message,
            system.scene.contacts[0].span,
            "leave contacts out by `--without contact`, or give the stop a stiffness `k`",
        )
    positions = _positions(system)
    assembly = PoseAssembly(Task(system, t, for_assembly(system.scene, positions), metric or Metric(system, {})), graph)
    for shape in assembly.shapes(positions):
        try:
            q = assembly.meant(shape)[0].q
            begin(system, t, q, np.zeros(system.n))
            return q
        except InitialisationError:
            if isinstance(shape, AsIs):
                raise
    raise AssertionError("the last attempt returns or raises")


def _sizes(system: System, items: list[InitialValue], t: float, q: Array, v: Array) -> Array:
    """The change of each target of ``items`` when bodies move by the mechanism's size or rotate by a radian; if it is a
    velocity, in the time in which the fastest body does so."""
    if not items:
        return np.zeros(0)
    _value, d_q, d_v = stack(system, items, t, q, v)
    scale = system.tables.scale
    fastest = np.abs(v * scale).max(initial=0.0)
    rates = [is_velocity_level(x.target) for x in items]
    one, per = np.ones(len(items)), 1.0 / scale
    return np.where(rates, fastest * row_size(scaled(d_v, one, per)), row_size(scaled(d_q, one, per)))


def determined(system: System, t: float, q: Array) -> bool:
    """Whether the constraints are independent and as many as the coordinates."""
    J = system.Phi_q(t, q)
    if J.shape[0] != J.shape[1]:
        return False
    J, _ = without_units(J, np.zeros(system.m), system.tables.scale)
    if isinstance(J, np.ndarray):
        sizes = np.linalg.svd(J, compute_uv=False)
    else:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        try:
            sizes = np.abs(splu(csc_array(J)).U.diagonal())
        except RuntimeError:  # exactly singular
            return False
    return bool(sizes.min() > 1e-9 * sizes.max())
