"""The exponentials of many matrices at once, without overflow."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array


def exponential(A: Array) -> tuple[Array, Array]:
    """E (N, k, k) and s (N,) with exp(A) = E e^s for each of the matrices A (N, k, k), without overflow.

    The diagonal Pade approximant of degree 6 of A/2^j, squared j times; Moler and Van Loan, SIAM Review 45 (2003) 3-49.
    """
    count, k = A.shape[:2]
    size = float(np.abs(A).sum(axis=2).max(initial=0.0))
    squarings = int(np.clip(np.ceil(np.log2(max(size, 0.5) / 0.5)), 0, 60))
    A = A / 2.0**squarings
    c = [1.0]
    for j in range(1, 7):
        c.append(c[-1] * (7.0 - j) / (j * (13.0 - j)))
    one, two = np.eye(k), A @ A
    four = two @ two
    even = c[0] * one + c[2] * two + c[4] * four + c[6] * (two @ four)
    odd = A @ (c[1] * one + c[3] * two + c[5] * four)
    E: Array = np.asarray(np.linalg.solve(even - odd, even + odd))
    s = np.zeros(count)
    for _ in range(squarings):
        E, s = E @ E, 2.0 * s
        largest = np.abs(E).max(axis=(1, 2))
        E, s = E / largest[:, None, None], s + np.log(largest)
    return E, s
