"""Elastic equilibrium of bodies in a mechanism that is held at its position.

A mechanism with degrees of freedom has no equilibrium initially, but its bodies have a shape in which elastic forces
balance the loads. Therefore additional constraints hold it: signals with initial values keep these, and the
mass-weighted mean displacement along each remaining motion of the undeformed mechanism is zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.expressions.symbolic import is_velocity_level
from mbdsl.initial.undeformed import Undeformed
from mbdsl.numerics.saddle_point import Array, dense, null_space, row_size
from mbdsl.statics.pseudo_transient import MotionSearch
from mbdsl.system import System
from mbdsl.system.signals import gradients


def relaxed(system: System, t: float, static: Sequence[str], q: Array) -> Array:
    """Positions (n,) near ``q`` with the named bodies in elastic equilibrium; the others keep their shapes.

    Without names all shapes may change: the bodies have been deformed by the assembly.

    Raises
    ------
    EquilibriumError
        If a body keeps moving.
    """
    search = MotionSearch(_Held(system, t, static, q), t, q)  # type: ignore[arg-type]
    search.descend()
    return search.q


class _Held:
    """A System with additional constraints that hold it at q except for the shapes of some bodies."""

    def __init__(self, system: System, t: float, static: Sequence[str], q: Array) -> None:
        self.system, self.t, self.n, self.p = system, t, system.n, system.p
        self.scene, self.tables = system.scene, system.tables
        self.targets = [x.target for x in system.scene.initial if not is_velocity_level(x.target)]
        self.values = self._gradients(q)[0]
        self.rows = np.concatenate([self._motions(q), self._shapes(static, q)])
        self.start = self.rows @ q
        self.m = system.m + len(self.targets) + len(self.rows)
        self.unknowns = self.n + self.m + self.p

    def _motions(self, q: Array) -> Array:
        """Rows that hold motions of the undeformed mechanism not held by initial values."""
        shape = Undeformed(self.system, q)
        J = np.concatenate([dense(self.system.Phi_q(self.t, q)), self._gradients(q)[1]])
        J = dense(shape.reduce(shape.start, J, q)) / shape.scale
        free = null_space(J / row_size(J)[:, None]) / shape.scale[:, None]
        motions = dense(shape.reduce(shape.start, np.eye(self.n), q)) @ free
        return motions.T @ dense(self.system.M(self.t, q))

    def _shapes(self, static: Sequence[str], q: Array) -> Array:
        """Rows that hold the shapes of the other bodies."""
        rows = []
        for name, body in self.tables.models.items() if static else ():
            if name not in static and body.deforms:
                d = self.tables.coordinates[name]
                own = slice(d, d + body.n)
                scale = self.tables.scale[own]
                motions = body.rigid(q[own]) * scale[:, None]
                found = np.zeros((body.n - 3, self.n))
                found[:, own] = np.linalg.svd(motions, full_matrices=True)[0][:, 3:].T * scale
                rows.append(found)
        return np.concatenate(rows) if rows else np.zeros((0, self.n))

    def _gradients(self, q: Array) -> tuple[Array, Array]:
        value, d_q, _ = gradients(self.system, self.targets, self.t, q, np.zeros(len(q)))
        return value, dense(d_q)

    def _own(self, lam: Array) -> tuple[Array, Array]:
        """The multipliers of the System, and those of the additional constraints."""
        m = self.system.m
        return np.concatenate([lam[:m], lam[self.m :]]), lam[m : self.m]

    def _held(self, q: Array) -> Array:
        """The Jacobian of the additional constraints."""
        return np.concatenate([self._gradients(q)[1], self.rows])

    def count_turns(self, q: Array, start: bool) -> None:
        self.system.count_turns(q, start)

    def count_angles(self) -> None:
        self.system.count_angles()

    def moved(self, q: Array, *changes: Array) -> Array:
        return self.system.moved(q, *changes)

    def difference(self, q: Array, q0: Array) -> Array:
        return self.system.difference(q, q0)

    def names(self) -> list[str]:
        return self.system.names()

    def Phi(self, t: float, q: Array) -> Array:
        more = self._gradients(q)[0] - self.values
        return np.concatenate([self.system.Phi(t, q), more, self.rows @ q - self.start])

    def evaluate(self, t: float, q: Array, v: Array, lam: Array) -> tuple[Array, Array, Array]:
        own, held = self._own(lam)
        f, Phi, rate = self.system.evaluate(t, q, v, own)
        return f - self._held(q).T @ held, Phi, rate

    def tangent(self, t: float, q: Array, v: Array, lam: Array | None = None, **factors: float) -> Array:
        n, m = self.n, self.system.m
        own = None if lam is None else self._own(lam)[0]
        found = np.zeros((self.unknowns, self.unknowns))
        at = np.concatenate([np.arange(n + m), np.arange(n + self.m, self.unknowns)])
        found[np.ix_(at, at)] = dense(self.system.tangent(t, q, v, own, **factors))
        rows, held = np.arange(n + m, n + self.m), self._held(q)
        found[:n, rows], found[rows, :n] = held.T, factors.get("cP", 0.0) * held
        return found
