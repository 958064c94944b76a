"""Factorisation and solution of linear systems with a complex matrix, stored as its real and imaginary parts.

Pattern, order, tables and algorithms are those of the real matrices (:mod:`mbdsl.integrators.loop.linear_solve`). The
two parts are separate matrices of the run, so that the buffers remain real.
"""

from __future__ import annotations

from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.sparse_lu import LOST, place
from mbdsl.kernels import buffer_layout
from mbdsl.kernels.marks import kernel, rare


@kernel
def complex_factor(real, imag, pivots, layout):
    """Factorise real + i imag in place; False if it is numerically singular."""
    return (
        sparse_factor(real, imag, layout)
        if layout[buffer_layout.SOLVER] == SPARSE_LU
        else dense_factor(real, imag, pivots, layout)
    )


@kernel
def complex_solve(real, imag, pivots, layout, y, z):
    """y + i z <- A^{-1} (y + i z), with the factors of A in real + i imag."""
    if layout[buffer_layout.SOLVER] == SPARSE_LU:
        sparse_solve(real, imag, layout, y, z)
    else:
        dense_solve(real, imag, pivots, layout, y, z)


@kernel
def invert(real, imag, k):
    """Replace entry k by its reciprocal."""
    a, b = real[k], imag[k]
    size = a * a + b * b
    real[k], imag[k] = a / size, -b / size


@rare
def sparse_factor(real, imag, layout):
    """Factorise in place: D, L and U are overwritten, W and (in ``real``) G written. False if a pivot is lost."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    order, starts = layout[o : o + n], layout[o + n : o + 2 * n + 1]
    c, table = starts[n], o + 2 * n + 1
    rows, updates = layout[table : table + c], layout[table + 5 * c + 1 :]
    G, listed, q, L, U, W = real[n + 3 * c :], layout[table + 5 * c], 0, n, n + c, n + 2 * c
    for i in range(n):
        G[i] = abs(real[i]) + abs(imag[i])
    for k in range(n):
        d, first, last = order[k], starts[k], starts[k + 1]
        if not abs(real[d]) + abs(imag[d]) > LOST * G[d]:
            return False
        invert(real, imag, d)
        for e in range(first, last):
            a, b, u, w = real[L + e], imag[L + e], real[U + e], imag[U + e]
            x, y = a * real[d] - b * imag[d], a * imag[d] + b * real[d]
            real[L + e], imag[L + e] = x, y
            G[rows[e]] += (abs(x) + abs(y)) * (abs(u) + abs(w))
            for s in range(first, last):
                if listed:
                    at = updates[q]
                    q += 1
                else:
                    at = place(rows[e], rows[s], n, c, starts, rows, updates)
                u, w = real[U + s], imag[U + s]
                real[at] -= x * u - y * w
                imag[at] -= x * w + y * u
    targets, places = layout[table + 2 * c : table + 3 * c], layout[table + 4 * c : table + 5 * c]
    for e in range(c):
        k, d = U + places[e], targets[e]
        real[W + e], imag[W + e] = real[k] * real[d] - imag[k] * imag[d], real[k] * imag[d] + imag[k] * real[d]
    return True


@kernel
def sparse_solve(real, imag, layout, y, z):
    """y + i z <- A^{-1} (y + i z); reads D, L and W."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    c, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + c :], layout[table + 2 * c :], layout[table + 3 * c :]
    L, M, W, X = real[n:], imag[n:], real[n + 2 * c :], imag[n + 2 * c :]
    for e in range(c):
        t, s = i[e], j[e]
        y[t] -= L[e] * y[s] - M[e] * z[s]
        z[t] -= L[e] * z[s] + M[e] * y[s]
    for e in range(n):
        y[e], z[e] = real[e] * y[e] - imag[e] * z[e], real[e] * z[e] + imag[e] * y[e]
    for e in range(c):
        t, s = k[e], l[e]
        y[t] -= W[e] * y[s] - X[e] * z[s]
        z[t] -= W[e] * z[s] + X[e] * y[s]


@rare
def dense_factor(real, imag, pivots, layout):
    """Factorise row-major matrices in place, write pivot rows to ``pivots``; False if they are singular.

    Pivots are compared after scaling of rows and columns; the scales are written behind ``real``.
    """
    n = layout[buffer_layout.N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(real[i * n + j]) + abs(imag[i * n + j]))
        real[r + i] = 1.0 / largest if largest > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, (abs(real[i * n + j]) + abs(imag[i * n + j])) * real[r + i])
        real[c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, 0.0
        for i in range(k, n):
            found = (abs(real[i * n + k]) + abs(imag[i * n + k])) * real[r + i]
            if found > size:
                pivot, size = i, found
        pivots[k] = pivot
        if not size * real[c + k] > 1e-14:
            return False
        if pivot != k:
            real[r + k], real[r + pivot] = real[r + pivot], real[r + k]
            for j in range(n):
                real[k * n + j], real[pivot * n + j] = real[pivot * n + j], real[k * n + j]
                imag[k * n + j], imag[pivot * n + j] = imag[pivot * n + j], imag[k * n + j]
        d = k * n + k
        invert(real, imag, d)
        for i in range(k + 1, n):
            at = i * n + k
            a, b = real[at], imag[at]
            if a != 0.0 or b != 0.0:
                x, y = a * real[d] - b * imag[d], a * imag[d] + b * real[d]
                real[at], imag[at] = x, y
                for j in range(k + 1, n):
                    u, w = real[k * n + j], imag[k * n + j]
                    real[i * n + j] -= x * u - y * w
                    imag[i * n + j] -= x * w + y * u
    return True


@rare
def dense_solve(real, imag, pivots, layout, y, z):
    """y + i z <- A^{-1} (y + i z); reads the factors and ``pivots``."""
    n = layout[buffer_layout.N_ALL]
    for k in range(n):
        if pivots[k] != k:
            y[k], y[pivots[k]] = y[pivots[k]], y[k]
            z[k], z[pivots[k]] = z[pivots[k]], z[k]
    for i in range(1, n):
        for j in range(i):
            a, b = real[i * n + j], imag[i * n + j]
            y[i] -= a * y[j] - b * z[j]
            z[i] -= a * z[j] + b * y[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            a, b = real[i * n + j], imag[i * n + j]
            y[i] -= a * y[j] - b * z[j]
            z[i] -= a * z[j] + b * y[j]
        d = i * n + i
        y[i], z[i] = real[d] * y[i] - imag[d] * z[i], real[d] * z[i] + imag[d] * y[i]
