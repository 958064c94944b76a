"""Solution of linear systems with the banded Cholesky factors of :mod:`mbdsl.numerics.banded_cholesky`, in compiled
code."""

from mbdsl.kernels.marks import kernel


@kernel
def cholesky_solve(k, band, L, y):
    """y <- (L L^T)^{-1} y. Row i of L contains its entries i - band ... i, the last one as its reciprocal."""
    for i in range(k):
        z = y[i]
        for j in range(max(0, i - band), i):
            z -= L[i * (band + 1) + band + j - i] * y[j]
        y[i] = z * L[i * (band + 1) + band]
    for i in range(k - 1, -1, -1):
        z = y[i] * L[i * (band + 1) + band]
        y[i] = z
        for j in range(max(0, i - band), i):
            y[j] -= L[i * (band + 1) + band + j - i] * z


@kernel
def cholesky_solve_pairs(k, band, L, y):
    """The same for two interleaved right-hand sides, y[2 i] and y[2 i + 1]."""
    for i in range(k):
        a, b = y[2 * i], y[2 * i + 1]
        for j in range(max(0, i - band), i):
            l = L[i * (band + 1) + band + j - i]
            a -= l * y[2 * j]
            b -= l * y[2 * j + 1]
        d = L[i * (band + 1) + band]
        y[2 * i], y[2 * i + 1] = a * d, b * d
    for i in range(k - 1, -1, -1):
        d = L[i * (band + 1) + band]
        a, b = y[2 * i] * d, y[2 * i + 1] * d
        y[2 * i], y[2 * i + 1] = a, b
        for j in range(max(0, i - band), i):
            l = L[i * (band + 1) + band + j - i]
            y[2 * j] -= l * a
            y[2 * j + 1] -= l * b
