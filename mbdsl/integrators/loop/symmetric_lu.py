"""Sparse factorisation of symmetric matrices, with half of the operations of :mod:`mbdsl.integrators.loop.sparse_lu`.

Pattern, order and tables are those of the general factorisation. The entries D and L are given; U is overwritten:

    D  the reciprocals of the pivots,  L  divided by its pivots,  U  L before the division
"""

from mbdsl.integrators.loop.sparse_lu import LOST, place
from mbdsl.kernels import buffer_layout
from mbdsl.kernels.marks import kernel, rare


@rare
def symmetric_factor(matrix, layout):
    """Factorise ``matrix`` in place. False if a pivot is lost."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    order, starts = layout[o : o + n], layout[o + n : o + 2 * n + 1]
    c, table = starts[n], o + 2 * n + 1
    rows, updates = layout[table : table + c], layout[table + 5 * c + 1 :]
    D, L, U = matrix[:n], matrix[n : n + c], matrix[n + c : n + 2 * c]
    G, listed, q = matrix[n + 3 * c :], layout[table + 5 * c], 0
    for i in range(n):
        G[i] = abs(D[i])
    for k in range(n):
        d, first, last = order[k], starts[k], starts[k + 1]
        if not abs(D[d]) > LOST * G[d]:
            return False
        D[d] = 1.0 / D[d]
        for e in range(first, last):
            U[e] = L[e]
            L[e] *= D[d]
            l = L[e]
            G[rows[e]] += abs(l * U[e])
            if listed:
                at = updates[q : q + last - first]
                for s in range(e - first + 1):
                    matrix[at[s]] -= l * U[first + s]
                q += last - first
            elif l != 0.0:
                for s in range(first, e + 1):
                    matrix[place(rows[e], rows[s], n, c, starts, rows, updates)] -= l * U[s]
    return True


@kernel
def symmetric_solve(matrix, layout, y):
    """y <- A^{-1} y; reads D and L of the factorised ``matrix`` A."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
    c, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + c :], layout[table + 2 * c :], layout[table + 3 * c :]
    D, L, places = matrix[:n], matrix[n : n + c], layout[table + 4 * c :]
    for e in range(c):
        y[i[e]] -= L[e] * y[j[e]]
    for e in range(n):
        y[e] *= D[e]
    for e in range(c):
        y[k[e]] -= L[places[e]] * y[l[e]]
