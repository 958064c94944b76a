"""The amplification of rounding errors along a motion, by the tangent (variational) equations.

Runs with different steps may agree although the motion is sensitive: a pendulum balanced upside down rests in all of
them, and yet an error in the last digit of its position makes it fall. Here perturbations as large as the positions (at
least one) and velocities are added at the start and at every sample of a run, and propagated by the equations
linearised there,

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

Jumps of forces, impacts, and the dependence of joint friction on reactions are not included. Models whose mass matrix
is badly conditioned (a link of 1 g on one of 10 t) are not examined: from sample to sample, V turns by a small angle
that mixes their momenta, and a small error of the heavy link is a large one for the light link.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.numerics.saddle_point import RANK
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations

Array = NDArray[np.float64]
Part = tuple[System, Array, Array, Array, Array, tuple[int, ...]]

#: largest number of unknowns for which the growth is computed, because the matrices are dense
MOST = 400
#: most and least samples of a run, unless finer ones are asked for; numbers in the matrices of all samples, which limit
#: the samples of large models
SAMPLES, FEWEST, NUMBERS = 160, 40, 200_000
#: number of propagated perturbations, in different directions
DIRECTIONS = 3
#: mass of a coordinate without mass, relative to the largest mass
MASSLESS = 1e-12
#: largest condition number of the reduced mass matrix
MOST_CONDITION = 1e6


@dataclass(frozen=True)
class Growth:
    """The growth of perturbations along a run.

    Attributes
    ----------
    t : (N,) [s]
    log : (N,)
        Logarithm of the perturbation at these times, when perturbations as large as the state itself are added at the
        start and at every sample.
    rate : float [1/s]
        The largest rate of growth over a fiftieth of the run.
    """

    t: Array
    log: Array
    rate: float

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
    if len(system.tables.rotations):
        return None  # these equations are those of coordinates whose rates are the velocities
    chosen = _samples(len(t), system, finer)
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


def _samples(count: int, system: System, finer: float) -> NDArray[np.int64]:
    most = int(np.clip(NUMBERS * finer**0.5 / max(1, system.unknowns) ** 2, FEWEST, SAMPLES * finer))
    rows = np.linspace(0, count - 1, min(count, most)).round().astype(np.int64)
    return rows[np.diff(rows, prepend=-1) > 0]  # each once; np.unique imports numpy.ma, which takes 14 ms


class _Points(NamedTuple):
    """The tangent equations at all samples: bases, u = mass x + G y, and the rate of [y; x]."""

    Z: Array
    V: Array
    B: Array
    mass: Array
    G: Array
    rate: Array
    sizes: Array  #: (N, 2) largest scaled position (at least one) and largest scaled velocity


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
    K, D, M = (s[:, None] * X[:, :n, :n] * s for X in (one, two, M))
    J, N = one[:, lower, :n] * s, two[:, lower, :n] * s
    size = np.abs(J).max(axis=2, initial=0.0)[:, :, None]
    size[size == 0.0] = 1.0
    J, N = J / size, N / size
    whole = _split(J)
    part = whole if both.all() else _split(J[:, both])
    if whole is None or part is None or not part[0].shape[2]:
        return None  # no degrees of freedom, or the constraints change rank along the run
    V, inverse = whole
    Z, turned = part[0], N
    if not both.all():
        turned = np.where(both[:, None], N, (other[:, lower, :n] * s / size - J) / e[:, None, None])
    B, V1 = -inverse @ (N @ Z), -inverse @ (turned @ V)
    Vt, Zt = np.swapaxes(V, 1, 2), np.swapaxes(Z, 1, 2)
    mass = Vt @ M @ V
    largest = np.abs(mass).max(axis=(1, 2), initial=0.0)[:, None, None]
    mass += MASSLESS * np.where(largest > 0.0, largest, 1.0) * np.eye(mass.shape[1])
    if np.linalg.cond(mass).max() > MOST_CONDITION:
        return None
    G, drive = Vt @ M @ B, np.swapaxes(V1, 1, 2) @ M - Vt @ D
    y = np.concatenate([Zt @ B, Zt @ V], axis=2)
    u = np.concatenate([drive @ B - Vt @ (K @ Z), drive @ V], axis=2)
    sizes = np.stack([np.maximum(1.0, np.abs(q / s).max(axis=1)), fastest], axis=1)
    rate = np.concatenate([y, np.linalg.solve(mass, u - G @ y)], axis=1)
    return _Points(Z, V, B, mass, G, rate, sizes) if np.isfinite(rate).all() else None


def _matrices(
    system: System, t: Array, q: Array, v: Array, lam: Array, left_out: tuple[int, ...], ahead: Array | None
) -> tuple[Array, Array, Array, Array]:
    """The derivatives by positions and by velocities (N, n + m + p, n + m + p), the mass matrices (N, n, n), and the
    derivatives by positions at times that are ``ahead`` (N,); without these, the first ones again."""
    diagonal, found, mass = system.mass_is_diagonal, np.empty((3, len(t), system.size)), []
    known = diagonal and bool(np.isfinite(lam).all())
    for k in range(len(t)):
        a, reactions = (None, lam[k]) if known else accelerations(system, t[k], q[k], v[k], left_out)
        if a is None:
            system.evaluate(t[k], q[k], v[k], reactions)
        else:
            system.tangent(t[k], q[k], v[k], reactions, a=a)
        found[0, k] = system.entries(t[k], cK=1.0, cP=1.0, cV=1.0, cA=0.0 if a is None else 1.0)
        found[1, k] = system.entries(t[k], cD=1.0, cN=1.0, cW=1.0)
        if not diagonal:
            mass.append(np.asarray(system.M(t[k], q[k])))
        if ahead is not None:
            system.evaluate(t[k] + ahead[k], q[k] + ahead[k] * v[k], v[k], reactions)
            found[2, k] = system.entries(t[k] + ahead[k], cP=1.0, cV=1.0)
    size, (rows, columns) = system.unknowns, system.tables.pattern
    place = np.arange(len(t))[:, None] * size**2 + rows * size + columns
    one, two, other = (
        np.bincount(place.ravel(), x.ravel(), len(t) * size**2).reshape(len(t), size, size)
        for x in (found[0], found[1], found[0 if ahead is None else 2])
    )
    M = np.stack(mass) if mass else np.broadcast_to(np.diag(system.mass()), (len(t), system.n, system.n))
    return one, two, M, other  # type: ignore[return-value]  # of bincount with weights: floats


def _split(J: Array) -> tuple[Array, Array] | None:
    """Orthonormal bases of the null spaces of J (N, k, n), as columns, and the pseudo-inverses (N, n, k) of J; None if
    the ranks differ."""
    if not J.shape[1]:
        return np.broadcast_to(np.eye(J.shape[2]), (len(J), J.shape[2], J.shape[2])), np.zeros((len(J), J.shape[2], 0))
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
    even = bool(np.ptp(h) <= 1e-6 * h.max())
    first, sizes_first = exponential(rate[: None if even else -1] * (0.5 * (h[0] if even else h[:, None, None])))
    second, sizes_second = (first[1:], sizes_first[1:]) if even else exponential(rate[1:] * (0.5 * h[:, None, None]))
    turn, turn_v = _turns(Z), _turns(V)  # from one basis to the next
    carry = np.zeros((len(h), r + d, r + d))
    carry[:, :r, :r] = turn
    kept = np.concatenate([(turn_v @ G[:-1] - G[1:] @ turn) / speed, turn_v @ mass[:-1]], axis=2)
    carry[:, r:] = np.linalg.solve(mass[1:], kept)
    steps = second @ carry @ first[: len(h)]
    new = np.random.default_rng(1).standard_normal((r + d, DIRECTIONS)) / np.sqrt(r + d)
    added = np.repeat(sizes / [1.0, speed], (r, d), axis=1)[:, :, None] * new
    x, log, done = added.copy(), np.zeros(len(t)), len(t)  # the propagated perturbations are x exp(log)
    for k in range(len(h)):
        y = steps[k] @ x[k]
        size = float(np.abs(y).max(initial=0.0)) or 1.0
        if not np.isfinite(size):
            done = k + 1
            break
        # with a negative sum the perturbations added are larger
        log[k + 1] = largest = max(0.0, total := log[k] + sizes_first[k] + sizes_second[k] + np.log(size))
        x[k + 1] = y * (np.exp(total - largest) / size) + added[k + 1] * np.exp(-largest)
    y, w = x[:, :r], x[:, r:]
    length = np.maximum(np.abs(Z @ y).max(axis=(1, 2)), np.abs(V @ w + B @ y / speed).max(axis=(1, 2)))[:done]
    t, log = t[:done], log[:done] + np.log(np.maximum(length, 1e-300))
    if done <= len(h):
        return Growth(t, log, np.inf)
    window = max((t[-1] - t[0]) / 50.0, float(h.min()))
    later = np.interp(np.minimum(t + window, t[-1]), t, log)
    return Growth(t, log, float(np.max((later - log) / window, initial=0.0)))


def _turns(Z: Array) -> Array:
    """Orthogonal matrices (N - 1, r, r) that take coordinates in each basis (N, n, r) to the next basis."""
    U, _, W = np.linalg.svd(np.swapaxes(Z[1:], 1, 2) @ Z[:-1])
    return U @ W


def exponential(A: Array) -> tuple[Array, Array]:
    """E (N, k, k) and s (N,) with exp(A) = E e^s for each of the matrices A (N, k, k), without overflow.

    The diagonal Pade approximant of degree 6 of A/2^j, squared j times; Moler and Van Loan, SIAM Review 45 (2003) 3-49.
    """
    count, k = A.shape[:2]
    size = np.abs(A).sum(axis=2).max(axis=1, initial=0.0)
    squarings = int(np.clip(np.ceil(np.log2(max(float(size.max(initial=0.0)), 0.5) / 0.5)), 0, 60))
    A = A / 2.0**squarings
    top = bottom = np.broadcast_to(np.eye(k), A.shape)
    power, c = np.broadcast_to(np.eye(k), A.shape), 1.0
    for j in range(1, 7):
        c *= (7.0 - j) / (j * (13.0 - j))
        power = power @ A
        top, bottom = top + c * power, bottom + (-1.0) ** j * c * power
    E: Array = np.asarray(np.linalg.solve(bottom, top))
    s = np.zeros(count)
    for _ in range(squarings):
        E, s = E @ E, 2.0 * s
        largest = np.abs(E).max(axis=(1, 2))
        E, s = E / largest[:, None, None], s + np.log(largest)
    return E, s
