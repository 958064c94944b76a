"""Linear algebra of the iteration matrix behind two names, ``factor`` and ``solve``.

Normally the sparse LU of :mod:`mbdsl.integrators.sparse`; where that loses a pivot (massless coordinates, redundant
constraints, singular poses), a dense LU with partial pivoting.
"""

from __future__ import annotations

from mbdsl.integrators.sparse import sparse_factor, sparse_solve
from mbdsl.kernels import kernel, rare
from mbdsl.layout import N_ALL, SOLVER

DENSE, SPARSE_LU = 0, 1  #: values of I[SOLVER]


@kernel
def factor(A, P, I):
    """Factorise the matrix in A in place; False where it is singular to rounding."""
    return sparse_factor(A, P, I) if I[SOLVER] == SPARSE_LU else dense_factor(A, P, I)


@kernel
def solve(A, P, I, Y, row):
    """Y[row] <- A^{-1} Y[row]."""
    if I[SOLVER] == SPARSE_LU:
        sparse_solve(A, I, Y, row)
    else:
        dense_solve(A, P, I, Y, row)


@rare
def dense_factor(A, P, I):
    """LU of the row-major N x N matrix in A, pivot rows in P."""
    n = I[N_ALL]
    largest = 0.0
    for k in range(n * n):
        largest = max(largest, abs(A[k]))
    for k in range(n):
        pivot, size = k, abs(A[k * n + k])
        for i in range(k + 1, n):
            if abs(A[i * n + k]) > size:
                pivot, size = i, abs(A[i * n + k])
        P[k] = pivot
        if not size > 1e-15 * largest:
            return False
        if pivot != k:
            for j in range(n):
                A[k * n + j], A[pivot * n + j] = A[pivot * n + j], A[k * n + j]
        inverse = 1.0 / A[k * n + k]
        for i in range(k + 1, n):
            if A[i * n + k] != 0.0:
                l = A[i * n + k] * inverse
                A[i * n + k] = l
                for j in range(k + 1, n):
                    A[i * n + j] -= l * A[k * n + j]
    return True


@rare
def dense_solve(A, P, I, Y, row):
    n = I[N_ALL]
    for k in range(n):
        if P[k] != k:
            Y[row, k], Y[row, P[k]] = Y[row, P[k]], Y[row, k]
    for i in range(1, n):
        y = Y[row, i]
        for j in range(i):
            y -= A[i * n + j] * Y[row, j]
        Y[row, i] = y
    for i in range(n - 1, -1, -1):
        y = Y[row, i]
        for j in range(i + 1, n):
            y -= A[i * n + j] * Y[row, j]
        Y[row, i] = y / A[i * n + i]
