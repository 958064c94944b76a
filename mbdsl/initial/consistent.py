"""Consistent initial values: assembled positions, then velocities, then accelerations and multipliers.

Fixed values are kept exactly; guesses change as little as possible, and coordinates without an initial value change
before guesses do:

    min 1/2 |W (q - g)|^2   subject to   Phi(q, t0) = 0,  sigma_fixed(q) = its value

by Gauss-Newton steps with the constraints linearised, damped while far from a solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import process_time

import numpy as np
from numpy.typing import NDArray

from mbdsl.collection import uncollected
from mbdsl.display_unit import DisplayUnit, UnitsOfSignals
from mbdsl.errors import InitialisationError, Span
from mbdsl.expressions.symbolic import is_velocity_level
from mbdsl.initial import gaps, telescopes, upside_down
from mbdsl.initial.dependent_rows import redundant_rows, without_units
from mbdsl.initial.in_plane import InPlane
from mbdsl.initial.mass_check import singular_mass
from mbdsl.initial.mirrored_poses import mirrored, unmirrored
from mbdsl.initial.misfits import check_tangents
from mbdsl.initial.placement import place
from mbdsl.initial.steady_states import steady
from mbdsl.initial.undeformed import AsIs, Undeformed
from mbdsl.initial.weights import Metric
from mbdsl.mechanism.given_attitudes import for_assembly
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import InitialValue
from mbdsl.numerics.saddle_point import dense, least_squares, row_size, scaled
from mbdsl.system.accelerations import accelerations
from mbdsl.system.signals import Matrix, begin, gradients, values
from mbdsl.system.system import System, build

Array = NDArray[np.float64]
Shape = AsIs | InPlane | Undeformed
Notes = tuple[tuple[str, ...], tuple[str, ...]]  #: of another assembly, and of bodies that turned far

SI = DisplayUnit()
LONGEST = 0.5  #: largest change of an angle in one iteration [rad]
FAR = 1e-2  #: violation of the constraints, in the size of the mechanism, that is not that of a pose near a solution
FIRST_OF_ALL = 1e-6  #: weight of rest while given velocities are met as well as possible
KEPT = 1e-9  #: change of a given velocity, relative to the largest, that is rounding
LIGHTEST = 1e-6  #: least effective mass of a given velocity, relative to the largest


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
    metric = Metric(system, members)
    q, v, (notes, turned) = _assembled(system, graph, t, metric, relax, static, until)
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
    contacts = (system.tables.rows[c.name] for c in system.scene.contacts)
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


def _pose(
    system: System, t: float, shape: Shape, given: list[InitialValue], metric: Metric, until: float = np.inf
) -> tuple[Shape, Array]:
    """Unknowns, and their values for the pose; in space with the axes of joints in the intended senses, if possible."""
    y = _positions(system, t, shape, given, metric, until)
    if not system.scene.spatial:
        return shape, y
    if isinstance(shape, InPlane):
        shape.count_turns(y)
    q = unmirrored(system, t, shape.expand(y), lambda q: _positions(system, t, AsIs(system, q), given, metric, until))
    return AsIs(system, q), q


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
    system: System,
    graph: MechanismGraph,
    t: float,
    metric: Metric,
    relax: Callable[[Array], Array] | None,
    static: bool,
    until: float,
) -> tuple[Array, Array, Notes]:
    """q and v, and notes about what was turned round; flexible bodies deform only if necessary."""
    positions = [x for x in system.scene.initial if not is_velocity_level(x.target)]
    velocities = [x for x in system.scene.initial if is_velocity_level(x.target)]
    for shape in _shapes(system, graph, t, positions):
        try:
            unknowns, y, notes = _meant(system, graph, t, for_assembly(system.scene, positions), metric, until, shape)
            q = unknowns.expand(y)
            if relax is not None and (static or isinstance(shape, AsIs)) and not system.scene.deformed:
                q = relax(q)
            return q, _velocities(system, t, q, y, unknowns, velocities, metric), notes
        except InitialisationError:
            if isinstance(shape, AsIs):
                raise
    raise AssertionError("the last attempt returns or raises")


def _meant(
    system: System,
    graph: MechanismGraph,
    t: float,
    given: list[InitialValue],
    metric: Metric,
    until: float,
    first: Shape,
) -> tuple[Shape, Array, Notes]:
    """The pose near the placement, or the one that is meant where the model decides nothing, with notes."""
    placed = first.expand(first.start)
    shape, y = _pose(system, t, first, given, metric, until)
    shape, y, legs = _reaching(system, t, given, metric, until, shape, y)
    if not isinstance(shape, AsIs | InPlane):
        return shape, y, (legs, ())
    shape, y, upright = _upright(system, graph, t, given, metric, until, shape, y)
    turned = tuple(upside_down.turned(system, graph, placed, shape.expand(y)))
    return shape, y, ((*legs, *upright), turned)


def _upright(
    system: System,
    graph: MechanismGraph,
    t: float,
    given: list[InitialValue],
    metric: Metric,
    until: float,
    shape: Shape,
    y: Array,
) -> tuple[Shape, Array, tuple[str, ...]]:
    """The pose, or that in which bodies without initial values are not upside down, with a note for each."""
    free, notes, attempts = upside_down.in_loops(system, graph), list[str](), 0
    for name, placement in free.items():
        q = shape.expand(y)
        before = upside_down.angles(system, q)[name]
        if abs(before) <= upside_down.UPRIGHT or attempts == upside_down.MOST:
            continue
        change = upside_down.turned_round(system, graph, placement, t, q)
        if change is None:
            continue
        attempts += 1
        turns = dict(system.tables.first_angles)
        upside_down.follow_turns(system, q, change)
        try:
            found, z = _pose(system, t, AsIs(system, system.moved(q, change)), given, metric, until)
            other = found.expand(z)
        except (InitialisationError, TimeoutError):
            other = q
        if upside_down.is_upright(system, placement, graph, q, other):
            shape, y = found, z
            after = upside_down.angles(system, other)[name]
            notes.append(upside_down.TAKEN.format(name, np.rad2deg(after), np.rad2deg(before)))
        else:
            for node, angle in turns.items():
                system.set_first_angle(node, angle)
    return shape, y, tuple(notes)


def _reaching(
    system: System, t: float, given: list[InitialValue], metric: Metric, until: float, shape: Shape, y: Array
) -> tuple[Shape, Array, tuple[str, ...]]:
    """The pose, or that in which telescopic legs without initial values are not turned round, with a note for each."""
    legs = telescopes.positions(system) if isinstance(shape, AsIs | InPlane) else {}
    before = telescopes.values_at(system, legs, t, shape.expand(y)) if legs else np.empty(0)
    if not (before < 0.0).any():
        return shape, y, ()
    away = [name for name, s in zip(legs, before, strict=True) if s < 0.0]
    other = AsIs(system, telescopes.turned_round(system, away, t, shape.expand(y)))
    try:
        found, z = _pose(system, t, other, given, metric, until)
    except (InitialisationError, TimeoutError):
        return shape, y, ()
    after = telescopes.values_at(system, legs, t, found.expand(z))
    if not after.min() > before.min() + telescopes.SAME * system.tables.size:
        return shape, y, ()
    each = zip(legs, before, after, strict=True)
    return found, z, tuple(telescopes.TAKEN.format(name, new, old) for name, old, new in each if old < 0.0)


def _shapes(system: System, graph: MechanismGraph, t: float, positions: list[InitialValue]) -> list[Shape]:
    """The sets of unknowns for assembly, in the order of the attempts."""
    placed = place(system, graph, t, positions)
    if begun := system.scene.deformed:  # the shapes of an equilibrium
        placed = np.array([begun.get(name, x) for name, x in zip(system.names(), placed, strict=True)])
        return [AsIs(system, placed)]
    as_is = AsIs(system, placed)
    if system.scene.spatial:
        in_plane = InPlane(system, placed)
        given = for_assembly(system.scene, positions)
        return [in_plane, as_is] if _flat(system, t, in_plane, given) else [as_is]
    return [Undeformed(system, placed), as_is] if system.tables.flexible else [as_is]


def _flat(system: System, t: float, shape: InPlane, given: list[InitialValue]) -> bool:
    """Whether constraints and initial values are those of a mechanism in the plane, at its guess."""
    q = shape.expand(shape.start)
    value, d_q, _v = _stack(system, given, t, q, np.zeros(system.n))
    r = np.concatenate([system.Phi(t, q), _misses(value, given)])
    return shape.suits(*without_units(_stacked(system.Phi_q(t, q), d_q), r, system.tables.scale))


def initial_position(system: System, graph: MechanismGraph, t: float, metric: Metric | None = None) -> Array:
    """Assembled positions q (n,) alone, without velocities.

    Raises
    ------
    InitialisationError
        As :func:`initial_state` does.
    """
    if system.scene.contacts:
        message = "equilibria and linear models with rigid contacts are not available"
        raise InitialisationError(message, system.scene.contacts[0].span, "take a stop with stiffness `k` in its place")
    positions = [x for x in system.scene.initial if not is_velocity_level(x.target)]
    given = for_assembly(system.scene, positions)
    for shape in _shapes(system, graph, t, positions):
        try:
            unknowns, y, _notes = _meant(system, graph, t, given, metric or Metric(system, {}), np.inf, shape)
            q = unknowns.expand(y)
            begin(system, t, q, np.zeros(system.n))
            return q
        except InitialisationError:
            if isinstance(shape, AsIs):
                raise
    raise AssertionError("the last attempt returns or raises")


# -- positions -----------------------------------------------------------------------------------------------


def _positions(
    system: System,
    t: float,
    shape: Shape,
    given: list[InitialValue],
    metric: Metric,
    until: float = np.inf,
    nearest: bool = True,
) -> Array:
    """The y of ``shape`` for the pose, the ``nearest`` to the guess or one that is found by the smallest steps."""
    fixed = [x for x in given if x.fixed]
    soft = [x for x in given if not x.fixed]
    guess, scale, angles, at_rest = shape.start, shape.scale, shape.angles, np.zeros(system.n)
    weight = shape.weights(metric.weight)
    tolerance = 1e-13 * (1.0 + np.abs(guess * scale).max(initial=0.0))
    best, best_violation = guess, np.inf
    members, _d = metric.positions_at(t, shape.expand(guess))
    rng = None  # imported late, because numpy loads its generators on first use
    for attempt in range(6):
        y = guess
        if attempt:  # at a singular pose there is no direction of descent: later attempts start near it
            rng = rng or np.random.default_rng(0)
            y = shape.moved(guess, rng.normal(size=len(guess)) * 0.1 * attempt / scale)
        shape.begin()
        for k in range(160):
            if process_time() > until:
                if best_violation <= tolerance:
                    return best
                raise TimeoutError(_inconsistent(system, t, shape.expand(best), fixed, None, interrupted=True))
            q = shape.expand(y)
            value, d_q, _v = _stack(system, fixed, t, q, at_rest)
            r_c = np.concatenate([system.Phi(t, q), _misses(value, fixed)])
            if system.tables.angles:
                system.count_angles()  # from iterate to iterate, which are less than half a turn apart
            soft_value, soft_q, _v = _stack(system, soft, t, q, at_rest)
            r_s = _misses(soft_value, soft)
            J, r_c = without_units(shape.reduce(y, _stacked(system.Phi_q(t, q), d_q)), r_c, scale)
            S, r_s = without_units(shape.reduce(y, soft_q), r_s, scale)
            violation = np.abs(r_c).max(initial=0.0)
            if y is guess and max(violation, np.abs(r_s).max(initial=0.0)) <= tolerance:
                return y  # assembled at the initial guess: no solution is nearer
            if violation < best_violation:
                best, best_violation = y, violation
            # Damped while the violation is large, then plain Gauss-Newton: the remaining violation may be that of a
            # solution at a dead centre, to which damped steps do not converge.
            plain = k >= 80 or violation < 1e-6
            solve = _constrained if plain else _damped
            value, d_q = metric.positions_at(t, q)
            d_y = scaled(shape.reduce(y, d_q), np.ones(len(value)), 1.0 / scale)
            S, r_s = _stacked(S, d_y), np.concatenate([r_s, value - members])
            away = weight * shape.difference(y, guess) * scale if nearest else np.zeros(len(y))
            step = solve(weight, away, S, r_s, J, r_c) / scale
            if not np.isfinite(step).all():
                break
            turn = np.abs(step[angles]).max(initial=0.0)
            y = shape.moved(y, step * min(1.0, LONGEST / max(turn, 1e-300)))
            if np.abs(step * scale).max(initial=0.0) <= 10.0 * tolerance:
                if violation <= tolerance:
                    return y
                if k >= 80 and violation > 1e3 * tolerance:
                    break  # the constraints contradict each other: this is the nearest compromise
            if k == 80 and attempt and violation > FAR and system.scene.spatial:
                break  # plain steps converge near a solution only; in space they take long
        if violation <= 1e3 * tolerance:
            return y
    if nearest and isinstance(shape, AsIs) and system.scene.spatial:
        # The rotation from the guess is not linear: Gauss-Newton steps may not converge if the guess is far from all
        # poses. Steps that only close the joints end at a pose that is near, but not the nearest.
        return _positions(system, t, shape, fixed, metric, until, nearest=False)
    raise _inconsistent(system, t, shape.expand(best), fixed, velocity=None)


def _damped(weight: Array, r_w: Array, S: Matrix, r_s: Array, J: Matrix, r_c: Array) -> Array:
    """As ``_constrained``, with a penalty on changes that increases with the violation.

    The penalty limits the steps for a nearly singular J, as of a mechanism close to a dead centre.
    """
    n, m = len(r_w), len(r_c)
    b = np.concatenate([-weight * r_w - S.T @ r_s, -r_c])
    # guesses far from the solution must not prevent convergence of the constraints
    mu = 0.1 * np.abs(r_c).max(initial=0.0) / (1.0 + np.abs(b[:n]).max(initial=0.0))
    if isinstance(J, np.ndarray):
        H = np.diag(weight**2) + S.T @ S
        return np.linalg.solve(np.block([[H, J.T], [J, -mu * np.eye(m)]]), b)[:n]
    from scipy.sparse import block_array, csc_array, diags_array
    from scipy.sparse.linalg import splu

    H = diags_array(weight**2) + S.T @ S
    return splu(csc_array(block_array([[H, J.T], [J, diags_array(np.full(m, -mu))]]))).solve(b)[:n]


def _sizes(system: System, items: list[InitialValue], t: float, q: Array, v: Array) -> Array:
    """The change of each target of ``items`` when bodies move by the mechanism's size or rotate by a radian; if it is a
    velocity, in the time in which the fastest body does so."""
    if not items:
        return np.zeros(0)
    _value, d_q, d_v = _stack(system, items, t, q, v)
    scale = system.tables.scale
    fastest = np.abs(v * scale).max(initial=0.0)
    rates = [is_velocity_level(x.target) for x in items]
    one, per = np.ones(len(items)), 1.0 / scale
    return np.where(rates, fastest * row_size(scaled(d_v, one, per)), row_size(scaled(d_q, one, per)))


def _stack(system: System, items: list[InitialValue], t: float, q: Array, v: Array):
    return gradients(system, [x.target for x in items], t, q, v)


def _misses(value: Array, items: list[InitialValue]) -> Array:
    """The differences of ``value`` from the initial values; of angles less than half a turn."""
    found = value - np.array([x.value for x in items])
    angles = np.array([x.target.op in ("angle", "atan2") for x in items], bool)
    found[angles] -= 2.0 * np.pi * np.round(found[angles] / (2.0 * np.pi))
    return found


def _stacked(J: Matrix, rows: Matrix) -> Matrix:
    if isinstance(J, np.ndarray):
        return np.vstack([J, rows])
    from scipy.sparse import vstack

    return vstack([J, rows]).tocsr()


def _constrained(weight: Array, r_w: Array, A_s: Matrix, r_s: Array, J: Matrix, r_c: Array) -> Array:
    """min |r_w + W d|^2 + |r_s + A_s d|^2 subject to J d = -r_c (least squares if it has no solution)."""
    n = len(weight)
    if isinstance(J, np.ndarray):
        U, s, Vt = np.linalg.svd(J, full_matrices=True)
        rank = int((s > 1e-10 * s.max(initial=0.0)).sum())
        d = Vt[:rank].T @ ((U[:, :rank].T @ -r_c) / s[:rank])
        Z = Vt[rank:].T
        if Z.shape[1]:
            A = np.vstack([weight[:, None] * Z, A_s @ Z])
            b = -np.concatenate([r_w + weight * d, r_s + A_s @ d])
            d = d + Z @ least_squares(A, b)
        return d
    from scipy.sparse import block_array, csc_array, csr_array, diags_array
    from scipy.sparse.linalg import splu

    S = csr_array(A_s)
    H = diags_array(weight**2) + S.T @ S
    regular = -(float(abs(H).max()) * 1e-14 + 1e-20) * np.ones(J.shape[0])
    K = block_array([[H, J.T], [J, diags_array(regular)]])
    return splu(csc_array(K)).solve(np.concatenate([-(weight * r_w) - S.T @ r_s, -r_c]))[:n]


# -- velocities, accelerations -------------------------------------------------------------------------------


def _velocities(
    system: System, t: float, q: Array, y: Array, shape: Shape, given: list[InitialValue], metric: Metric
) -> Array:
    """The velocities (n,): fixed values exactly, then the given ones, then those nearest to rest.

    Given values that agree with each other and with the constraints are kept. If they do not, they change as by an
    impulse: the sum of m (v - given)^2 is least, with the effective mass m of each given velocity.
    """
    fixed = [x for x in given if x.fixed]
    soft = [x for x in given if not x.fixed]
    fix, wish = np.array([x.value for x in fixed]), np.array([x.value for x in soft])
    if not soft or len(soft) >= len(y):
        return _nearest_rates(system, t, q, y, shape, metric, (fixed, fix), (soft, wish))
    v = _nearest_rates(system, t, q, y, shape, metric, (fixed, fix), (soft, wish), FIRST_OF_ALL)
    reached = _stack(system, soft, t, q, v)[0]
    size = np.abs([*wish, *reached]).max(initial=0.0)
    reached = np.where(np.abs(reached - wish) <= KEPT * size, wish, reached)
    return _nearest_rates(system, t, q, y, shape, metric, ([*fixed, *soft], np.append(fix, reached)), ([], np.empty(0)))


def _effective_masses(system: System, t: float, q: Array, rows: Matrix) -> Array:
    """1/(g M^{-1} g^T) of each row g of ``rows`` (k, n), relative to the largest and at least ``LIGHTEST``."""
    found = np.array([1.0 / max(g @ system.solve_mass(t, q, g), 1e-300) for g in np.atleast_2d(dense(rows))])
    return np.clip(found / found.max(initial=1e-300), LIGHTEST, 1.0)


def _nearest_rates(
    system: System,
    t: float,
    q: Array,
    y: Array,
    shape: Shape,
    metric: Metric,
    fixed: tuple[list[InitialValue], Array],
    soft: tuple[list[InitialValue], Array],
    rest: float = 1.0,
) -> Array:
    """Velocities (n,) with ``fixed`` values, nearest to ``soft`` values and, with the weight ``rest``, to rest."""
    scale, w = shape.scale, np.zeros(len(y))  # w: rates in the mechanism's size, and in radians
    complete = len(soft[0]) >= len(y)  # the state of another run: nothing remains to be nearest to rest
    driven = not complete and bool(_velocity_residual(system, t, q, np.zeros(system.n)).any())
    metric = metric.relative() if driven else metric
    weight, asked, near = rest * shape.weights(metric.weight), 0.0, np.zeros(len(y))
    at_rest, rates = metric.velocities_at(t, q)  # linear in v
    R = rest * scaled(shape.reduce(y, rates, q), np.ones(len(at_rest)), 1.0 / scale)
    masses: Array | None = None
    for k in range(20 if system.p else 3):  # mostly linear in v: the second pass refines, the third confirms
        v = shape.rates(y, w / scale, q)
        value, _q, d_v = _stack(system, fixed[0], t, q, v)
        soft_value, _q, soft_v = _stack(system, soft[0], t, q, v)
        r_s = soft_value - soft[1]
        r_c = np.concatenate([_velocity_residual(system, t, q, v), value - fixed[1]])
        if not r_c.any() and not r_s.any():
            return v  # at rest, as intended
        J = _stacked(system.velocity_jacobian(t, q, v), d_v)
        finite = np.isfinite(r_c).all() and np.isfinite(J if isinstance(J, np.ndarray) else J.data).all()
        if not finite and k == 0 and (fixed[0] or soft[0]):  # sqrt(v^2) has no derivative at rest: begin as given
            J, r_c = _stacked(soft_v, d_v), np.concatenate([soft_value - soft[1], value - fixed[1]])
            J, r_c = without_units(shape.reduce(y, J, q), r_c, scale)
            w = least_squares(dense(J), -r_c)
            continue
        if not finite:
            bad = np.flatnonzero(~np.isfinite(_velocity_residual(system, t, q, v)))
            names = [system.constraint_names()[k] for k in bad[:3]]
            raise InitialisationError(
                f"the constraints are not finite numbers in the initial pose{': ' * bool(names)}{', '.join(names)}",
                hint="give initial values that lead to another pose; a rolling disc, for example, must not lie flat",
            )
        if masses is None and soft[0]:
            masses = np.sqrt(_effective_masses(system, t, q, soft_v))
        J, r_c = without_units(shape.reduce(y, J, q), r_c, scale)
        S, r_s = without_units(shape.reduce(y, soft_v, q), r_s, scale)
        if masses is not None:
            S, r_s = scaled(S, masses, np.ones(len(y))), masses * r_s
        asked = max(asked, np.abs(r_c).max(initial=0.0))
        S, r_s = _stacked(S, R), np.append(r_s, rest * (at_rest + rates @ v))
        step = _constrained(weight, weight * (w - near), S, r_s, J, r_c)
        w = w + step
        if driven or complete:  # not nearest to rest in the world
            near = w
        if np.abs(step).max(initial=0.0) <= 1e-15 * np.abs(w).max(initial=0.0):
            break
    v = shape.rates(y, w / scale, q)
    value, _q, d_v = _stack(system, fixed[0], t, q, v)
    r_c = np.concatenate([_velocity_residual(system, t, q, v), value - fixed[1]])
    J = _stacked(system.velocity_jacobian(t, q, v), d_v)
    _, r_c = without_units(shape.reduce(y, J, q), r_c, scale)
    if np.abs(r_c).max(initial=0.0) > 1e-9 * max(asked, np.abs(w).max(initial=0.0)):
        raise _inconsistent(system, t, q, [x for x in fixed[0] if x.fixed], velocity=v)
    return v


def _velocity_residual(system: System, t: float, q: Array, v: Array) -> Array:
    """[Phi_q v + Phi_t; Gam] (m + p,)."""
    return np.concatenate([system.evaluate(t, q, v)[2], system.Gam(t, q, v)])


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


def _opened(system: System, t: float, q: Array, fixed: list[InitialValue], kind: str, name: str, own: slice) -> str:
    """How far a joint in space is open."""

    def residual(q: Array) -> tuple[Array, Array]:
        value, d_q, _v = _stack(system, fixed, t, q, np.zeros(system.n))
        r = np.concatenate([system.Phi(t, q), _misses(value, fixed)])
        J, r = without_units(_stacked(system.Phi_q(t, q), d_q), r, system.tables.scale)
        return r, dense(J)

    if (found := gaps.gap(system, t, q, own, residual)) is not None:
        return f"{kind} {name} is open by {gaps.text(*found)} if all others are closed"
    return f"{kind} {name} is violated by {gaps.text(*gaps.parts(system, t, q, own))}"


def _with_units(violation: float, kind, velocity: Array | None) -> str:
    """A violation with the units of the constraints of a joint, which follow from those of its reactions."""
    found = [unit for unit, names in (("m", {"fx", "fy"}), ("rad", {"tau"})) if names & set(kind.reaction)]
    per = "" if velocity is None else "/s"
    degrees = f" ({np.rad2deg(violation):.3g} deg{per})" if found == ["rad"] else ""
    return f"{violation:.3g} {' or '.join(unit + per for unit in found) or '(SI units)'}{degrees}"


def _inconsistent(
    system: System, t: float, q: Array, fixed: list[InitialValue], velocity, interrupted: bool = False
) -> InitialisationError:
    """The constraints and fixed values that contradict each other, with their places.

    At a pose where the search was ``interrupted``, they perhaps do not: a joint then is not open if all others are
    closed, and its violation in this pose is stated.
    """
    level = "positions" if velocity is None else "velocities"
    v = np.zeros(system.n) if velocity is None else velocity
    residual = system.Phi(t, q) if velocity is None else _velocity_residual(system, t, q, v)
    value, d_q, d_v = _stack(system, fixed, t, q, v)
    residual = np.concatenate([residual, value - np.array([x.value for x in fixed])])
    J = _stacked(system.Phi_q(t, q), d_q) if velocity is None else _stacked(system.velocity_jacobian(t, q, v), d_v)
    alike = np.abs(without_units(J, residual, system.tables.scale)[1])  # metres and radians are comparable
    wrong: list[tuple[float, str, Span | None]] = []
    where: dict[str, tuple[str, str, slice]] = {}
    ranges = [(name, row, system.scene.components[name].kind.rows) for name, row in system.tables.rows.items()]  # type: ignore[attr-defined]
    if velocity is not None:
        for name, row in system.tables.velocity_rows.items():
            ranges.append((name, row, len(system.scene.components[name].velocity_constraints)))
    for name, row, count in ranges:
        component, part = system.scene.components[name], slice(row, row + count)
        kind, most = component.kind, np.abs(residual[part]).max()
        text = f"{kind.name} {name} is violated by {_with_units(most, kind, velocity)}"
        wrong.append((float(alike[part].max()), text, component.span))
        where[text] = kind.name, name, part
    for item, x, size in zip(fixed, value, alike[len(alike) - len(fixed) :], strict=True):
        text = f"{item.name} = {item.unit.text(item.value)} is fixed, but comes out as {item.unit.text(x)}"
        wrong.append((float(size), text, item.span))
    wrong.sort(key=lambda w: -w[0])
    wrong = [w for w in wrong if w[0] > 1e-3 * wrong[0][0]][:6]  # relative: the largest misfit may be tiny
    if system.scene.spatial and velocity is None and not interrupted:
        wrong = [
            (w, _opened(system, t, q, fixed, *where[text]) if text in where else text, at) for w, text, at in wrong
        ]
    return InitialisationError(
        f"no consistent initial {level} found at time {t:g}",
        span=wrong[0][2] if wrong else None,
        notes=tuple((text, span) for _, text, span in wrong),
        hint="check lengths and fixed values; give guesses near the intended pose"
        if velocity is None
        else "fix fewer velocities, or make them fit the joints and drivers",
    )
