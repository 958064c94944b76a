"""Interpolation between the steps of a motion: q and v by cubic Hermite polynomials, multipliers linearly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def between(t: Array, known: Array, q: Array, v: Array, lam: Array) -> tuple[Array, Array, Array]:
    """q, v (N, n) and lam (N, m) at times t (N,) from those at ``known`` times (K,), ascending, which enclose t."""
    if len(known) == 1:
        return q[np.zeros(len(t), int)], v[np.zeros(len(t), int)], lam[np.zeros(len(t), int)]
    k = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    h = (known[k + 1] - known[k])[:, None]
    x = (t - known[k])[:, None] / h
    q0, q1, v0, v1 = q[k], q[k + 1], h * v[k], h * v[k + 1]
    c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
    found_q, found_v = q0 + x * (v0 + x * (c2 + x * c3)), (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
    found_lam = lam[k] + x * (lam[k + 1] - lam[k])
    for row in (0, 1):  # known values are not interpolated
        at = x[:, 0] == row
        found_q[at], found_v[at], found_lam[at] = q[k[at] + row], v[k[at] + row], lam[k[at] + row]
    return found_q, found_v, found_lam
