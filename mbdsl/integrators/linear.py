"""Linear algebra of the iteration matrix behind two names, ``factor`` and ``solve``.

Small systems: dense LU with partial pivoting on a row-major matrix.
"""

from __future__ import annotations

from mbdsl.elements.kind import kernel
from mbdsl.layout import N_ALL


@kernel
def factor(A, P, I):
    """LU factors of the N x N matrix in A, in place, pivot rows in P; False where it is singular to rounding."""
    n = I[N_ALL]
    for k in range(n):
        pivot, largest = k, abs(A[k * n + k])
        for i in range(k + 1, n):
            candidate = abs(A[i * n + k])
            if candidate > largest:
                pivot, largest = i, candidate
        P[k] = pivot
        if not largest > 1e-300:
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


@kernel
def solve(A, P, I, Y, row):
    """Y[row] <- A^{-1} Y[row]."""
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
