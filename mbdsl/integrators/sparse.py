"""Sparse LU without pivoting, on a pattern and an order that are found once from the mechanism's graph.

Bodies are eliminated before the joints between them: the pivots of a body are its masses, those of a joint the
effective inverse masses that it sees, so that no search for pivots is needed while masses are positive and
constraints independent. Growth is watched; where a pivot is lost, ``factor`` says so, and the dense solver with
pivoting takes over.

Storage: row by row, columns ascending in the new order, L (unit diagonal) left of the diagonal, U right of it, the
reciprocal pivot on it. Tables, at I[SPARSE]: permutation (N: new -> old), row starts (N + 1), diagonal (N), columns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels import kernel, rare
from mbdsl.layout import N_ALL, SPARSE, T1, T2

Ints = NDArray[np.int64]

#: a pivot this much smaller than it was on the way is what cancellation left over
LOST = 1e-11


@dataclass(frozen=True)
class Pattern:
    """Symbolic factorisation: ``table`` for the kernels, ``slots`` of the requested entries, number of entries."""

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
    keys = np.repeat(np.arange(n), np.diff(starts_array)) * n + cols_array
    slots = np.searchsorted(keys, r * n + c)
    table = np.concatenate([order, starts_array, np.array(diagonal, np.int64), cols_array])
    return Pattern(table, slots, len(cols))


@rare
def sparse_factor(A, P, I):
    """LU in place; P is scratch for the place of each column. False where a pivot is lost."""
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
    return True


@kernel
def sparse_solve(A, I, Y, row):
    """Y[row] <- A^{-1} Y[row]; row T1 is scratch."""
    n, o = I[N_ALL], I[SPARSE]
    start, diagonal, column = o + n, o + 2 * n + 1, o + 3 * n + 1
    for i in range(n):
        y = Y[row, I[o + i]]
        for p in range(I[start + i], I[diagonal + i]):
            y -= A[p] * Y[T1, I[column + p]]
        Y[T1, i] = y
    for i in range(n - 1, -1, -1):
        d = I[diagonal + i]
        y = Y[T1, i]
        for p in range(d + 1, I[start + i + 1]):
            y -= A[p] * Y[T1, I[column + p]]
        y *= A[d]
        Y[T1, i] = y
        Y[row, I[o + i]] = y


@kernel
def sparse_solve_both(A, I, Y, row, row2):
    """The same for two matrices of one pattern: Y[row] <- A[0]^{-1} Y[row], Y[row2] <- A[1]^{-1} Y[row2].

    A solve spends its time waiting for its own last result; two of them wait together. Row T2 is scratch as well.
    """
    n, o = I[N_ALL], I[SPARSE]
    start, diagonal, column = o + n, o + 2 * n + 1, o + 3 * n + 1
    for i in range(n):
        y, y2 = Y[row, I[o + i]], Y[row2, I[o + i]]
        for p in range(I[start + i], I[diagonal + i]):
            j = I[column + p]
            y -= A[0, p] * Y[T1, j]
            y2 -= A[1, p] * Y[T2, j]
        Y[T1, i], Y[T2, i] = y, y2
    for i in range(n - 1, -1, -1):
        d = I[diagonal + i]
        y, y2 = Y[T1, i], Y[T2, i]
        for p in range(d + 1, I[start + i + 1]):
            j = I[column + p]
            y -= A[0, p] * Y[T1, j]
            y2 -= A[1, p] * Y[T2, j]
        y, y2 = y * A[0, d], y2 * A[1, d]
        Y[T1, i], Y[T2, i] = y, y2
        Y[row, I[o + i]], Y[row2, I[o + i]] = y, y2
