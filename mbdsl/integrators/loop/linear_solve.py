"""Linear algebra of the iteration matrix behind two names, ``factor`` and ``solve``.

Normally the sparse LU of :mod:`mbdsl.integrators.loop.sparse_lu`; where that loses a pivot (massless coordinates,
redundant constraints, singular poses), a dense LU with partial pivoting.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import D2, N_ALL, N_Q, SIZE, SOLVER, SPARSE, D
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.sparse_lu import sparse_factor, sparse_solve, sparse_solve_both

DENSE, SPARSE_LU = 0, 1  #: values of I[SOLVER]


@kernel
def factor(A, P, I):
    """Factorise the matrix in A in place; False where it is singular to rounding."""
    return sparse_factor(A, I) if I[SOLVER] == SPARSE_LU else dense_factor(A, P, I)


@kernel
def solve(A, P, I, Y, row):
    """Y[row] <- A^{-1} Y[row]."""
    if I[SOLVER] == SPARSE_LU:
        sparse_solve(A, I, Y, row)
    else:
        dense_solve(A, P, I, Y, row)


@kernel
def solve_both(A, P, I, Y):
    """Y[D] <- A[0]^{-1} Y[D], Y[D2] <- A[1]^{-1} Y[D2]."""
    if I[SOLVER] == SPARSE_LU:
        sparse_solve_both(A, I, Y, D, D2)
    else:
        for k in range(2):
            dense_solve(A[k], P[k], I, Y, D + k)


@rare
def compress(A, P, I):
    """Leave nothing of a matrix that is not factorised but its entries in the columns of the coordinates: their values
    in A, their rows and columns in P, their number at the end of P."""
    n, m, o, count = I[N_ALL], I[N_Q], I[SPARSE], 0
    entries = I[o + 2 * n] if I[SOLVER] == SPARSE_LU else 0  # below the diagonal
    lower = o + 2 * n + 1
    for p in range(I[SIZE]):
        r, c = p // n, p % n
        if I[SOLVER] == SPARSE_LU:
            if p < n:
                r, c = p, p
            elif p < n + entries:
                r, c = I[lower + p - n], I[lower + p - n + entries]
            else:
                r, c = I[lower + p - n], I[lower + p - n - entries]
        if c < m and A[p] != 0.0:
            A[count], P[2 * count], P[2 * count + 1] = A[p], r, c
            count += 1
    P[P.size - 1] = count


@kernel
def multiply(A, P, Y, row, target):
    """Y[target] += A Y[row] for a compressed matrix."""
    for k in range(P[P.size - 1]):
        Y[target, P[2 * k]] += A[k] * Y[row, P[2 * k + 1]]


@kernel
def larger(a, b):
    """max(a, b), or not a number if a is none."""
    return a if a > b or a != a else b


@rare
def dense_factor(A, P, I):
    """LU of the row-major N x N matrix in A, pivot rows in P.

    Pivots are compared after scaling rows and columns (behind the matrix in A): a small body's mass is no lost pivot.
    """
    n = I[N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(A[i * n + j]))
        A[r + i] = 1.0 / largest if largest > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, abs(A[i * n + j]) * A[r + i])
        A[c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, abs(A[k * n + k]) * A[r + k]
        for i in range(k + 1, n):
            if abs(A[i * n + k]) * A[r + i] > size:
                pivot, size = i, abs(A[i * n + k]) * A[r + i]
        P[k] = pivot
        if not size * A[c + k] > 1e-14:
            return False
        if pivot != k:
            A[r + k], A[r + pivot] = A[r + pivot], A[r + k]
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
