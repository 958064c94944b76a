"""Impacts of rigid bodies: Newton's law of restitution with Coulomb's friction.

    u+ = u- + G P;   0 <= u_N+ + e min(u_N-, 0)  perp  P_N >= 0;   |P_T| <= mu P_N, opposite to the slip u_T+

u are the velocities of the contacts' rows (:mod:`mbdsl.numerics.contact_modes`). Touching bodies strike one another in
sequence, the fastest approach first; contacts of equal approach strike at once. With friction, Newton's law may gain
energy (T. R. Kane, D. A. Levinson, Dynamics, 1985): then all e of the problem are scaled by the largest factor s <= 1
without gain. With e = 0 there is none: the energy P . u+ - P G P/2 is then not positive.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.contact_modes import OPEN, Contacts, Modes, solve

Array = NDArray[np.float64]

EQUAL = 1e-9  #: relative difference of speeds of approach that count as equal, and speed that counts as rest
MOST = 1000  #: most problems of a sequence; what remains is solved at once
GAIN = 1e-12  #: gain of energy, relative to the energy of the approach, that is rounding


class Impact(NamedTuple):
    """Impulses P (r,), modes of the last problem of each contact, and the least factor of the restitutions."""

    P: Array
    modes: Modes
    factor: float


class UnsolvableError(Exception):
    """There is no solution with these contacts (numbers)."""

    def __init__(self, which: tuple[int, ...]) -> None:
        super().__init__(f"no impulses satisfy the laws of contacts {which}")
        self.which = which


def gain(contacts: Contacts, u: Array, P: Array) -> float:
    """The energy [J] that the impulses P add: P . (u- + u+)/2."""
    return float(P @ u + 0.5 * P @ contacts.G @ P)


def at_once(contacts: Contacts, u: Array, e: Array) -> Impact:
    """All contacts in one problem.

    Raises
    ------
    UnsolvableError
        If there are no such impulses.
    """
    return separating(contacts, u, -e * np.minimum(u[contacts.first], 0.0))


def separating(
    contacts: Contacts, u: Array, speeds: Array, last: Modes | None = None, guess: Array | None = None
) -> Impact:
    """The impulses after which gaps do not grow slower than with these ``speeds`` (k,), unless energy were gained.

    ``last``, ``guess``: modes and impulses (r,) to begin with, as of the step before in time stepping.

    Raises
    ------
    UnsolvableError
        If there are no such impulses.
    """
    normals = contacts.first

    def struck(factor: float) -> tuple[Array, Modes]:
        b = u.copy()
        b[normals] -= factor * speeds
        found = solve(contacts, b, last, guess=guess)
        if found is None:
            raise UnsolvableError(tuple(range(len(normals))))
        return found

    mass = np.where(contacts.G.diagonal() > 0.0, contacts.G.diagonal(), 1.0)
    most = GAIN * float((u * u / mass).sum())
    P, modes = struck(1.0)
    if gain(contacts, u, P) <= most or not speeds.any():
        return Impact(P, modes, 1.0)
    low, high = 0.0, 1.0
    P, modes = struck(0.0)
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        tried = struck(middle)
        if gain(contacts, u, tried[0]) <= most:
            low, (P, modes) = middle, tried
        else:
            high = middle
    return Impact(P, modes, low)


def in_sequence(contacts: Contacts, u: Array, e: Array, most: int = MOST) -> Impact:
    """The contacts one after another, that of the fastest approach first, those of equal approach at once.

    Approaches that remain after ``most`` problems, or that are slower than ``EQUAL`` times the first, end in one
    problem, without restitution if they are slow.

    Raises
    ------
    UnsolvableError
        If there are no such impulses.
    """
    G, normals = contacts.G, np.array(contacts.first)
    P, modes, factor = np.zeros(len(u)), [OPEN] * len(normals), 1.0
    now, first = u, float(-u[normals].min(initial=0.0))
    for k in range(most + 1):
        approach = -now[normals]
        fastest = float(approach.max(initial=0.0))
        if fastest <= 1e-15 * first:
            break
        slow = fastest <= EQUAL * first
        every = slow or k == most
        which = np.arange(len(normals)) if every else np.flatnonzero(approach >= fastest * (1.0 - EQUAL))
        part = contacts.only(which.tolist())
        rows = [r for i in which for r in range(normals[i], normals[i] + contacts.sizes[i])]
        try:
            one = at_once(part, now[rows], e[which] * (not slow))
        except UnsolvableError as error:
            raise UnsolvableError(tuple(int(which[i]) for i in error.which)) from None
        P[rows] += one.P
        now = u + G @ P
        factor = min(factor, one.factor)
        for i, mode in zip(which, one.modes, strict=True):
            modes[i] = mode
        if every:
            break
    return Impact(P, tuple(modes), factor)


def comes_to_rest(speed: float, a: float, e: float, shortest: float) -> float | None:
    """The time [s] of all further impacts of a contact, if it is less than ``shortest``; else None.

    After an impact the gap grows with ``speed`` and the acceleration -a. The impacts that follow take
    2 speed/a (1 + e + e^2 + ...) = 2 speed/(a (1 - e)).
    """
    if a <= 0.0 or e >= 1.0:
        return None
    rest = 2.0 * max(0.0, speed) / (a * (1.0 - e))
    return rest if rest < shortest else None
