"""The System: the DAE of a mechanism, the only object that an integrator or an external backend sees.

    q' = v,   M(q) v' + Phi_q^T lam = Q(t, q, v),   Phi(q, t) = 0
"""

from __future__ import annotations

import subprocess
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl import layout
from mbdsl.graph import MechanismGraph
from mbdsl.graph import build as build_graph
from mbdsl.scene import Scene
from mbdsl.system import beside, emit
from mbdsl.system.emit import Kernels
from mbdsl.system.tables import Tables, build_tables

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]

#: up to this many unknowns matrices are handed out dense: importing scipy would take longer than using it
DENSE_LIMIT = 400


@dataclass
class Workspace:
    """The buffers of one computation; see :mod:`mbdsl.layout`."""

    Y: Array
    Z: Array
    C: Array
    F: Array
    I: NDArray[np.int64]


@dataclass
class System:
    """Sizes, kernels and numbers of one scene.

    The methods here evaluate single quantities, for initial values, output, tests and external backends; the step
    loop calls ``kernels.evaluate`` and ``kernels.tangent`` itself.
    """

    scene: Scene
    graph: MechanismGraph
    tables: Tables
    code: str = ""
    _kernels: dict[bool, Kernels] = field(default_factory=dict)
    _work: Workspace | None = None
    _A: Array | None = None

    @property
    def n(self) -> int:
        """Number of generalised coordinates."""
        return self.tables.n

    @property
    def m(self) -> int:
        """Number of holonomic constraints."""
        return self.tables.m

    @property
    def p(self) -> int:
        """Number of nonholonomic constraints."""
        return 0

    @property
    def size(self) -> int:
        """Number of entries of A that tangent fills when slots are kept apart (one a request)."""
        return len(self.tables.pattern[0])

    def kernels(self, with_mu: bool = False) -> Kernels:
        """The compiled ``evaluate`` and ``tangent`` for this structure."""
        if with_mu not in self._kernels:
            self._kernels[with_mu] = emit.load(self.tables.blocks, self.tables.has_tape, with_mu)
        return self._kernels[with_mu]

    def module_name(self, with_mu: bool = False) -> str:
        """The name of the emitted module of this structure."""
        return emit.module_name(emit.emit(self.tables.blocks, self.tables.has_tape, with_mu))

    def compile_beside(self, with_mu: bool = False) -> subprocess.Popen | None:
        """Start to compile the kernels in another process."""
        return beside.start(self.tables.blocks, self.tables.has_tape, with_mu)

    def workspace(self, slots: NDArray[np.int64] | None = None) -> Workspace:
        """Fresh buffers. ``slots`` gives the position in A of every requested entry (default: one each)."""
        t = self.tables
        if slots is None:
            slots = np.arange(self.size)
        I = np.concatenate([t.I, slots.astype(np.int64)])
        I[layout.SLOTS] = len(t.I)
        Y = np.zeros((layout.ROWS, max(1, self.n + self.m)))
        Y[layout.SCALE, : self.n] = t.scale
        C = np.zeros((max(1, t.pair_rows), layout.GRADIENT_COLUMNS))
        return Workspace(Y, t.Z.copy(), C, t.F.copy(), I)

    # -- single quantities -----------------------------------------------------------------------------------
    def _at(self, t: float, q, v=None, lam=None, mu=None) -> Workspace:
        if self._work is None:
            self._work = self.workspace()
        w = self._work
        n = self.n
        w.Y[layout.Q, :n] = q
        w.Y[layout.V, :n] = 0.0 if v is None else v
        w.Y[layout.X, n : n + self.m] = 0.0 if lam is None else lam
        w.Y[layout.X2, n : n + self.m] = 0.0 if mu is None else mu
        with_mu = mu is not None or True in self._kernels  # either serves; what is loaded costs nothing
        self.kernels(with_mu).evaluate(float(t), w.Y, w.Z, w.C, w.F, w.I)
        return w

    def evaluate(self, t: float, q, v=None, lam=None) -> tuple[Array, Array, Array]:
        """f = Q - Phi_q^T lam (n,), Phi (m,) and Phi_q v + Phi_t (m,)."""
        Y, n = self._at(t, q, v, lam).Y, self.n
        return Y[layout.FP, :n].copy(), Y[layout.FP, n : n + self.m].copy(), Y[layout.GD, n : n + self.m].copy()

    def Q(self, t: float, q, v=None) -> Array:
        """Generalised applied force (n,)."""
        return self.evaluate(t, q, v)[0]

    def Phi(self, t: float, q) -> Array:
        """Position-level constraints (m,)."""
        return self.evaluate(t, q)[1]

    def Phi_t(self, t: float, q) -> Array:
        """Their partial derivative with respect to time (m,)."""
        return self.evaluate(t, q)[2]

    def constraint_force(self, t: float, q, mu) -> Array:
        """Phi_q^T mu (n,)."""
        return self._at(t, q, mu=mu).Y[layout.GD, : self.n].copy()

    def gradient_table(self) -> Array:
        """Rows of the gradient table (see :mod:`mbdsl.layout`) at the last state evaluated."""
        assert self._work is not None
        return self._work.C

    def mass(self) -> Array:
        """The diagonal of the mass matrix (n,)."""
        o = self.tables.I[layout.MASS]
        return self.tables.F[o : o + self.n].copy()

    def tangent(self, t: float, q, v=None, lam=None, *, cM=0.0, cK=0.0, cD=0.0, cP=0.0, cN=0.0) -> Array | csr_array:
        """[[cM M + cK K + cD D, Phi_q^T], [cP Phi_q + cN N, 0]] (n + m, n + m).

        K = (Phi_q^T lam - Q)_q, D = -Q_v, N = (Phi_q v)_q. Dense up to ``DENSE_LIMIT`` unknowns, sparse above.
        """
        w = self._at(t, q, v, lam)
        if self._A is None:
            self._A = np.zeros(self.size)
        self.kernels(True in self._kernels).tangent(float(t), cM, cK, cD, cP, cN, w.Y, w.Z, w.C, w.F, w.I, self._A)
        size = self.n + self.m
        rows, columns = self.tables.pattern
        if size <= DENSE_LIMIT:
            return np.bincount(rows * size + columns, self._A, size * size).reshape(size, size)
        from scipy.sparse import csr_array

        return csr_array((self._A.copy(), (rows, columns)), shape=(size, size))

    def Phi_q(self, t: float, q) -> Array | csr_array:
        """Constraint Jacobian (m, n)."""
        return self.tangent(t, q, cP=1.0)[self.n :, : self.n]

    def stiffness(self, t: float, q, v=None, lam=None) -> Array | csr_array:
        """K = (Phi_q^T lam - Q)_q (n, n)."""
        return self.tangent(t, q, v, lam, cK=1.0)[: self.n, : self.n]

    def damping(self, t: float, q, v=None) -> Array | csr_array:
        """D = -Q_v (n, n)."""
        return self.tangent(t, q, v, cD=1.0)[: self.n, : self.n]

    def Phi_v_q(self, t: float, q, v) -> Array | csr_array:
        """N = (Phi_q v)_q (m, n)."""
        return self.tangent(t, q, v, cN=1.0)[self.n :, : self.n]

    def gamma_c(self, t: float, q, v) -> Array:
        """Acceleration right-hand side (m,): Phi_q v' = gamma_c = -(Phi_q v)_q v - Phi_tt."""
        N = self.Phi_v_q(t, q, v)  # also runs the gradient tape, which holds u''
        Phi_tt = np.zeros(self.m)
        assert self._work is not None
        I, F = self._work.I, self._work.F
        for r in range(self.m):
            registers = I[I[layout.PAIRS] + layout.PAIR * r + 4]
            if registers >= 0:
                Phi_tt[r] = -F[I[layout.REGISTERS] + I[registers + 2]]
        return -(N @ np.asarray(v, float)) - Phi_tt

    def elimination_order(self) -> NDArray[np.int64]:
        """The order, from the graph, in which coordinates and constraints are eliminated (n + m,): new -> old."""
        order: list[int] = []
        for name in self.graph.elimination_order():
            component = self.scene.components[name]
            if name in self.tables.coordinates:
                first, count = self.tables.coordinates[name], len(component.kind.coordinates)
            else:
                first, count = self.n + self.tables.rows[name], component.kind.rows
            order.extend(range(first, first + count))
        return np.array(order, np.int64)

    def names(self) -> list[str]:
        """A name for each coordinate, e.g. "crank.phi" (n,)."""
        return [f"{b.name}.{key}" for b in self.scene.bodies() for key in b.kind.coordinates]

    def constraint_names(self) -> list[str]:
        """A name for each constraint, e.g. "O.Phi[1]" (m,)."""
        ordered = sorted(self.tables.rows.items(), key=lambda item: item[1])
        return [f"{j}.Phi[{k + 1}]" for j, _ in ordered for k in range(self.scene.components[j].kind.rows)]

    def describe(self) -> str:
        """Sizes and numbering, as text."""
        t = self.tables
        lines = [f"n = {self.n} coordinates, m = {self.m} holonomic constraints, p = {self.p} nonholonomic", ""]
        for body in self.scene.bodies():
            first = t.coordinates[body.name]
            keys = ", ".join(body.kind.coordinates)
            lines.append(f"q[{first}:{first + len(body.kind.coordinates)}]  {body.name} ({keys})")
        for name, first in sorted(t.rows.items(), key=lambda item: item[1]):
            kind = self.scene.components[name].kind
            lines.append(f"Phi[{first}:{first + kind.rows}]  {name} ({kind.name})")
        lines += ["", f"{len(t.frames)} frames: {', '.join(list(t.frames)[:40])}{' ...' if len(t.frames) > 40 else ''}"]
        return "\n".join(lines)


def build(scene: Scene, graph: MechanismGraph | None = None) -> System:
    """Scene to System: numbers, tables and the text of the specialised code; compiles nothing yet."""
    tables = build_tables(scene)
    mechanism = graph if graph is not None else build_graph(scene)
    return System(scene, mechanism, tables, emit.emit(tables.blocks, tables.has_tape, True))
