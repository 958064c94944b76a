"""Elimination, real, complex and of coupled systems, against NumPy: pivots anywhere, and rows and columns of all
sizes."""

import numpy as np
import pytest

from mbdsl.integrators.loop import block_lu, linear_solve, sparse_lu, symmetric_lu
from mbdsl.integrators.loop.block_lu import BLOCKS, COMPLEX
from mbdsl.kernels import buffer_layout as L

N = 6


def tables():
    I = np.zeros(L.N_ALL + 1, np.int64)
    I[L.N_ALL] = N
    return np.zeros(N, np.int64), I


def matrix(rng, singular):
    """A well-conditioned matrix, or one with a repeated column, apart from the units of rows and columns."""
    M = rng.normal(size=(N, N))
    M[:, 3] = M[:, 1] if singular else M[:, 3]
    rows, columns = 10.0 ** rng.integers(-9, 10, size=(2, N))
    return rows, M, columns


@pytest.mark.parametrize("singular", [False, True])
def test_real_systems(singular):
    rng = np.random.default_rng(4)
    for _ in range(3):
        rows, M, columns = matrix(rng, singular)
        P, I = tables()
        A, y = np.zeros(N * N + 2 * N), rng.normal(size=N)
        A[: N * N] = (rows[:, None] * M * columns).ravel()
        expected = None if singular else np.linalg.solve(M, y / rows) / columns
        assert linear_solve.dense_factor(A, P, I) != singular
        if not singular:
            linear_solve.dense_solve(A, P, I, y)
            assert y * columns == pytest.approx(expected * columns, rel=1e-9)


@pytest.mark.parametrize("singular", [False, True])
def test_complex_systems(singular):
    rng = np.random.default_rng(4)
    for _ in range(3):
        rows, M, columns = matrix(rng, False)
        C = M + 1j * rng.normal(size=(N, N))
        C[:, 3] = 1j * C[:, 1] if singular else C[:, 3]
        P, I = tables()
        A, B = np.zeros((2, N * N + 2 * N))
        y, z = rng.normal(size=(2, N))
        K = rows[:, None] * C * columns
        A[: N * N], B[: N * N] = K.real.ravel(), K.imag.ravel()
        expected = None if singular else np.linalg.solve(C, (y + 1j * z) / rows)
        assert block_lu.dense_factor(COMPLEX, (A, B), P, I) != singular
        if not singular:
            block_lu.dense_solve(COMPLEX, (A, B), P, I, (y, z))
            assert (y + 1j * z) * columns == pytest.approx(expected, rel=1e-9)


def coupled(rng):
    """Four matrices of rows and columns of all sizes, and the whole."""
    rows, columns = 10.0 ** rng.integers(-9, 10, size=(2, N))
    four = [rows[:, None] * rng.normal(size=(N, N)) * columns for _ in range(4)]
    return rows, columns, four, np.block([four[:2], four[2:]])


@pytest.mark.parametrize("singular", [False, True])
def test_dense_coupled_systems(singular):
    rng = np.random.default_rng(4)
    for _ in range(3):
        rows, columns, four, whole = coupled(rng)
        if singular:
            for M in four:
                M[:, 3] = M[:, 1] / columns[1] * columns[3]
        P, I = tables()
        A, y, z = np.zeros((4, N * N + 2 * N)), rows * rng.normal(size=N), rows * rng.normal(size=N)
        A[:, : N * N] = [M.ravel() for M in four]
        scaled = whole / np.tile(rows, 2)[:, None] / np.tile(columns, 2)
        expected = None if singular else np.linalg.solve(scaled, np.concatenate([y, z]) / np.tile(rows, 2))
        assert block_lu.dense_factor(BLOCKS, tuple(A), P, I) != singular
        if not singular:
            block_lu.dense_solve(BLOCKS, tuple(A), P, I, (y, z))
            assert np.concatenate([y, z]) * np.tile(columns, 2) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("most", [sparse_lu.MOST, 0], ids=["listed", "searched"])
def test_sparse_coupled_systems(most):
    """A pattern with fill-in, with the places of updates listed or searched; and a lost pivot."""
    rng = np.random.default_rng(5)
    off = np.array([(0, 4), (1, 5), (2, 4), (3, 5), (0, 5), (2, 3)])
    r, c = np.concatenate([np.arange(N), off[:, 0], off[:, 1]]), np.concatenate([np.arange(N), off[:, 1], off[:, 0]])
    pattern = sparse_lu.analyse(N, r, c, np.array([2, 0, 1, 4, 3, 5]), most)
    I = np.zeros(L.BLOCKS, np.int64)
    I[L.N_ALL], I[L.SPARSE] = N, len(I)
    I = np.concatenate([I, pattern.table])
    A, M = np.zeros((4, pattern.length)), np.zeros((4, N, N))
    for k in range(4):
        M[k, r, c] = rng.normal(size=len(r)) + (4.0 * (r == c) if k in (0, 3) else 0.0)
        A[k, pattern.slots] = M[k, r, c]
    y, z = rng.normal(size=(2, N))
    expected = np.linalg.solve(np.block([[M[0], M[1]], [M[2], M[3]]]), np.concatenate([y, z]))
    lost = A.copy()
    assert block_lu.sparse_factor(BLOCKS, tuple(A), I)
    block_lu.sparse_solve(BLOCKS, tuple(A), I, (y, z))
    assert np.concatenate([y, z]) == pytest.approx(expected, rel=1e-11)
    lost[2:, 2], lost[:2, 2] = 3.0, 3.0  # the first pivot is singular
    assert not block_lu.sparse_factor(BLOCKS, tuple(lost), I)


CHAIN = 5


def chain_pattern():
    """The pattern of a chain: entries next to the diagonal; its table, its slots, rows and columns."""
    off = np.arange(CHAIN - 1)
    r, c = np.concatenate([np.arange(CHAIN), off, off + 1]), np.concatenate([np.arange(CHAIN), off + 1, off])
    pattern = sparse_lu.analyse(CHAIN, r, c, np.arange(CHAIN), sparse_lu.MOST)
    I = np.zeros(L.BLOCKS, np.int64)
    I[L.N_ALL], I[L.SPARSE] = CHAIN, len(I)
    return np.concatenate([I, pattern.table]), pattern, r, c


def chain_matrix(lost):
    """L L^T with ones beside the diagonal, whose pivot number ``lost`` is zero, although no entry is."""
    lower = np.eye(CHAIN) + np.diag(np.ones(CHAIN - 1), -1)
    D = np.array([2.0, 3.0, 5.0, 7.0, 11.0])
    if lost is not None:
        D[lost] = 0.0
    return lower @ np.diag(D) @ lower.T


@pytest.mark.parametrize("lost", [None, 1, 2, 3, 4])
def test_symmetric_systems(lost):
    """Solutions, and a pivot that is lost at any place."""
    I, pattern, r, c = chain_pattern()
    M, A = chain_matrix(lost), np.zeros(pattern.length)
    A[pattern.slots] = M[r, c]
    assert symmetric_lu.symmetric_factor(A, I) == (lost is None)
    if lost is None:
        y = np.array([1.0, -2.0, 3.0, 0.5, 4.0])
        x = np.linalg.solve(M, y)
        symmetric_lu.symmetric_solve(A, I, y)
        assert y == pytest.approx(x, rel=1e-13)


@pytest.mark.parametrize("side", [0, 3])
@pytest.mark.parametrize("lost", [1, 2, 3, 4])
def test_coupled_systems_lose_a_pivot_at_any_place(lost, side):
    """In the first or in the second of two systems that are not coupled."""
    I, pattern, r, c = chain_pattern()
    A = np.zeros((4, pattern.length))
    for k in (0, 3):
        A[k, pattern.slots] = chain_matrix(lost if k == side else None)[r, c]
    assert not block_lu.sparse_factor(BLOCKS, tuple(A), I)
