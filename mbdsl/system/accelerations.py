"""Accelerations and multipliers at a state, from the equations of motion and the constraints at acceleration level."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics.saddle_point import least_squares, refined
from mbdsl.system.broken_laws import not_finite
from mbdsl.system.system import System

#: bounds of the residual and of the solution of a regular system, relative to its right-hand side
ACCURATE, BOUNDED = 1e-12, 1e8
#: number of states whose accelerations are kept
KNOWN = 8
#: iterations for forces that depend on multipliers, and their last relative change
ITERATIONS, CONVERGED = 50, 1e-12


def accelerations(system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...] = ()) -> tuple[Array, Array]:
    """a (n,) and lam (m + p,) from the equations of motion and constraints at acceleration level.

        [[M, J^T], [J, 0]] [a; lam] = [Q; gamma_c],   J = [Phi_q; Gam_v],   lam = 0 in rows left out

    Where constraints are redundant, lam is the solution of least norm. Where Q depends on lam (friction in joints),
    Newton's method finds both.

    Raises
    ------
    InitialisationError
        If there is no solution.
    """
    known = system.kept(_Known)
    key = known.key(system, t, q, v, left_out)
    if (found := known.found.get(key)) is None:
        found = _solved(system, t, q, v, left_out)
        known.add(key, found)
    a, lam = found
    return a.copy(), lam.copy()


class _Known:
    """The accelerations of a system at the last few states: what follows an event asks for them again."""

    def __init__(self, system: System) -> None:
        tables, layout = system.tables, system.tables.layout
        self.places = np.array([*tables.inputs.values(), *tables.counters], np.int64)
        self.marks = np.array([layout[L.PAIRS] + L.PAIR * row + L.LEFT_OUT for row in tables.switchable], np.int64)
        self.found: dict[tuple, tuple[Array, Array]] = {}

    def key(self, system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> tuple:
        """All that they depend on."""
        w = system.buffers
        numbers, marks = w.numbers[self.places].tobytes(), w.layout[self.marks].tobytes()
        return t, q.tobytes(), v.tobytes(), left_out, numbers, marks, system.tables.scale.tobytes()

    def add(self, key: tuple, found: tuple[Array, Array]) -> None:
        if len(self.found) == KNOWN:
            del self.found[next(iter(self.found))]
        self.found[key] = found


def _solved(system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> tuple[Array, Array]:
    motion = equations(system, t, q, v, left_out)
    a, lam = solve_motion(system, motion, np.zeros(system.m + system.p))
    if not (system.of_multipliers and lam.any()):
        return a, lam
    size = np.abs(lam).max(initial=0.0)
    for _ in range(ITERATIONS):
        a, found = solve_motion(system, motion, lam)
        change, lam = np.abs(found - lam).max(initial=0.0), found
        size = max(size, np.abs(lam).max(initial=0.0))
        if change <= CONVERGED * size:
            return a, lam
    from mbdsl.system.paradox import paradox  # which needs this System

    found_it = paradox(system, t, q, v, lam, left_out)
    why = found_it.text if found_it else "friction and the reactions that it depends on do not agree"
    raise InitialisationError(
        f"no accelerations found at t = {t:g} s: {why}",
        found_it.span if found_it else None,
        "take a smaller coefficient of friction; with a large one there may be no solution, or several",
    )


@lru_cache(maxsize=64)
def rows_kept(count: int, left_out: tuple[int, ...]) -> Integers:
    """The numbers below ``count`` that are not among ``left_out``."""
    return np.setdiff1d(np.arange(count), np.array(left_out, int))


class Equations(NamedTuple):
    """What the equations contain at a state, whatever the multipliers are: the constraints kept, M, J, the right-hand
    side (Q, gamma_c), and the scales of ``balance``."""

    t: float
    q: Array
    v: Array
    kept: Integers
    M: Any
    J: Any
    right: Array
    d: Array


def equations(system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> Equations:
    kept, n = rows_kept(system.m + system.p, left_out), system.n
    both = system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0)
    M, J = both[:n, :n], both[n:, :n][kept]
    derivatives = system.entries(t, cK=1.0, cD=1.0, cL=1.0, cN=1.0, cW=1.0)
    right = np.concatenate([system.force(), system.gamma_c_here(v, derivatives)[kept]])
    if not (system.of_multipliers or _finite(derivatives)):  # else they are checked where the multipliers are known
        _check(system, (t, q, v), np.zeros(system.m + system.p), right, (both, derivatives))
    with np.errstate(all="ignore"):  # entries that are not finite are reported later
        d = balance(system, M.diagonal(), J)
    return Equations(t, q, v, kept, M, J, right, d)


def solve_motion(system: System, motion: Equations, lam: Array) -> tuple[Array, Array]:
    """a and lam with Q linearised about ``lam``.

    Rows and columns are balanced, because a mechanism of micrometres and micrograms has entries from 1 down to 1e-24,
    whose ratios do not show the rank.
    """
    t, q, v, kept, M, J, right, d = motion
    n, m, b = system.n, len(kept), right
    U = J.T  # the matrix of the multipliers: J^T - Q_lam
    if system.of_multipliers:
        derivatives = system.tangent(t, q, v, lam, cK=1.0, cD=1.0, cL=1.0, cV=1.0)
        U = derivatives[:n, n:][:, kept]
        b = np.concatenate([system.force() + U @ lam[kept], right[n:]])
        if not _finite(derivatives):
            _check(system, (t, q, v), lam, b, (M, J, derivatives))
    given = b
    if isinstance(J, np.ndarray):
        K = np.zeros((n + m, n + m))
        K[:n, :n], K[:n, n:], K[n:, :n] = M, U, J
        with np.errstate(all="ignore"):
            K, b = d[:, None] * K * d, d * b
            try:
                x = np.linalg.solve(K, b)
            except np.linalg.LinAlgError:
                x = np.full(n + m, np.nan)
            r, size = b - K @ x, np.abs(b).max(initial=0.0)
        off = np.abs(r).max(initial=0.0)
        if not (off <= ACCURATE * size and np.abs(x).max(initial=0.0) <= BOUNDED * size):
            _check(system, (t, q, v), lam, given, (M, J))
            x = least_squares(K, b, 1e-13)  # of any rank
            r = b - K @ x
            off = np.abs(r).max(initial=0.0)
    else:
        from scipy.sparse import block_array, diags_array

        _check(system, (t, q, v), lam, given, (M, J))
        S = block_array([[M, U], [J, None]], format="csr")
        S, b = diags_array(d) @ S @ diags_array(d), d * b
        x = refined(S, n, b)
        r = b - S @ x
        off, size = np.abs(r).max(initial=0.0), np.abs(b).max(initial=0.0)
    if not off <= 1e-8 * size:  # or NaN
        names = system.names() + [system.constraint_names()[k] for k in kept]
        worst = f"; worst: {names[int(np.abs(r).argmax())]}" if np.isfinite(r).all() else ""
        raise InitialisationError(
            f"no accelerations satisfy the equations of motion at t = {t:g} s{worst}",
            hint="a body without mass or inertia moves freely, or the pose is singular",
        )
    x = d * x
    found = np.zeros(system.m + system.p)
    found[kept] = x[n:]
    return x[:n], found


def _check(system: System, at: tuple[float, Array, Array], lam: Array, b: Array, found: tuple[Any, ...]) -> None:
    """Raise an error if forces b, or matrices, are not finite; every implicit method needs the derivatives."""
    if not np.isfinite(b).all():
        raise not_finite(system, *at, "the forces", lam)
    if not all(map(_finite, found)):
        raise not_finite(system, *at, "the derivatives of the forces or constraints", lam)


def _finite(X: Any) -> bool:
    """Whether all entries of a matrix are finite."""
    return bool(np.isfinite(X if isinstance(X, np.ndarray) else X.data).all())


def balance(system: System, M: Array, J) -> Array:
    """Powers of two d (..., n + m) for which d [[M, J^T], [J, 0]] d has entries near one: masses first, then the rows
    of J (..., m, n). M (..., n) is the diagonal."""
    if len(system.tables.rotations):  # in world axes, an axis without inertia has rounding errors of the others
        own = system.tables.rotations[:, :1] + np.arange(3)
        M = M.copy()
        M[..., own] = M[..., own].max(axis=-1, keepdims=True)
    massive = M > 0.0
    if not massive.all():  # massless coordinates are treated like the one with the largest mass
        square = system.tables.scale**2
        largest = (M / square).max(axis=-1, initial=0.0, keepdims=True)  # as moments of inertia
        M = np.where(massive, M, np.where(largest > 0.0, largest, 1.0) * square)
    d = 1 / np.sqrt(M)
    rows = abs(J) @ d if M.ndim == 1 else np.einsum("...ij,...j->...i", abs(J), d)
    d = np.concatenate([d, 1 / np.where(rows > 0.0, rows, 1.0)], axis=-1)
    # the offset avoids half exponents, as of masses of 0.5 and 2 kg, where rounding errors would decide
    return np.exp2(np.floor(np.log2(d) + 0.4))
