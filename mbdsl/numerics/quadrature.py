"""Quadrature of functions that are known at given times: weights of the values."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array

#: points within an interval, from 0 to 1, and weights, of the Lobatto rule with both ends, exact up to degree 7
LOBATTO = 0.5 + 0.5 * np.array([-((3.0 / 7.0) ** 0.5), 0.0, (3.0 / 7.0) ** 0.5])
LOBATTO_WEIGHTS = np.array([1.0 / 20.0, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0])
#: ratio of two intervals above which the derivative between them is not used: one of them is the width of a jump
UNLIKE = 100.0
EVEN = 1e-6  #: relative difference up to which all intervals count as equal


def weights(t: Array) -> Array:
    """Weights (N,) of values at ascending times t (N,), for their integral over time.

    The trapezoidal rule with the correction h^2/12 (y'_0 - y'_1) of each interval, which has order 4. The derivatives
    are those of parabolas through three points.
    """
    if len(t) < 2:
        return np.zeros(len(t))
    h = np.diff(t)
    w = np.zeros(len(t))
    w[:-1] += 0.5 * h
    w[1:] += 0.5 * h
    if h.max() - h.min() > EVEN * h.max():
        _correct(w, h)
    for end in (slice(0, 3), slice(-1, -4, -1)) if len(h) > 1 else ():
        a, b = np.abs(np.diff(t[end]))
        if max(a, b) < UNLIKE * min(a, b):  # the derivative at an end, inwards
            d = np.array([-(2.0 * a + b) / (a * (a + b)), (a + b) / (a * b), -a / (b * (a + b))])
            w[end] += a**2 / 12.0 * d
    return w


def _correct(w: Array, h: Array) -> None:
    """Add the corrections at the times between two intervals h (N - 1,), which vanish if these are equal."""
    h0, h1 = h[:-1], h[1:]
    alike = (h0 < UNLIKE * h1) & (h1 < UNLIKE * h0)
    h0, h1 = np.where(alike, h0, 1.0), np.where(alike, h1, 1.0)
    c = np.where(alike, (h1**2 - h0**2) / 12.0, 0.0)
    w[:-2] -= c * h1 / (h0 * (h0 + h1))
    w[1:-1] += c * (h1 - h0) / (h0 * h1)
    w[2:] += c * h0 / (h1 * (h0 + h1))


def lobatto_points(t: Array) -> tuple[Array, Array]:
    """Times (4 N - 3,) at and within the intervals of t (N,), and their weights by the Lobatto rule of five points."""
    h = np.diff(t)
    times = np.empty(4 * len(h) + 1)
    times[::4] = t
    w = np.zeros(len(times))
    for k in range(1, 4):
        times[k::4] = t[:-1] + LOBATTO[k - 1] * h
        w[k::4] = LOBATTO_WEIGHTS[k] * h
    w[:-1:4] += LOBATTO_WEIGHTS[0] * h
    w[4::4] += LOBATTO_WEIGHTS[4] * h
    return times, w
