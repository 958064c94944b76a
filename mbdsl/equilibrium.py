"""Static equilibria: where a mechanism stays when it is at rest.

    v = 0,   Q(t, q, 0, lam) - Phi_q^T lam - Gam_v^T nu = 0,   Phi(q, t) = 0

found by following the overdamped motion W q' = Q - Phi_q^T lam - Gam_v^T nu from the assembled positions on, downhill,
by implicit steps that grow into Newton's (pseudo-transient continuation, Kelley and Keyes, SIAM J. Numer. Anal. 35
(1998) 508, with steps accepted by the work of the forces as a trust region accepts them by a decrease). W measures
coordinates by the size of the mechanism. Where it ends on a saddle, it is pushed off along the most unstable direction.

Nonholonomic constraints hold as they do at rest: positions only move along directions that they allow, and their
forces are among the reactions. For gears and rolling this is what they mean for positions; for a knife edge the
equilibrium depends on where the motion started.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from mbdsl import graph as mechanism_graph
from mbdsl import jit
from mbdsl.elements.kind import JointKind
from mbdsl.errors import EquilibriumError, Span, UsageError
from mbdsl.lang.expressions import is_velocity_level
from mbdsl.saddle import Array, Matrix, Saddle, dense, largest, null_space, row_size, scaled
from mbdsl.scene import Scene
from mbdsl.simulation import as_scene
from mbdsl.system import System, build
from mbdsl.system.bodies import LARGEST_BEND
from mbdsl.system.initial import initial_position, redundant_rows
from mbdsl.system.system import DENSE_LIMIT
from mbdsl.trajectory import Trajectory
from mbdsl.wording import count, few

if TYPE_CHECKING:
    from mbdsl.builder import Builder

NEAR = 1e-9  #: what is left of forces, relative to the largest one, where plain Newton steps take over
ZERO = 1e-12  #: stiffness relative to the largest that counts as none
MOST = 1000  #: steps
FARTHEST = 1e7  #: sizes of the mechanism, or radians, beyond which something falls
PUSHES = 20  #: how often a saddle is left


@dataclass
class Equilibrium:
    """Where a mechanism stays.

    Attributes
    ----------
    system : System
        Of the scene as written.
    t : float [s]
    q : (n,) [m, rad]
    lam : (m + p,)
        Multipliers; the constraint force is -Phi_q^T lam - Gam_v^T nu. Zero in redundant rows.
    iterations : int
        Steps of the overdamped motion and Newton's.
    stability : str
        "stable", "indifferent" (some motion meets neither resistance nor help), "unstable", or "held" (the constraints
        leave nothing free).
    stiffness : float or None [J]
        The smallest eigenvalue of the stiffness (Phi_q^T lam - Q)_q on the directions that the constraints allow, in
        coordinates scaled by the size of the mechanism: only its sign means something. None where nothing is free.
    redundant : list of str
        Constraints that follow from the others.
    notes : list of str

    Examples
    --------
    ``equilibrium["pin.fy"]`` is a number; ``equilibrium.trajectory`` is a Trajectory of one point.
    """

    system: System
    t: float
    q: Array
    lam: Array
    iterations: int
    stability: str
    stiffness: float | None
    redundant: list[str]
    notes: list[str]
    left_out: tuple[int, ...] = field(default=(), repr=False)

    @property
    def scene(self) -> Scene:
        return self.system.scene

    @property
    def stable(self) -> bool:
        """Whether all that can move returns, or nothing can."""
        return self.stability in ("stable", "held")

    @cached_property
    def trajectory(self) -> Trajectory:
        """The equilibrium as a trajectory of one point: every signal by name, to be written as any other."""
        stats: dict = {"method": "static", "h": None, "tol": None, "status": "done", "iterations": self.iterations}
        stats |= {"stability": self.stability, "redundant": self.redundant}
        q, lam = self.q[None], self.lam[None]
        return AtRest(self.system, np.array([self.t]), q, np.zeros_like(q), lam, stats, (), self.left_out)

    def __getitem__(self, name: str) -> float:
        return float(self.trajectory[name][0])

    def select(self, patterns: Sequence[str]) -> list[str]:
        """Names of signals that match; see :meth:`mbdsl.trajectory.Trajectory.select`."""
        return self.trajectory.select(patterns)

    @property
    def poses(self) -> list[str]:
        """Names of the positions of all bodies; of those that deform, of their ends as well."""
        names = []
        for c in self.scene.bodies():
            names += [f"{c.name}.{key}" for key in c.kind.coordinates]
            if len(c.coordinates) > len(c.kind.coordinates):
                names += [f"{c.name}.{end}.{key}" for end in "ab" for key in c.kind.coordinates]
        return names

    @property
    def reactions(self) -> list[str]:
        """Names of the reactions of all joints."""
        names = []
        for c in self.scene.components.values():
            if isinstance(c.kind, JointKind):
                names += [f"{c.name}.{key}" for key in c.kind.reaction]
        return [name for name in names if name in self.trajectory]

    def __str__(self) -> str:
        known = {"held": "nothing can move"}.get(self.stability, self.stability)
        steps = count(self.iterations, "iteration")
        head = f"{self.scene.name}: equilibrium at t = {self.t:g} s, {known} ({steps})"
        table = [(name, self[name], self.trajectory.unit(name)) for name in (*self.poses, *self.reactions)]
        return "\n".join([head, *listed(table), *(f"note: {text}" for text in self.notes)])


class AtRest(Trajectory):
    """A trajectory whose points are not left: without accelerations."""

    @property
    def _motion(self) -> tuple[Array, Array]:  # type: ignore[override]
        return np.zeros_like(self.q), self._lam  # type: ignore[return-value]


def listed(rows: Sequence[tuple[str, float, str]], most: int = 120) -> list[str]:
    """Lines ``name value unit`` of what may be thousands."""
    width = max((len(name) for name, *_ in rows), default=0)
    size = dict[str, float]()
    for _, value, unit in rows:
        size[unit] = max(size.get(unit, 0.0), abs(value))
    # what is but rounding of others in the same unit is told as nothing; files have all digits
    rows = [(name, value if abs(value) > 1e-13 * size[unit] else 0.0, unit) for name, value, unit in rows]
    lines = [f"  {name:{width}} {value:13.6g} {unit}".rstrip() for name, value, unit in rows[:most]]
    return lines + ([f"  ... ({len(rows)} in all)"] if len(rows) > most else [])


def prepare(
    model: Scene | Builder | str | PathLike,
    parameters: Mapping[str, str | float] | None,
    without: Sequence[str],
    announce: Callable[[str], None] | None,
) -> tuple[System, mechanism_graph.MechanismGraph]:
    """The System of a model as written, with its code loaded or compiled, and its graph."""
    scene = as_scene(model, parameters, without)
    mechanism = mechanism_graph.build(scene)
    system = build(scene, mechanism)
    # what a simulation has left in the cache serves here as well
    sets = 2 if jit.is_compiled(system.module_name(2)) else 1
    if announce is not None and not jit.is_compiled(system.module_name(sets)):
        announce("compiling for the first time; the result is kept, later runs start at once ...")
    system.kernels(sets)
    return system, mechanism


def static(
    model: Scene | Builder | str | PathLike,
    *,
    start: float | None = None,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Equilibrium:
    """The equilibrium that ``model`` comes to from its initial positions, were it overdamped.

    Parameters
    ----------
    model : Scene, Builder or path
    start : float, optional [s]
        The time at which drivers and forces are taken; default the model's start time.
    without : sequence of str, optional
        Effects to leave out, for a model given by path.
    parameters : mapping, optional
        Overrides of the model's parameters, for a model given by path.
    announce : callable, optional
        Told what takes long before it starts.

    Raises
    ------
    ModelError, UsageError
        If model or arguments make no sense.
    InitialisationError
        If the mechanism cannot be assembled.
    EquilibriumError
        If something keeps moving; the message names it.
    """
    system, mechanism = prepare(model, parameters, without, announce)
    t = float(system.scene.experiment.start if start is None else start)
    if not np.isfinite(t):
        raise UsageError(f"start = {t} is not a finite number")
    return settle(system, t, initial_position(system, mechanism, t))


def settle(system: System, t: float, q: Array) -> Equilibrium:
    """The equilibrium of ``system`` at time ``t`` that overdamped motion from ``q`` leads to."""
    notes = _at_rest(system, t, q)
    search = Search(system, t, q)
    pushes = 0
    while True:
        search.descend()
        stiffness, zero, directions = search.stability()
        if stiffness is None or stiffness >= -zero or pushes == PUSHES:
            break
        search.push(directions[:, 0], stiffness)
        pushes += 1
        if pushes == 1 and search.iterations == 0:
            notes.append("the start is an unstable equilibrium, which the slightest push leaves: so was done")
    if pushes == PUSHES:
        notes.append(f"pushed off {PUSHES} saddles, and came to another")
    if stiffness is None:
        stability = "held"
    elif stiffness < -zero:
        stability = "unstable"
    elif stiffness <= zero:
        stability = "indifferent"
        names = _movers(system, np.abs(directions).max(axis=1))
        notes.append(f"indifferent: nothing resists a motion of {few(names)}, which stays where it starts")
    else:
        stability = "stable"
    if not search.symmetric:
        notes.append("some forces have no potential: whether it oscillates away, only eigenvalues tell (mbdsl eigen)")
    q, lam, left_out = search.q, search.lam, redundant_rows(system, t, search.q, np.zeros(system.n))
    if left_out:
        lam = _without(system, t, q, lam, left_out)
    for name, body in system.tables.models.items():
        d = system.tables.coordinates[name]
        (angle,) = body.bend(q[None, d : d + body.n])
        if angle > LARGEST_BEND:
            raise EquilibriumError(
                f"{name} bends by {angle:.2g} rad: in a floating frame deformation is taken as small",
                system.scene.components[name].span,
                hint='formulation = "ancf" takes deformation as large',
            )
    names = [system.constraint_names()[k] for k in left_out]
    if names:
        notes.append(
            f"redundant: {few(names)} {'follows' if len(names) == 1 else 'follow'} from the other constraints; "
            "how the reactions share the load there is not determined"
        )
    return Equilibrium(system, t, q, lam, search.iterations, stability, stiffness, names, notes, left_out)


def _at_rest(system: System, t: float, q: Array) -> list[str]:
    """Notes on what moves at the start, or cannot be told by positions."""
    notes = []
    moving = [x.name for x in system.scene.initial if is_velocity_level(x.target) and x.value != 0.0]
    names = system.constraint_names()
    rates = np.concatenate([system.Phi_t(t, q), system.Gam(t, q, np.zeros(system.n))])
    moving += list(dict.fromkeys(names[k].rsplit(".", 1)[0] for k in np.flatnonzero(rates)))
    if moving:
        notes.append(f"taken at rest, at t = {t:g} s: {few(moving)}")
    if system.p:
        held = list(dict.fromkeys(name.rsplit(".", 1)[0] for name in names[system.m :]))
        notes.append(f"held as at rest, by forces: what {few(held)} says of velocities")
    return notes


def _without(system: System, t: float, q: Array, lam: Array, left_out: tuple[int, ...]) -> Array:
    """The same constraint force with multipliers that are zero in the rows left out, of which there are few."""
    J = dense(system.velocity_jacobian(t, q, np.zeros(system.n)))
    kept = np.delete(np.arange(len(lam)), left_out)
    J = J / system.tables.scale
    found = np.zeros(len(lam))
    found[kept] = lam[kept] + np.linalg.lstsq(J[kept].T, J[list(left_out)].T @ lam[list(left_out)], rcond=1e-12)[0]
    return found


def _movers(system: System, size: Array) -> list[str]:
    """Names of the bodies whose scaled coordinates have the largest entries of ``size`` (n,)."""
    largest = float(size.max(initial=0.0))
    names = [name.rsplit(".", 1)[0] for name in system.names()]
    return list(dict.fromkeys(name for name, s in zip(names, size, strict=True) if s >= 0.1 * largest > 0.0))


class Search:
    """A point of the overdamped motion, and how it goes on.

    ``g`` (n,) is the scaled velocity of overdamped motion, W g = f with f = Q - Phi_q^T lam - Gam_v^T nu and the
    multipliers that keep it to what the constraints allow: zero in equilibrium. It has the unit of energy, as have
    ``size``, the largest force, and ``kappa``, the largest stiffness, in scaled coordinates.
    """

    def __init__(self, system: System, t: float, q: Array) -> None:
        self.system, self.t, self.scale = system, t, system.tables.scale
        self.still = np.zeros(system.n)
        self.start, self.iterations, self.symmetric = q, 0, True
        self.longest, self.shift = 0.3, 0.0  # of a step; and what was added to the stiffness for the last one
        self._go(self._at(q, np.zeros(system.m + system.p)))

    # -- points ------------------------------------------------------------------------------------------------
    def _at(self, q: Array, lam: Array) -> _Point:
        """The point q with the multipliers that balance most; ``lam`` is what they may depend on through forces."""
        system, n, t = self.system, self.system.n, self.t
        f = system.evaluate(t, q, self.still, lam)[0]
        if not np.isfinite(f).all():
            where = "where it starts" if not self.iterations else f"after {count(self.iterations, 'step')}"
            raise EquilibriumError(
                f"the forces at t = {t:g} s are not finite numbers {where}",
                hint="an expression divides by zero or leaves the domain of a function there",
            )
        A = system.tangent(t, q, self.still, lam, cL=1.0, cP=1.0, cV=1.0)
        U, J = A[:n, n:], A[n:, :n]
        x, more = Saddle(self._metric(), U, J, self.scale).solve(f)
        lam = lam + more
        return _Point(q, lam, x * self.scale, system.evaluate(t, q, self.still, lam)[0] + J.T @ lam, U, J)

    def _go(self, point: _Point) -> None:
        self.point, n = point, self.system.n
        self.q, self.lam, self.g = point.q, point.lam, point.g
        self.K = self.system.tangent(self.t, self.q, self.still, self.lam, cK=1.0)[:n, :n]
        self.kappa = largest(self._scaled(self.K))
        inner = point.J.T @ point.lam
        forces = np.abs(np.concatenate([point.Q, inner])) / np.tile(self.scale, 2)
        # springs that balance each other leave but rounding of what they are
        self.size = max(float(forces.max(initial=0.0)), 1e-4 * self.kappa)

    def _scaled(self, A: Matrix) -> Matrix:
        return scaled(A, 1.0 / self.scale, 1.0 / self.scale)

    def _metric(self, by: float = 1.0) -> Matrix:
        """W times a factor."""
        if self.system.unknowns <= DENSE_LIMIT:
            return np.diag(by * self.scale**2)
        from scipy.sparse import csr_array, diags_array

        return csr_array(diags_array(by * self.scale**2))

    # -- motion ------------------------------------------------------------------------------------------------
    def descend(self) -> None:
        """Follow the overdamped motion to an equilibrium."""
        while self.point.left > NEAR * self.size:
            if self.iterations >= MOST or np.abs((self.q - self.start) * self.scale).max() > FARTHEST:
                raise self._endless()
            self.iterations += 1
            for _ in range(30):
                step = self._step()
                there = self._restored(self.q + step, float(np.abs(step * self.scale).max()))
                ratio = self._agreement(step, there) if there is not None else 0.0
                if ratio > 0.1:
                    break
                self.longest = 0.3 * float(np.abs(step * self.scale).max())
            else:
                raise self._stuck()
            assert there is not None
            if ratio > 0.5:
                self.shift *= 0.1
                self.longest *= 2.5 if ratio < 2.0 else 1.0
            self._go(there)
        self._refine()

    def _step(self, newton: bool = False) -> Array:
        """The change of q (n,) of one implicit step: no longer than ``longest``, and downhill."""
        f = self.point.Q - self.point.J.T @ self.lam
        # what is free of forces and stiffness stays where it is
        least = max(1e-10 * self.kappa, 1e-3 * self.point.left / self.longest)
        shift = 1e-10 * self.kappa if newton else self.shift
        for _ in range(60):
            step, _mu = Saddle(self.K + self._metric(shift), self.point.U, self.point.J, self.scale).solve(f)
            x = step * self.scale
            length = float(np.abs(x).max(initial=0.0))
            if newton or (x @ self.g > 0.0 and length <= 1.2 * self.longest):
                break
            longer = length / self.longest if np.isfinite(length) and x @ self.g > 0.0 else 4.0
            shift = max(least, shift * min(10.0, max(2.0, longer)))
        else:
            raise self._stuck()
        self.shift = shift
        return step

    def _restored(self, q: Array, length: float) -> _Point | None:
        """The point near q that satisfies the constraints; None if there is none within ``length`` (scaled)."""
        system, n, t, first = self.system, self.system.n, self.t, q
        tolerance = 1e-13 * (1.0 + float(np.abs(q * self.scale).max(initial=0.0)))
        before = np.inf
        for _ in range(12 if system.m + system.p else 0):
            J = system.tangent(t, q, self.still, cP=1.0, cV=1.0)[n:, :n]
            c = system.Phi(t, q)
            if system.p:  # what only velocities know of: the change of positions has to obey it halfway
                J_half = system.tangent(t, (q + self.q) / 2, self.still, cV=1.0)[n + system.m :, :n]
                c = np.concatenate([c, J_half @ (q - self.q)])
            open_ = float(np.abs(c / row_size(scaled(J, np.ones(len(c)), 1.0 / self.scale))).max(initial=0.0))
            if not np.isfinite(open_) or open_ <= tolerance or (open_ >= before and open_ <= 1e3 * tolerance):
                break
            before = open_
            q = q + Saddle(self._metric(), J.T, J, self.scale).solve(np.zeros(n), -c)[0]
            if not np.abs((q - first) * self.scale).max() <= length:
                return None
        else:
            if system.m + system.p and not open_ <= 1e3 * tolerance:
                return None
        return self._at(q, self.lam)

    def _agreement(self, step: Array, there: _Point) -> float:
        """The work of applied forces over what the tangent promised; 1 where rounding hides both."""
        promised = self.g @ (step * self.scale) - 0.5 * step @ (self.K @ step)
        change = there.q - self.q
        work = 0.5 * (self.point.Q + there.Q) @ change
        if promised <= 1e-11 * float(np.abs(self.point.Q * change).sum()) or there.left <= 0.1 * self.point.left:
            return 1.0 if there.left <= 2.0 * self.point.left else 0.0
        return float(work / promised)

    def _refine(self) -> None:
        """Newton's steps as long as they leave less."""
        for _ in range(10):
            if self.point.left == 0.0:
                return
            step = self._step(newton=True)
            length = float(np.abs(step * self.scale).max(initial=0.0))
            there = self._restored(self.q + step, 1e-3) if length < 1e-2 else None
            if there is None or there.left >= self.point.left:
                return
            enough = there.left > 0.5 * self.point.left
            self._go(there)
            if enough:
                return

    def push(self, direction: Array, stiffness: float) -> None:
        """Leave a saddle along ``direction`` (n,), scaled, of the given negative stiffness."""
        direction = direction / direction[np.abs(direction).argmax()]
        self.longest, self.shift = 0.3, 2.0 * abs(stiffness)
        for size in 0.05 * 0.3 ** np.arange(12):
            there = self._restored(self.q + size * direction / self.scale, size)
            if there is not None and (self.point.Q + there.Q) @ (there.q - self.q) > 0.0:
                self._go(there)
                return
        raise self._stuck()

    # -- what it has come to -----------------------------------------------------------------------------------
    def stability(self) -> tuple[float | None, float, Array]:
        """The smallest stiffness along what constraints allow [J], below what it counts as none, and directions.

        Directions (n, k) in scaled coordinates are those without stiffness, or that of the smallest where it is below
        zero. For large systems the stiffnesses next to zero are looked at, and the far end of those below.
        """
        K = self._scaled(self.K)
        self.symmetric = largest(K - K.T) <= 1e-9 * self.kappa
        zero = ZERO * self.kappa
        values, vectors = self._all(K) if isinstance(K, np.ndarray) else self._few(K)
        if not len(values):
            return None, zero, vectors
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
        chosen = [0] if values[0] < -zero else np.flatnonzero(values <= zero)
        return float(values[0]), zero, vectors[:, chosen]

    def _all(self, K: Array) -> tuple[Array, Array]:
        J, U = scaled(dense(self.point.J), np.ones(len(self.lam)), 1.0 / self.scale), dense(self.point.U)
        Z = null_space(J / row_size(J)[:, None])
        if not Z.shape[1]:
            return np.zeros(0), Z
        L, U = Z, (U / self.scale[:, None]).T
        if not np.array_equal(U, J):
            L = null_space(U / row_size(U)[:, None])
        reduced = np.linalg.solve(L.T @ Z, L.T @ K @ Z)
        if largest(reduced - reduced.T) <= 1e-9 * self.kappa:
            values, y = np.linalg.eigh((reduced + reduced.T) / 2)
            return values, Z @ y
        found, y = np.linalg.eig(reduced)
        self.symmetric = False
        return found.real, Z @ y.real

    def _few(self, K: Matrix) -> tuple[Array, Array]:
        from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, eigsh

        n = self.system.n
        sigma = -1e-9 * self.kappa
        inverse = Saddle(self.K + self._metric(-sigma), self.point.U, self.point.J, self.scale)
        onto = Saddle(self._metric(), self.point.J.T, self.point.J, self.scale)
        k, v0 = min(6, n - 2), np.random.default_rng(0).normal(size=n)

        def allowed(x: Array) -> Array:
            return self.scale * onto.solve(self.scale * x)[0]

        if np.abs(allowed(v0)).max() <= 1e-9:  # nothing is free
            return np.zeros(0), np.zeros((n, 0))
        solve = eigsh if self.symmetric else eigs
        near = LinearOperator((n, n), lambda x: self.scale * inverse.solve(self.scale * x)[0], dtype=float)
        far = LinearOperator((n, n), lambda x: allowed(K @ allowed(x)), dtype=float)
        values, vectors = solve(near, k, v0=v0)
        free = np.abs(values) > 1e-12 / self.kappa  # what constraints forbid has none
        values, vectors = (1.0 / values[free]).real + sigma, vectors[:, free].real
        try:
            below, down = solve(far, 1, which="SA" if self.symmetric else "SR", v0=v0, tol=1e-2, maxiter=300)
        except ArpackNoConvergence:
            return values, vectors
        if below[0].real < -1e-6 * self.kappa:
            values, vectors = np.append(values, below.real), np.hstack([vectors, down.real])
        return values, vectors

    # -- what may go wrong ---------------------------------------------------------------------------------------
    def _endless(self) -> EquilibriumError:
        names = _movers(self.system, np.abs(self.g))
        return EquilibriumError(
            f"no equilibrium: {few(names)} {'keeps' if len(names) == 1 else 'keep'} moving",
            self._span(names),
            hint="what acts on it meets no resistance that grows; a spring, a joint or a driver would hold it",
        )

    def _stuck(self) -> EquilibriumError:
        names = _movers(self.system, np.abs(self.g))
        return EquilibriumError(
            f"no equilibrium found after {count(self.iterations, 'step')}: forces still move {few(names)}",
            self._span(names),
            hint="a law that jumps has none where it does; in a singular pose, start from another one",
        )

    def _span(self, names: Sequence[str]) -> Span | None:
        return self.system.scene.components[names[0]].span if names else None


@dataclass(frozen=True)
class _Point:
    """Positions with what acts there: multipliers, the velocity g of overdamped motion, applied forces Q (n,), and how
    multipliers act, U (n, m + p) and J (m + p, n)."""

    q: Array
    lam: Array
    g: Array
    Q: Array
    U: Matrix
    J: Matrix

    @property
    def left(self) -> float:
        """What of the forces is not balanced."""
        return float(np.abs(self.g).max(initial=0.0))
