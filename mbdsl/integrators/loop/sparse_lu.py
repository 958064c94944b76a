"""Sparse LU without pivoting, on a pattern and an order that are found once from the mechanism's graph.

Bodies are eliminated before the joints between them: the pivots of a body are its masses, those of a joint the
effective inverse masses that it sees, so that no search for pivots is needed while masses are positive and
constraints independent. Growth is watched; where a pivot is lost, ``factor`` says so, and the dense solver with
pivoting takes over.

The pattern is symmetric. With c entries below the diagonal, a matrix is stored as

    D (N)   pivots, then their reciprocals, in the numbering of the unknowns
    L (c)   column by column in the order of elimination; divided by its pivots once it is factorised
    U (c)   row by row in that order: entry (k, i) where L has (i, k)
    W (c)   U divided by its pivots, column by column from the last
    G (N)   what pivots would have been without cancellation

and a matrix is assembled in the first three. All loops of a solve are over single entries, in the unknowns' own
numbering: no entry waits for the one before it, and there are no short inner loops to be mispredicted.

Tables, at layout[SPARSE]: ``order`` (N: in which unknowns are eliminated), ``starts`` (N + 1: columns of L), rows and
columns of L (c each), rows, columns and places in U of W (c each), and for every pivot k the places of all that it
changes, (i, j) for i and j in column k of L: ``updates``. Where there are more than ``MOST`` of these they are looked
for instead, with ``rank`` (N), the inverse of the order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation.buffer_layout import N_ALL, SPARSE
from mbdsl.compilation.marks import kernel, rare

Ints = NDArray[np.int64]

#: a pivot this much smaller than what it was made of is what cancellation left over
LOST = 1e-11
#: longest list of updates that is made (8 bytes each)
MOST = 10_000_000


@dataclass(frozen=True)
class Pattern:
    """Symbolic factorisation: ``table`` for the kernels, ``slots`` of the requested entries; ``size`` is of what a
    matrix is assembled in, ``length`` of the whole of it."""

    table: Ints
    slots: Ints
    size: int
    length: int


def analyse(n: int, rows: Ints, columns: Ints, order: Ints, most: int = MOST) -> Pattern:
    """Pattern of L + U for a matrix with entries (rows, columns), eliminated in ``order`` (new -> old)."""
    rank = np.empty(n, np.int64)
    rank[order] = np.arange(n)
    r, c = rank[rows], rank[columns]
    below: list[set[int]] = [set() for _ in range(n)]  # the rows of each column of L
    for i, j in set(zip(np.maximum(r, c).tolist(), np.minimum(r, c).tolist(), strict=True)):
        if i != j:
            below[j].add(i)
    for found in below:
        if found:
            # what eliminating k joins is passed on to its parent in the elimination tree
            parent = min(found)
            below[parent] |= found
            below[parent].discard(parent)
    counts = np.array([len(found) for found in below], np.int64)
    starts = np.concatenate([[0], np.cumsum(counts)])
    row = np.array([i for found in below for i in sorted(found)], np.int64)
    column = np.repeat(np.arange(n), counts)
    keys = column * n + row  # ascending

    def place(i: Ints, j: Ints) -> Ints:
        at = n + np.searchsorted(keys, np.minimum(i, j) * n + np.maximum(i, j))
        return np.where(i == j, order[i], np.where(i > j, at, at + len(row)))

    backwards = np.argsort(-row, kind="stable")
    total = int((counts**2).sum())
    if total <= most:
        of = counts[column]
        first = np.repeat(np.arange(len(row)), of)
        second = np.arange(total) - np.repeat(np.cumsum(of) - of, of) + starts[column[first]]
        updates = place(row[first], row[second])
    else:
        updates = rank
    table = [order, starts, order[row], order[column], order[column[backwards]], order[row[backwards]], backwards]
    table += [np.array([total <= most]), updates]
    size = n + 2 * len(row)
    return Pattern(np.concatenate(table, dtype=np.int64), place(r, c), size, size + len(row) + n)


@rare
def sparse_factor(matrix, layout):
    """LU in place. False where a pivot is lost."""
    n, o = layout[N_ALL], layout[SPARSE]
    order, starts = layout[o : o + n], layout[o + n : o + 2 * n + 1]
    c, table = starts[n], o + 2 * n + 1
    rows, updates = layout[table : table + c], layout[table + 5 * c + 1 :]
    D, L, U = matrix[:n], matrix[n : n + c], matrix[n + c : n + 2 * c]
    W, G, listed, q = matrix[n + 2 * c : n + 3 * c], matrix[n + 3 * c :], layout[table + 5 * c], 0
    for i in range(n):
        G[i] = abs(D[i])
    for k in range(n):
        d, first, last = order[k], starts[k], starts[k + 1]
        if not abs(D[d]) > LOST * G[d]:
            return False
        D[d] = 1.0 / D[d]
        for e in range(first, last):
            L[e] *= D[d]
            l = L[e]
            G[rows[e]] += abs(l * U[e])
            if listed:
                at = updates[q : q + last - first]
                for s in range(last - first):
                    matrix[at[s]] -= l * U[first + s]
                q += last - first
            elif l != 0.0:
                for s in range(first, last):
                    matrix[place(rows[e], rows[s], n, c, starts, rows, updates)] -= l * U[s]
    targets, places = layout[table + 2 * c : table + 3 * c], layout[table + 4 * c : table + 5 * c]
    for e in range(c):
        W[e] = U[places[e]] * D[targets[e]]
    return True


@rare
def place(i, j, n, c, starts, rows, rank):
    """Where entry (i, j) stands, by bisection."""
    if i == j:
        return i
    k, other = (j, i) if rank[i] > rank[j] else (i, j)
    low, high = starts[rank[k]], starts[rank[k] + 1]
    while high - low > 1:
        middle = (low + high) // 2
        if rank[rows[middle]] <= rank[other]:
            low = middle
        else:
            high = middle
    return n + low if other == i else n + c + low


@kernel
def sparse_solve(matrix, layout, y):
    """y <- the inverse of the matrix times y."""
    n, o = layout[N_ALL], layout[SPARSE]
    c, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + c :], layout[table + 2 * c :], layout[table + 3 * c :]
    D, L, W = matrix[:n], matrix[n : n + c], matrix[n + 2 * c : n + 3 * c]
    for e in range(c):
        y[i[e]] -= L[e] * y[j[e]]
    for e in range(n):
        y[e] *= D[e]
    for e in range(c):
        y[k[e]] -= W[e] * y[l[e]]


@kernel
def sparse_solve_both(matrices, layout, y, y2):
    """The same for two matrices of one pattern, the first with y and the second with y2."""
    n, o = layout[N_ALL], layout[SPARSE]
    c, table = layout[o + 2 * n], o + 2 * n + 1
    i, j, k, l = layout[table:], layout[table + c :], layout[table + 2 * c :], layout[table + 3 * c :]
    D, L, W = matrices[0, :n], matrices[0, n : n + c], matrices[0, n + 2 * c : n + 3 * c]
    D2, L2, W2 = matrices[1, :n], matrices[1, n : n + c], matrices[1, n + 2 * c : n + 3 * c]
    for e in range(c):
        t, s = i[e], j[e]
        y[t] -= L[e] * y[s]
        y2[t] -= L2[e] * y2[s]
    for e in range(n):
        y[e] *= D[e]
        y2[e] *= D2[e]
    for e in range(c):
        t, s = k[e], l[e]
        y[t] -= W[e] * y[s]
        y2[t] -= W2[e] * y2[s]
