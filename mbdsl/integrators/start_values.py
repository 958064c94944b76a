"""Start values of a run: rates of initial accelerations, the first step, and projections onto the constraints."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.kernels.arrays import Array
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations, rows_kept

#: largest h omega for reactions from M^{-1} Q; above it their error is some percent, and soon exceeds them
STIFFEST = 300.0


def rate(after: Callable[[float], Array], now: Array, e: float) -> Array:
    """The rate of a quantity (n,) at the start, by one-sided differences over the time e; zero if it does not exist.

    ``now`` is its value at the start, and ``after(s)`` that at the time s later.
    """
    try:
        found = (4 * after(e) - after(2 * e) - 3 * now) / (2 * e)
    except InitialisationError:
        return np.zeros_like(now)
    return found if np.isfinite(found).all() else np.zeros_like(now)


def applied(system: System, t: float, q: Array, v: Array, lam: Array) -> Array:
    """fa = M^{-1} Q (n,), where Q contains the forces of nonholonomic constraints."""
    force = system.applied_force(t, q, v, lam)
    return system.solve_mass(t, q, force)


def rates(
    system: System, t: float, e: float, q: Array, v: Array, a: Array, lam: Array, left_out: tuple[int, ...]
) -> tuple[Array, Array, Array]:
    """fa, the rate of a and the rate of fa, (n,) each; the rates by differences over the time e."""

    @cache
    def motion(s: float) -> tuple[Array, Array]:
        return system.moved(q, s * v, s * s / 2 * a), v + s * a

    def forced(s: float) -> Array:
        return applied(system, t + s, *motion(s), lam)

    fa = forced(0.0)
    jerk = rate(lambda s: accelerations(system, t + s, *motion(s), left_out)[0], a, e)
    return fa, jerk, rate(forced, fa, e)


def first_step(
    h: float,
    local_error: Callable[[float, float], tuple[float, float]],
    allowed: float,
    exponent: float,
    sizes: tuple[Array, float, float],
    a: Array,
    jerk: Array,
    e: float,
) -> float:
    """The first step, at most h, whose estimated error is about the allowed one.

    ``local_error`` gives the errors of q and v in a step h from jerk and snap; h is proportional to the power
    ``exponent`` of the error. ``sizes``: the scale of q (n,), a speed, and the length of the run.
    Derivatives may vanish at a symmetric start and be large shortly after. Therefore lower bounds of jerk and snap
    follow from the time scale of ``speed`` and of the accelerations. The jerk is known by differences over the time e,
    which show no rate above 1/e: an acceleration that is rounding, beside its change in this time, is no scale.
    """
    scale, speed, span = sizes
    fast = float(np.abs(a * scale).max(initial=0.0))
    w = max(1.0 / span, speed, fast**0.5)
    change = float(np.abs(jerk * scale).max(initial=0.0))
    snap = np.abs(jerk) * (change / max(fast, e * change) if change else 0.0)
    snap, jerk = np.maximum(snap, np.abs(a) * w**2), np.maximum(np.abs(jerk), np.abs(a) * w)
    error = 0.0
    for k in range(len(a)):
        e_q, e_v = local_error(jerk[k], snap[k])
        error = max(error, abs(e_q) * scale[k], abs(e_v) * scale[k] / speed)
    return h * min(1.0, (allowed / error) ** exponent) if error > 0.0 else h


def normal_part(system: System, t: float, q: Array, v: Array, x: Array, left_out: tuple[int, ...]) -> Array:
    """The part of x (n,) along the normals of the holonomic constraints, in the metric of M."""
    right = np.zeros(system.unknowns)
    right[system.n : system.n + system.m] = system.Phi_q(t, q) @ x
    found = _projected(system, t, q, v, right, left_out)
    return np.zeros(system.n) if found is None else found


def onto_constraints(system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> tuple[Array, Array]:
    """q and v (n,) projected onto Phi, its rate and Gam by one Newton step, in the metric of M."""
    n, m = system.n, system.m
    if len(left_out) == m + system.p:
        return q, v
    right = np.zeros(system.unknowns)
    right[n : n + m] = -system.Phi(t, q)
    change = _projected(system, t, q, v, right, left_out)
    q = q if change is None else system.moved(q, change)
    right[n:] = -system.constraint_rates(t, q, v)
    change = _projected(system, t, q, v, right, left_out)
    return q, v if change is None else v + change


def _projected(system: System, t: float, q: Array, v: Array, right: Array, left_out: tuple[int, ...]) -> Array | None:
    """x (n,) from [[M, J^T], [J, 0]] [x; .] = right, with J = [Phi_q; Gam_v]; None if the matrix is singular."""
    n = system.n
    kept = np.concatenate([np.arange(n), n + rows_kept(system.m + system.p, left_out)])
    matrix = system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0)
    found = np.zeros(system.unknowns)
    try:
        if isinstance(matrix, np.ndarray):
            found[kept] = np.linalg.solve(matrix[kept[:, None], kept], right[kept])
        else:
            from scipy.sparse.linalg import splu

            found[kept] = splu(matrix[kept][:, kept].tocsc()).solve(right[kept])
    except (np.linalg.LinAlgError, RuntimeError):  # a singular pose, or a body without mass
        return None
    return found[:n]


def check_stiffness(system: System, method: str, t: float, h: float, q: Array, v: Array, lam: Array) -> None:
    """Check that the rounding of q, multiplied by M^{-1} K, is smaller than the reactions.

    Raises
    ------
    InitialisationError
        If it is larger.
    """
    K, M = system.stiffness(t, q, v, lam).diagonal(), system.M(t, q).diagonal()
    fastest = np.sqrt(np.maximum(K / M, 0.0))
    k = int(fastest.argmax()) if system.n else 0
    if system.n and h * fastest[k] > STIFFEST:
        raise InitialisationError(
            f"{method} finds reactions from M^-1 Q, where stiffness magnifies rounding: "
            f"{system.names()[k]} has {fastest[k]:.1e} rad/s, {h * fastest[k]:.0f} times 1/h",
            hint=f"take a step below {STIFFEST / fastest[k]:.2g} s or another method, or remove this (axial?) mode",
        )
