"""The linear algebra of :mod:`mbdsl.integrators.loop.linear_solve` for a complex matrix, its real part in A, its
imaginary in B.

Pattern, order and tables are those of the real matrices. Parts are kept apart, so that the buffers stay what they are.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import N_ALL, SOLVER, SPARSE
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.sparse_lu import LOST, place


@kernel
def complex_factor(A, B, P, I):
    """Factorise A + iB in place; False where it is singular to rounding."""
    return sparse_factor(A, B, I) if I[SOLVER] == SPARSE_LU else dense_factor(A, B, P, I)


@kernel
def complex_solve(A, B, P, I, y, z):
    """y + iz <- (A + iB)^{-1} (y + iz)."""
    if I[SOLVER] == SPARSE_LU:
        sparse_solve(A, B, I, y, z)
    else:
        dense_solve(A, B, P, I, y, z)


@kernel
def invert(A, B, k):
    """Entry k becomes its reciprocal."""
    a, b = A[k], B[k]
    size = a * a + b * b
    A[k], B[k] = a / size, -b / size


@rare
def sparse_factor(A, B, I):
    n, o = I[N_ALL], I[SPARSE]
    order, starts = I[o : o + n], I[o + n : o + 2 * n + 1]
    c, table = starts[n], o + 2 * n + 1
    rows, updates = I[table : table + c], I[table + 5 * c + 1 :]
    G, listed, q, L, U, W = A[n + 3 * c :], I[table + 5 * c], 0, n, n + c, n + 2 * c
    for i in range(n):
        G[i] = abs(A[i]) + abs(B[i])
    for k in range(n):
        d, first, last = order[k], starts[k], starts[k + 1]
        if not abs(A[d]) + abs(B[d]) > LOST * G[d]:
            return False
        invert(A, B, d)
        for e in range(first, last):
            a, b, u, w = A[L + e], B[L + e], A[U + e], B[U + e]
            x, y = a * A[d] - b * B[d], a * B[d] + b * A[d]
            A[L + e], B[L + e] = x, y
            G[rows[e]] += (abs(x) + abs(y)) * (abs(u) + abs(w))
            for s in range(first, last):
                if listed:
                    at = updates[q]
                    q += 1
                else:
                    at = place(rows[e], rows[s], n, c, starts, rows, updates)
                u, w = A[U + s], B[U + s]
                A[at] -= x * u - y * w
                B[at] -= x * w + y * u
    targets, places = I[table + 2 * c : table + 3 * c], I[table + 4 * c : table + 5 * c]
    for e in range(c):
        k, d = U + places[e], targets[e]
        A[W + e], B[W + e] = A[k] * A[d] - B[k] * B[d], A[k] * B[d] + B[k] * A[d]
    return True


@kernel
def sparse_solve(A, B, I, y, z):
    n, o = I[N_ALL], I[SPARSE]
    c, table = I[o + 2 * n], o + 2 * n + 1
    i, j, k, l = I[table:], I[table + c :], I[table + 2 * c :], I[table + 3 * c :]
    L, M, W, X = A[n:], B[n:], A[n + 2 * c :], B[n + 2 * c :]
    for e in range(c):
        t, s = i[e], j[e]
        y[t] -= L[e] * y[s] - M[e] * z[s]
        z[t] -= L[e] * z[s] + M[e] * y[s]
    for e in range(n):
        y[e], z[e] = A[e] * y[e] - B[e] * z[e], A[e] * z[e] + B[e] * y[e]
    for e in range(c):
        t, s = k[e], l[e]
        y[t] -= W[e] * y[s] - X[e] * z[s]
        z[t] -= W[e] * z[s] + X[e] * y[s]


@rare
def dense_factor(A, B, P, I):
    """LU of row-major matrices, pivot rows in P, pivots compared after scaling rows and columns (behind A)."""
    n = I[N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(A[i * n + j]) + abs(B[i * n + j]))
        A[r + i] = 1.0 / largest if largest > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, (abs(A[i * n + j]) + abs(B[i * n + j])) * A[r + i])
        A[c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, 0.0
        for i in range(k, n):
            found = (abs(A[i * n + k]) + abs(B[i * n + k])) * A[r + i]
            if found > size:
                pivot, size = i, found
        P[k] = pivot
        if not size * A[c + k] > 1e-14:
            return False
        if pivot != k:
            A[r + k], A[r + pivot] = A[r + pivot], A[r + k]
            for j in range(n):
                A[k * n + j], A[pivot * n + j] = A[pivot * n + j], A[k * n + j]
                B[k * n + j], B[pivot * n + j] = B[pivot * n + j], B[k * n + j]
        d = k * n + k
        invert(A, B, d)
        for i in range(k + 1, n):
            at = i * n + k
            a, b = A[at], B[at]
            if a != 0.0 or b != 0.0:
                x, y = a * A[d] - b * B[d], a * B[d] + b * A[d]
                A[at], B[at] = x, y
                for j in range(k + 1, n):
                    u, w = A[k * n + j], B[k * n + j]
                    A[i * n + j] -= x * u - y * w
                    B[i * n + j] -= x * w + y * u
    return True


@rare
def dense_solve(A, B, P, I, y, z):
    n = I[N_ALL]
    for k in range(n):
        if P[k] != k:
            y[k], y[P[k]] = y[P[k]], y[k]
            z[k], z[P[k]] = z[P[k]], z[k]
    for i in range(1, n):
        for j in range(i):
            a, b = A[i * n + j], B[i * n + j]
            y[i] -= a * y[j] - b * z[j]
            z[i] -= a * z[j] + b * y[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            a, b = A[i * n + j], B[i * n + j]
            y[i] -= a * y[j] - b * z[j]
            z[i] -= a * z[j] + b * y[j]
        d = i * n + i
        y[i], z[i] = A[d] * y[i] - B[d] * z[i], A[d] * z[i] + B[d] * y[i]
