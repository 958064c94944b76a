"""The amplification of rounding errors along a motion, by the tangent (variational) equations.

Runs with different steps may agree although the motion is sensitive: a pendulum balanced upside down rests in all of
them, and yet an error in the last digit of its position makes it fall. Here perturbations as large as the positions (at
least one) and velocities are added at the start and at every sample of a run - to a velocity at a sample, one as large
as this velocity, to which the rounding of steps is relative - and propagated by the equations linearised there,

    M dv' + K dq + D dv + Phi_q^T dlam + Gam_v^T dnu = 0,   Phi_q dq = 0,   J dv + N dq = 0,

J = [Phi_q; Gam_v], N = [(Phi_q v)_q; Gam_q]. With orthonormal columns of Z (n, r) and V (n, d), Phi_q Z = 0, J V = 0,
and the least rotation of these bases along the motion, V' = -J^+ J' V, Z^T Z' = 0,

    dq = Z y,   dv = V x + B y,   B = -J^+ N Z,
    y' = Z^T dv,   u = V^T M dv,   u' = V'^T M dv - V^T (D dv + K dq),

all in scaled coordinates. Without constraints on velocities V = Z and V' = B. The matrices are taken as constant from
the middle of one interval between samples to the middle of the next, and the solution is the exponential, so that
neither large negative nor large positive rates matter. y and u are carried over from sample to sample, so that B' is
not needed. If rates are large for a time shorter than an interval, this overestimates the growth; the calibration then
takes finer samples, at the steps of the run.

In space, rotations and angular velocities are perturbed in body axes and written in world axes, which change as slowly
as the mechanism: dq contains the small rotation theta, dv the change c of the angular velocity, and theta' = c. With I
the inertia, in world axes, the equations above have D c - omega x I c in place of D c, because I turns with the body.
Bodies without constraints on their rotation have body axes, theta' = c - Omega x theta. Samples resolve the turning of
I, or the model is not examined.

Jumps of forces, impacts, and the dependence of joint friction on reactions are not included. Models whose mass matrix
is badly conditioned (a link of 1 g on one of 10 t) are not examined: from sample to sample, V turns by a small angle
that mixes their momenta, and a small error of the heavy link is a large one for the light link.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbdsl.bodies.spatial_rigid_body_kernels import J as INERTIA
from mbdsl.errors import InitialisationError
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics.matrix_exponential import exponential
from mbdsl.numerics.rotation_arrays import cross_matrices, matrices
from mbdsl.numerics.saddle_point import RANK
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.tangents import tangents

Part = tuple[System, Array, Array, Array, Array, tuple[int, ...]]

#: largest number of unknowns for which the growth is computed, because the matrices are dense
MOST = 400
#: most and least samples of a run, unless finer ones are asked for; numbers in the matrices of all samples, which limit
#: the samples of large models
SAMPLES, FEWEST, NUMBERS = 160, 40, 200_000
#: largest change of an inertia in space between samples, relative to it, and the most samples for that
TURN, MOST_SAMPLES = 0.25, 4000
#: number of propagated perturbations, in different directions
DIRECTIONS = 3
#: logarithm up to which numbers are not scaled
LARGE = 200.0
#: mass of a coordinate without mass, relative to the largest mass
MASSLESS = 1e-12
#: largest condition number of the reduced mass matrix
MOST_CONDITION = 1e6
#: part of the condition number of constraints that are dependent, below which QR factors show their null space
REGULAR = 1e-3


@dataclass(frozen=True)
class Growth:
    """The growth of perturbations along a run."""

    t: Array  #: (N,) [s]
    #: (N,): logarithm of the perturbation at these times, when perturbations as large as the state itself are added at
    #: the start and at every sample
    log: Array
    rate: float  #: [1/s] the largest rate of growth over a fiftieth of the run

    def at(self, times: Array) -> Array:
        """The logarithm of the largest perturbation up to each of ``times``."""
        return np.interp(times, self.t, np.maximum.accumulate(self.log))


def growth(
    system: System,
    t: Array,
    q: Array,
    v: Array,
    lam: Array,
    left_out: tuple[int, ...],
    speed: float,
    finer: float = 1.0,
) -> Growth | None:
    """The growth along a run with the states q, v (N, n) and multipliers lam (N, m + p) at times t (N,).

    Parameters
    ----------
    left_out : tuple of int
        Redundant constraints.
    speed : float [1/s]
        The largest scaled velocity of the run.
    finer : float
        Factor on the number of samples, as far as the run has them; less for large models.

    Returns
    -------
    Growth or None
        None if the model is not examined, or if the constraints change rank along the run.

    Raises
    ------
    InitialisationError
        If the accelerations at a sample cannot be found.
    """
    if system.unknowns > MOST or len(t) < 2 or not system.n:
        return None
    if (least := _resolving(system, t, v)) > 2.0 * min(len(t), MOST_SAMPLES):
        return None
    chosen = _samples(len(t), system, finer, least)
    t, q, v, lam = t[chosen], q[chosen], v[chosen], lam[chosen]
    points = _points(system, t, q, v, lam, left_out)
    return None if points is None else _carried(t, points, speed)


def along(parts: Iterable[Part], t: Array, speed: float, finer: float = 1.0) -> tuple[Growth, int]:
    """The growth at times t (N,) along a motion of several parts, and the number of parts for which it is complete.

    ``parts`` are the system of each, its times, q, v and lam there, and its redundant constraints, as from
    ``Motion.parts_of``; ``speed`` and ``finer`` as for :func:`growth`. Parts that cannot be examined are not counted.
    """
    found, rate, known = np.zeros(len(t)), 0.0, 0
    for system, own_t, q, v, lam, left_out in parts:
        try:
            with np.errstate(all="ignore"):
                own = growth(system, own_t, q, v, lam, left_out, speed, finer)
        except (InitialisationError, np.linalg.LinAlgError):
            continue  # there are no tangent equations here
        if own is not None:
            found, rate = np.fmax(found, own.at(t)), max(rate, own.rate)
            known += own.t[-1] == own_t[-1]
    return Growth(t, found, rate), known


def _samples(count: int, system: System, finer: float, least: float) -> Integers:
    most = int(np.clip(NUMBERS * finer**0.5 / max(1, system.unknowns) ** 2, FEWEST, SAMPLES * finer))
    most = max(most, min(int(least), MOST_SAMPLES))
    rows = np.linspace(0, count - 1, min(count, most)).round().astype(np.int64)
    return rows[np.diff(rows, prepend=-1) > 0]  # each once; np.unique imports numpy.ma, which takes 14 ms


def _resolving(system: System, t: Array, v: Array) -> float:
    """The number of samples which resolve the turning of inertias in space; 0 in the plane."""
    if not len(system.tables.rotations):
        return 0.0
    d, at = system.tables.rotations.T
    inertia = system.tables.numbers[at[:, None] + INERTIA + np.arange(9)].reshape(-1, 3, 3)  # in body axes
    spin = cross_matrices(v[:, d[:, None] + np.arange(3)])
    rate = np.abs(spin @ inertia - inertia @ spin).max(axis=(2, 3))
    rate /= np.maximum(np.abs(inertia).max(axis=(1, 2)), 1e-300)
    return float(rate.max()) * (t[-1] - t[0]) / TURN


class _Points(NamedTuple):
    """The tangent equations at all samples: bases, u = mass x + G y, and the rate of [y; x]."""

    Z: Array
    V: Array
    B: Array
    mass: Array
    G: Array
    rate: Array
    sizes: Array  #: (N, r + d) sizes of perturbations of y: the largest scaled position, at least one; and of x


def _points(system: System, t: Array, q: Array, v: Array, lam: Array, left_out: tuple[int, ...]) -> _Points | None:
    """The tangent equations at these states; None if the constraints change rank, the mass matrix is ill-conditioned,
    or a derivative is not finite.

    The matrices of all samples are decomposed together: a call of NumPy takes longer than its work on one of them.
    """
    n, m, s = system.n, system.m, 1.0 / system.tables.scale
    kept = np.delete(np.arange(m + system.p), np.array(left_out, int))
    both, lower = kept < m, n + kept
    e = 1e-6 / np.where((fastest := np.abs(v / s).max(axis=1)) > 0.0, fastest, 1.0)
    one, two, M, other = _matrices(system, t, q, v, lam, left_out, None if both.all() else e)
    W = _turn_with_bodies(system, q, v, M, one, two)
    diagonal = M.shape[2] == 1
    K, D = (s[:, None] * X[:, :n, :n] * s for X in (one, two))
    M = s[:, None] * M * (s[:, None] if diagonal else s)
    J, N = one[:, lower, :n] * s, two[:, lower, :n] * s
    size = np.abs(J).max(axis=2, initial=0.0)[:, :, None]
    size[size == 0.0] = 1.0
    J, N = J / size, N / size
    whole = _split(J)
    part = whole if both.all() else _split(J[:, both])
    if whole is None or part is None or not part[0].shape[2]:
        return None  # no degrees of freedom, or the constraints change rank along the run
    V, inverse = whole
    Z = part[0]
    B = V1 = -inverse @ (N @ Z)
    if not both.all():
        turned = np.where(both[:, None], N, (other[:, lower, :n] * s / size - J) / e[:, None, None])
        V1 = -inverse @ (turned @ V)
    Vt, Zt = np.swapaxes(V, 1, 2), np.swapaxes(Z, 1, 2)
    MV, MB = (M * X if diagonal else M @ X for X in (V, B))
    mass = Vt @ MV
    largest = np.abs(mass).max(axis=(1, 2), initial=0.0)[:, None, None]
    mass += MASSLESS * np.where(largest > 0.0, largest, 1.0) * np.eye(mass.shape[1])
    own = np.linalg.eigvalsh(mass)  # without columns where drivers prescribe all velocities
    if (own[:, -1:] > MOST_CONDITION * own[:, :1]).any():
        return None
    G, V1t, VtD = Vt @ MB, np.swapaxes(V1, 1, 2), Vt @ D
    y = np.concatenate([Zt @ (B if W is None else B + W @ Z), Zt @ V], axis=2)
    u = np.concatenate([V1t @ MB - VtD @ B - Vt @ (K @ Z), V1t @ MV - VtD @ V], axis=2)
    far = np.repeat(np.maximum(1.0, np.abs(q / s).max(axis=1))[:, None], Z.shape[2], axis=1)
    own = _velocities(system, v, W)
    own[0] = fastest[0]  # of the data, in any axes
    sizes = np.concatenate([far, np.sqrt(np.einsum("kij,ki->kj", V**2, own**2))], axis=1)
    rate = np.concatenate([y, np.linalg.solve(mass, u - G @ y)], axis=1)
    return _Points(Z, V, B, mass, G, rate, sizes) if np.isfinite(rate).all() else None


def _matrices(
    system: System, t: Array, q: Array, v: Array, lam: Array, left_out: tuple[int, ...], ahead: Array | None
) -> tuple[Array, Array, Array, Array]:
    """The derivatives by positions and by velocities (N, n + m + p, n + m + p), the mass matrices (N, n, n), or their
    diagonals (N, n, 1), and the derivatives by positions at times that are ``ahead`` (N,); without these, the first
    ones again."""
    n, a, in_space = system.n, None, len(system.tables.rotations) > 0
    constant = system.mass_is_diagonal or in_space  # in body axes
    diagonal = constant and not in_space
    if not (constant and np.isfinite(lam).all()):
        found = [accelerations(system, *state, left_out) for state in zip(t, q, v, strict=True)]
        a, lam = np.array([x for x, _ in found]), np.array([x for _, x in found])
    requests = [dict(cK=1.0, cP=1.0, cV=1.0, cA=0.0 if a is None else 1.0), dict(cD=1.0, cN=1.0, cW=1.0)]
    one, two, *mass = tangents(system, t, q, v, lam, a, requests if diagonal else [*requests, dict(cM=1.0)])
    M = np.broadcast_to(system.mass()[:, None], (len(t), n, 1)) if diagonal else mass[0][:, :n, :n]
    if ahead is None:
        return one, two, M, one
    later = system.moved(q, ahead[:, None] * v)
    return one, two, M, tangents(system, t + ahead, later, v, lam, None, [dict(cP=1.0, cV=1.0)])[0]


def _turn_with_bodies(
    system: System, q: Array, v: Array, M: Array, of_positions: Array, of_velocities: Array
) -> Array | None:
    """Replace D by D - omega~ I in world axes; if no constraint acts on the rotation of a body, go to its axes instead.

    Returns W (N, n, n) with dq' = dv + W dq, None if it is zero.
    """
    n, found = system.n, None
    for d in system.tables.rotations[:, 0]:
        own = slice(d, d + 3)
        R = matrices(q[:, own])
        if of_positions[:, n:, own].any() or of_velocities[:, n:, own].any():
            of_velocities[:, own, :n] -= cross_matrices((R @ v[:, own, None])[:, :, 0]) @ M[:, own]
            continue
        found = np.zeros((len(q), n, n)) if found is None else found
        found[:, own, own] = -cross_matrices(v[:, own])
        for A in (M, of_positions, of_velocities):
            A[:, own] = np.swapaxes(R, 1, 2) @ A[:, own]
            A[:, :, own] = A[:, :, own] @ R
    return found


def _velocities(system: System, v: Array, W: Array | None) -> Array:
    """The size (N, n) of each scaled velocity, to which rounding is relative; of a rotation in world axes, the size of
    the whole angular velocity."""
    found = np.abs(v * system.tables.scale)
    for d in system.tables.rotations[:, 0]:
        own = slice(d, d + 3)
        if W is None or not W[:, own, own].any():
            found[:, own] = np.linalg.norm(found[:, own], axis=1)[:, None]
    return found


def _split(J: Array) -> tuple[Array, Array] | None:
    """Orthonormal bases of the null spaces of J (N, k, n), as columns, and the pseudo-inverses (N, n, k) of J; None if
    the ranks differ."""
    count, k, n = J.shape
    if not k:
        return np.broadcast_to(np.eye(n), (count, n, n)), np.zeros((count, n, 0))
    if k <= n:  # for J of full rank, QR factors take a fraction of the time of singular values
        Q, R = np.linalg.qr(np.swapaxes(J, 1, 2), mode="complete")
        R = R[:, :k]
        if np.abs(R.diagonal(axis1=1, axis2=2)).min() > 0.0:
            inverse = np.linalg.inv(R)
            if (np.abs(inverse).max(axis=(1, 2)) * np.abs(R).max(axis=(1, 2))).max() < REGULAR / RANK:
                return Q[:, :, k:], Q[:, :, :k] @ np.swapaxes(inverse, 1, 2)
    U, s, Vt = np.linalg.svd(J)
    ranks = (s > RANK * s.max(axis=1, keepdims=True, initial=0.0)).sum(axis=1)
    rank = int(ranks[0])
    if (ranks != rank).any():
        return None
    inverse = np.swapaxes(Vt[:, :rank], 1, 2) @ np.swapaxes(U[:, :, :rank] / s[:, None, :rank], 1, 2)
    return np.swapaxes(Vt[:, rank:], 1, 2), inverse


def _carried(t: Array, points: _Points, speed: float) -> Growth:
    (Z, V, B, mass, G, rate, sizes), h = points, np.diff(t)
    r, d = Z.shape[2], V.shape[2]
    rate[:, :r, r:], rate[:, r:, :r] = speed * rate[:, :r, r:], rate[:, r:, :r] / speed  # of velocities over the speed
    first, sizes_first, second, sizes_second = _halves(rate, h, r)
    turn = _turns(Z)  # from one basis to the next
    turn_v = turn if V is Z else _turns(V)
    carry = np.zeros((len(h), r + d, r + d))
    carry[:, :r, :r] = turn
    kept = np.concatenate([(turn_v @ G[:-1] - G[1:] @ turn) / speed, turn_v @ mass[:-1]], axis=2)
    carry[:, r:] = np.linalg.solve(mass[1:], kept)
    steps, logs = second @ carry @ first, sizes_first + sizes_second
    new = np.random.default_rng(1).standard_normal((r + d, DIRECTIONS)) / np.sqrt(r + d)
    added = (sizes / np.repeat([1.0, speed], (r, d)))[:, :, None] * new
    x, log, done = _propagated(steps, logs, added)
    y, w = x[:, :r], x[:, r:]
    length = np.maximum(np.abs(Z @ y).max(axis=(1, 2)), np.abs(V @ w + B @ y / speed).max(axis=(1, 2)))[:done]
    t, log = t[:done], log[:done] + np.log(np.maximum(length, 1e-300))
    if done <= len(h):
        return Growth(t, log, np.inf)
    window = max((t[-1] - t[0]) / 50.0, float(h.min()))
    later = np.interp(np.minimum(t + window, t[-1]), t, log)
    return Growth(t, log, float(np.max((later - log) / window, initial=0.0)))


def _propagated(steps: Array, logs: Array, added: Array) -> tuple[Array, Array, int]:
    """x (N, k, d), log (N,) and the number of samples that are reached: the sum of all perturbations ``added``
    (N, k, d) up to each sample is x exp(log), where ``steps`` exp(``logs``) (N - 1, k, k), (N - 1,) lead from one
    sample to the next."""
    x, log = added.copy(), np.zeros(len(added))
    if (np.abs(logs) < LARGE).all():
        for k, step in enumerate(steps * np.exp(logs)[:, None, None]):
            x[k + 1] += step @ x[k]
        if np.abs(x).max(initial=0.0) < np.exp(LARGE):  # false for nan
            return x, log, len(x)
    for k, step in enumerate(steps):  # where they grow without bound, they are scaled at every sample
        y = step @ x[k]
        size = float(np.abs(y).max(initial=0.0)) or 1.0
        if not np.isfinite(size):
            return x, log, k + 1
        # with a negative sum the perturbations added are larger
        log[k + 1] = largest = max(0.0, total := log[k] + logs[k] + np.log(size))
        x[k + 1] = y * (np.exp(total - largest) / size) + added[k + 1] * np.exp(-largest)
    return x, log, len(x)


def _halves(rate: Array, h: Array, r: int) -> tuple[Array, Array, Array, Array]:
    """The solutions over the first and the second half of every interval h (N - 1,), each with the rate (N, k, k) of
    the sample at its end, as from ``exponential``. The first r of the k unknowns are positions."""
    alike = np.abs(np.diff(h)) <= 1e-6 * h[:-1]  # both halves at a sample have the same length, and the same solution
    others = np.append(np.flatnonzero(~alike) + 1, len(h))
    every = np.concatenate([rate[:-1] * (0.5 * h)[:, None, None], rate[others] * (0.5 * h[others - 1])[:, None, None]])
    # scaled velocities, so that the norm is near the largest frequency, not near its square; by a power of two: exact
    up, down = (float(np.abs(x).sum(axis=2).max(initial=0.0)) for x in (every[:, :r, r:], every[:, r:, :r]))
    scale = 2.0 ** np.round(0.5 * np.log2(down / up)) if up > 0.0 < down else 1.0
    every[:, :r, r:], every[:, r:, :r] = scale * every[:, :r, r:], every[:, r:, :r] / scale
    E, s = exponential(every)
    E[:, :r, r:], E[:, r:, :r] = E[:, :r, r:] / scale, scale * E[:, r:, :r]
    at = np.arange(1, len(h) + 1)
    at[others - 1] = len(h) + np.arange(len(others))
    return E[: len(h)], s[: len(h)], E[at], s[at]


def _turns(Z: Array) -> Array:
    """Orthogonal matrices (N - 1, r, r) that take coordinates in each basis (N, n, r) to the next basis."""
    U, _, W = np.linalg.svd(np.swapaxes(Z[1:], 1, 2) @ Z[:-1])
    return U @ W
