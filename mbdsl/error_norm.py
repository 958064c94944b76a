"""The error of a motion as one number: the norm of every tolerance.

Positions are divided by the mechanism's size, angles stay in radians: that is what ``System.tables.scale`` multiplies
coordinates by. Velocities are scaled so, too, and divided by the fastest scaled velocity of the run, which counts as at
least one size (or radian) in the time of the run. The error is the largest of these over all coordinates and outputs.
Units of length, mass and time do not change it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def fastest(scale: Array, v: Array, span: float) -> float:
    """The largest scaled velocity [1/s] of a motion.

    Parameters
    ----------
    scale : (n,)
        What makes coordinates comparable: ``System.tables.scale``.
    v : (N, n) [m/s, rad/s]
    span : float [s]
        The time of the run.
    """
    return max(float(np.abs(v * scale).max(initial=0.0)), 1.0 / span if span > 0.0 else 1.0)


def differences(scale: Array, speed: float, dq: Array, dv: Array) -> Array:
    """The norm of differences (N, n) in q and v at each of N times, for a motion as fast as ``speed`` [1/s]."""
    q, v = np.abs(dq * scale), np.abs(dv * scale) / speed
    return np.maximum(q.max(axis=1, initial=0.0), v.max(axis=1, initial=0.0))


def distance(scale: Array, span: float, found: tuple[Array, Array], exact: tuple[Array, Array]) -> float:
    """The error of q and v (N, n) that are ``found``, where others are ``exact``, in a run of so many seconds."""
    speed = fastest(scale, exact[1], span)
    return float(differences(scale, speed, found[0] - exact[0], found[1] - exact[1]).max(initial=0.0))
