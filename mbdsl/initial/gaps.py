"""Gaps of loops that cannot be closed: how far a joint is open if all other constraints hold.

Where constraints contradict each other, assembly ends at a compromise that violates every joint of the loop a little.
The gap at one joint, in metres and degrees, is what a user finds who puts the mechanism together: the least violation
of this joint, by Gauss-Newton steps among the poses in which the others hold.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense, least_squares, null_space
from mbdsl.system.system import System

Residual = Callable[[Array], tuple[Array, Array]]  #: r (m,) and its Jacobian (m, n) over scaled coordinates, at a pose

CLOSED = 1e-9  #: misfit of the other constraints up to which they hold, relative to the mechanism's size
STEPS = 30  #: most Gauss-Newton steps
LARGEST = 200  #: constraint rows above which gaps are not computed


def gap(system: System, t: float, q: Array, own: slice, residual: Residual) -> tuple[float, float] | None:
    """The distance [m] and the angle [rad] by which the joint of the rows ``own`` is open if the others are closed.

    None if the others cannot be closed either, or if there are too many constraints.
    """
    if system.m > LARGEST:
        return None
    scale, size = system.tables.scale, system.tables.size
    for _ in range(STEPS):
        r, J = residual(q)
        others = np.ones(len(r), bool)
        others[own] = False
        step = least_squares(J[others], -r[others], 1e-9)
        Z = null_space(J[others])
        if Z.shape[1]:
            step = step + Z @ least_squares(J[own] @ Z, -(r[own] + J[own] @ step), 1e-9)
        q = system.moved(q, step * min(1.0, 0.3 / max(np.abs(step).max(), 1e-300)) / scale)
        if np.abs(step).max() < 1e-12:
            break
    r, _ = residual(q)
    r = np.delete(r, own)
    if np.abs(r).max(initial=0.0) > CLOSED * max(1.0, size):
        return None
    far, turned = parts(system, t, q, own)
    return far, turned


def parts(system: System, t: float, q: Array, own: slice) -> tuple[float, float]:
    """The violation of the rows ``own`` of positions: a distance [m] and an angle [rad]."""
    r, J = system.Phi(t, q)[own], dense(system.Phi_q(t, q))[own]
    lengths = (J[:, system.tables.lengths] != 0.0).any(axis=1)
    return float(np.linalg.norm(r[lengths])), float(np.arcsin(min(1.0, float(np.linalg.norm(r[~lengths])))))


def text(far: float, turned: float) -> str:
    """ "0.02 m and 1.5 deg"; a part at rounding level compared with the other is left out."""
    largest = max(far, turned)
    found = [f"{far:.3g} m"] if far > 1e-6 * largest else []
    if turned > 1e-6 * largest:
        found.append(f"{np.rad2deg(turned):.3g} deg")
    return " and ".join(found) or "0 m"
