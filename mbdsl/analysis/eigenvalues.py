"""Eigenvalues and shapes of linearised equations: all of small systems, the lowest of large ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.analysis.tangent_bases import Moving, Still
from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Complex
from mbdsl.numerics.saddle_point import Array, Matrix, Saddle, largest, null_space, row_size, scaled
from mbdsl.system import System

ROUNDING = 1e-14  #: frequency, relative to the highest one, that is zero


class Projected(NamedTuple):
    """The equations M u' + D u + K y = L^T f of speeds u (d,) and coordinates y (r,), with L (n, d); f are forces.

    The matrices have further columns for the given values of released constraints.
    """

    M: Array
    D: Array
    K: Array
    L: Array


def projected(system: System, M: Array, D: Array, K: Array, U: Array, J: Array, basis: Still | Moving) -> Projected:
    """The linearised equations in the coordinates of a basis, without reactions."""
    Z, Z1, W, W1, T, T1, S, S1 = (getattr(basis, name) for name in ("Z", "Z1", "W", "W1", "T", "T1", "S", "S1"))
    d = T.shape[1] - basis.given
    L = (Z @ T)[:, :d]
    if not np.array_equal(U, J.T):  # forces that depend on multipliers do not act in the directions of the constraints
        U = (U / system.tables.scale[:, None]).T
        L = null_space(U / row_size(U)[:, None]) / system.tables.scale[:, None]
        if L.shape[1] != d:
            raise UsageError(
                "the reactions, with the forces that depend on them, are linearly dependent", hint="another state"
            )
    if not d:
        return Projected(np.zeros((0, basis.given)), np.zeros((0, basis.given)), np.zeros((0, T.shape[0])), L)
    DZ = M @ (Z1 + W) + D @ Z
    Mr = L.T @ M @ Z @ T
    Dr = L.T @ (M @ Z @ (T1 + S @ T) + DZ @ T)
    Kr = L.T @ (M @ Z @ (S1 + S @ S) + DZ @ S + M @ W1 + D @ W + K @ Z)
    # entries that are only the rounding residue of terms that cancel along the motion are set to zero
    size = 1e-9 * basis.rate * largest(np.abs(L).T @ np.abs(M) @ np.abs(Z))
    Dr = np.where(np.abs(Dr) > size, Dr, 0.0)
    Kr = np.where(np.abs(Kr) > size * basis.rate, Kr, 0.0)
    return Projected(Mr, Dr, Kr, L)


def reduced(
    system: System, M: Array, D: Array, K: Array, U: Array, J: Array, basis: Still | Moving
) -> tuple[list[complex], list[Complex]]:
    """All eigenvalues, one of each conjugate pair if the pairs are known, and vectors y (r,)."""
    T, S = basis.T, basis.S
    Mr, Dr, Kr, _ = projected(system, M, D, K, U, J, basis)
    integrals = basis.integrals
    if T.shape[1] and not integrals and not Dr.any() and not S.any() and _symmetric(Mr) and _symmetric(Kr):
        found = _undamped(Mr, Kr)
        if found is not None:
            return found
    return _first_order(Mr, Dr, Kr, T, S, basis.rate, integrals)


def _symmetric(A: Array) -> bool:
    return A.shape[0] == A.shape[1] and largest(A - A.T) <= 1e-12 * largest(A)


def _undamped(M: Array, K: Array) -> tuple[list[complex], list[Complex]] | None:
    """Eigenvalues of M y'' + K y = 0, symmetric; None if a massless coordinate can move."""
    d = 1.0 / np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
    M, K = d[:, None] * (M + M.T) / 2.0 * d, d[:, None] * (K + K.T) / 2.0 * d
    try:
        C = np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        return None
    if np.diag(C).min() < 1e-6:
        return None
    _, x = np.linalg.eigh(np.linalg.solve(C, np.linalg.solve(C, K).T))
    x = np.linalg.solve(C.T, x)
    # by Rayleigh quotients, so that low frequencies are not affected by the rounding of high ones
    work, size = (x * (K @ x)).sum(axis=0), (np.abs(x) * (np.abs(K) @ np.abs(x))).sum(axis=0)
    square = np.where(np.abs(work) > 1e-13 * size, work, 0.0) / (x * (M @ x)).sum(axis=0)
    return _of_squares(square, d[:, None] * x, ROUNDING**2 * np.abs(square).max(initial=0.0))


def _of_squares(square: Array, y: Array, zero: float = 0.0) -> tuple[list[complex], list[Complex]]:
    """Eigenvalues from squares of frequencies: two for each negative one."""
    values: list[complex] = []
    shapes: list[Complex] = []
    for w2, x in zip(square, y.T, strict=True):
        w = 0.0 if abs(w2) <= zero else float(np.sqrt(abs(w2)))
        for s in [complex(w), complex(-w)] if w2 < 0.0 and w else [complex(0.0, w)]:
            values.append(s)
            shapes.append(x.astype(complex))
    return values, shapes


def _first_order(
    M: Array, D: Array, K: Array, T: Array, S: Array, turning: float, integrals: Sequence[int] = ()
) -> tuple[list[complex], list[Complex]]:
    """Eigenvalues of y' = T u + S y, M u' + D u + K y = 0. A coordinate without mass and damping has none.

    ``turning`` is the rate of change [1/s] of the bases, whose derivatives are differences. The ``integrals`` of
    states, which nothing reads, are left out; in the vectors y their entries are those of the states.
    """
    r, d = T.shape
    if not r:
        return [], []
    # unit of time in which masses and stiffnesses have the same order of magnitude
    tau = float(np.sqrt(largest(M) / (largest(K) or largest(D) ** 2 / (largest(M) or 1.0) or 1.0)))
    tau = tau or 1.0 / (largest(S) or 1.0)
    size = largest(M) or 1.0
    A = np.block([[tau * S, T], [-(tau**2) * K / size, -tau * D / size]])
    B = np.block([[np.eye(r), np.zeros((r, d))], [np.zeros((d, r)), M / size]])
    own = np.delete(np.arange(r + d), list(integrals))
    A, B = A[np.ix_(own, own)], B[np.ix_(own, own)]
    unit = np.ones(len(own))
    if integrals and np.linalg.cond(M) < 1e12:  # the units of states are not comparable with those of motions
        from scipy.linalg import matrix_balance

        A, (unit, _) = matrix_balance(np.linalg.solve(B, A), permute=False, separate=True)
        B = np.eye(len(own))
    if not d or np.linalg.cond(M) < 1e12:
        values, x = np.linalg.eig(np.linalg.solve(B, A))
    else:
        from scipy.linalg import eig

        pairs, x = eig(A, B, homogeneous_eigvals=True)
        alpha, beta = pairs
        finite = np.abs(beta) > 1e-12 * np.abs(alpha)
        values, x = alpha[finite] / beta[finite], x[:, finite]
    order = np.argsort(np.abs(values), kind="stable")
    values, x = values[order], x[:, order]
    largest_ = float(np.abs(values).max(initial=0.0))
    # rounding splits a double zero into a pair of the size of its square root; null vectors show the zeros instead
    zero = 1e-13 + 1e-12 * (turning * tau) ** 2
    null = _null_space(A, zero)
    if null.shape[1]:
        many = _zeros(A, B, zero)
        values = np.concatenate([np.zeros(null.shape[1]), values[many:]])
        x = np.hstack([null, x[:, many:]])
    rounding = 64.0 * np.finfo(float).eps * largest_
    oscillates = np.abs(values.imag) > rounding
    values = np.where(oscillates & (np.abs(values.real) <= rounding), 1j * values.imag, values)
    values = np.where(oscillates, values, values.real) / tau
    whole = np.zeros((r + d, x.shape[1]), complex)
    whole[own] = unit[:, None] * x
    whole[list(integrals)] = T[list(integrals)] @ whole[r:] / tau
    return [complex(s) for s in values], list(whole[:r].T)


def _null_space(A: Array, zero: float) -> Array:
    """Null space of a square matrix with rows of one magnitude: of singular values up to ``zero`` times the largest."""
    _, s, Vt = np.linalg.svd(A)
    return Vt[int((s > zero * s.max(initial=0.0)).sum()) :].T


def _zeros(A: Array, B: Array, zero: float) -> int:
    """Algebraic multiplicity of the eigenvalue 0 of A x = s B x: null spaces are removed until none is left."""
    found = 0
    while (N := _null_space(A, zero)).shape[1]:
        found += N.shape[1]
        left, right = null_space((B @ N).T), null_space(N.T)
        if left.shape != right.shape or not right.shape[1]:
            break
        A, B = left.T @ A @ right, left.T @ B @ right
    return found


def normalised(system: System, x: Complex) -> Complex:
    size = x * system.tables.scale
    most = size[int(np.argmax(np.round(np.abs(size) / (np.abs(size).max(initial=0.0) or 1.0), 9)))] if len(x) else 1.0
    return x / most if most else x


def one_of_each(values: Sequence[complex], shapes: Sequence[Complex]) -> tuple[list[complex], list[Complex]]:
    """Eigenvalues in ascending order without the conjugates; of real ones, growing before decaying."""
    kept = [(s, x) for s, x in zip(values, shapes, strict=True) if s.imag >= 0.0]
    kept.sort(key=lambda item: (round(abs(item[0]), 12), -item[0].real))
    return [s for s, _ in kept], [x for _, x in kept]


def lowest(
    system: System, M: Matrix, D: Matrix, K: Matrix, U: Matrix, J: Matrix, count: int
) -> tuple[list[complex], list[Complex], int | None]:
    """The modes of the lowest frequencies at rest, by Arnoldi's method for the inverse within the constraints."""
    from scipy.sparse.linalg import LinearOperator, eigs, eigsh

    n, scale = system.n, system.tables.scale
    stiff = largest(scaled(K, 1.0 / scale, 1.0 / scale))
    fast = stiff / (largest(scaled(M, 1.0 / scale, 1.0 / scale)) or 1.0) or 1.0  #: square of the highest frequency
    v0 = np.random.default_rng(0).normal(size=2 * n)
    symmetric = all(largest(A - A.T) <= 1e-12 * largest(A) for A in (M, K)) and largest(U - J.T) == 0.0
    if symmetric and largest(D) == 0.0:
        sigma, k = -1e-9 * fast, min(count, n - 2)
        inverse = Saddle(K - sigma * M, U, J, scale)
        OP = LinearOperator((n, n), lambda b: inverse.solve(b)[0], dtype=float)
        square, x = eigsh(K, k, M=M, sigma=sigma, OPinv=OP, v0=v0[:n])
        real = np.abs(square) < 1e6 * fast  # directions that the constraints forbid are infinitely stiff
        values, shapes = _of_squares(square[real], x[:, real], 1e-7 * abs(sigma))
    else:
        shift, k = float(np.sqrt(1e-9 * fast)), min(2 * count + 2, 2 * n - 2)
        inverse = Saddle(K + shift * D + shift**2 * M, U, J, scale)

        def apply(x: Array) -> Array:
            q, v = x[:n], x[n:]
            found = inverse.solve(-(M @ v + D @ q + shift * (M @ q)))[0]
            return np.concatenate([found, shift * found + q])

        v0 = apply(np.concatenate([inverse.solve(v0[:n])[0], inverse.solve(v0[n:])[0]]))
        nu, x = eigs(LinearOperator((2 * n, 2 * n), apply, dtype=float), k, v0=v0)
        finite = np.abs(nu) > 1e-9 / np.sqrt(fast)
        found = shift + 1.0 / nu[finite]
        found = np.where(np.abs(found) <= 1e-5 * shift, 0.0, found)
        found = np.where(np.abs(found.imag) <= 1e-9 * np.abs(found), found.real, found)
        values, shapes = [complex(s) for s in found], list(x[:n, finite].T)
    values, shapes = one_of_each(values, [normalised(system, s) for s in shapes])
    zero = [k for k, s in enumerate(values) if s == 0.0][: system.tables.states]  # of the integrals of states
    kept = [k for k in range(len(values)) if k not in zero][:count]
    return [values[k] for k in kept], [shapes[k] for k in kept], None
