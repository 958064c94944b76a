"""Factorisation and solution of linear systems with the matrices of a run, sparse or dense.

The sparse LU of :mod:`mbdsl.integrators.loop.sparse_lu` is used until it loses a pivot (massless coordinates, redundant
constraints, singular poses); from then on, a dense LU with partial pivoting.
"""

from mbdsl.integrators.loop.rotation_chart import to_body, to_world
from mbdsl.integrators.loop.sparse_lu import sparse_factor, sparse_solve, sparse_solve_both
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

DENSE, SPARSE_LU = 0, 1  #: values of layout[SOLVER]


@kernel
def factor(k, run):
    """Factorise matrix k in place; False if it is numerically singular."""
    matrix, pivots, layout = run.matrices[k], run.pivots[k], run.layout
    return sparse_factor(matrix, layout) if layout[L.SOLVER] == SPARSE_LU else dense_factor(matrix, pivots, layout)


@kernel
def solve(k, row, run):
    """vectors[row] <- A^{-1} vectors[row], where A is the factorised matrix k."""
    to_world(row, run)
    if run.layout[L.SOLVER] == SPARSE_LU:
        sparse_solve(run.matrices[k], run.layout, run.vectors[row])
    else:
        dense_solve(run.matrices[k], run.pivots[k], run.layout, run.vectors[row])
    to_body(row, run)


@kernel
def solve_both(run):
    """``solve`` with matrix 0 for row CORRECTION, and with matrix 1 for row CORRECTION2."""
    first, second = run.vectors[L.CORRECTION], run.vectors[L.CORRECTION2]
    to_world(L.CORRECTION, run)
    to_world(L.CORRECTION2, run)
    if run.layout[L.SOLVER] == SPARSE_LU:
        sparse_solve_both(run.matrices, run.layout, first, second)
    else:
        dense_solve(run.matrices[0], run.pivots[0], run.layout, first)
        dense_solve(run.matrices[1], run.pivots[1], run.layout, second)
    to_body(L.CORRECTION, run)
    to_body(L.CORRECTION2, run)


@rare
def compress(k, run):
    """Replace matrix k, which must not be factorised, by a list of its nonzero entries in the columns of coordinates.

    Writes their values to matrices[k], their rows and columns to pivots[k], and their number to the last entry of
    pivots[k]. ``multiply`` reads this list.
    """
    matrix, places, layout = run.matrices[k], run.pivots[k], run.layout
    n, m, o, count = layout[L.N_ALL], layout[L.N_Q], layout[L.SPARSE], 0
    entries = layout[o + 2 * n] if layout[L.SOLVER] == SPARSE_LU else 0  # number of entries below the diagonal
    lower = o + 2 * n + 1
    for p in range(layout[L.SIZE]):
        r, c = p // n, p % n
        if layout[L.SOLVER] == SPARSE_LU:
            if p < n:
                r, c = p, p
            elif p < n + entries:
                r, c = layout[lower + p - n], layout[lower + p - n + entries]
            else:
                r, c = layout[lower + p - n], layout[lower + p - n - entries]
        if c < m and matrix[p] != 0.0:
            matrix[count], places[2 * count], places[2 * count + 1] = matrix[p], r, c
            count += 1
    places[places.size - 1] = count


@kernel
def clear(k, run):
    """Make the list of the compressed matrix k empty."""
    run.pivots[k, run.pivots.shape[1] - 1] = 0


@kernel
def has_entries(k, run):
    """Whether the list of the compressed matrix k has entries."""
    return run.pivots[k, run.pivots.shape[1] - 1] > 0


@kernel
def multiply(k, row, target, run):
    """vectors[target] <- vectors[target] + A vectors[row], where A is the compressed matrix k."""
    matrix, places, x, y = run.matrices[k], run.pivots[k], run.vectors[row], run.vectors[target]
    to_world(row, run)
    to_world(target, run)
    for e in range(places[places.size - 1]):
        y[places[2 * e]] += matrix[e] * x[places[2 * e + 1]]
    to_body(row, run)
    to_body(target, run)


@kernel
def larger(a, b):
    """max(a, b), or nan if a is nan."""
    return a if a > b or a != a else b


@rare
def dense_factor(matrix, pivots, layout):
    """Factorise the row-major N x N ``matrix`` in place, write pivot rows to ``pivots``; False if it is singular.

    Pivots are compared after scaling of rows and columns: the mass of a small body must not count as a lost pivot. The
    scales are written behind the matrix.
    """
    n = layout[L.N_ALL]
    r, c = n * n, n * n + n
    for i in range(n):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(matrix[i * n + j]))
        matrix[r + i] = 1.0 / largest if largest > 0.0 else 0.0
    for j in range(n):
        largest = 0.0
        for i in range(n):
            largest = max(largest, abs(matrix[i * n + j]) * matrix[r + i])
        matrix[c + j] = 1.0 / largest if largest > 0.0 else 0.0
    for k in range(n):
        pivot, size = k, abs(matrix[k * n + k]) * matrix[r + k]
        for i in range(k + 1, n):
            if abs(matrix[i * n + k]) * matrix[r + i] > size:
                pivot, size = i, abs(matrix[i * n + k]) * matrix[r + i]
        pivots[k] = pivot
        if not size * matrix[c + k] > 1e-14:
            return False
        if pivot != k:
            matrix[r + k], matrix[r + pivot] = matrix[r + pivot], matrix[r + k]
            for j in range(n):
                matrix[k * n + j], matrix[pivot * n + j] = matrix[pivot * n + j], matrix[k * n + j]
        inverse = 1.0 / matrix[k * n + k]
        for i in range(k + 1, n):
            if matrix[i * n + k] != 0.0:
                l = matrix[i * n + k] * inverse
                matrix[i * n + k] = l
                for j in range(k + 1, n):
                    matrix[i * n + j] -= l * matrix[k * n + j]
    return True


@rare
def dense_solve(matrix, pivots, layout, y):
    """y <- A^{-1} y; reads the factors of A in ``matrix`` and ``pivots``."""
    n = layout[L.N_ALL]
    for k in range(n):
        if pivots[k] != k:
            y[k], y[pivots[k]] = y[pivots[k]], y[k]
    for i in range(1, n):
        x = y[i]
        for j in range(i):
            x -= matrix[i * n + j] * y[j]
        y[i] = x
    for i in range(n - 1, -1, -1):
        x = y[i]
        for j in range(i + 1, n):
            x -= matrix[i * n + j] * y[j]
        y[i] = x / matrix[i * n + i]
