"""The linearised equations of motion with excitations, and the quantities that follow from their solution.

In the notation of :mod:`mbdsl.analysis.linearisation`, and with offsets w of drivers and of prescribed velocities,

    x' = A x + B0 w + B1 w' + B2 w'',   y = C x + D0 w + D1 w' + D2 w''.

The constraints that drivers move are released: their values are coordinates that are given
(:class:`mbdsl.analysis.tangent_bases.Moving`). B1, B2, D1 and D2 are zero for forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbdsl.analysis.eigenvalues import Projected, projected
from mbdsl.analysis.excitations import INPUT, Excitation, ExcitationColumns
from mbdsl.analysis.input_forces import signal_derivatives
from mbdsl.analysis.named_basis import AtRest, Named
from mbdsl.analysis.operating_points import OperatingPoint
from mbdsl.errors import UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.mechanism.signal_names import ACCELERATIONS
from mbdsl.messages import few
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.saddle_point import Array, dense

#: condition number of the mass matrix in the chosen coordinates from which a coordinate counts as massless
MASSLESS = 1e12
#: the signals of accelerations in space
IN_SPACE = ("ax", "ay", "az", "alphax", "alphay", "alphaz")
HELD = 1e-6  #: part of a released constraint that the other constraints hold, from which it cannot move


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Quantities as linear functions of the states (k, r), and of excitations and their two rates (3, k, i)."""

    x: Array
    u: Array

    __array_ufunc__ = None  # a matrix of numpy leaves the product to __rmatmul__

    def __rmatmul__(self, matrix: Array) -> LinearRows:
        return LinearRows(matrix @ self.x, matrix @ self.u)

    def __add__(self, other: LinearRows) -> LinearRows:
        return LinearRows(self.x + other.x, self.u + other.u)


class LinearEquations:
    """The linearised equations, and from them dq, dv, da and dlam.

    Attributes
    ----------
    A : (r, r)
    B : (3, r, i)
        Of the excitations and their first and second rates.
    coordinates, speeds : list of Quantity
        What the entries of x are.
    """

    def __init__(self, point: OperatingPoint, excitations: Sequence[Excitation], columns: ExcitationColumns) -> None:
        system, t, q, v, a, lam = point.system, point.t, point.q, point.v, point.a, point.lam
        at_rest = AtRest.suits(system, v, a)
        released = columns.released
        basis = AtRest(system, t, q, a, released) if at_rest else Named(system, t, q, v, a, released)
        self.point, self.system, self.basis, self.excitations = point, system, basis, list(excitations)
        n = system.n
        tangent = dense(system.tangent(t, q, v, lam, cL=1.0, cP=1.0, cV=1.0))
        U, J = tangent[:n, n:], tangent[n:, :n]
        M, D = dense(system.M(t, q)), dense(system.damping(t, q, v, lam))
        K = dense(system.stiffness(t, q, v, lam, a))
        self._check_released(J, columns)
        y, speeds, changes = self._solve(basis, projected(system, M, D, K, U, J, basis), columns)
        rates = basis.S @ y + basis.T @ speeds
        second = basis.S @ rates + basis.S1 @ y + basis.T @ changes + basis.T1 @ speeds
        self.dq, self.dv = basis.Z @ y, basis.Z @ rates + basis.W @ y
        self.da = basis.Z @ second + (basis.Z1 + basis.W) @ rates + basis.W1 @ y
        left = M @ self.da + D @ self.dv + K @ self.dq
        left.u[0] -= columns.forces
        kept = np.delete(np.arange(U.shape[1]), point.left_out)
        r, i = len(self.A), columns.forces.shape[1]
        self.dlam = LinearRows(np.zeros((U.shape[1], r)), np.zeros((3, U.shape[1], i)))
        if len(kept):
            scale = system.tables.scale[:, None]
            right = -np.hstack([left.x, *left.u]) / scale
            solved = np.linalg.lstsq(U[:, kept] / scale, right, rcond=1e-12)[0]
            self.dlam.x[kept] = solved[:, :r]
            self.dlam.u[:, kept] = np.stack(np.split(solved[:, r:], 3, axis=1))
        self._without(basis.integrals)

    def _without(self, integrals: list[int]) -> None:
        """Leave out the integrals of states, on which nothing depends: states are among the speeds."""
        own = np.delete(np.arange(len(self.A)), integrals)
        self.coordinates = [x for k, x in enumerate(self.basis.coordinates) if k not in integrals]
        self.speeds = self.basis.speeds
        if integrals:
            self.A, self.B = self.A[np.ix_(own, own)], self.B[:, own]
            for name in ("dq", "dv", "da", "dlam"):
                found = getattr(self, name)
                setattr(self, name, LinearRows(found.x[:, own], found.u))

    def _check_released(self, J: Array, columns: ExcitationColumns) -> None:
        """Raise an error if other constraints hold what a driver moves."""
        basis, (positions, velocities) = self.basis, columns.released
        r = basis.Z.shape[1] - len(positions)
        moved = J[: self.system.m] @ basis.Z[:, r:]
        moved[positions, np.arange(len(positions))] -= 1.0
        rates = J[self.system.m :] @ basis.Z @ basis.T[:, basis.T.shape[1] - len(velocities) :]
        rates[velocities, np.arange(len(velocities))] -= 1.0
        for part, by in ((moved, columns.positions), (rates, columns.velocities)):
            for k in np.flatnonzero(np.abs(part).max(axis=0, initial=0.0) > HELD):
                names = few([e.name for e, x in zip(self.excitations, by[k], strict=True) if x])
                raise UsageError(
                    f"`{names}` cannot oscillate: the other constraints hold what it moves",
                    hint="remove a redundant constraint; `mbdsl check` lists them",
                )

    def _solve(
        self, basis: Named, found: Projected, columns: ExcitationColumns
    ) -> tuple[LinearRows, LinearRows, LinearRows]:
        """A and B from the projected equations; the coordinates y, the speeds s and s', with the given ones."""
        h, g, i = len(columns.released.positions), len(columns.released.velocities), columns.forces.shape[1]
        r, d = basis.T.shape[0] - h, basis.T.shape[1] - h - g
        M = found.M[:, :d]
        if d:
            size = 1.0 / np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
            if not np.linalg.cond(size[:, None] * M * size) < MASSLESS:
                raise UsageError(
                    "a coordinate without mass can move, and has no equation of motion",
                    hint="give every body that moves a mass and a moment of inertia",
                )
        y = LinearRows(np.eye(r + h, r + d), np.zeros((3, r + h, i)))
        speeds, changes = (LinearRows(np.zeros((d + h + g, r + d)), np.zeros((3, d + h + g, i))) for _ in range(2))
        speeds.x[:d, r:] = np.eye(d)
        y.u[0, r:] = speeds.u[1, d : d + h] = changes.u[2, d : d + h] = columns.positions
        speeds.u[0, d + h :] = changes.u[1, d + h :] = columns.velocities
        y.x[r:] = 0.0
        right = found.K @ y + found.D @ speeds + found.M[:, d:] @ LinearRows(changes.x[d:], changes.u[:, d:])
        right.u[0] -= found.L.T @ columns.forces
        solved = -np.linalg.solve(M, np.hstack([right.x, *right.u]))
        changes.x[:d] = solved[:, : r + d]
        changes.u[:, :d] = np.stack(np.split(solved[:, r + d :], 3, axis=1))
        rates = basis.S @ y + basis.T @ speeds
        self.A = np.vstack([rates.x[:r], changes.x[:d]])
        self.B = np.concatenate([rates.u[:, :r], changes.u[:, :d]], axis=1)
        return y, speeds, changes

    def _acceleration(self, first: int, key: str) -> tuple[LinearRows, float]:
        """A world acceleration of the body in space with this first coordinate, and its value."""
        a, at = self.point.a, IN_SPACE.index(key)
        if at < 3:
            return LinearRows(self.da.x[first + at], self.da.u[:, first + at]), float(a[first + at])
        own = slice(first + 3, first + 6)
        R = rotation_arrays.matrices(self.point.q[None, own])[0][at - 3]
        x = self.da.x[own] + np.cross(self.dq.x[own].T, a[own]).T
        u = self.da.u[:, own] + np.cross(self.dq.u[:, own], a[own], axisa=1, axisc=1)
        return LinearRows(R @ x, R @ u), float(R @ a[own])

    def outputs(self, known: AskedSignals, names: Sequence[str]) -> tuple[Array, Array, Array]:
        """C (o, r), D (3, o, i) and values (o,) of signals."""
        point, system, i = self.point, self.system, len(self.excitations)
        found, y0 = LinearRows(np.zeros((len(names), len(self.A))), np.zeros((3, len(names), i))), np.zeros(len(names))
        plain = [k for k, name in enumerate(names) if name in known.formulas]
        roots = [known.formulas[names[k]][0] for k in plain]
        of = [k for k, e in enumerate(self.excitations) if e.sort == INPUT]
        inputs = [self.excitations[k].name for k in of]
        slopes = signal_derivatives(system, roots, inputs, point.t, point.q, point.v, point.lam)
        total = slopes.q @ self.dq + slopes.v @ self.dv + slopes.lam @ self.dlam
        total.u[0][:, of] += slopes.u
        found.x[plain], found.u[:, plain] = total.x, total.u
        y0[plain] = slopes.value
        for k in set(range(len(names))) - set(plain):
            owner, _, key = names[k].rpartition(".")
            if owner not in system.tables.coordinates:
                message = f"`{names[k]}` cannot be an output of a linear model: `{owner}` is not a body"
                raise UsageError(message, hint="accelerations of centres of mass can be, such as `crank.ax`")
            first = system.tables.coordinates[owner]
            if system.scene.spatial:
                row, y0[k] = self._acceleration(first, key)
            else:
                j = first + list(ACCELERATIONS).index(key)
                row, y0[k] = LinearRows(self.da.x[j], self.da.u[:, j]), point.a[j]
            found.x[k], found.u[:, k] = row.x, row.u
        return found.x, found.u, y0
