"""Interpolation between the steps of a motion: q and v by cubic Hermite polynomials, multipliers linearly."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics.rotation_arrays import from_spin, to_spin, turned

NO_ROTATIONS = np.empty(0, np.int64)
#: times closer than this part of the largest one, as on both sides of an event: the change of q is rounding there
AT_ONCE = 1e-9


def between(
    t: Array,
    known: Array,
    q: Array,
    v: Array,
    lam: Array,
    rotations: Integers = NO_ROTATIONS,
    a: Array | None = None,
) -> tuple[Array, Array, Array]:
    """q, v (N, n) and lam (N, m) at times t (N,) from those at ``known`` times (K,), ascending, which enclose t.

    With the accelerations ``a`` (K, n), q has degree 5, where these are finite. Between two times so close that the
    change of q is rounding, v is linear.

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
    way, at_once = q1 - q0, h <= AT_ONCE * np.abs(known[[0, -1]]).max()
    lost = at_once & (np.abs(way) <= AT_ONCE * np.abs(q).max(axis=0))
    way = np.where(lost, 0.5 * (v0 + v1), way)
    c2, c3 = 3.0 * way - 2.0 * v0 - v1, -2.0 * way + v0 + v1
    found_q, found_v = q0 + x * (v0 + x * (c2 + x * c3)), (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
    if a is not None:
        a0, a1 = h * h * a[k], h * h * a[k + 1]
        a1[:, own] = _second_rates(q1[:, own], h[:, :, None] * v[k + 1][:, own], a1[:, own])
        more, rate = _degree_five(x, 2.0 * c2, 2.0 * c2 + 6.0 * c3, a0, a1)
        found_q, found_v = found_q + more, found_v + rate / h
    found_v[:, own] = to_spin(found_q[:, own], found_v[:, own])
    found_q[:, own] = turned(base, found_q[:, own])
    found_lam = lam[k] + x * (lam[k + 1] - lam[k])
    for row in (0, 1):  # known values are not interpolated
        at = x[:, 0] == row
        found_q[at], found_v[at], found_lam[at] = q[k[at] + row], v[k[at] + row], lam[k[at] + row]
    return found_q, found_v, found_lam


def _degree_five(x: Array, b0: Array, b1: Array, a0: Array, a1: Array) -> tuple[Array, Array]:
    """What a cubic with second derivatives b0 and b1 at 0 and 1 lacks to have a0 and a1 there, at x; its derivative.

    It is x^2 (1 - x)^2 (c + d x); c + d x is linear, and half of the missing second derivatives at both ends.
    """
    c = np.where(np.isfinite(a0), 0.5 * (a0 - b0), 0.0)
    d = np.where(np.isfinite(a1), 0.5 * (a1 - b1), 0.0) - c
    y, line = x * (1.0 - x), c + d * x
    return y * y * line, 2.0 * y * (1.0 - 2.0 * x) * line + y * y * d


def _second_rates(psi: Array, w: Array, rate: Array) -> Array:
    """psi'' (N, R, 3) of rotation vectors with the angular velocities w and their rates: a central difference."""
    e, d_psi = 1e-5, from_spin(psi, w)
    return (from_spin(psi + e * d_psi, w + e * rate) - from_spin(psi - e * d_psi, w - e * rate)) / (2.0 * e)
