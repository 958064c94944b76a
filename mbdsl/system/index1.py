"""The index-1 reduction: y' = f(t, y) with y = [x; v], from the equations at acceleration level.

    q' = v,   [[M, J^T], [J, 0]] [v'; lam] = [Q; gamma_c],   J = [Phi_q; Gam_v]

Exact solutions satisfy Phi = 0, Phi_q v + Phi_t = 0 and Gam = 0 if they do so initially; numerical ones drift.
``project`` corrects them by the smallest change in the norm of the masses, with one linear system for both levels:

    [[M, J^T], [J, 0]] [dq, dv; ...] = -[0, 0; (Phi, 0), (Phi_q v + Phi_t, Gam)],   repeated until convergence

In the plane, x is q; in space it has quaternions (:mod:`mbdsl.system.quaternions`).

Source: the reduction is classical; projection onto invariants: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical
Integration* (2006), section IV.4; in the norm of the masses: C. Lubich, BIT 31 (1991), 545-550.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import refined
from mbdsl.system.accelerations import balance
from mbdsl.system.quaternions import Quaternions
from mbdsl.system.system import System

#: relative change of coordinates at which a projection has converged
ARRIVED = 1e-12
#: largest number of iterations of a projection, and of accelerations if forces depend on multipliers
MOST = 20
#: solutions larger than this, in balanced units, come from a singular matrix
SINGULAR = 1e8


class Index1:
    """The right-hand side f of y' = f(t, y); call it. ``left_out`` are redundant constraints, with zero multipliers.

    Attributes
    ----------
    evaluations : int
        Number of evaluations of f.
    """

    def __init__(self, system: System, left_out: Sequence[int] = ()) -> None:
        self.system, self.n = system, system.n
        self.evaluations = 0
        self.coordinates = Quaternions(system.n, system.tables.rotations[:, 0])
        rows = np.delete(np.arange(system.m + system.p), list(left_out))
        self._kept = np.concatenate([np.arange(self.n), self.n + rows])
        self._all = len(rows) == system.m + system.p
        self._d: Array | None = None

    def join(self, q: Array, v: Array) -> Array:
        """y (x and v) of q and v (n,)."""
        return np.concatenate([self.coordinates.join(q), v])

    def split(self, y: Array) -> tuple[Array, Array]:
        """q and v (n,) of y, copies."""
        size = self.coordinates.size
        return self.coordinates.split(y[:size]), y[size:].copy()

    def __call__(self, t: float, y: Array) -> Array:
        """f(t, y), as y; nan if forces are not finite or accelerations do not exist."""
        self.evaluations += 1
        q, v = self.split(y)
        return np.concatenate([self.coordinates.rates(y[: self.coordinates.size], v), self.motion(t, q, v)[0]])

    def motion(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Accelerations a (n,) and multipliers lam (m + p,) at a state; nan if they do not exist."""
        system, n = self.system, self.n
        work = system._at(t, q, v)
        gamma: Array | None = None
        lam = np.zeros(system.m + system.p)
        size = 0.0
        for _ in range(MOST):
            force = work.vectors[L.FORCE, :n].copy()
            K = self._matrix(t, 1.0)
            if gamma is None:
                gamma = system.gamma_c_here(np.asarray(v), system.entries(t, cN=1.0, cW=1.0))
            # forces are linearised about lam, and the unknown is its change
            x = self._solve(K, np.concatenate([force, gamma])[self._kept])
            change = np.zeros(n + len(lam))
            change[self._kept] = x
            lam = lam + change[n:]
            size = max(size, float(np.abs(lam).max(initial=0.0)))
            if not system.of_multipliers or np.abs(change[n:]).max(initial=0.0) <= 1e-12 * size:
                return change[:n], lam
            work = system._at(t, q, v, lam)
        return np.full(n, np.nan), np.full(len(lam), np.nan)

    def project(self, t: float, y: Array) -> Array:
        """The state, as y, nearest to ``y`` that satisfies the constraints of positions and velocities.

        If there is none, the last iterate is returned; it violates the constraints or is nan.
        """
        system, n, m = self.system, self.n, self.system.m
        x, v = self.coordinates.units(y[: self.coordinates.size]), y[self.coordinates.size :]
        if not m and not system.p:
            return np.concatenate([x, v])
        scale = np.concatenate([system.tables.scale] * 2)
        for _ in range(MOST):
            work = system._at(t, self.coordinates.split(x), v)
            right = np.zeros((n + m + system.p, 2))
            right[n : n + m, 0] = -work.vectors[L.FORCE, n : n + m]
            right[n : n + m, 1] = -work.vectors[L.FORCE2, n : n + m]
            right[n + m :, 1] = -work.vectors[L.FORCE, n + m : system.unknowns]
            change = self._solve(self._matrix(t, 0.0), right[self._kept])[:n].T.ravel()
            x, v = self.coordinates.moved(x, change[:n]), v + change[n:]
            speed = 1.0 + np.abs(v * scale[n:]).max(initial=0.0)
            size = np.abs(change * scale)
            if not max(size[:n].max(initial=0.0), size[n:].max(initial=0.0) / speed) > ARRIVED:
                break
        return np.concatenate([x, v])

    def _matrix(self, t: float, cL: float):
        """[[M, J^T - cL Q_lam], [J, 0]] of the last evaluated state, without rows and columns that are left out."""
        K = self.system.matrix(self.system.entries(t, cM=1.0, cL=cL, cP=1.0, cV=1.0))
        if self._all:
            return K
        return K[np.ix_(self._kept, self._kept)] if isinstance(K, np.ndarray) else K[self._kept][:, self._kept]

    def _solve(self, K, b: Array) -> Array:
        """x of K x = b, of least norm where K is singular."""
        if self._d is None:
            self._d = balance(self.system, K.diagonal()[: self.n], K[self.n :, : self.n])
        d = self._d
        b = (d * b.T).T
        if not np.isfinite(b).all():
            return np.full_like(b, np.nan)
        if not isinstance(K, np.ndarray):
            return (d * self._sparse(K, b).T).T
        K = d[:, None] * K * d
        if not np.isfinite(K).all():
            return np.full_like(b, np.nan)
        try:
            x = np.linalg.solve(K, b)
        except np.linalg.LinAlgError:
            x = np.full_like(b, np.nan)
        if not np.abs(x).max(initial=0.0) <= SINGULAR * np.abs(b).max(initial=0.0):
            x = np.linalg.lstsq(K, b, rcond=1e-13)[0]
        return (d * x.T).T

    def _sparse(self, K, b: Array) -> Array:
        """As above for a large K, balanced here."""
        from scipy.sparse import diags_array

        return refined(diags_array(self._d) @ K @ diags_array(self._d), self.n, b, times=2)
