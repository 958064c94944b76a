"""Interpolation between the steps of a motion: q and v by cubic Hermite polynomials, multipliers linearly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.rotation_arrays import from_spin, to_spin, turned

Array = NDArray[np.float64]
NO_ROTATIONS = np.empty(0, np.int64)


def between(
    t: Array, known: Array, q: Array, v: Array, lam: Array, rotations: NDArray[np.int64] = NO_ROTATIONS
) -> tuple[Array, Array, Array]:
    """q, v (N, n) and lam (N, m) at times t (N,) from those at ``known`` times (K,), ascending, which enclose t.

    ``rotations`` (R,) are the first of the three coordinates of each rotation in space, a rotation vector; they are
    interpolated relative to the attitude at the earlier of two times, and their v are angular velocities in body axes.
    """
    if len(known) == 1:
        return q[np.zeros(len(t), int)], v[np.zeros(len(t), int)], lam[np.zeros(len(t), int)]
    k = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    h = (known[k + 1] - known[k])[:, None]
    x = (t - known[k])[:, None] / h
    q0, q1, v0, v1 = q[k], q[k + 1], h * v[k], h * v[k + 1]
    own = rotations[:, None] + np.arange(3)
    base, q0[:, own] = q0[:, own], 0.0
    q1[:, own] = turned(-base, q1[:, own])
    v1[:, own] = from_spin(q1[:, own], v1[:, own])
    c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
    found_q, found_v = q0 + x * (v0 + x * (c2 + x * c3)), (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
    found_v[:, own] = to_spin(found_q[:, own], found_v[:, own])
    found_q[:, own] = turned(base, found_q[:, own])
    found_lam = lam[k] + x * (lam[k + 1] - lam[k])
    for row in (0, 1):  # known values are not interpolated
        at = x[:, 0] == row
        found_q[at], found_v[at], found_lam[at] = q[k[at] + row], v[k[at] + row], lam[k[at] + row]
    return found_q, found_v, found_lam
