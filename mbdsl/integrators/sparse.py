"""Sparse LU without pivoting, on a pattern and an order that are found once from the mechanism's graph.

Bodies are eliminated before the joints between them: the pivots of a body are its masses, those of a joint the
effective inverse masses that it sees, so that no search for pivots is needed while masses are positive and
constraints independent. Growth is watched; where a pivot is lost, ``factor`` says so, and the dense solver with
pivoting takes over.

While a matrix is assembled and factorised it is stored row by row, columns ascending in the new order: L (unit
diagonal) left of the diagonal, U right of it, reciprocal pivots on it. Behind that, in the same row of A, stand the
factors as they are solved with: L column by column, U (divided by its pivots, so that its diagonal is one, too) column
by column from the last, the reciprocal pivots. A solve is then three loops without any inner ones, in the original
numbering: no entry waits for the one before it, and there is nothing to be mispredicted.

Tables, at I[SPARSE]: permutation (N: new -> old), row starts (N + 1), diagonal (N), columns; of the entries of L,
then of U, as they are solved with: their targets, their sources, the places that they come from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels import kernel, rare
from mbdsl.layout import N_ALL, SPARSE

Ints = NDArray[np.int64]

#: a pivot this much smaller than it was on the way is what cancellation left over
LOST = 1e-11


@dataclass(frozen=True)
class Pattern:
    """Symbolic factorisation: ``table`` for the kernels, ``slots`` of the requested entries, number of entries.

    A row of A takes twice so many.
    """

    table: Ints
    slots: Ints
    size: int


def analyse(n: int, rows: Ints, columns: Ints, order: Ints) -> Pattern:
    """Pattern of L + U for a matrix with entries (rows, columns), eliminated in ``order`` (new -> old)."""
    new = np.empty(n, np.int64)
    new[order] = np.arange(n)
    r, c = new[rows], new[columns]
    low, high = np.minimum(r, c), np.maximum(r, c)
    above: list[set[int]] = [set() for _ in range(n)]  # U's columns of each row, without the diagonal
    for i, j in set(zip(low.tolist(), high.tolist(), strict=True)):
        if i != j:
            above[i].add(j)
    left: list[list[int]] = [[] for _ in range(n)]  # L's columns of each row
    for k in range(n):
        found = above[k]
        if found:
            # what eliminating k joins is passed on to its parent in the elimination tree
            parent = min(found)
            above[parent] |= found
            above[parent].discard(parent)
            for i in found:
                left[i].append(k)
    starts, diagonal, cols = [0], [], []
    for i in range(n):
        cols += left[i]
        diagonal.append(len(cols))
        cols.append(i)
        cols += sorted(above[i])
        starts.append(len(cols))
    starts_array, cols_array = np.array(starts, np.int64), np.array(cols, np.int64)
    # entries of a row are ascending, so that row * n + column is ascending over all
    row_of = np.repeat(np.arange(n), np.diff(starts_array))
    keys = row_of * n + cols_array
    slots = np.searchsorted(keys, r * n + c)
    lower, upper = np.flatnonzero(cols_array < row_of), np.flatnonzero(cols_array > row_of)
    lower = lower[np.argsort(cols_array[lower], kind="stable")]
    upper = upper[np.argsort(-cols_array[upper], kind="stable")]
    places = np.concatenate([lower, upper])
    targets, sources = order[row_of[places]], order[cols_array[places]]
    table = np.concatenate([order, starts_array, diagonal, cols_array, targets, sources, places], dtype=np.int64)
    return Pattern(table, slots, len(cols))


@rare
def sparse_factor(A, P, I):
    """LU in place, and as it is solved with; P is scratch for the place of each column. False where a pivot is lost."""
    n, o = I[N_ALL], I[SPARSE]
    start, diagonal, column = o + n, o + 2 * n + 1, o + 3 * n + 1
    for i in range(n):
        first, d, last = I[start + i], I[diagonal + i], I[start + i + 1]
        for p in range(first, last):
            P[I[column + p]] = p
        largest = abs(A[d])
        for p in range(first, d):
            k = I[column + p]
            l = A[p] * A[I[diagonal + k]]
            A[p] = l
            if l != 0.0:
                for s in range(I[diagonal + k] + 1, I[start + k + 1]):
                    A[P[I[column + s]]] -= l * A[s]
                largest = max(largest, abs(A[d]))
        if not abs(A[d]) > LOST * largest:
            return False
        A[d] = 1.0 / A[d]
    for i in range(n):
        d = I[diagonal + i]
        for p in range(d + 1, I[start + i + 1]):
            A[p] *= A[d]
    size = I[start + n]
    place = column + size + 2 * (size - n)
    for e in range(size - n):
        A[size + e] = A[I[place + e]]
    for i in range(n):
        A[2 * size - n + I[o + i]] = A[I[diagonal + i]]
    return True


@kernel
def sparse_solve(A, I, Y, row):
    """Y[row] <- A^{-1} Y[row]."""
    n, o = I[N_ALL], I[SPARSE]
    size = I[o + 2 * n]
    count, first = size - n, o + 3 * n + 1 + size
    targets, sources = I[first : first + count], I[first + count : first + 2 * count]
    values, inverse, y = A[size : size + count], A[size + count : 2 * size], Y[row]
    for e in range(count // 2):
        y[targets[e]] -= values[e] * y[sources[e]]
    for i in range(n):
        y[i] *= inverse[i]
    for e in range(count // 2, count):
        y[targets[e]] -= values[e] * y[sources[e]]


@kernel
def sparse_solve_both(A, I, Y, row, row2):
    """The same for two matrices of one pattern: Y[row] <- A[0]^{-1} Y[row], Y[row2] <- A[1]^{-1} Y[row2]."""
    n, o = I[N_ALL], I[SPARSE]
    size = I[o + 2 * n]
    count, first = size - n, o + 3 * n + 1 + size
    targets, sources = I[first : first + count], I[first + count : first + 2 * count]
    values, inverse, y = A[0, size : size + count], A[0, size + count : 2 * size], Y[row]
    values2, inverse2, y2 = A[1, size : size + count], A[1, size + count : 2 * size], Y[row2]
    for e in range(count // 2):
        i, j = targets[e], sources[e]
        y[i] -= values[e] * y[j]
        y2[i] -= values2[e] * y2[j]
    for i in range(n):
        y[i] *= inverse[i]
        y2[i] *= inverse2[i]
    for e in range(count // 2, count):
        i, j = targets[e], sources[e]
        y[i] -= values[e] * y[j]
        y2[i] -= values2[e] * y2[j]
