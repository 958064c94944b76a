"""Dense elimination, real and complex, against NumPy: pivots anywhere, and rows and columns of all sizes."""

import numpy as np
import pytest

from mbdsl.compilation import buffer_layout
from mbdsl.integrators.loop import complex_lu, linear_solve

N = 6


def tables():
    I = np.zeros(buffer_layout.N_ALL + 1, np.int64)
    I[buffer_layout.N_ALL] = N
    return np.zeros(N, np.int64), I


def matrix(rng, singular):
    """A well-conditioned matrix, or one with a repeated column, apart from the units of rows and columns."""
    M = rng.normal(size=(N, N))
    M[:, 3] = M[:, 1] if singular else M[:, 3]
    rows, columns = 10.0 ** rng.integers(-9, 10, size=(2, N))
    return rows, M, columns


@pytest.mark.parametrize("singular", [False, True])
def test_real_systems(singular, plain):
    rng = np.random.default_rng(4)
    for _ in range(3):
        rows, M, columns = matrix(rng, singular)
        P, I = tables()
        A, y = np.zeros(N * N + 2 * N), rng.normal(size=N)
        A[: N * N] = (rows[:, None] * M * columns).ravel()
        expected = None if singular else np.linalg.solve(M, y / rows) / columns
        assert plain(linear_solve.dense_factor)(A, P, I) != singular
        if not singular:
            plain(linear_solve.dense_solve)(A, P, I, y)
            assert y * columns == pytest.approx(expected * columns, rel=1e-9)


@pytest.mark.parametrize("singular", [False, True])
def test_complex_systems(singular, plain):
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
        assert plain(complex_lu.dense_factor)(A, B, P, I) != singular
        if not singular:
            plain(complex_lu.dense_solve)(A, B, P, I, y, z)
            assert (y + 1j * z) * columns == pytest.approx(expected, rel=1e-9)
