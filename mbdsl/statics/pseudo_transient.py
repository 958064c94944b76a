"""Overdamped motion to an equilibrium: W q' = Q - Phi_q^T lam - Gam_v^T nu, from a given position.

The implicit steps become Newton steps as they grow (pseudo-transient continuation, Kelley and Keyes, SIAM J. Numer.
Anal. 35 (1998) 508). A step is accepted by comparing the work of the forces with its prediction, as a trust-region
method does with the decrease of a function. W scales coordinates by the size of the mechanism. The motion may end at a
saddle point; ``push`` leaves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbdsl.errors import EquilibriumError, Span
from mbdsl.messages import count, few
from mbdsl.numerics.saddle_point import Array, Matrix, Saddle, dense, largest, null_space, row_size, scaled
from mbdsl.system import System
from mbdsl.system.system import DENSE_LIMIT

NEAR = 1e-9  #: residual force, relative to the largest force, below which plain Newton steps are used
ZERO = 1e-12  #: stiffness, relative to the largest, that counts as zero
MOST = 1000  #: largest number of steps
FARTHEST = 1e7  #: displacement, in sizes of the mechanism or radians, above which a body is falling


def movers(system: System, size: Array) -> list[str]:
    """Names of the bodies whose scaled coordinates have the largest entries of ``size`` (n,)."""
    largest = float(size.max(initial=0.0))
    names = [name.rsplit(".", 1)[0] for name in system.names()]
    return list(dict.fromkeys(name for name, s in zip(names, size, strict=True) if s >= 0.1 * largest > 0.0))


class MotionSearch:
    """A point of the overdamped motion and its continuation.

    ``g`` (n,) is the scaled velocity of overdamped motion, W g = f with f = Q - Phi_q^T lam - Gam_v^T nu and the
    multipliers for which it satisfies the constraints: zero in equilibrium. It has the unit of energy, as have
    ``size``, the largest force, and ``kappa``, the largest stiffness, in scaled coordinates.
    """

    def __init__(self, system: System, t: float, q: Array) -> None:
        self.system, self.t, self.scale = system, t, system.tables.scale
        self.still = np.zeros(system.n)
        self.start, self.iterations, self.symmetric = q, 0, True
        self.longest, self.shift = 0.3, 0.0  # longest step; shift of the stiffness in the last step
        self._go(self._at(q, np.zeros(system.m + system.p)))

    # -- points ------------------------------------------------------------------------------------------------
    def _at(self, q: Array, lam: Array) -> _Point:
        """The point q with its multipliers; ``lam`` is their initial guess, on which forces may depend."""
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
        self.system.count_turns(point.q, start=True)
        self.q, self.lam, self.g = point.q, point.lam, point.g
        self.K = self.system.tangent(self.t, self.q, self.still, self.lam, cK=1.0)[:n, :n]
        self.system.count_angles()
        self.kappa = largest(self._scaled(self.K))
        inner = point.J.T @ point.lam
        forces = np.abs(np.concatenate([point.Q, inner])) / np.tile(self.scale, 2)
        # springs that balance each other leave only rounding
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
            far = np.abs(self.system.difference(self.q, self.start) * self.scale).max()
            if self.iterations >= MOST or far > FARTHEST:
                raise self._endless()
            self.iterations += 1
            for _ in range(30):
                step = self._step()
                there = self._restored(self.system.moved(self.q, step), float(np.abs(step * self.scale).max()))
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
        """The change of q (n,) in one implicit step, at most ``longest`` and in a direction of descent."""
        f = self.point.Q - self.point.J.T @ self.lam
        # coordinates without force and stiffness do not move
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
            if system.p:  # constraints at velocity level only: the change of positions satisfies them at its midpoint
                J_half = system.tangent(t, self._middle(q), self.still, cV=1.0)[n + system.m :, :n]
                c = np.concatenate([c, J_half @ system.difference(q, self.q)])
            open_ = float(np.abs(c / row_size(scaled(J, np.ones(len(c)), 1.0 / self.scale))).max(initial=0.0))
            if not np.isfinite(open_) or open_ <= tolerance or (open_ >= before and open_ <= 1e3 * tolerance):
                break
            before = open_
            q = system.moved(q, Saddle(self._metric(), J.T, J, self.scale).solve(np.zeros(n), -c)[0])
            if not np.abs(system.difference(q, first) * self.scale).max() <= length:
                return None
        else:
            if system.m + system.p and not open_ <= 1e3 * tolerance:
                return None
        return self._at(q, self.lam)

    def _middle(self, q: Array) -> Array:
        """The position between that of the search and q."""
        if self.system.scene.spatial:
            return self.system.moved(self.q, 0.5 * self.system.difference(q, self.q))
        return (q + self.q) / 2

    def _agreement(self, step: Array, there: _Point) -> float:
        """The ratio of the work of applied forces to its prediction by the tangent; 1 if rounding dominates both."""
        promised = self.g @ (step * self.scale) - 0.5 * step @ (self.K @ step)
        change = self.system.difference(there.q, self.q)
        work = 0.5 * (self.point.Q + there.Q) @ change
        if promised <= 1e-11 * float(np.abs(self.point.Q * change).sum()) or there.left <= 0.1 * self.point.left:
            return 1.0 if there.left <= 2.0 * self.point.left else 0.0
        return float(work / promised)

    def _refine(self) -> None:
        """Newton steps, as long as they reduce the residual."""
        for _ in range(10):
            if self.point.left == 0.0:
                return
            step = self._step(newton=True)
            length = float(np.abs(step * self.scale).max(initial=0.0))
            there = self._restored(self.system.moved(self.q, step), 1e-3) if length < 1e-2 else None
            if there is None or there.left >= self.point.left:
                return
            enough = there.left > 0.5 * self.point.left
            self._go(there)
            if enough:
                return

    def push(self, direction: Array, stiffness: float) -> None:
        """Leave a saddle point along ``direction`` (n,), scaled, which has the given negative stiffness."""
        direction = direction / direction[np.abs(direction).argmax()]
        self.longest, self.shift = 0.3, 2.0 * abs(stiffness)
        for size in 0.05 * 0.3 ** np.arange(12):
            there = self._restored(self.system.moved(self.q, size * direction / self.scale), size)
            if there is not None and (self.point.Q + there.Q) @ self.system.difference(there.q, self.q) > 0.0:
                self._go(there)
                return
        raise self._stuck()

    # -- stability ---------------------------------------------------------------------------------------------
    def stability(self) -> tuple[float | None, float, Array]:
        """The smallest stiffness within the constraints [J], the limit below which it is zero, and directions.

        Directions (n, k), in scaled coordinates, are those without stiffness, or that of the smallest stiffness if it
        is negative. For large systems the stiffnesses next to zero and the most negative one are computed.
        """
        K = self._scaled(self.K)
        if not np.isfinite(K if isinstance(K, np.ndarray) else K.data).all():
            raise EquilibriumError(
                "the forces in this pose have derivatives that are not finite numbers",
                hint="look for an angle between axes that is not defined there, or a law with a root or a quotient",
            )
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

        if np.abs(allowed(v0)).max() <= 1e-9:  # no degree of freedom
            return np.zeros(0), np.zeros((n, 0))
        solve = eigsh if self.symmetric else eigs
        near = LinearOperator((n, n), lambda x: self.scale * inverse.solve(self.scale * x)[0], dtype=float)
        far = LinearOperator((n, n), lambda x: allowed(K @ allowed(x)), dtype=float)
        values, vectors = solve(near, k, v0=v0)
        free = np.abs(values) > 1e-12 / self.kappa  # directions that the constraints forbid have zero compliance
        values, vectors = (1.0 / values[free]).real + sigma, vectors[:, free].real
        try:
            below, down = solve(far, 1, which="SA" if self.symmetric else "SR", v0=v0, tol=1e-2, maxiter=300)
        except ArpackNoConvergence:
            return values, vectors
        if below[0].real < -1e-6 * self.kappa:
            values, vectors = np.append(values, below.real), np.hstack([vectors, down.real])
        return values, vectors

    # -- errors --------------------------------------------------------------------------------------------------
    def _endless(self) -> EquilibriumError:
        names, hint = movers(self.system, np.abs(self.g)), "add a spring, a joint or a driver"
        if joints := self.system.scene.sticking:
            named = few([x.name for x in joints], 4)
            hint = f"friction of {named} is left out, mbdsl simulate shows whether it holds; or {hint}"
        return EquilibriumError(
            f"no equilibrium: {few(names)} {'keeps' if len(names) == 1 else 'keep'} moving",
            self._span(names),
            hint=f"no restoring force balances the load on it; {hint}",
        )

    def _stuck(self) -> EquilibriumError:
        names = movers(self.system, np.abs(self.g))
        return EquilibriumError(
            f"no equilibrium found after {count(self.iterations, 'step')}: forces still move {few(names)}",
            self._span(names),
            hint="there may be none where a law jumps; if the pose is singular, start from another one",
        )

    def _span(self, names: Sequence[str]) -> Span | None:
        return self.system.scene.components[names[0]].span if names else None


@dataclass(frozen=True)
class _Point:
    """Positions, multipliers, the velocity g of overdamped motion, and applied forces Q (n,).

    U (n, m + p) and J (m + p, n) are the matrices of the multipliers.
    """

    q: Array
    lam: Array
    g: Array
    Q: Array
    U: Matrix
    J: Matrix

    @property
    def left(self) -> float:
        """The residual force."""
        return float(np.abs(self.g).max(initial=0.0))
