"""Banded Cholesky factorisation, in the format that :mod:`mbdsl.numerics.banded` reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def cholesky(M: NDArray[np.float64]) -> tuple[int, list[float]]:
    """The bandwidth, and the rows of the factor within it, with the reciprocals of diagonal entries."""
    k = len(M)
    i, j = np.nonzero(M)
    band = int(np.abs(i - j).max(initial=0))
    L = np.linalg.cholesky(M) if k else np.zeros((0, 0))
    rows = np.zeros((k, band + 1))
    for a in range(k):
        low = max(0, a - band)
        rows[a, band - (a - low) :] = L[a, low : a + 1]
    rows[:, band] = 1.0 / rows[:, band]
    return band, rows.ravel().tolist()
