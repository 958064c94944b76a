"""Saddle-point systems [[A, U], [J, 0]] [x; mu] = [b; c], as statics and eigenmodes solve them.

Coordinates are scaled as in :mod:`mbdsl.initial.consistent`, rows of J and columns of U by their largest entries, and A
by its largest entry, so that the rank does not depend on lengths, units and stiffnesses. Rows of J may be linearly
dependent: a block -EPS I keeps the matrix regular, and iterative refinement removes its effect.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mbdsl.kernels.arrays import Array

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Matrix: TypeAlias = "Array | csr_array"

EPS = 1e-12  #: the block -EPS I replaces the zero block
REFINEMENTS = 3  #: iterations after the solution with the regularised matrix
RANK = 1e-10  #: singular values of J, relative to the largest, that count as zero


def dense(A: Matrix) -> Array:
    """``A`` as an array."""
    return A if isinstance(A, np.ndarray) else A.toarray()


def largest(A: Matrix) -> float:
    """The largest absolute value of an entry of ``A``, 0 where there is none."""
    if isinstance(A, np.ndarray):
        return float(np.abs(A).max(initial=0.0))
    return float(np.abs(A.data).max(initial=0.0))


def scaled(A: Matrix, left: Array, right: Array) -> Matrix:
    """diag(left) A diag(right)."""
    if isinstance(A, np.ndarray):
        return left[:, None] * A * right
    from scipy.sparse import diags_array

    return (diags_array(left) @ A @ diags_array(right)).tocsr()


def row_size(J: Matrix) -> Array:
    """The largest absolute value in each row of J, 1 where a row is zero."""
    if isinstance(J, np.ndarray):
        size = np.abs(J).max(axis=1, initial=0.0)
    else:
        size = abs(J).max(axis=1).toarray().ravel() if J.shape[0] else np.zeros(0)
    return np.where(size > 0.0, size, 1.0)


def null_space(J: Array) -> Array:
    """An orthonormal basis of the null space of J (m, n)."""
    if not len(J):
        return np.eye(J.shape[1])
    _, s, Vt = np.linalg.svd(J, full_matrices=True)
    return Vt[int((s > RANK * s.max(initial=0.0)).sum()) :].T


def regularised(S: csr_array, n: int) -> Callable[[Array], Array]:
    """A direct solver for a sparse [[A, U], [J, 0]] with n rows above the zero block, which -EPS I replaces.

    Iterative refinement with S removes the effect of EPS; see ``refined``. If S is exactly singular, x is NaN.
    """
    from scipy.sparse import csc_array, diags_array
    from scipy.sparse.linalg import splu

    shift = np.concatenate([np.zeros(n), np.full(S.shape[0] - n, -EPS)])
    try:
        return splu(csc_array(S + diags_array(shift))).solve
    except RuntimeError:
        return lambda b: np.full_like(b, np.nan)


def refined(S: csr_array, n: int, b: Array, times: int = REFINEMENTS) -> Array:
    """x of S x = b for S as in ``regularised``, after ``times`` iterative refinements."""
    solve = regularised(S, n)
    x = solve(b)
    for _ in range(times):
        x = x + solve(b - S @ x)
    return x


class Saddle:
    """The factorised matrix [[A, U], [J, 0]]; ``scale`` (n,) times coordinates is of order one.

    A (n, n), U (n, m) and J (m, n) are dense or sparse; ``U`` is J^T where forces do not depend on multipliers.
    """

    def __init__(self, A: Matrix, U: Matrix, J: Matrix, scale: Array) -> None:
        self.n, self.d = len(scale), 1.0 / scale
        A = scaled(A, self.d, self.d)
        self.kappa = largest(A) or 1.0
        J = scaled(J, np.ones(J.shape[0]), self.d)
        self.r = 1.0 / row_size(J)
        A, J = A / self.kappa, scaled(J, self.r, np.ones(self.n))
        U = scaled(U, self.d, self.r)
        m = len(self.r)
        self._solve: Callable[[Array], Array]
        if isinstance(A, np.ndarray):
            self._S = np.block([[A, dense(U)], [dense(J), np.zeros((m, m))]])
            regular = self._S - np.diag(np.concatenate([np.zeros(self.n), np.full(m, EPS)]))
            try:  # NumPy has no stored LU factorisation; the inverse suffices, as solutions are refined
                inverse = np.linalg.inv(regular)
                self._solve = lambda b: inverse @ b
            except np.linalg.LinAlgError:
                self._solve = lambda b: np.full_like(b, np.nan)
            return
        from scipy.sparse import block_array

        self._S = block_array([[A, U], [J, None]], format="csr") if m else A
        self._solve = regularised(self._S, self.n)

    def solve(self, b: Array, c: Array | None = None) -> tuple[Array, Array]:
        """x (n,) and mu (m,); nan if the matrix is singular."""
        right = np.concatenate([self.d * b / self.kappa, np.zeros(len(self.r)) if c is None else self.r * c])
        x = self._solve(right)
        for _ in range(REFINEMENTS):
            x = x + self._solve(right - self._S @ x)
        return self.d * x[: self.n], self.kappa * self.r * x[self.n :]


def least_squares(A: Array, b: Array, rcond: float | None = None) -> Array:
    """The x of least norm that minimises ``|A x - b|``. LAPACK would print to the terminal if values were not finite.

    Raises
    ------
    LinAlgError
        If A or b contains a value that is not finite, or the singular values were not found.
    """
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        raise np.linalg.LinAlgError("least squares of values that are not finite")
    return np.linalg.lstsq(A, b, rcond=rcond)[0].astype(float, copy=False)
