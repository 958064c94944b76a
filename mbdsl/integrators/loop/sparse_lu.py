"""Sparse LU without pivoting; pattern and elimination order are computed once, from the mechanism's graph.

Bodies are eliminated before the joints between them. The pivots of a body are its masses, those of a joint effective
inverse masses. Therefore no search for pivots is needed as long as masses are positive and constraints are independent.
The growth of entries is monitored: ``sparse_factor`` returns False if a pivot is lost, and the dense solver with
pivoting then replaces this one.

The pattern is symmetric. With c entries below the diagonal, a matrix is stored as

    D (N)   pivots, then their reciprocals, in the numbering of the unknowns
    L (c)   column by column in the order of elimination; divided by its pivots after factorisation
    U (c)   row by row in that order: entry (k, i) at the place of (i, k) in L
    W (c)   U divided by its pivots, column by column from the last
    G (N)   sums of the magnitudes of all terms of the pivots, for comparison

A matrix is assembled in D, L and U. The loops of a solve run over single entries, numbered as the unknowns. Successive
entries are independent of each other, and there are no short inner loops, which cause branch mispredictions.

Tables, at layout[SPARSE]: ``order`` (N: unknowns in the order of elimination), ``starts`` (N + 1: first entry of each
column of L), rows and columns of L (c each), rows, columns and places in U of W (c each), a flag, and ``updates``: for
every pivot k the places of all entries that it changes, (i, j) for i and j in column k of L. If there are more than
``MOST`` of them, the flag is 0, and ``rank`` (N), the inverse of ``order``, replaces the updates: each place is then
searched for.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels import buffer_layout
from mbdsl.kernels.marks import kernel, rare

Ints = NDArray[np.int64]

#: a pivot is lost, and only rounding is left of it, if it is smaller than this part of its entry in G
LOST = 1e-11
#: largest number of updates in the table (8 bytes each)
MOST = 10_000_000


@dataclass(frozen=True)
class Pattern:
    """Symbolic factorisation: the ``table`` of the kernels, and the ``slots`` (places) of the given entries.

    A matrix is assembled in its first ``size`` entries; with W and G it has ``length`` entries.
    """

    table: Ints
    slots: Ints
    size: int
    length: int


def analyse(n: int, rows: Ints, columns: Ints, order: Ints, most: int = MOST) -> Pattern:
    """Pattern of L + U for a matrix with entries (rows, columns), eliminated in ``order`` (new -> old)."""
    rank = np.empty(n, np.int64)
    rank[order] = np.arange(n)
    r, c = rank[rows], rank[columns]
    given = np.sort((np.minimum(r, c) * n + np.maximum(r, c))[r != c])  # column by column
    given = given[np.diff(given, prepend=-1) > 0]
    first_given = np.searchsorted(given, np.arange(n + 1) * n).tolist()
    given_rows = (given % n).tolist()
    below: list[list[int]] = []  # the rows of each column of L, ascending
    filled: dict[int, set[int]] = {}  # further rows of a column
    for j in range(n):
        found = given_rows[first_given[j] : first_given[j + 1]]
        if j in filled:
            found = sorted(filled.pop(j).union(found))
        below.append(found)
        if len(found) > 1:
            # fill-in: the rows of a column are also rows of the column of its parent in the elimination tree
            parent, *others = found
            if parent in filled:
                filled[parent].update(others)
            else:
                filled[parent] = set(others)
    counts = np.array([len(found) for found in below], np.int64)
    starts = np.concatenate([[0], np.cumsum(counts)])
    row = np.fromiter(chain.from_iterable(below), np.int64, int(starts[-1]))
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
    """Factorise ``matrix`` in place: D, L and U are overwritten, W and G written. False if a pivot is lost."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
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
    """Place of entry (i, j) in a matrix, by bisection in the columns of L."""
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
    """y <- A^{-1} y; reads D, L and W of the factorised ``matrix`` A."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
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
    """y <- A^{-1} y and y2 <- A2^{-1} y2 in one loop; A and A2 are matrices 0 and 1, of the same pattern."""
    n, o = layout[buffer_layout.N_ALL], layout[buffer_layout.SPARSE]
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
