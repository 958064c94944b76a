"""Friction of contacts and joints that hold the same motion: shares of it with which each of them can stay at rest.

All forces that hold the rows are F + Z y, with Z the null space of the equations. Each contact stays at rest if
|F_T| <= mu N for some y. A linear program finds those with the largest reserve s:

    max s,   u . F_i(y) <= mu (N_i(y) - s R_i)      for directions u, to which those of F_i are added
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.contact_modes import FEW, SENSE, STICK, Contacts, Modes, independent_rows, solve

Array = NDArray[np.float64]
DIRECTIONS = 30  #: most directions of the friction of a joint that are added
PRECISE = {"primal_feasibility_tolerance": 1e-10}  #: of the linear program, the least that is possible
EXCEEDED = 5e-10  #: part of the largest friction by which a share may exceed it, that is rounding
DEPENDS, WRONG = 1e-10, 1e-9  #: relative singular value that is zero, and error of rows that cannot be held
LESS = 0.01  #: part of friction that is taken away where contacts begin to slide
LIGHT = 0.1  #: part of the largest normal force for which friction of the others is kept in reserve


class FrictionLimits(NamedTuple):
    """Friction of joints: their places among the rows, mu_s (k,), N (k,) with its derivatives by y (k, d), and R (k,),
    by default N."""

    own: list[list[int]]
    mu: Array
    N: Array
    slope: Array
    reserve: Array | None = None

    def exceeded(self, F: Array, y: Array) -> list[int]:
        """The joints whose friction F (rows,) is larger than it can be."""
        most = self.mu * (self.N + self.slope @ y) * (1.0 + EXCEEDED)
        return [i for i, own in enumerate(self.own) if own and not np.linalg.norm(F[own]) <= most[i]]


def largest_reserve(F: Array, Z: Array, limits: FrictionLimits) -> Array | None:
    """y (d,) of the largest reserve of friction F + Z y; None if some joint has none."""
    from scipy.optimize import linprog

    own, mu, N, slope, reserve = limits
    R, d = N if reserve is None else reserve, Z.shape[1]
    cuts = [(i, u) for i, which in enumerate(own) for e in np.eye(len(which)) for u in (e, -e)]
    cuts += [(i, np.zeros(0)) for i, which in enumerate(own) if not which]  # N >= 0
    for _ in range(DIRECTIONS):
        A = [[*(u @ Z[own[i]] - mu[i] * slope[i]), mu[i] * R[i]] for i, u in cuts]
        b = [mu[i] * N[i] - u @ F[own[i]] for i, u in cuts]
        found = linprog([0.0] * d + [-1.0], A, b, bounds=[(None, None)] * d + [(None, 1.0)], options=PRECISE)
        if found.status != 0 or found.x[-1] < -EXCEEDED:
            return None
        y = found.x[:-1]
        carried = F + Z @ y
        over = limits.exceeded(carried, y)
        if not over:
            return y
        cuts += [(i, carried[own[i]] / np.linalg.norm(carried[own[i]])) for i in over]
    return None


# -- contacts ----------------------------------------------------------------------------------------------------------


def active(contacts: Contacts, P: Array, modes: Modes) -> list[int]:
    """Independent rows of the contacts that are closed, those with the largest reactions first, and of those that
    stick."""
    held = contacts.held(modes)
    normals = sorted(set(held) & set(contacts.first), key=lambda r: -P[r])
    order = [*normals, *(r for r in held if r not in set(normals))]
    return [r for r, x in zip(order, independent_rows(contacts.G, order), strict=True) if x]


def exerted(contacts: Contacts, modes: Modes, rows: list[int]) -> Array:
    """C (r, rows): the forces P = C x of all rows that forces x of ``rows`` cause, with the friction of contacts that
    slide."""
    C = np.zeros((len(contacts.G), len(rows)))
    C[rows, np.arange(len(rows))] = 1.0
    for i, mode in enumerate(modes):
        if contacts.rubs(i) and mode in SENSE and contacts.first[i] in rows:
            T = contacts.tangents(i)
            C[T] = -SENSE[mode] * contacts.limit(i, mode) * C[contacts.first[i]]
    return C


def at_rest(contacts: Contacts, b: Array, last: Modes) -> tuple[Array, Modes] | None:
    """P (r,) and the mode of each contact, as of :func:`~mbdsl.numerics.contact_modes.solve`.

    Where contacts may hold the same motion, it is tried first whether all can stay at rest. If not, they begin to slide
    where this has just become impossible, with accelerations near zero, which do not show the direction: it is that
    with a little less friction.
    """
    modes = tuple(STICK if STICK in x else x[-1] for x in map(contacts.choices, range(len(contacts.sizes))))
    dependent = not independent_rows(contacts.G, held := contacts.held(modes)).all()
    if dependent and (P := _all_rest(contacts, b, modes, held)) is not None:
        return P, modes
    if not dependent or (len(contacts.sizes) <= FEW and max(contacts.sizes) < 3):
        return solve(contacts, b, last, independent=True)
    less = Contacts(contacts.G, contacts.sizes, (1.0 - LESS) * contacts.mu, contacts.slips)
    return solve(less, b, last) or solve(contacts, b, last)


def _all_rest(contacts: Contacts, b: Array, modes: Modes, held: list[int]) -> Array | None:
    """P (r,) with which the rows ``held`` of these modes have no acceleration; of all such P, the reserve of friction
    is largest. None if there is none."""
    C, scale = exerted(contacts, modes, held), 1.0 / np.sqrt(np.maximum(contacts.G.diagonal()[held], DEPENDS))
    A, c = scale[:, None] * (contacts.G @ C)[held] * scale, -scale * b[held]
    U, s, V = np.linalg.svd(A)
    rank = int((s > DEPENDS * s.max(initial=0.0)).sum())
    x = V[:rank].T @ ((U[:, :rank].T @ c) / s[:rank])
    most = np.abs(x).max(initial=0.0)
    if np.abs(A @ x - c).max(initial=0.0) > WRONG * np.abs(c).max(initial=0.0) or not most:
        return None
    place = {row: k for k, row in enumerate(held)}
    F, Z, N = scale * x / most, scale[:, None] * V[rank:].T, [place[n] for n in contacts.first]
    sticks = [mode == STICK and contacts.sizes[i] > 1 for i, mode in enumerate(modes)]
    own = [[*range(n + 1, n + contacts.sizes[i])] if sticks[i] else [] for i, n in enumerate(N)]
    mu = np.array([contacts.limit(i) if x else 1.0 for i, x in enumerate(sticks)])
    y = largest_reserve(F, Z, FrictionLimits(own, mu, F[N], Z[N], np.maximum(F[N], LIGHT * F[N].max())))
    return None if y is None else C @ (most * (F + Z @ y))
