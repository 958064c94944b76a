"""The error norm of every tolerance: the error of a motion as one number.

Positions are divided by the mechanism's size, angles stay in radians; ``System.tables.scale`` holds these factors.
Velocities are scaled by the same factors and divided by the largest scaled velocity of the run, which is at least one
size (or radian) per duration of the run. The error is the maximum over all coordinates and outputs. It does not depend
on the units of length, mass and time.
"""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array


def fastest(scale: Array, v: Array, span: float) -> float:
    """The largest scaled velocity [1/s] of a motion.

    Parameters
    ----------
    scale : (n,)
        Factors that make coordinates comparable: ``System.tables.scale``.
    v : (N, n) [m/s, rad/s]
    span : float [s]
        The duration of the run.
    """
    return max(float(np.abs(v * scale).max(initial=0.0)), 1.0 / span if span > 0.0 else 1.0)


def differences(scale: Array, speed: float, dq: Array, dv: Array, of_v: Array | None = None) -> Array:
    """The norm of differences (N, n) in q and v at each of N times; ``speed`` [1/s] is the largest scaled velocity.

    ``of_v`` (n,) are the factors of velocities, if these are not ``scale``.
    """
    q, v = np.abs(dq * scale), np.abs(dv * (scale if of_v is None else of_v)) / speed
    return np.maximum(q.max(axis=1, initial=0.0), v.max(axis=1, initial=0.0))


def distance(scale: Array, span: float, found: tuple[Array, Array], exact: tuple[Array, Array]) -> float:
    """The error of the q and v (N, n) in ``found`` relative to those in ``exact``; the run takes ``span`` [s]."""
    speed = fastest(scale, exact[1], span)
    return float(differences(scale, speed, found[0] - exact[0], found[1] - exact[1]).max(initial=0.0))
