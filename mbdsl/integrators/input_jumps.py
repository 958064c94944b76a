"""Jumps of accelerations and reactions at a change of inputs.

An input occurs in the laws of forces. If these neither depend on reactions nor prescribe velocities, a change of inputs
does not change masses and constraints, and the jump follows from the jump of the forces:

    [[M, J^T], [J, 0]] [da; dlam] = [dQ; 0],   J = [Phi_q; Gam_v],   d(fa) = M^{-1} (dQ - Gam_v^T dnu)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import leaves
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import least_squares
from mbdsl.system import System
from mbdsl.system.accelerations import ACCURATE, BOUNDED, balance
from mbdsl.system.broken_laws import not_finite
from mbdsl.system.system import DENSE_LIMIT


class Jump(NamedTuple):
    """Jumps of accelerations a (n,), multipliers lam (m + p,), applied forces over masses fa (n,), and of M a (n,)."""

    a: Array
    lam: Array
    fa: Array
    force: Array


def acts_by_forces(system: System) -> bool:
    """Whether inputs occur in forces only, and no force depends on reactions; the equations are small."""
    if system.unknowns > DENSE_LIMIT or system.of_multipliers:
        return False
    rows = [row for c in system.scene.components.values() for row in c.velocity_constraints]
    return not any(leaf.op == "input" for leaf in leaves(*rows))


def jump(system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...], change: Callable[[], None]) -> Jump:
    """The jump at a state by ``change()``, which sets inputs of the system.

    Raises
    ------
    InitialisationError
        If forces are not finite, or accelerations do not exist.
    """
    n = system.n
    before = system._at(t, q, v).vectors[L.FORCE, :n].copy()
    K = system.matrix(system.entries(t, cM=1.0, cP=1.0, cV=1.0))
    change()
    dQ = system._at(t, q, v).vectors[L.FORCE, :n] - before
    if not np.isfinite(dQ).all():
        raise not_finite(system, t, q, v, "the forces")
    assert isinstance(K, np.ndarray)
    kept = np.delete(np.arange(system.unknowns), np.array(left_out, int) + n) if left_out else slice(None)
    d = balance(system, K.diagonal()[:n], K[n:, :n])[kept]
    A = d[:, None] * K[kept][:, kept] * d
    b = np.zeros(len(d))
    b[:n] = d[:n] * dQ
    x, size = _solved(A, b), float(np.abs(b).max(initial=0.0))
    if not np.abs(b - A @ x).max(initial=0.0) <= 1e-8 * size:
        raise InitialisationError(
            f"no accelerations satisfy the equations of motion at t = {t:g} s",
            hint="a body without mass or inertia moves freely, or the pose is singular",
        )
    found = np.zeros(system.unknowns)
    found[kept] = d * x
    a, lam = found[:n], found[n:]
    applied = dQ - K[n + system.m :, :n].T @ lam[system.m :] if system.p else dQ
    return Jump(a, lam, system.solve_mass(t, q, applied), K[:n, :n] @ a)


def _solved(A: Array, b: Array) -> Array:
    """x of A x = b; of least norm if A is singular."""
    try:
        x = np.linalg.solve(A, b)
    except np.linalg.LinAlgError:
        return least_squares(A, b, 1e-13)
    size = np.abs(b).max(initial=0.0)
    fits = np.abs(b - A @ x).max(initial=0.0) <= ACCURATE * size and np.abs(x).max(initial=0.0) <= BOUNDED * size
    return np.asarray(x, float) if fits else least_squares(A, b, 1e-13)
