"""The stabilised index-2 form: F(t, y, y') = 0 with y = [x; v; lam; mu], and its exact sparse Jacobian.

    W (q' - v) + Phi_q^T mu = 0             n
    M v' - f = 0                            n,  f = Q - Phi_q^T lam - Gam_v^T nu
    Phi = 0,  Gam = 0                       m + p
    Phi_q v + Phi_t = 0                     m

lam contains the multipliers of Phi and then nu, those of Gam; mu (m,) is zero in the exact solution and compensates for
the discretisation error of velocities. W is a constant diagonal of masses, so that lengths and angles are weighted as
in M. For a constraint that is left out, the equations are lam = 0 and mu = 0.

In the plane x is q. In space it has quaternions p (:mod:`mbdsl.system.quaternions`), with four rows for each,

    W p' - E(p^)/2 (W v - Phi_q^T mu) = 0

The Jacobian follows from that of the form above, J_q, in which q is a small rotation: L J_q R + T. L turns rows from
world to body axes and multiplies by E(p^)/2, R is its counterpart in the columns, and T is the remainder in the
columns of p.

Source: C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985), 77-90.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.kernels import buffer_layout
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.system.accelerations import balance
from mbdsl.system.quaternions import Quaternions
from mbdsl.system.system import System

Indices = Integers


class StabilisedIndex2:
    """The residual F(t, y, y') of a system; call it. ``left_out`` are redundant constraints.

    Attributes
    ----------
    size : int
        Number of unknowns, 2 n + m + p + m, and one more for each rotation in space.
    algebraic : (m + p + m,) of int
        Indices of multipliers in y, whose rates do not occur.
    pattern : (indices (nonzeros,), starts (size + 1,))
        Rows of the Jacobian's entries column by column, and starts of the columns: compressed columns (CSC).
    """

    def __init__(self, system: System, left_out: Sequence[int] = ()) -> None:
        self.system = system
        n, m, p = system.n, system.m, system.p
        self.coordinates = Quaternions(n, system.tables.rotations[:, 0])
        self.n, self._flat = n, 2 * n + m + p + m
        self.size = self._flat - n + self.coordinates.size
        self.algebraic = np.arange(self.coordinates.size + n, self.size)
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
        found, self._slots = np.unique(columns * self._flat + rows, return_inverse=True)
        self.pattern = found % self._flat, np.searchsorted(found, self._flat * np.arange(self._flat + 1))
        left_out = np.concatenate([lam + self._out, rate + self._out2])
        others = np.arange(len(rows)) < len(rows) - len(left_out)
        self._nothing = np.flatnonzero(others & (np.isin(rows, left_out) | np.isin(columns, left_out)))
        if self.coordinates.size > n:
            self._flat_pattern = self.pattern
            self._places_in_space()

    def _places_in_space(self) -> None:
        """The places of L and R, with ones for the entries that are constant; the pattern of the Jacobian."""
        n, x, flat = self.n, self.coordinates, self._flat
        turns = self.system.tables.rotations[:, :1] + np.arange(3)
        later, others = x.size - n, np.setdiff1d(np.arange(flat), np.concatenate([turns, n + turns]))
        #: places in y and in the unknowns of J_q: of quaternions, of spins, and of all others
        self._pairs = (x.places, turns), (x.size + turns, n + turns)
        self._same = np.where(others < n, others, others + later), others
        k = len(turns)
        J = self._lifted(np.ones(len(self.pattern[0])), np.ones((k, 3, 3)), np.ones((k, 4, 3)), np.ones((k, 3, 4)))
        J = J + self._on_quaternions(np.ones((k, 4, 4)))
        J.sort_indices()
        self.pattern = J.indices.astype(np.int64), J.indptr.astype(np.int64)

    def join(self, q: Array, v: Array, lam: Array, mu: Array | None = None) -> Array:
        """y (size,)."""
        return np.concatenate([self.coordinates.join(q), v, lam, np.zeros(self.system.m) if mu is None else mu])

    def rates(self, y: Array, a: Array) -> Array:
        """y' (size,) for the accelerations a (n,) and constant multipliers."""
        first = self.coordinates.size
        x = self.coordinates.rates(y[:first], y[first : first + self.n])
        return np.concatenate([x, a, np.zeros(self.size - first - self.n)])

    def split(self, y: Array) -> tuple[Array, Array, Array]:
        """q, v (n,) and lam (m + p,) of y, copies."""
        n, m, first = self.n, self.system.m, self.coordinates.size
        return self.coordinates.split(y[:first]), y[first : first + n].copy(), y[first + n : self.size - m].copy()

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
        n, m, system, first = self.n, self.system.m, self.system, self.coordinates.size
        W, x, v = self.weights(t, self.coordinates.split(y[:first])), y[:first], y[first : first + n]
        w = self._evaluate(t, y)
        f, more = (
            w.vectors[buffer_layout.FORCE, : system.unknowns].copy(),
            w.vectors[buffer_layout.FORCE2, : n + m].copy(),
        )
        w.vectors[buffer_layout.UNKNOWN, :n] = rate[first : first + n]
        drift = self.coordinates.each(W, 1.0) * (rate[:first] - self.coordinates.rates(x, v))
        drift = drift + self.coordinates.rates(x, more[:n])
        F = np.concatenate([drift, self._inertia(t) - f[:n], f[n:], more[n:]])
        lam = first + n
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
        n, system, first = self.n, self.system, self.coordinates.size
        W = self.weights(t, self.coordinates.split(y[:first]))
        w = self._evaluate(t, y)
        more = w.vectors[buffer_layout.FORCE2, :n].copy()
        w.vectors[buffer_layout.UNKNOWN, :n] = rate[first : first + n]
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
        if first == n:
            return np.asarray(np.bincount(self._slots, every, len(self.pattern[0])), float)
        return self._in_space(every, W, more, y, cj)

    # -- in space --------------------------------------------------------------------------------------------
    def _in_space(self, every: Array, W: Array, more: Array, y: Array, cj: float) -> Array:
        """The entries in the order of ``pattern``, from those of J_q."""
        x, own = self.coordinates, self.system.tables.rotations
        coordinates, v = y[: x.size], y[x.size : x.size + self.n]
        work = self.system._work
        assert work is not None
        attitudes = work.numbers[own[:, 1:] + np.arange(9)].reshape(-1, 3, 3)
        values = np.asarray(np.bincount(self._slots, every, len(self._flat_pattern[0])), float)
        lifting, lowering = x.lifting(coordinates), x.lowering(coordinates)
        weight = W[own[:, 0]][:, None, None]
        rest = cj * weight * (np.eye(4) - lifting @ lowering) - x.turning(coordinates, W * v - more)
        J = self._lifted(values, attitudes, lifting, lowering) + self._on_quaternions(rest)
        rows, starts = self.pattern
        at = J.tocoo()
        keys = np.repeat(np.arange(self.size), np.diff(starts)) * self.size + rows
        found = np.zeros(len(rows))
        np.add.at(found, np.searchsorted(keys, at.col.astype(np.int64) * self.size + at.row), at.data)
        return found

    def _lifted(self, values: Array, attitudes: Array, lifting: Array, lowering: Array):
        """L J_q R (size, size) of the entries of J_q, the matrices (rotations, 3, 3) of attitudes, and ``lifting`` and
        ``lowering`` of the coordinates; compressed columns."""
        from scipy.sparse import csc_array

        back = np.swapaxes(attitudes, 1, 2)
        left = zip(self._pairs, (lifting @ back, back), strict=True)
        right = zip(self._pairs, (attitudes @ lowering, attitudes), strict=True)
        L = self._scattered((self.size, self._flat), [(rows, columns, B) for (rows, columns), B in left], self._same)
        R = self._scattered(
            (self._flat, self.size), [(rows, columns, B) for (columns, rows), B in right], self._same[::-1]
        )
        return csc_array(L @ csc_array((values, *self._flat_pattern), shape=(self._flat,) * 2) @ R)

    def _on_quaternions(self, blocks: Array):
        """A matrix (size, size) with blocks (rotations, 4, 4) on its diagonal."""
        places = self.coordinates.places
        return self._scattered((self.size, self.size), [(places, places, blocks)], (places[:0, 0], places[:0, 0]))

    @staticmethod
    def _scattered(shape: tuple[int, int], blocks: list, ones: tuple[Indices, Indices]):
        """A matrix of blocks (k, r, c) at rows (k, r) and columns (k, c), with ones at the places ``ones``."""
        from scipy.sparse import csc_array

        rows, columns, values = [ones[0]], [ones[1]], [np.ones(len(ones[0]))]
        for r, c, B in blocks:
            rows.append(np.repeat(r, c.shape[1], axis=1).ravel())
            columns.append(np.tile(c, (1, r.shape[1])).ravel())
            values.append(B.ravel())
        return csc_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)

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
