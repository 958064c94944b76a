"""Rigid contacts of a run: their impacts, and which of them last.

Where a gap closes, Newton's law of restitution (:mod:`mbdsl.numerics.impact`) gives the velocities behind the impact. A
contact whose further impacts would end within a very short time comes to rest at once. The contacts at rest close if
the accelerations without them would close their gaps: a closed contact is a row of the constraints, and opens where its
reaction would pull. Rows that depend on those of other closed contacts are left out.

With J the rows of all other constraints and W those of the contacts, Delassus's matrix is G = W X, where

    [[M, J^T], [J, 0]] [X; .] = [W^T; 0]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.numerics import contact_modes
from mbdsl.numerics.contact_modes import Contacts
from mbdsl.numerics.impact import UnsolvableError, at_once, comes_to_rest, in_sequence
from mbdsl.numerics.saddle_point import dense, least_squares
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.contact_numbers import CLOSED, COUNT, DEPENDENT, EDGE, IMPULSE, MODE, OPEN, number

Array = NDArray[np.float64]

#: relative to the mechanism's size: gaps that count as closed; error of the gap of a closed contact, and overlap at the
#: start that is rounding; and the overlap at which a gap has closed, which is more than the rounding error of gaps
NEAR, OVERLAP, ROUNDING = 1e-9, 1e-6, 1e-14
SLOW = 1e-10  #: speed of a gap, relative to the fastest motion, that counts as rest
SAME = 1e-13  #: relative change of velocities that is rounding
#: a contact rests if its impacts end within this part of the tolerance, and of a run, or within this part of a run
OF_TOLERANCE, LEAST = 1e-3, 2e-14
LOOSEST = 1e-5  #: tolerance that counts, of runs with fixed steps too
DEPENDS = 1e-10  #: relative pivot below which a row depends on others


class UnsolvedContactsError(InitialisationError):
    """No impulses or reactions satisfy the laws of the contacts."""


class Touching(NamedTuple):
    """The contacts (numbers) whose gaps are closed, their rows W (k, n), X (n, k), and G (k, k)."""

    which: NDArray[np.int64]
    W: Array
    X: Array
    G: Array


class ContactSet:
    """The rigid contacts of a run of ``system``.

    Attributes
    ----------
    struck : bool
        Whether the last event was an impact.
    """

    def __init__(self, system: System) -> None:
        self.system, self.contacts = system, system.scene.contacts
        self.rows = np.array([system.tables.rows[c.name] for c in self.contacts], int)
        self.e = np.array([c.e for c in self.contacts])
        self.law = in_sequence if self.contacts and self.contacts[0].sequential else at_once
        self.shortest, self.struck = 0.0, False

    def begin(self, t: float, q: Array, span: float, tol: float | None, values: dict[str, float]) -> None:
        """Start a run of ``span`` [s] with this tolerance.

        Raises
        ------
        InitialisationError
            If bodies overlap.
        """
        size = self.system.tables.size
        self.shortest = max(OF_TOLERANCE * min(tol or LOOSEST, LOOSEST), LEAST) * span
        for contact, gap in zip(self.contacts, self._gaps(t, q), strict=True):
            values[number(contact.name, EDGE)] = -ROUNDING * size
            if gap < -OVERLAP * size:
                message = f"the gap of `{contact.name}` is {gap:.6g} m at the start: the bodies overlap"
                raise InitialisationError(message, contact.span, "give initial values at which it is not negative")

    def _gaps(self, t: float, q: Array) -> Array:
        return self.system.Phi(t, q)[self.rows]

    def left_out(self, left_out: tuple[int, ...], values: dict[str, float]) -> tuple[int, ...]:
        """The rows that are left out: those of ``left_out`` that are no contacts, and of contacts that are not closed
        by their rows."""
        own = set(self.rows.tolist())
        modes = [values[number(c.name, MODE)] for c in self.contacts]
        inactive = (int(row) for row, mode in zip(self.rows, modes, strict=True) if mode != CLOSED)
        return tuple(sorted({row for row in left_out if row not in own} | set(inactive)))

    def all_open(self, values: dict[str, float]) -> bool:
        """Whether no row of a contact is closed."""
        return all(values[number(c.name, MODE)] != CLOSED for c in self.contacts)

    def act(
        self, t: float, q: Array, v: Array, left_out: tuple[int, ...], values: dict[str, float]
    ) -> tuple[Array, Array]:
        """q and v (n,) behind the event at time t, ``v`` itself if it does not change; ``values`` get the modes.

        Raises
        ------
        InitialisationError
            If no impulses or reactions satisfy the laws of the contacts.
        """
        self.struck = False
        modes = np.array([values[number(c.name, MODE)] for c in self.contacts])
        gaps = self._gaps(t, q)
        which = np.flatnonzero(gaps < np.where(modes == OPEN, NEAR, OVERLAP) * self.system.tables.size)
        closed, dependent, given = np.zeros(0, int), np.zeros(0, int), v
        if len(which):
            others = tuple(sorted({*left_out, *self.rows.tolist()}))
            touching = self._touching(t, q, v, which, others)
            q, v = self._back(t, q, v, touching, np.maximum(-gaps[which], 0.0), others)
            v = self._struck(t, q, v, touching, values)
            v, closed, dependent = self._lasting(t, q, v, touching, others)
        for k, contact in enumerate(self.contacts):
            mode = CLOSED if k in closed else DEPENDENT if k in dependent else OPEN
            values[number(contact.name, MODE)] = mode
        return q, given if np.abs(v - given).max(initial=0.0) <= SAME * np.abs(given).max(initial=0.0) else v

    def _back(
        self, t: float, q: Array, v: Array, touching: Touching, depth: Array, others: tuple[int, ...]
    ) -> tuple[Array, Array]:
        """q and v where the gaps closed, before they were negative by ``depth`` (k,): without what this way adds to
        the energy, u^2 - 2 a depth, impacts would not die away."""
        if not depth.any():
            return q, v
        u, _ = self._speeds(t, q, v, touching.which)
        a, _ = accelerations(self.system, t, q, v, others)
        fall = touching.W @ a - self.system.gamma_c(t, q, v)[self.rows[touching.which]]
        before = np.where(u < 0.0, -np.sqrt(np.maximum(u * u + 2.0 * fall * depth, 0.0)), u)
        shift = least_squares(touching.G, np.stack([depth, before - u], axis=1), DEPENDS)
        return self.system.moved(q, touching.X @ shift[:, 0]), v + touching.X @ shift[:, 1]

    def _touching(self, t: float, q: Array, v: Array, which: NDArray[np.int64], others: tuple[int, ...]) -> Touching:
        """The rows of contacts, and their Delassus matrix; ``others``: rows that do not constrain."""
        system, n = self.system, self.system.n
        matrix = dense(system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0))
        W = matrix[n + self.rows[which], :n]
        kept = np.setdiff1d(np.arange(system.unknowns), n + np.array(others, int))
        K, right = matrix[np.ix_(kept, kept)], np.zeros((len(kept), len(which)))
        right[:n] = W.T
        try:
            X = np.linalg.solve(K, right)[:n]
        except np.linalg.LinAlgError:
            raise self._unsolvable("impulses", t, which) from None
        G = W @ X
        return Touching(which, W, X, 0.5 * (G + G.T))

    def _speeds(self, t: float, q: Array, v: Array, which: NDArray[np.int64]) -> tuple[Array, float]:
        """The rates of gaps, and the speed that counts as rest."""
        fastest = float(np.abs(v * self.system.tables.scale).max(initial=0.0))
        return self.system.evaluate(t, q, v)[2][self.rows[which]], SLOW * fastest * self.system.tables.size

    def _struck(self, t: float, q: Array, v: Array, touching: Touching, values: dict[str, float]) -> Array:
        """The velocities behind the impact, if there is one."""
        which = touching.which
        u, slow = self._speeds(t, q, v, which)
        if not (u < -slow).any():
            return v
        laws = Contacts(touching.G, (1,) * len(which), np.zeros(len(which)))
        try:
            P = self.law(laws, u, self.e[which]).P
        except UnsolvableError as error:
            raise self._unsolvable("impulses", t, which[list(error.which)]) from None
        for k in np.flatnonzero(P > 0.0):
            name = self.contacts[which[k]].name
            values[number(name, COUNT)] += 1.0
            values[number(name, IMPULSE)] = float(P[k])
        self.struck = True
        return v + touching.X @ P

    def _lasting(
        self, t: float, q: Array, v: Array, touching: Touching, others: tuple[int, ...]
    ) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        """The velocities with contacts at rest, the contacts that close, and those that close by the rows of others."""
        which, W, X, G = touching
        u, slow = self._speeds(t, q, v, which)
        a, _ = accelerations(self.system, t, q, v, others)
        b = W @ a - self.system.gamma_c(t, q, v)[self.rows[which]]
        rest = np.abs(u) <= slow
        for k in np.flatnonzero(self.struck & ~rest):
            rest[k] = comes_to_rest(u[k], -b[k], self.e[which[k]], self.shortest) is not None
        at = np.flatnonzero(rest)
        found = contact_modes.solve(Contacts(G[np.ix_(at, at)], (1,) * len(at), np.zeros(len(at))), b[at])
        if found is None:
            raise self._unsolvable("reactions", t, which[at])
        closed = at[[mode != contact_modes.OPEN for mode in found[1]]]
        if not len(closed):
            return v, closed, closed
        v = v - X[:, closed] @ least_squares(G[np.ix_(closed, closed)], u[closed], DEPENDS)
        own = _independent(G[np.ix_(closed, closed)])
        return v, which[closed[own]], which[closed[~own]]

    def _unsolvable(self, what: str, t: float, which: NDArray[np.int64]) -> UnsolvedContactsError:
        names = ", ".join(f"`{self.contacts[k].name}`" for k in which)
        return UnsolvedContactsError(
            f"no {what} satisfy the laws of the contacts {names} at t = {t:.9g} s",
            self.contacts[which[0]].span,
            "the bodies that touch are jammed between others: leave a gap, or take a contact with stiffness `k`",
        )


def _independent(G: Array) -> NDArray[np.bool_]:
    """Whether each row is independent of those before it, by the pivots of Cholesky's factorisation of G (k, k)."""
    A, found = G.copy(), np.zeros(len(G), bool)
    for k in range(len(A)):
        found[k] = A[k, k] > DEPENDS * G[k, k]
        if found[k]:
            A[k + 1 :, k + 1 :] -= np.outer(A[k + 1 :, k], A[k, k + 1 :]) / A[k, k]
    return found
