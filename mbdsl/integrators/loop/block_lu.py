"""LU of matrices whose entries have several parts: complex numbers, and blocks of two coupled systems.

    COMPLEX   (a, b): a + i b, of a real and an imaginary part
    BLOCKS    (a, b, c, d): [[a, b], [c, d]], of the four matrices of [[A, B], [C, D]], which have the same pattern

Pattern, order, tables and algorithms are those of one real matrix (:mod:`mbdsl.integrators.loop.linear_solve`). The
parts are matrices of the run, so that the buffers remain real: ``M`` is a tuple of them, ``y`` a tuple of two vectors,
and ``F`` says how to calculate with entries. Entries on the diagonal are replaced by their inverses.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.sparse_lu import LOST, place
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare


class Algebra(NamedTuple):
    """How to calculate with the entries x, y of a kind of matrices, which are tuples of their parts."""

    parts: tuple[int, ...]  #: numbers of the parts
    times: Callable  #: (x, y): the product
    inverse: Callable  #: (x)
    apply: Callable  #: (x, u): the product with a pair of entries of vectors
    weight: Callable  #: (x): the terms of the sums G and H that ``is_lost`` compares with
    growth: Callable  #: (x, y): what the product adds to these sums
    is_lost: Callable  #: (x, G, H): whether only rounding is left of a pivot
    largest: Callable  #: (x, r, s): the sizes r and s of the rows of x, raised to those of x
    size: Callable  #: (x, r, s): the size of a pivot whose rows are multiplied by r and s


@kernel
def complex_times(x, y):
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


@kernel
def complex_inverse(x):
    size = x[0] * x[0] + x[1] * x[1]
    return x[0] / size, -x[1] / size


@kernel
def complex_weight(x):
    return abs(x[0]) + abs(x[1]), 0.0


@kernel
def complex_growth(x, y):
    return (abs(x[0]) + abs(x[1])) * (abs(y[0]) + abs(y[1])), 0.0


@kernel
def complex_is_lost(x, G, H):
    return not abs(x[0]) + abs(x[1]) > LOST * G


@kernel
def complex_largest(x, r, s):
    return max(r, abs(x[0]) + abs(x[1])), 0.0


@kernel
def complex_size(x, r, s):
    return (abs(x[0]) + abs(x[1])) * r


@kernel
def block_times(x, y):
    a, b, c, d = x
    return a * y[0] + b * y[2], a * y[1] + b * y[3], c * y[0] + d * y[2], c * y[1] + d * y[3]


@kernel
def block_inverse(x):
    a, b, c, d = x
    r = 1.0 / (a * d - b * c)
    return r * d, -r * b, -r * c, r * a


@kernel
def block_apply(x, u):
    return x[0] * u[0] + x[1] * u[1], x[2] * u[0] + x[3] * u[1]


@kernel
def block_weight(x):
    return abs(x[0]), abs(x[3])


@kernel
def block_growth(x, y):
    return abs(x[0] * y[0]) + abs(x[1] * y[2]), abs(x[2] * y[1]) + abs(x[3] * y[3])


@kernel
def block_is_lost(x, G, H):
    a, b, c, d = x
    if not abs(a) > LOST * G:
        return True
    of_first = c * b / a
    return not abs(d - of_first) > LOST * (H + abs(of_first))


@kernel
def block_largest(x, r, s):
    return max(r, abs(x[0]), abs(x[1])), max(s, abs(x[2]), abs(x[3]))


@kernel
def block_size(x, r, s):
    """About the smallest singular value."""
    a, b, c, d = x
    largest = max(r * max(abs(a), abs(b)), s * max(abs(c), abs(d)))
    return abs(a * d - b * c) * r * s / largest if largest > 0.0 else 0.0


COMPLEX = Algebra(
    (0, 1),
    *(complex_times, complex_inverse, complex_times, complex_weight, complex_growth, complex_is_lost, complex_largest),
    complex_size,
)
BLOCKS = Algebra(
    (0, 1, 2, 3),
    *(block_times, block_inverse, block_apply, block_weight, block_growth, block_is_lost, block_largest, block_size),
)


@kernel
def factor_parts(F, M, pivots, layout):
    """Factorise the matrix in place; False if it is numerically singular."""
    return sparse_factor(F, M, layout) if layout[L.SOLVER] == SPARSE_LU else dense_factor(F, M, pivots, layout)


@kernel
def solve_parts(F, M, pivots, layout, y):
    """y <- A^{-1} y, with the factors of A."""
    if layout[L.SOLVER] == SPARSE_LU:
        sparse_solve(F, M, layout, y)
    else:
        dense_solve(F, M, pivots, layout, y)


# -- entries -----------------------------------------------------------------------------------------------------------


@kernel
def entry(M, k):
    return tuple(X[k] for X in M)


@kernel
def put(F, M, k, x):
    for part in F.parts:
        M[part][k] = x[part]


@kernel
def subtract(F, M, k, x):
    for part in F.parts:
        M[part][k] -= x[part]


@kernel
def take(F, M, k, y, i, j):
    """Entries i of y -= entry k of the matrix times entries j of y."""
    x = F.apply(entry(M, k), (y[0][j], y[1][j]))
    y[0][i] -= x[0]
    y[1][i] -= x[1]


@kernel
def multiply(F, M, k, y, i):
    """Entries i of y <- entry k of the matrix times entries i of y."""
    y[0][i], y[1][i] = F.apply(entry(M, k), (y[0][i], y[1][i]))


# -- factors -----------------------------------------------------------------------------------------------------------


@rare
def sparse_factor(F, M, layout):
    """Factorise in place: the entries D, L and U of each part are overwritten, W and the sums G and H, in the first and
    the last part, written. False if a pivot is lost."""
    n, o = layout[L.N_ALL], layout[L.SPARSE]
    order, starts = layout[o : o + n], layout[o + n : o + 2 * n + 1]
    c, table = starts[n], o + 2 * n + 1
    rows, updates = layout[table : table + c], layout[table + 5 * c + 1 :]
    G, H, listed, q, lower, upper, W = (
        M[0][n + 3 * c :],
        M[-1][n + 3 * c :],
        layout[table + 5 * c],
        0,
        n,
        n + c,
        n + 2 * c,
    )
    for i in range(n):
        G[i], H[i] = F.weight(entry(M, i))
    for k in range(n):
        d, first, last = order[k], starts[k], starts[k + 1]
        if F.is_lost(entry(M, d), G[d], H[d]):
            return False
        put(F, M, d, F.inverse(entry(M, d)))
        for e in range(first, last):
            x = F.times(entry(M, lower + e), entry(M, d))
            put(F, M, lower + e, x)
            g, h = F.growth(x, entry(M, upper + e))
            G[rows[e]] += g
            H[rows[e]] += h
            for s in range(first, last):
                if listed:
                    at = updates[q]
                    q += 1
                else:
                    at = place(rows[e], rows[s], n, c, starts, rows, updates)
                subtract(F, M, at, F.times(x, entry(M, upper + s)))
    targets, places = layout[table + 2 * c : table + 3 * c], layout[table + 4 * c : table + 5 * c]
    for e in range(c):
        put(F, M, W + e, F.times(entry(M, targets[e]), entry(M, upper + places[e])))
    return True


@kernel
def sparse_solve(F, M, layout, y):
    """y <- A^{-1} y; reads the entries D, L and W of each part."""
    n, o = layout[L.N_ALL], layout[L.SPARSE]
    c, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + c :], layout[table + 2 * c :], layout[table + 3 * c :]
    for e in range(c):
        take(F, M, n + e, y, i[e], j[e])
    for e in range(n):
        multiply(F, M, e, y, e)
    for e in range(c):
        take(F, M, n + 2 * c + e, y, k[e], l[e])


@rare
def dense_factor(F, M, pivots, layout):
    """Factorise row-major matrices in place, write pivot rows to ``pivots``; False if they are singular.

    Pivots are compared after scaling of rows and columns; the scales are written behind the first and the last part.
    """
    n = layout[L.N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        first, second = 0.0, 0.0
        for j in range(n):
            first, second = F.largest(entry(M, i * n + j), first, second)
        M[0][r + i], M[-1][r + i] = 1.0 / first if first > 0.0 else 0.0, 1.0 / second if second > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, F.size(entry(M, i * n + j), M[0][r + i], M[-1][r + i]))
        M[0][c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, 0.0
        for i in range(k, n):
            found = F.size(entry(M, i * n + k), M[0][r + i], M[-1][r + i])
            if found > size:
                pivot, size = i, found
        pivots[k] = pivot
        if not size * M[0][c + k] > 1e-14:
            return False
        if pivot != k:
            for X in M:
                X[r + k], X[r + pivot] = X[r + pivot], X[r + k]
                for j in range(n):
                    X[k * n + j], X[pivot * n + j] = X[pivot * n + j], X[k * n + j]
        d = k * n + k
        put(F, M, d, F.inverse(entry(M, d)))
        for i in range(k + 1, n):
            nonzero = False
            for X in M:
                nonzero = nonzero or X[i * n + k] != 0.0
            if nonzero:
                x = F.times(entry(M, i * n + k), entry(M, d))
                put(F, M, i * n + k, x)
                for j in range(k + 1, n):
                    subtract(F, M, i * n + j, F.times(x, entry(M, k * n + j)))
    return True


@rare
def dense_solve(F, M, pivots, layout, y):
    """y <- A^{-1} y; reads the factors and ``pivots``."""
    n = layout[L.N_ALL]
    for k in range(n):
        if pivots[k] != k:
            for x in y:
                x[k], x[pivots[k]] = x[pivots[k]], x[k]
    for i in range(1, n):
        for j in range(i):
            take(F, M, i * n + j, y, i, j)
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            take(F, M, i * n + j, y, i, j)
        multiply(F, M, i * n + i, y, i)
