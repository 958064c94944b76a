"""Rigid contacts of a run: their impacts, and which of them last.

Where a gap closes, Newton's law of restitution (:mod:`mbdsl.numerics.impact`) gives the velocities behind the impact. A
contact whose further impacts would end within a very short time comes to rest at once. The contacts at rest close if
the accelerations without them would close their gaps: a closed contact is a row of the constraints, and opens where its
reaction would pull. Rows that depend on those of other closed contacts are left out. Friction is part of both problems:
a contact that sticks has the rows of its slip as well, one that slides has mu N against it.

With J the rows of all other constraints and W those of the contacts, one of the gap of each and those of its slips,
Delassus's matrix is G = W X, where

    [[M, J^T], [J, 0]] [X; .] = [W^T; 0]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators.friction_set import FrictionSet
from mbdsl.numerics import contact_modes
from mbdsl.numerics.contact_modes import SENSE, STICK, Contacts, independent_rows, painleve
from mbdsl.numerics.impact import UnsolvableError, at_once, comes_to_rest, in_sequence
from mbdsl.numerics.saddle_point import dense, least_squares
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.contact_numbers import (
    ALONG,
    ALONG_2,
    CLOSED,
    COEFFICIENT,
    COUNT,
    DEPENDENT,
    EDGE,
    HELD,
    IMPULSE,
    MODE,
    OPEN,
    SLIDING,
    SLOW,
    number,
)

Array = NDArray[np.float64]

#: relative to the mechanism's size: gaps that count as closed; error of the gap of a closed contact, and overlap at the
#: start that is rounding; and the overlap at which a gap has closed, which is more than the rounding error of gaps
NEAR, OVERLAP, ROUNDING = 1e-9, 1e-6, 1e-14
PARALLEL = 1e-6  #: relative pivot below which the overlaps of two contacts are removed as one
NEVER = -1e300  #: the gap [m] at which a contact closes that is left out
#: height of a bounce, relative to the coordinates in its gap, below which it is rounding
ROUNDED = 64.0 * float(np.finfo(float).eps)
#: speed of a gap, relative to the fastest motion, that counts as rest; and relative to the size over the run
REST, STILL = 1e-10, 1e-13
SAME = 1e-13  #: relative change of velocities that is rounding
#: a contact rests if its impacts end within this part of the tolerance, and of a run, or within this part of a run
OF_TOLERANCE, LEAST = 1e-3, 2e-14
LOOSEST = 1e-5  #: tolerance that counts, of runs with fixed steps too
VANISHED = 1e-7  #: acceleration by a reaction, relative to the largest of gaps and slips, at which a contact opens
DEPENDS = 1e-10  #: relative pivot below which a row depends on others
#: speed of slip that counts as rest: this part of the size of the mechanism over the run, and of its largest velocity
SLIP_OF_SIZE, SLIP_OF_SPEED = 1e-9, 1e-10


class UnsolvedContactsError(InitialisationError):
    """No impulses or reactions satisfy the laws of the contacts."""


class Touching(NamedTuple):
    """The contacts (numbers) whose gaps are closed, their rows W (r, n), X (n, r), and the problem with G (r, r)."""

    which: NDArray[np.int64]
    W: Array
    X: Array
    laws: Contacts

    @property
    def normals(self) -> list[int]:
        return self.laws.first

    def only(self, at: NDArray[np.int64]) -> Touching:
        """Some of the contacts."""
        rows = [r for i in at for r in range(self.normals[i], self.normals[i] + self.laws.sizes[i])]
        return Touching(self.which[at], self.W[rows], self.X[:, rows], self.laws.only(at.tolist()))


class ContactSet:
    """The rigid contacts of a run of ``system``.

    Attributes
    ----------
    struck : bool
        Whether the last event was an impact.
    """

    def __init__(self, system: System) -> None:
        self.system, self.contacts = system, system.scene.contacts
        self.all_rows = system.tables.contact_rows
        self.rows = np.array([rows[0] for rows in self.all_rows], int)
        self.e, self.present = np.array([c.e for c in self.contacts]), np.array([not c.absent for c in self.contacts])
        self.law = in_sequence if self.contacts and self.contacts[0].sequential else at_once
        self.shortest, self.struck, self.span = 0.0, False, 1.0
        self._before: tuple[float, dict[str, float]] = np.nan, {}  # time of the last event, and values before it

    def begin(self, t: float, q: Array, span: float, tol: float | None, values: dict[str, float]) -> None:
        """Start a run of ``span`` [s] with this tolerance.

        Raises
        ------
        InitialisationError
            If bodies overlap.
        """
        size, self._before = self.system.tables.size, (np.nan, {})
        self._release(values)
        self.shortest, self.span = max(OF_TOLERANCE * min(tol or LOOSEST, LOOSEST), LEAST) * span, span or 1.0
        for contact, gap in zip(self.contacts, self._gaps(t, q), strict=True):
            if not contact.absent and gap < -OVERLAP * size:
                message = f"the gap of `{contact.name}` is {gap:.6g} {contact.unit} at the start: the bodies overlap"
                raise InitialisationError(message, contact.span, "give initial values at which it is not negative")

    def _gaps(self, t: float, q: Array) -> Array:
        return self.system.Phi(t, q)[self.rows]

    def left_out(self, left_out: tuple[int, ...], values: dict[str, float]) -> tuple[int, ...]:
        """The rows that are left out: those of ``left_out`` that are no contacts, and of contacts that are not closed
        by their rows, or do not stick."""
        own, inactive = set[int](), set[int]()
        for c, (row, *slips) in zip(self.contacts, self.all_rows, strict=True):
            own |= {row, *slips}
            inactive |= {row} if values[number(c.name, MODE)] != CLOSED else set()
            inactive |= set(slips) if slips and not values[number(c.name, HELD)] else set()
        return tuple(sorted({row for row in left_out if row not in own} | inactive))

    def all_open(self, values: dict[str, float]) -> bool:
        """Whether no row of a contact is closed."""
        return all(values[number(c.name, MODE)] != CLOSED for c in self.contacts)

    def act(
        self,
        t: float,
        q: Array,
        v: Array,
        left_out: tuple[int, ...],
        values: dict[str, float],
        friction: FrictionSet | None = None,
    ) -> tuple[Array, Array]:
        """q and v (n,) behind the event at time t, ``v`` itself if it does not change; ``values`` get the modes.

        Joints with ``friction`` that are held slide behind an impact that moves them: friction of a finite force has
        no impulse.

        Raises
        ------
        InitialisationError
            If no impulses or reactions satisfy the laws of the contacts.
        """
        self.struck = False
        modes = np.array([values[number(c.name, MODE)] for c in self.contacts])
        gaps = self._gaps(t, q)
        near = np.where(modes == OPEN, NEAR, OVERLAP) * self.system.tables.size
        which = np.flatnonzero((gaps < near) & self.present)
        given = v
        if t != self._before[0]:
            self._before = t, dict(values)
        before = self._before[1]
        self._release(values)
        if len(which):
            others = tuple(sorted({*left_out, *(row for rows in self.all_rows for row in rows)}))
            touching = self._touching(t, q, v, which, others)
            q, v = self._back(t, q, v, touching, np.maximum(-gaps[which], 0.0), others)
            free = tuple(sorted({*others, *self.system.tables.switchable}))
            v = self._struck(t, q, v, touching if free == others else self._touching(t, q, v, which, free), values)
            if self.struck and friction is not None and friction.release(t, q, v, values):
                others = friction.left_out(others, values)
                touching = self._touching(t, q, v, which, others)
            v = self._lasting(t, q, v, touching, others, before, values)
        scale = self.system.tables.scale
        change, fastest = (float(np.abs(x * scale).max(initial=0.0)) for x in (v - given, given))
        return q, given if change <= SAME * fastest else v

    def _release(self, values: dict[str, float]) -> None:
        """Open all contacts."""
        for c in self.contacts:
            values[number(c.name, MODE)] = OPEN
            values[number(c.name, EDGE)] = NEVER if c.absent else -ROUNDING * self.system.tables.size
            if c.slips:
                values |= {number(c.name, x): 0.0 for x in (COEFFICIENT, SLIDING, HELD, ALONG, ALONG_2)}
                for name in (COEFFICIENT, SLIDING):
                    self.system.set_input(number(c.name, name), 0.0)

    def _back(
        self, t: float, q: Array, v: Array, touching: Touching, depth: Array, others: tuple[int, ...]
    ) -> tuple[Array, Array]:
        """q and v where the gaps closed, before they were negative by ``depth`` (k,): without what this way adds to
        the energy, u^2 - 2 a depth, impacts would not die away."""
        if not depth.any():
            return q, v
        u, slow = self._speeds(t, q, v, touching)
        N = touching.normals
        a, _ = accelerations(self.system, t, q, v, others)
        fall = touching.W[N] @ a - self.system.gamma_c(t, q, v)[self.rows[touching.which]]
        fall = self._supported(touching, fall, np.abs(u[N]) <= slow)
        before = np.where(u[N] < 0.0, -np.sqrt(np.maximum(u[N] * u[N] + 2.0 * fall * depth, 0.0)), u[N])
        right = np.stack([depth, before - u[N]], axis=1)
        shift = least_squares(touching.laws.G[np.ix_(N, N)], right, PARALLEL)  # nearly parallel rows would move much
        X = touching.X[:, N]
        return self.system.moved(q, X @ shift[:, 0]), v + X @ shift[:, 1]

    @staticmethod
    def _supported(touching: Touching, b: Array, rest: NDArray[np.bool_]) -> Array:
        """The accelerations of gaps (k,) with the contacts at ``rest`` closed, where ``b`` are those with all open: a
        ball bounces on a table that its floor carries."""
        at = np.flatnonzero(rest)
        if not len(at) or len(at) == len(rest):
            return b
        N = np.array(touching.normals)
        G = touching.laws.G[np.ix_(N, N)]
        found = contact_modes.solve(Contacts(G[np.ix_(at, at)], (1,) * len(at), np.zeros(len(at))), b[at])
        return b if found is None else b + G[:, at] @ found[0]

    @staticmethod
    def _carried(touching: Touching, u: Array, rest: NDArray[np.bool_]) -> Array:
        """The rates of gaps (k,) once those at ``rest`` are held, where ``u`` are those before."""
        at, N = np.flatnonzero(rest), np.array(touching.normals)
        G = touching.laws.G[np.ix_(N, N)]
        return u - G[:, at] @ least_squares(G[np.ix_(at, at)], u[at], DEPENDS) if len(at) else u

    def _touching(self, t: float, q: Array, v: Array, which: NDArray[np.int64], others: tuple[int, ...]) -> Touching:
        """The rows of contacts, and their Delassus matrix; ``others``: rows that do not constrain."""
        system, n = self.system, self.system.n
        matrix = dense(system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0))
        W = matrix[n + self._rows_of(which), :n]
        kept = np.setdiff1d(np.arange(system.unknowns), n + np.array(others, int))
        K, right = matrix[np.ix_(kept, kept)], np.zeros((len(kept), len(W)))
        right[:n] = W.T
        try:
            X = np.linalg.solve(K, right)[:n]
        except np.linalg.LinAlgError:
            raise self._unsolvable("impulses", t, which) from None
        G = W @ X
        own = [self.contacts[k] for k in which]
        mu, mu_s = np.array([c.mu for c in own]), np.array([c.mu_s for c in own])
        return Touching(which, W, X, Contacts(0.5 * (G + G.T), tuple(1 + len(c.slips) for c in own), mu, (), mu_s))

    def _rows_of(self, which: NDArray[np.int64]) -> NDArray[np.int64]:
        """The rows of contacts, in their order."""
        return np.array([row for k in which for row in self.all_rows[k]], int)

    def _speeds(self, t: float, q: Array, v: Array, touching: Touching) -> tuple[Array, float]:
        """The rates of gaps and the slips (r,), and the speed that counts as rest."""
        fastest = float(np.abs(v * self.system.tables.scale).max(initial=0.0))
        slow = self.system.tables.size * (REST * fastest + STILL / self.span)
        return self.system.constraint_rates(t, q, v)[self._rows_of(touching.which)], slow

    def _struck(self, t: float, q: Array, v: Array, touching: Touching, values: dict[str, float]) -> Array:
        """The velocities behind the impact, if there is one."""
        which = touching.which
        u, slow = self._speeds(t, q, v, touching)
        if not (u[touching.normals] < -slow).any():
            return v
        laws = touching.laws
        try:
            P = self.law(Contacts(laws.G, laws.sizes, laws.mu), u, self.e[which]).P
        except UnsolvableError as error:
            raise self._unsolvable("impulses", t, which[list(error.which)]) from None
        for k, impulse in enumerate(P[touching.normals]):
            if impulse > 0.0:
                name = self.contacts[which[k]].name
                values[number(name, COUNT)] += 1.0
                values[number(name, IMPULSE)] = float(impulse)
        self.struck = True
        return v + touching.X @ P

    def _lasting(
        self,
        t: float,
        q: Array,
        v: Array,
        touching: Touching,
        others: tuple[int, ...],
        before: dict[str, float],
        values: dict[str, float],
    ) -> Array:
        """The velocities with contacts at rest; ``values`` get the modes, which were those of ``before``."""
        u, slow = self._speeds(t, q, v, touching)
        a, _ = accelerations(self.system, t, q, v, others)
        b = touching.W @ a - self.system.gamma_c(t, q, v)[self._rows_of(touching.which)]
        N = np.array(touching.normals)
        rest = np.abs(u[N]) <= slow
        height = ROUNDED * np.abs(touching.W[N]) @ np.abs(q)  # in which rounding decides the times of impacts
        while self.struck:  # what comes to rest may carry others, and take part in their velocities
            fall, speeds = self._supported(touching, b[N], rest), self._carried(touching, u[N], rest)
            few = [
                comes_to_rest(speed, -a, e, self.shortest) is not None or speed**2 < -2.0 * a * low
                for speed, a, e, low in zip(speeds, fall, self.e[touching.which], height, strict=True)
            ]
            if not (rest < few).any():
                break
            rest |= few
        at = np.flatnonzero(rest)
        rows = [r for k in at for r in range(N[k], N[k] + touching.laws.sizes[k])]
        own, u, b = touching.only(at), u[rows], b[rows]
        edge = self._slow_slip(v)
        slips = self._senses(own, u, edge)
        each = enumerate(zip(own.which, slips, strict=True))
        last = tuple(self._last(k, sense, u[own.laws.tangents(i)], before) for i, (k, sense) in each)
        laws, turn = self._reduced(own, u, slips)
        if (paradox := painleve(laws)) is not None:
            raise self._paradox(t, int(own.which[paradox[0]]), paradox[1])
        found = contact_modes.solve(laws, turn @ b, last, independent=True)
        if found is None:
            raise self._unsolvable("reactions", t, own.which)
        P, modes = found
        modes = self._opening(own, laws, P, modes, np.abs(b).max(initial=0.0), before)
        w = turn @ b + laws.G @ P
        active = self._active(laws, P, modes)
        if len(sharing := [k for i, k in enumerate(own.which) if self._shares(laws, i, modes[i], active)]):
            raise self._not_unique(t, sharing)
        for i, (k, mode) in enumerate(zip(own.which, modes, strict=True)):
            name = self.contacts[k].name
            n = laws.first[i]
            if n in active:
                values[number(name, MODE)] = CLOSED
            elif mode != contact_modes.OPEN or not independent_rows(laws.G, [*active, n])[-1]:
                values[number(name, MODE)] = DEPENDENT
                values[number(name, EDGE)] = -0.5 * OVERLAP * self.system.tables.size
            if self.contacts[k].slips and n in active:
                self._rub(name, laws, i, mode, (u[own.laws.tangents(i)], w[laws.tangents(i)]), edge, active, values)
        if not active:
            return v
        J, rate = turn[active] @ own.W, turn[active] @ u
        X = own.X @ turn[active].T
        return v - X @ least_squares(J @ X, rate, DEPENDS)

    def _opening(
        self, own: Touching, laws: Contacts, P: Array, modes: contact_modes.Modes, size: float, before: dict[str, float]
    ) -> contact_modes.Modes:
        """The modes in which contacts are open whose reaction is zero, but for rounding."""
        found = list(modes)
        for i, (k, n) in enumerate(zip(own.which, laws.first, strict=True)):
            was_closed = before[number(self.contacts[k].name, MODE)] == CLOSED
            if laws.G[n, n] * P[n] <= (VANISHED if was_closed else SAME) * size:  # bodies that touch without pressing
                found[i] = contact_modes.OPEN
        return tuple(found)

    def _slow_slip(self, v: Array) -> float:
        """The speed of slip that counts as rest [m/s]."""
        tables = self.system.tables
        fastest = float(np.abs(v * tables.scale).max(initial=0.0))
        return tables.size * (SLIP_OF_SIZE / self.span + SLIP_OF_SPEED * fastest)

    @staticmethod
    def _senses(own: Touching, u: Array, edge: float) -> tuple[int, ...]:
        """Of each contact the sign of its slip, 1 if this has two directions; 0 of those at rest."""
        found = []
        for i, size in enumerate(own.laws.sizes):
            slip = u[own.laws.tangents(i)]
            moves = size > 1 and np.linalg.norm(slip) > edge
            found.append(0 if not moves else 1 if size == 3 else int(np.sign(slip[0])))
        return tuple(found)

    def _last(self, k: int, slides: int, slip: Array, before: dict[str, float]) -> int:
        """The present mode of contact k, which is tried first; one that has just begun to slide goes on."""
        contact = self.contacts[k]
        if not contact.slips:
            return contact_modes.FORWARD
        sense = slides or int(before[number(contact.name, SLIDING)])
        if len(slip) == 1 and sense * slip[0] < 0.0:
            sense = 0
        return {0: STICK, 1: contact_modes.FORWARD, -1: contact_modes.BACKWARD}[sense]

    @staticmethod
    def _reduced(own: Touching, u: Array, slips: tuple[int, ...]) -> tuple[Contacts, Array]:
        """The problem in which contacts in space that slide have friction along their slip alone, and the matrix
        (rows, r) of its rows."""
        laws, rows, sizes = own.laws, [], []
        every = np.eye(len(u))
        for i, (n, size) in enumerate(zip(laws.first, laws.sizes, strict=True)):
            rows.append(every[n : n + 1])
            T = laws.tangents(i)
            along = size == 3 and slips[i]
            rows.append((u[T] / np.linalg.norm(u[T])) @ every[T] if along else every[T])
            sizes.append(2 if along else size)
        turn = np.vstack(rows) if rows else np.zeros((0, 0))
        return Contacts(turn @ laws.G @ turn.T, tuple(sizes), laws.mu, slips, laws.mu_s), turn

    @staticmethod
    def _active(laws: Contacts, P: Array, modes: contact_modes.Modes) -> list[int]:
        """Independent rows of the contacts that are closed, those with the largest reactions first, and of those that
        stick."""
        held = laws.held(modes)
        normals = sorted(set(held) & set(laws.first), key=lambda r: -P[r])
        order = [*normals, *(r for r in held if r not in set(normals))]
        return [r for r, x in zip(order, independent_rows(laws.G, order), strict=True) if x]

    @staticmethod
    def _rub(
        name: str,
        laws: Contacts,
        i: int,
        mode: int,
        motion: tuple[Array, Array],
        edge: float,
        active: list[int],
        values: dict[str, float],
    ) -> None:
        """Set the numbers of friction of contact i; ``motion``: its slip, and the acceleration of it."""
        slip, begins = motion
        values[number(name, SLOW)] = edge
        if mode == STICK:
            values[number(name, HELD)] = 1.0
            return
        sense = SENSE[mode]
        values[number(name, COEFFICIENT)] = -sense * laws.limit(i, mode)
        values[number(name, SLIDING)] = sense
        if len(slip) > 1:
            along = slip if laws.slides(i) else begins
            along = along / (np.linalg.norm(along) or 1.0)
            values[number(name, ALONG)], values[number(name, ALONG_2)] = map(float, along)

    @staticmethod
    def _shares(laws: Contacts, i: int, mode: int, active: list[int]) -> bool:
        """Whether contact i sticks, and other contacts hold its slip as well."""
        T = laws.tangents(i)
        return mode == STICK and laws.first[i] in active and not {*range(T.start, T.stop)} <= {*active}

    def _not_unique(self, t: float, which: list[int]) -> UnsolvedContactsError:
        names = ", ".join(f"`{self.contacts[k].name}`" for k in which)
        return UnsolvedContactsError(
            f"friction of {names} at rest at t = {t:.9g} s is not unique: other contacts hold the same motion",
            self.contacts[which[0]].span,
            "give friction to fewer of them, take contacts with stiffness `k`, or the method moreau-jean",
        )

    def _paradox(self, t: float, k: int, mu: float) -> UnsolvedContactsError:
        contact = self.contacts[k]
        return UnsolvedContactsError(
            f"friction of `{contact.name}` is too large at t = {t:.9g} s: with mu = {contact.mu:g} its reaction does "
            f"not exist or is not unique, from mu = {mu:.6g} on (Painleve's paradox)",
            contact.span,
            "take a smaller mu, or a contact with stiffness `k`",
        )

    def _unsolvable(self, what: str, t: float, which: NDArray[np.int64]) -> UnsolvedContactsError:
        names = ", ".join(f"`{self.contacts[k].name}`" for k in which)
        return UnsolvedContactsError(
            f"no {what} satisfy the laws of the contacts {names} at t = {t:.9g} s",
            self.contacts[which[0]].span,
            "the bodies that touch are jammed between others: leave a gap, or take a contact with stiffness `k`",
        )
