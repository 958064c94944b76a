"""The stabilised index-2 form: F(t, y, y') = 0 with y = [q; v; lam; mu], and its exact sparse Jacobian.

    W (q' - v) + Phi_q^T mu = 0             n
    M v' - f = 0                            n,  f = Q - Phi_q^T lam - Gam_v^T nu
    Phi = 0,  Gam = 0                       m + p
    Phi_q v + Phi_t = 0                     m

lam contains the multipliers of Phi and then nu, those of Gam; mu (m,) is zero in the exact solution and compensates for
the discretisation error of velocities. W is a constant diagonal of masses, so that lengths and angles are weighted as
in M. For a constraint that is left out, the equations are lam = 0 and mu = 0.

Source: C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985), 77-90.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import buffer_layout
from mbdsl.system.accelerations import balance
from mbdsl.system.system import System

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class StabilisedIndex2:
    """The residual F(t, y, y') of a system; call it. ``left_out`` are redundant constraints.

    Attributes
    ----------
    size : int
        Number of unknowns, 2 n + m + p + m.
    algebraic : (m + p + m,) of int
        Indices of multipliers in y, whose rates do not occur.
    pattern : (indices (nonzeros,), starts (size + 1,))
        Rows of the Jacobian's entries column by column, and starts of the columns: compressed columns (CSC).
    """

    def __init__(self, system: System, left_out: Sequence[int] = ()) -> None:
        self.system = system
        n, m, p = system.n, system.m, system.p
        self.n, self.size = n, 2 * n + m + p + m
        self.algebraic = np.arange(2 * n, self.size)
        self._out = np.array(sorted(left_out), np.int64)
        self._out2 = self._out[self._out < m]
        self._W: Array | None = None
        rows, columns = system.tables.pattern
        self._K = np.flatnonzero((rows < n) & (columns < n))
        self._U = np.flatnonzero((rows < n) & (columns >= n))
        self._J = np.flatnonzero((rows >= n) & (columns < n))
        self._H = self._J[rows[self._J] < n + m]  # holonomic ones among them
        self._mu = self._U[columns[self._U] < n + m]
        self._places()

    def _places(self) -> None:
        """The places in the Jacobian of the entries of ``_values``, in their order."""
        n, m, p = self.n, self.system.m, self.system.p
        r, c = self.system.tables.pattern
        K, U, J, H, mu, q = self._K, self._U, self._J, self._H, self._mu, np.arange(n)
        lam, rate = 2 * n, 2 * n + m + p  # first rows of [Phi; Gam] and of Phi_q v + Phi_t, columns of lam and mu
        blocks = [
            (q, q),  # W cj
            (q, n + q),  # -W
            (r[K], c[K]),  # (Phi_q^T mu)_q
            (r[mu], rate - n + c[mu]),  # Phi_q^T
            (n + r[K], c[K]),  # K'
            (n + r[K], n + c[K]),  # cj M + D
            (n + r[U], lam - n + c[U]),  # J^T - Q_lam
            (lam - n + r[J], c[J]),  # Phi_q, Gam_q
            (lam - n + r[J], n + c[J]),  # 0, Gam_v
            (rate - n + r[H], c[H]),  # (Phi_q v + Phi_t)_q
            (rate - n + r[H], n + c[H]),  # Phi_q
            (lam + self._out, lam + self._out),  # 1
            (rate + self._out2, rate + self._out2),  # 1
        ]
        rows, columns = (np.concatenate([block[k] for block in blocks]) for k in (0, 1))
        found, self._slots = np.unique(columns * self.size + rows, return_inverse=True)
        self.pattern = found % self.size, np.searchsorted(found, self.size * np.arange(self.size + 1))
        left_out = np.concatenate([lam + self._out, rate + self._out2])
        others = np.arange(len(rows)) < len(rows) - len(left_out)
        self._nothing = np.flatnonzero(others & (np.isin(rows, left_out) | np.isin(columns, left_out)))

    def join(self, q: Array, v: Array, lam: Array, mu: Array | None = None) -> Array:
        """y (size,)."""
        return np.concatenate([q, v, lam, np.zeros(self.system.m) if mu is None else mu])

    def split(self, y: Array) -> tuple[Array, Array, Array]:
        """q, v (n,) and lam (m + p,) of y, copies."""
        n, m = self.n, self.system.m
        return y[:n].copy(), y[n : 2 * n].copy(), y[2 * n : self.size - m].copy()

    def weights(self, t: float, q: Array) -> Array:
        """W (n,): the diagonal of M at the first evaluation; that of the heaviest coordinate for massless ones."""
        if self._W is None:
            n = self.n
            K = self.system.tangent(t, q, cM=1.0, cP=1.0)
            self._W = 1.0 / balance(self.system, K.diagonal()[:n], K[n:, :n])[:n] ** 2
        return self._W

    def _evaluate(self, t: float, y: Array):
        """The workspace with all of [f; Phi; Gam] and [Phi_q^T mu; Phi_q v + Phi_t] at y."""
        q, v, lam = self.split(y)
        mu = y[self.size - self.system.m :].copy()
        lam[self._out], mu[self._out2] = 0.0, 0.0
        return self.system._at(t, q, v, lam, mu)

    def __call__(self, t: float, y: Array, rate: Array) -> Array:
        """F(t, y, y') (size,)."""
        n, m, system = self.n, self.system.m, self.system
        W = self.weights(t, y[:n])
        w = self._evaluate(t, y)
        f, more = (
            w.vectors[buffer_layout.FORCE, : system.unknowns].copy(),
            w.vectors[buffer_layout.FORCE2, : n + m].copy(),
        )
        w.vectors[buffer_layout.UNKNOWN, :n] = rate[n : 2 * n]
        F = np.concatenate([W * (rate[:n] - y[n : 2 * n]) + more[:n], self._inertia(t) - f[:n], f[n:], more[n:]])
        lam = 2 * n
        F[lam + self._out] = y[lam + self._out]
        F[self.size - m + self._out2] = y[self.size - m + self._out2]
        return F

    def _inertia(self, t: float) -> Array:
        """M times the row UNKNOWN of vectors at the last evaluated state (n,)."""
        system, n = self.system, self.n
        w = system._work
        assert w is not None
        if not system.mass_is_diagonal:
            system._any_kernels(2).inertia(
                buffer_layout.TIMES, buffer_layout.UNKNOWN, buffer_layout.MX, w.vectors, w.numbers, w.layout
            )
            return system.mass() * w.vectors[buffer_layout.UNKNOWN, :n] + w.vectors[buffer_layout.MX, :n]
        return system.mass() * w.vectors[buffer_layout.UNKNOWN, :n]

    def jacobian(self, t: float, y: Array, rate: Array, cj: float) -> Array:
        """dF/dy + cj dF/dy' as entries (nonzeros,) in the order of ``pattern``."""
        n, system = self.n, self.system
        W = self.weights(t, y[:n])
        w = self._evaluate(t, y)
        w.vectors[buffer_layout.UNKNOWN, :n] = rate[n : 2 * n]
        coordinates = system.entries(t, cK=1.0, cA=1.0, cL=1.0, cP=1.0, cW=1.0).copy()
        velocities = system.entries(t, cM=cj, cD=1.0, cV=1.0).copy()
        rates = system.entries(t, cP=1.0).copy()
        of_rates = system.entries(t, cN=1.0).copy()
        K, U, J, H = self._K, self._U, self._J, self._H
        ones = np.ones(len(self._out) + len(self._out2))
        values = [cj * W, -W, self._of_mu(t, y), rates[self._mu], coordinates[K], velocities[K], coordinates[U]]
        values += [coordinates[J], velocities[J], of_rates[H], rates[H], ones]
        every = np.concatenate(values)
        every[self._nothing] = 0.0
        return np.asarray(np.bincount(self._slots, every, len(self.pattern[0])), float)

    def _of_mu(self, t: float, y: Array) -> Array:
        """(Phi_q^T mu)_q: the change of f's derivative when mu replaces lam, except in the laws of forces."""
        if not y[self.size - self.system.m :].any():
            return np.zeros(len(self._K))
        w = self._evaluate(t, y)
        nothing = buffer_layout.MULTIPLIED
        found = []
        for row in (buffer_layout.UNKNOWN2, nothing):
            w.vectors[nothing] = 0.0
            w.layout[buffer_layout.LAM_ROW] = row
            try:
                self.system._any_kernels(2).evaluate(float(t), w.vectors, w.frames, w.gradients, w.numbers, w.layout)
                found.append(self.system.entries(t, cK=1.0)[self._K].copy())
            finally:
                w.layout[buffer_layout.LAM_ROW] = buffer_layout.UNKNOWN
        return found[0] - found[1]
