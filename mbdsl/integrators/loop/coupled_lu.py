"""Factorisation and solution of two coupled linear systems of the same pattern, as one system of 2 x 2 blocks.

Pattern, order, tables and algorithms are those of one system (:mod:`mbdsl.integrators.loop.linear_solve`); every entry
is a block [[a, b], [c, d]] of the four matrices A, B, C, D of [[A, B], [C, D]]. Blocks on the diagonal are replaced by
their inverses.
"""

from __future__ import annotations

from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.sparse_lu import LOST, place
from mbdsl.kernels import buffer_layout
from mbdsl.kernels.marks import kernel, rare


@kernel
def coupled_factor(A, B, C, D, pivots, layout):
    """Factorise [[A, B], [C, D]] in place; False if it is numerically singular."""
    if layout[buffer_layout.SOLVER] == SPARSE_LU:
        return sparse_factor(A, B, C, D, layout)
    return dense_factor(A, B, C, D, pivots, layout)


@kernel
def coupled_solve(A, B, C, D, pivots, layout, y, z):
    """(y, z) <- the solution of the system with the right side (y, z); reads its factors."""
    if layout[buffer_layout.SOLVER] == SPARSE_LU:
        sparse_solve(A, B, C, D, layout, y, z)
    else:
        dense_solve(A, B, C, D, pivots, layout, y, z)


@kernel
def invert(A, B, C, D, k):
    """Replace block k by its inverse."""
    a, b, c, d = A[k], B[k], C[k], D[k]
    r = 1.0 / (a * d - b * c)
    A[k], B[k], C[k], D[k] = r * d, -r * b, -r * c, r * a


@kernel
def times(A, B, C, D, j, k):
    """Block j times block k."""
    return (
        A[j] * A[k] + B[j] * C[k],
        A[j] * B[k] + B[j] * D[k],
        C[j] * A[k] + D[j] * C[k],
        C[j] * B[k] + D[j] * D[k],
    )


@kernel
def subtract(A, B, C, D, at, a, b, c, d, k):
    """Block ``at`` -= [[a, b], [c, d]] times block k."""
    A[at] -= a * A[k] + b * C[k]
    B[at] -= a * B[k] + b * D[k]
    C[at] -= c * A[k] + d * C[k]
    D[at] -= c * B[k] + d * D[k]


@rare
def sparse_factor(A, B, C, D, layout):
    """Factorise in place: the entries D, L and U of each matrix are overwritten, W and G (in A and D) written. False if
    a pivot is lost."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    order, starts = layout[o : o + n], layout[o + n : o + 2 * n + 1]
    m, table = starts[n], o + 2 * n + 1
    rows, updates = layout[table : table + m], layout[table + 5 * m + 1 :]
    G, H, listed, q, L, U, W = A[n + 3 * m :], D[n + 3 * m :], layout[table + 5 * m], 0, n, n + m, n + 2 * m
    for i in range(n):
        G[i], H[i] = abs(A[i]), abs(D[i])
    for k in range(n):
        p, first, last = order[k], starts[k], starts[k + 1]
        if not abs(A[p]) > LOST * G[p]:
            return False
        of_first = C[p] * B[p] / A[p]
        if not abs(D[p] - of_first) > LOST * (H[p] + abs(of_first)):
            return False
        invert(A, B, C, D, p)
        for e in range(first, last):
            a, b, c, d = times(A, B, C, D, L + e, p)
            A[L + e], B[L + e], C[L + e], D[L + e] = a, b, c, d
            u = U + e
            G[rows[e]] += abs(a * A[u]) + abs(b * C[u])
            H[rows[e]] += abs(c * B[u]) + abs(d * D[u])
            for s in range(first, last):
                if listed:
                    at = updates[q]
                    q += 1
                else:
                    at = place(rows[e], rows[s], n, m, starts, rows, updates)
                subtract(A, B, C, D, at, a, b, c, d, U + s)
    targets, places = layout[table + 2 * m : table + 3 * m], layout[table + 4 * m : table + 5 * m]
    for e in range(m):
        A[W + e], B[W + e], C[W + e], D[W + e] = times(A, B, C, D, targets[e], U + places[e])
    return True


@kernel
def sparse_solve(A, B, C, D, layout, y, z):
    """(y, z) <- the solution; reads the entries D, L and W of each matrix."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    m, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + m :], layout[table + 2 * m :], layout[table + 3 * m :]
    for e in range(m):
        t, s, x = i[e], j[e], n + e
        y[t] -= A[x] * y[s] + B[x] * z[s]
        z[t] -= C[x] * y[s] + D[x] * z[s]
    for e in range(n):
        y[e], z[e] = A[e] * y[e] + B[e] * z[e], C[e] * y[e] + D[e] * z[e]
    for e in range(m):
        t, s, x = k[e], l[e], n + 2 * m + e
        y[t] -= A[x] * y[s] + B[x] * z[s]
        z[t] -= C[x] * y[s] + D[x] * z[s]


@kernel
def smallest(A, B, C, D, k, r, s):
    """About the smallest singular value of block k, whose rows are multiplied by r and s."""
    a, b, c, d = abs(A[k]), abs(B[k]), abs(C[k]), abs(D[k])
    largest = max(r * max(a, b), s * max(c, d))
    return abs(A[k] * D[k] - B[k] * C[k]) * r * s / largest if largest > 0.0 else 0.0


@rare
def dense_factor(A, B, C, D, pivots, layout):
    """Factorise row-major matrices in place, write pivot rows to ``pivots``; False if they are singular.

    Pivots are compared after scaling of rows and columns; the scales are written behind A (of A and B) and D (of C
    and D).
    """
    n = layout[buffer_layout.N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        first, second = 0.0, 0.0
        for j in range(n):
            at = i * n + j
            first, second = max(first, abs(A[at]), abs(B[at])), max(second, abs(C[at]), abs(D[at]))
        A[r + i], D[r + i] = 1.0 / first if first > 0.0 else 0.0, 1.0 / second if second > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, smallest(A, B, C, D, i * n + j, A[r + i], D[r + i]))
        A[c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, 0.0
        for i in range(k, n):
            found = smallest(A, B, C, D, i * n + k, A[r + i], D[r + i])
            if found > size:
                pivot, size = i, found
        pivots[k] = pivot
        if not size * A[c + k] > 1e-14:
            return False
        if pivot != k:
            for X in (A, B, C, D):
                X[r + k], X[r + pivot] = X[r + pivot], X[r + k]
                for j in range(n):
                    X[k * n + j], X[pivot * n + j] = X[pivot * n + j], X[k * n + j]
        p = k * n + k
        invert(A, B, C, D, p)
        for i in range(k + 1, n):
            at = i * n + k
            if A[at] != 0.0 or B[at] != 0.0 or C[at] != 0.0 or D[at] != 0.0:
                w, x, y, z = times(A, B, C, D, at, p)
                A[at], B[at], C[at], D[at] = w, x, y, z
                for j in range(k + 1, n):
                    subtract(A, B, C, D, i * n + j, w, x, y, z, k * n + j)
    return True


@rare
def dense_solve(A, B, C, D, pivots, layout, y, z):
    """(y, z) <- the solution; reads the factors and ``pivots``."""
    n = layout[buffer_layout.N_ALL]
    for k in range(n):
        if pivots[k] != k:
            y[k], y[pivots[k]] = y[pivots[k]], y[k]
            z[k], z[pivots[k]] = z[pivots[k]], z[k]
    for i in range(1, n):
        for j in range(i):
            e = i * n + j
            y[i] -= A[e] * y[j] + B[e] * z[j]
            z[i] -= C[e] * y[j] + D[e] * z[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            e = i * n + j
            y[i] -= A[e] * y[j] + B[e] * z[j]
            z[i] -= C[e] * y[j] + D[e] * z[j]
        e = i * n + i
        y[i], z[i] = A[e] * y[i] + B[e] * z[i], C[e] * y[i] + D[e] * z[i]
