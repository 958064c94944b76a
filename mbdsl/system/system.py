"""The System: the DAE of a mechanism. Integrators and external backends access the mechanism only through it.

    q' = v,   M(q) v' + Phi_q^T lam + Gam_v^T nu = Q(t, q, v, lam, nu, u),   Phi(q, t) = 0,   Gam(v, q, t) = 0

with m holonomic constraints Phi, p nonholonomic ones Gam and inputs u. One vector (m + p,) contains all multipliers,
those of Phi first; in what follows, ``lam`` is this vector.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.expressions.symbolic import Expr, const, substitute
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.kernels.factors import Factors
from mbdsl.mechanism.extreme_numbers import blame_extremes
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.graph import build as build_graph
from mbdsl.mechanism.scene import Scene
from mbdsl.storage.garbage_collection import uncollected
from mbdsl.system import emit, switches
from mbdsl.system.body_models import at_rest
from mbdsl.system.build_tables import build_tables
from mbdsl.system.compiled_scene import CompiledScene
from mbdsl.system.massless import massless
from mbdsl.system.peaks_in_time import Replayed, Zone, time_zones
from mbdsl.system.time_derivatives import TimeTerms
from mbdsl.system.time_events import time_events

if TYPE_CHECKING:
    from scipy.sparse import csr_array


#: up to this many unknowns matrices are dense: importing scipy would take longer than dense algebra
DENSE_LIMIT = 400


class System(CompiledScene):
    """Sizes, kernels and numbers of one scene.

    The methods here evaluate single quantities, for initial values, output, tests and external backends; the step
    loop calls ``kernels.evaluate`` and ``kernels.tangent`` itself.
    """

    def __reduce__(self) -> tuple:
        """Pickled as the arguments of ``build``, and the inputs and reference angles that are set; no compiled code."""
        turns = {name: body.turn for name, body in self.tables.models.items() if body.turn}
        there = [*self.tables.inputs.values(), *(b.counter for b in self.tables.models.values() if b.counter >= 0)]
        numbers = {} if self._work is None else {at: float(self._work.numbers[at]) for at in there}
        return _rebuilt, (self.scene, self._built, turns, numbers, self.tables.first_angles)

    def __repr__(self) -> str:
        return f"<System of {self.scene.name}: n = {self.n}, m = {self.m}, p = {self.p}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        numbering = TextTable("", ("entries", "component", "coordinates or kind"), self._numbering())
        return fragment(f"{self.scene.name}: {self._sizes()}", (), [numbering], [self._frames()])

    def evaluate(self, t: float, q, v=None, lam=None) -> tuple[Array, Array, Array]:
        """f = Q - Phi_q^T lam - Gam_v^T nu (n,), Phi (m,) and Phi_q v + Phi_t (m,)."""
        vectors, n = self._at(t, q, v, lam).vectors, self.n
        return (
            vectors[L.FORCE, :n].copy(),
            vectors[L.FORCE, n : n + self.m].copy(),
            vectors[L.FORCE2, n : n + self.m].copy(),
        )

    def Q(self, t: float, q, v=None) -> Array:
        """Generalised applied force (n,), without the part that depends on multipliers (see ``of_multipliers``)."""
        return self.evaluate(t, q, v)[0]

    @property
    def of_multipliers(self) -> bool:
        """Whether forces depend on multipliers, as friction in joints does."""
        return self.tables.of_multipliers

    def Gam(self, t: float, q, v) -> Array:
        """Nonholonomic constraints (p,)."""
        return self._at(t, q, v).vectors[L.FORCE, self.n + self.m : self.unknowns].copy()

    def constraint_rates(self, t: float, q, v) -> Array:
        """The rates of Phi, then Gam (m + p,)."""
        work, n = self._at(t, q, v).vectors, self.n
        return np.concatenate([work[L.FORCE2, n : n + self.m], work[L.FORCE, n + self.m : self.unknowns]])

    def Gam_v(self, t: float, q, v) -> Array | csr_array:
        """Their Jacobian (p, n) with respect to v."""
        return self.tangent(t, q, v, cV=1.0)[self.n + self.m :, : self.n]

    def Gam_q(self, t: float, q, v) -> Array | csr_array:
        """Their Jacobian (p, n) with respect to q."""
        return self.tangent(t, q, v, cW=1.0)[self.n + self.m :, : self.n]

    def counted_angles(self) -> dict[Expr, float]:
        """Angles of ``searched_laws`` that count turns, at the last accepted state."""
        numbers = self.tables.numbers if self._work is None else self._work.numbers
        return {node: float(numbers[at]) for node, at in self.searched_angles.items()}

    def Phi(self, t: float, q) -> Array:
        """Position-level constraints (m,)."""
        return self.evaluate(t, q)[1]

    def Phi_t(self, t: float, q) -> Array:
        """Their partial derivative with respect to time (m,)."""
        return self.evaluate(t, q)[2]

    def constraint_force(self, t: float, q, mu) -> Array:
        """Phi_q^T mu (n,)."""
        return self._at(t, q, mu=mu).vectors[L.FORCE2, : self.n].copy()

    def gradient_table(self) -> Array:
        """Rows of the gradient table (see :mod:`mbdsl.kernels.buffer_layout`) at the last state evaluated."""
        assert self._work is not None
        return self._work.gradients

    def mass(self) -> Array:
        """The constant part of the diagonal of the mass matrix (n,): all of M if there are rigid bodies only."""
        o = self.tables.layout[L.MASS]
        return self.tables.numbers[o : o + self.n].copy()

    @property
    def mass_is_diagonal(self) -> bool:
        return self.tables.layout[L.MASS_KIND] == 0

    def M(self, t: float, q) -> Array | csr_array:
        """Mass matrix (n, n)."""
        return self.tangent(t, q, cM=1.0)[: self.n, : self.n]

    def solve_mass(self, t: float, q, force: Array) -> Array:
        """M^{-1} force (n,); motions without mass are given a mass of 1."""
        mass = self.mass()
        if self.mass_is_diagonal:
            return force / np.where(mass > 0.0, mass, 1.0)
        M, free = self.M(t, q), massless(self.tables)
        if isinstance(M, np.ndarray):
            return np.asarray(np.linalg.solve(M + free @ free.T, force), float)
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        columns = csc_array(free)
        return splu(csc_array(M) + columns @ columns.T).solve(force)

    def tangent(self, t: float, q, v=None, lam=None, *, a=None, **factors: float) -> Array | csr_array:
        """The matrix (n + m + p, n + m + p) with some :class:`mbdsl.kernels.factors.Factors`, by their names; with an
        acceleration a (n,), cA is cK. Dense up to ``DENSE_LIMIT`` unknowns, sparse above.
        """
        w = self._at(t, q, v, lam)
        w.vectors[L.UNKNOWN, : self.n] = 0.0 if a is None else a
        return self.matrix(self.entries(t, **factors, cA=0.0 if a is None else factors.get("cK", 0.0)))

    def entries(self, t: float, **factors: float) -> Array:
        """The requested entries (size,) of the matrix of ``tangent`` at the last evaluated state; requests for the same
        place are separate entries.

        The acceleration a is that in row UNKNOWN of vectors. The array is overwritten by the next call.
        """
        w = self._work
        assert w is not None
        if self._A is None:
            self._A = np.zeros(self.size)
        buffers = w.vectors, w.frames, w.gradients, w.numbers, w.layout, self._A
        self._any_kernels(1).tangent(float(t), *Factors(**factors), *buffers)
        return self._A

    def matrix(self, entries: Array) -> Array | csr_array:
        """A new matrix with these entries (size,), dense up to ``DENSE_LIMIT`` unknowns."""
        size = self.unknowns
        rows, columns = self.tables.pattern
        if size <= DENSE_LIMIT:
            return self._in_body_axes(np.bincount(rows * size + columns, entries, size * size).reshape(size, size))
        from scipy.sparse import csr_array

        A = csr_array((entries.copy(), (rows, columns)), shape=(size, size))
        if not len(self.tables.rotations):
            return A
        from scipy.sparse import eye_array

        W, work = eye_array(size, format="lil"), self._work
        assert work is not None
        for d, at in self.tables.rotations:
            W[d : d + 3, d : d + 3] = work.numbers[at : at + 9].reshape(3, 3)
        return csr_array(W.T @ A @ W.tocsr())

    def force(self) -> Array:
        """f = Q - Phi_q^T lam - Gam_v^T nu (n,) at the state of the last tangent."""
        assert self._work is not None
        return self._work.vectors[L.FORCE, : self.n].copy()

    def Phi_q(self, t: float, q) -> Array | csr_array:
        """Constraint Jacobian (m, n)."""
        return self.tangent(t, q, cP=1.0)[self.n : self.n + self.m, : self.n]

    def stiffness(self, t: float, q, v=None, lam=None, a=None) -> Array | csr_array:
        """K = (Phi_q^T lam + Gam_v^T nu - Q)_q (n, n), and (M a)_q where an acceleration a (n,) is given."""
        return self.tangent(t, q, v, lam, cK=1.0, a=a)[: self.n, : self.n]

    def damping(self, t: float, q, v=None, lam=None) -> Array | csr_array:
        """D = (Gam_v^T nu - Q)_v (n, n)."""
        return self.tangent(t, q, v, lam, cD=1.0)[: self.n, : self.n]

    def Q_lam(self, t: float, q, v, lam) -> Array | csr_array:
        """Derivative (n, m + p) of forces with respect to multipliers."""
        with_, without = self.tangent(t, q, v, lam, cL=1.0, cV=1.0), self.tangent(t, q, v, lam, cV=1.0)
        return (without - with_)[: self.n, self.n :]

    def velocity_jacobian(self, t: float, q, v) -> Array | csr_array:
        """[Phi_q; Gam_v] (m + p, n), the factor of v' in the constraints at acceleration level."""
        return self.tangent(t, q, v, cP=1.0, cV=1.0)[self.n :, : self.n]

    def Phi_v_q(self, t: float, q, v) -> Array | csr_array:
        """N = (Phi_q v)_q (m, n)."""
        return self.tangent(t, q, v, cN=1.0)[self.n : self.n + self.m, : self.n]

    def gamma_c(self, t: float, q, v) -> Array:
        """Acceleration right-hand side (m + p,): [Phi_q; Gam_v] v' = gamma_c.

        gamma_c = -(Phi_q v)_q v - Phi_tt, then -Gam_q v - Gam_t.
        """
        self._at(t, q, v).vectors[L.UNKNOWN, : self.n] = 0.0
        return self.gamma_c_here(t, np.asarray(v, float))

    def gamma_c_here(self, t: float, v: Array) -> Array:
        """The same at the last evaluated state, whose velocities are v."""
        # also runs the gradient tape, which holds u'' and Gam_t
        rate = self.matrix(self.entries(t, cN=1.0, cW=1.0))[self.n :, : self.n] @ v
        return -rate - self.in_time()

    def in_time(self) -> Array:
        """The partial time derivatives in -gamma_c (m + p,), of drivers and Gam, at the state of the last tangent."""
        w = self._work
        assert w is not None
        if self._clock is None:
            self._clock = TimeTerms(w.layout, self.m, self.p)
        return self._clock(w)

    def switches(self, t: float, q, v, lam=None) -> Integers:
        """States of all switches in the expressions of the equations: conditions, signs, cells of tables.

        While they do not change, the equations of motion are smooth; a change between two states of a motion can be
        located by bisection. Empty if there are no switches. ``tables.switches`` lists their expressions; see
        :mod:`mbdsl.system.switches`.
        """
        if not self.tables.switches:
            return np.zeros(0, np.int64)
        w, found = self._at(t, q, v, lam), self.kept(_states)  # the same array: calls with new ones take longer
        switches.compiled()(w.numbers, w.layout, found)
        return found.copy()

    def quantities(self) -> Array:
        """The quantity whose sign decides each switch, at the last evaluated state; see
        :func:`mbdsl.system.switches.quantity`."""
        w = self._work
        assert w is not None
        registers = w.numbers[w.layout[L.REGISTERS] :]
        return np.array([switches.quantity(x, registers) for x in self.tables.quantities])

    def time_events(self, t0: float, t1: float, corners: bool = True) -> Iterator[float]:
        """The times t0 < t < t1 [s], ascending, at which switches that depend on time alone change; generated lazily.

        Without ``corners``, only those at which accelerations may jump: not at the knots of a linear table of forces.
        They are exact to a few units in the last place: end a step slightly before, and begin the next slightly after.
        They are found if the expressions are piecewise linear in time, such as `time < 1 s`, tables over time,
        mod(time, 1 s) < 0.2 s. Changes of others, such as sin(time) < 0, show in :meth:`switches` only.
        """
        chosen = [switch for switch in self.tables.switches if corners or not switch.is_corner]
        chosen = [replace(switch, node=substitute(switch.node, self._at_rest)) for switch in chosen]
        return time_events(chosen, t0, t1)

    def time_zones(self, t0: float, t1: float, longest: float = np.inf) -> Iterator[Zone]:
        """Zones between t0 and t1 [s] in which steps have to end because of functions of time; generated lazily.

        Each zone surrounds a pulse, a window or another extremum of a law, driver, table or condition that depends on
        time alone; in it, the value differs from the extremum by less than a quarter of its height (see
        :mod:`mbdsl.system.peaks_in_time`).
        Terms whose form shows that steps up to the ``longest`` [s] cannot pass over their extrema are left out.
        """
        key = t0, t1, longest
        if key not in self._zones:
            self.zones_end = []
            self._zones = {key: Replayed(time_zones(self.laws.values(), *key, self.zones_end))}
        return iter(self._zones[key])

    @cached_property
    def laws(self) -> dict[Expr, Expr]:
        """Every expression of the equations, and the same with numbers in place of coordinates of frames at rest."""
        return {x: substitute(x, self._at_rest) for x in self.tables.values}

    @cached_property
    def searched_laws(self) -> dict[Expr, Expr]:
        """What the user wrote as laws, which is searched for peaks along the motion.

        Rows of constraints by expression are zero at all states, and differ from zero between them by interpolation
        only: of them, the laws of drivers and abrupt functions are searched.
        """
        found = self.laws | {x: y and substitute(y, self._at_rest) for x, y in self.tables.row_laws.items()}
        return {x: law for x, law in found.items() if law is not None}

    @cached_property
    def searched_angles(self) -> dict[Expr, int]:
        """Angles of these laws that count turns -> offset in numbers of their value at the last accepted step."""
        return {substitute(node, self._at_rest): places[0] for node, places in self.tables.angles.items()}

    def _at_rest(self, x: Expr) -> Expr | None:
        """The value of a coordinate of a frame that does not move, or of an expression at the start."""
        if x.op == "start":
            return const(self.tables.first_angles.get(x, 0.0))
        if x.op != "coordinate":
            return None
        name, key = x.value
        frame = self.scene.frames[name]
        if frame.body in self.tables.models or frame.motion is not None:
            return None
        return const(at_rest(self.scene.components[frame.body], frame, key))

    def elimination_order(self) -> Integers:
        """The order, from the graph, in which coordinates and constraints are eliminated (n + m + p,): new -> old."""
        order: list[int] = []
        holding = {joint.name: joint.rows for joint in self.scene.sticking}
        for name in self.graph.elimination_order():
            component = self.scene.components[name]
            if name in self.tables.coordinates:
                order.extend(self.tables.coordinates[name] + i for i in self.tables.models[name].eliminate())
            if name in self.tables.rows:
                first = self.n + self.tables.rows[name]
                order.extend(range(first, first + component.kind.rows))
            order.extend(self.n + self.tables.rows[row] for row in holding.get(name, ()))
            if name in self.tables.velocity_rows:
                first = self.n + self.tables.velocity_rows[name]
                order.extend(range(first, first + len(component.velocity_constraints)))
        return np.array(order, np.int64)

    def names(self) -> list[str]:
        """A name for each coordinate, e.g. "crank.phi" (n,)."""
        return [f"{b.name}.{key}" for b in self.scene.with_coordinates() for key in b.coordinates]

    def constraint_names(self) -> list[str]:
        """A name for each constraint, e.g. "O.Phi[1]", and "skate.Gam[1]" for nonholonomic ones (m + p,)."""
        components = self.scene.components
        ordered = sorted(self.tables.rows.items(), key=lambda item: item[1])
        names = [f"{j}.Phi[{k + 1}]" for j, _ in ordered for k in range(self.tables.joint(j).kind.rows)]
        ordered = sorted(self.tables.velocity_rows.items(), key=lambda item: item[1])
        return names + [f"{j}.Gam[{k + 1}]" for j, _ in ordered for k in range(len(components[j].velocity_constraints))]

    def describe(self) -> str:
        """Sizes and numbering, as text."""
        rows = [f"{place}  {name} ({what})" for place, name, what in self._numbering()]
        return "\n".join([self._sizes(), "", *rows, "", self._frames()])

    def _sizes(self) -> str:
        return f"n = {self.n} coordinates, m = {self.m} holonomic constraints, p = {self.p} nonholonomic"

    def _frames(self) -> str:
        frames = self.tables.frames
        return f"{len(frames)} frames: {', '.join(list(frames)[:40])}{' ...' if len(frames) > 40 else ''}"

    def _numbering(self) -> list[tuple[str, str, str]]:
        """Entries of q, Phi and Gam, the component that they belong to, and its coordinates or kind."""
        t, found = self.tables, []
        for body in self.scene.with_coordinates():
            first = t.coordinates[body.name]
            found.append((f"q[{first}:{first + len(body.coordinates)}]", body.name, ", ".join(body.coordinates)))
        for name, first in sorted(t.rows.items(), key=lambda item: item[1]):
            kind = self.tables.joint(name).kind
            found.append((f"Phi[{first}:{first + kind.rows}]", name, kind.name))
        for name, first in sorted(t.velocity_rows.items(), key=lambda item: item[1]):
            component = self.scene.components[name]
            first -= self.m
            count = len(component.velocity_constraints)
            found.append((f"Gam[{first}:{first + count}]", name, component.kind.name))
        return found


def _states(system: System) -> Integers:
    """A buffer for the states of its switches."""
    return np.zeros(len(system.tables.switches), np.int64)


@blame_extremes
@uncollected
def build(
    scene: Scene, graph: MechanismGraph | None = None, general: bool = False, size: float | None = None
) -> System:
    """Build the System of a Scene: numbers, tables and the text of the specialised code; nothing is compiled yet.

    ``general`` code contains the loops of all kinds, whether or not the scene has them. ``size`` is that of the
    mechanism [m], if the scene is only a part of it.
    """
    tables = build_tables(scene, general, size)
    mechanism = graph if graph is not None else build_graph(scene)
    code = emit.emit(tables.blocks, tables.has_tape, 2)
    return System(scene, mechanism, tables, code, _built=(general, size))


def _rebuilt(
    scene: Scene,
    built: tuple[bool, float | None],
    turns: Mapping[str, float],
    numbers: Mapping[int, float],
    angles: Mapping[Expr, float],
) -> System:
    """A pickled System."""
    system = build(scene, None, *built)
    for node, angle in angles.items():
        system.set_first_angle(node, angle)
    for name, angle in turns.items():
        system.set_turn(name, angle)
    for at, value in numbers.items():
        system.set_number(at, value)
    return system
