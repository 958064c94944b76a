"""Painleve's paradox in joints: coefficients of friction from which on reactions do not exist or are not unique.

Friction that slides is mu N, and N depends on reactions lam. With the forces Q(lam) = Q_0 + s Q_lam lam at s times the
coefficients of friction, the equations of motion are

    [[M, J^T - s Q_lam], [J, 0]] [a; lam] = [Q_0; gamma_c]

Up to the least s > 0 at which this matrix is singular, for either sign of the reactions, there is one solution. With
L = A^{-1} J M^{-1} Q_lam and A = J M^{-1} J^T, these are s = 1/|l| of the real eigenvalues l of L.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbdsl.errors import Span
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.system import System

REAL = 1e-6  #: imaginary part of an eigenvalue, relative to its size, that is rounding
NEAR = 1.02  #: multiple of the present coefficients up to which the paradox is near


class Paradox(NamedTuple):
    """A joint whose reactions have no unique solution, from the coefficient mu on, and its place in the model."""

    joint: str
    mu: float
    span: Span | None

    @property
    def text(self) -> str:
        what = f"reactions of `{self.joint}` do not exist or are not unique"
        return f"{what} from mu = {self.mu:.6g} on (Painleve's paradox)"


def paradox(system: System, t: float, q: Array, v: Array, lam: Array, left_out: tuple[int, ...]) -> Paradox | None:
    """The paradox at a state with multipliers lam (m + p,), if it is near; None if there is none."""
    joints = {c.name: c for c in system.scene.components.values() if c.friction is not None}
    kept = np.delete(np.arange(system.m + system.p), left_out)
    if not joints or not len(kept):
        return None
    n = system.n
    M, J = dense(system.M(t, q)), dense(system.velocity_jacobian(t, q, v))[kept]
    lam = np.where(lam == 0.0, 1.0, lam)  # friction has no derivative there
    Q_lam = J.T - dense(system.tangent(t, q, v, lam, cL=1.0, cV=1.0))[:n, n:][:, kept]
    try:
        X = np.linalg.solve(M, np.hstack([J.T, Q_lam]))
        sizes, vectors = np.linalg.eig(np.linalg.solve(J @ X[:, : len(kept)], J @ X[:, len(kept) :]))
    except np.linalg.LinAlgError:  # a body without mass, or a singular pose
        return None
    real = np.abs(sizes.imag) <= REAL * np.abs(sizes)
    if not real.any() or (largest := float(np.abs(sizes[real]).max())) * NEAR < 1.0:
        return None
    part = np.zeros(system.m + system.p)
    part[kept] = np.abs(vectors[:, int(np.argmax(np.where(real, np.abs(sizes), -1.0)))])
    rows = {name: range(r, r + joints[name].kind.rows) for name, r in system.tables.rows.items() if name in joints}
    name = max(rows, key=lambda x: part[list(rows[x])].max(initial=0.0))
    return Paradox(name, float(joints[name].values["mu"]) / largest, joints[name].span)
