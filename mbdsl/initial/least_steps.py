"""Linear least-squares steps of the assembly, and the residuals of initial values."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import InitialValue
from mbdsl.numerics.saddle_point import least_squares
from mbdsl.system.signals import Matrix, gradients
from mbdsl.system.system import System


def stack(system: System, items: list[InitialValue], t: float, q: Array, v: Array):
    """Values of the targets of ``items``, and their gradients with respect to q and v."""
    return gradients(system, [x.target for x in items], t, q, v)


def misses(value: Array, items: list[InitialValue]) -> Array:
    """The differences of ``value`` from the initial values; of angles less than half a turn."""
    found = value - np.array([x.value for x in items])
    angles = np.array([x.target.op in ("angle", "atan2") for x in items], bool)
    found[angles] -= 2.0 * np.pi * np.round(found[angles] / (2.0 * np.pi))
    return found


def velocity_residual(system: System, t: float, q: Array, v: Array) -> Array:
    """[Phi_q v + Phi_t; Gam] (m + p,)."""
    return np.concatenate([system.evaluate(t, q, v)[2], system.Gam(t, q, v)])


def stacked(J: Matrix, rows: Matrix) -> Matrix:
    """J with further rows."""
    if isinstance(J, np.ndarray):
        return np.vstack([J, rows])
    from scipy.sparse import vstack

    return vstack([J, rows]).tocsr()


def constrained(weight: Array, r_w: Array, A_s: Matrix, r_s: Array, J: Matrix, r_c: Array) -> Array:
    """min |r_w + W d|^2 + |r_s + A_s d|^2 subject to J d = -r_c (least squares if it has no solution)."""
    n = len(weight)
    if isinstance(J, np.ndarray):
        U, s, Vt = np.linalg.svd(J, full_matrices=True)
        rank = int((s > 1e-10 * s.max(initial=0.0)).sum())
        d = Vt[:rank].T @ ((U[:, :rank].T @ -r_c) / s[:rank])
        Z = Vt[rank:].T
        if Z.shape[1]:
            A = np.vstack([weight[:, None] * Z, A_s @ Z])
            b = -np.concatenate([r_w + weight * d, r_s + A_s @ d])
            d = d + Z @ least_squares(A, b)
        return d
    from scipy.sparse import block_array, csc_array, csr_array, diags_array
    from scipy.sparse.linalg import splu

    S = csr_array(A_s)
    H = diags_array(weight**2) + S.T @ S
    regular = -(float(abs(H).max()) * 1e-14 + 1e-20) * np.ones(J.shape[0])
    K = block_array([[H, J.T], [J, diags_array(regular)]])
    return splu(csc_array(K)).solve(np.concatenate([-(weight * r_w) - S.T @ r_s, -r_c]))[:n]


def damped(weight: Array, r_w: Array, S: Matrix, r_s: Array, J: Matrix, r_c: Array) -> Array:
    """As :func:`constrained`, with a penalty on changes that increases with the violation.

    The penalty limits the steps for a nearly singular J, as of a mechanism close to a dead centre.
    """
    n, m = len(r_w), len(r_c)
    b = np.concatenate([-weight * r_w - S.T @ r_s, -r_c])
    # guesses far from the solution must not prevent convergence of the constraints
    mu = 0.1 * np.abs(r_c).max(initial=0.0) / (1.0 + np.abs(b[:n]).max(initial=0.0))
    if isinstance(J, np.ndarray):
        H = np.diag(weight**2) + S.T @ S
        return np.linalg.solve(np.block([[H, J.T], [J, -mu * np.eye(m)]]), b)[:n]
    from scipy.sparse import block_array, csc_array, diags_array
    from scipy.sparse.linalg import splu

    H = diags_array(weight**2) + S.T @ S
    return splu(csc_array(block_array([[H, J.T], [J, diags_array(np.full(m, -mu))]]))).solve(b)[:n]
