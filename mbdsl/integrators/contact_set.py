"""Rigid contacts of a run: their impacts, and which of them last.

Where a gap closes, Newton's law of restitution (:mod:`mbdsl.numerics.impact`) gives the velocities behind the impact. A
contact whose further impacts would end within a very short time comes to rest at once. The contacts at rest close if
the accelerations without them would close their gaps: a closed contact is a row of the constraints, and opens where its
reaction would pull. Rows that depend on those of other closed contacts are left out. Friction is part of both problems:
a contact that sticks has the rows of its slip as well, one that slides has mu N against it. Of contacts that hold the
same motion, each carries a share of the forces, besides the multipliers of its own rows that are independent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators import contact_errors
from mbdsl.integrators.friction_set import FrictionSet
from mbdsl.integrators.rim_corners import RimCorners
from mbdsl.integrators.shared_reactions import SharedReactions
from mbdsl.integrators.touching import DEPENDS, Touching, alike, reduced, senses
from mbdsl.mechanism.contacts import (
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
    SHARES,
    SLIDING,
    SLOW,
    held,
    idle,
    number,
)
from mbdsl.numerics import contact_modes
from mbdsl.numerics.contact_modes import SENSE, STICK, Contacts, independent_rows, painleve
from mbdsl.numerics.friction_shares import active, at_rest, exerted
from mbdsl.numerics.impact import UnsolvableError, at_once, comes_to_rest, in_sequence
from mbdsl.numerics.saddle_point import dense, least_squares
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations, rows_kept
from mbdsl.system.driven_contacts import drivers_at_fault

Array = NDArray[np.float64]
State = tuple[float, Array, Array]  #: t, q, v
Places = NDArray[np.int64]
Rows = tuple[int, ...]
Numbers = dict[str, float]

#: relative to the mechanism's size: gaps that count as closed; error of the gap of a closed contact, and overlap at the
#: start that is rounding; and the overlap at which a gap has closed, which is more than the rounding error of gaps
NEAR, OVERLAP, ROUNDING = 1e-9, 1e-6, 1e-14
PARALLEL = 1e-6  #: relative pivot below which the overlaps of two contacts are removed as one
NEVER = -1e300  #: the gap [m] at which a contact closes that is left out
#: height of a bounce, relative to the coordinates in its gap, below which it is rounding
ROUNDED = 64.0 * float(np.finfo(float).eps)
#: speed of a gap, relative to the fastest motion, that counts as rest; and relative to the size over the run
REST, STILL = 1e-10, 1e-13
SAME, NOTHING = 1e-13, 1e-30  #: change of velocities that is rounding, relative to them; and over the run
#: a contact rests if its impacts end within this part of the tolerance, and of a run, or within this part of a run
OF_TOLERANCE, LEAST = 1e-3, 2e-14
LOOSEST = 1e-5  #: tolerance that counts, of runs with fixed steps too
VANISHED = 1e-7  #: acceleration by a reaction, relative to the largest of gaps and slips, at which a contact opens
#: speed of slip that counts as rest: this part of the size of the mechanism over the run, and of its largest velocity
SLIP_OF_SIZE, SLIP_OF_SPEED = 1e-9, 1e-10


class ContactSet:
    """The rigid contacts of a run of ``system``.

    Attributes
    ----------
    struck : bool
        Whether the last event was an impact.
    eased : bool
        Whether contacts that hold the same motion have got other shares of it.
    shared : list of (float, tuple of str)
        Times [s] at which contacts stick that hold the same motion, and their names.
    read, corners : SharedReactions, RimCorners
        The laws and conditions that read reactions which contacts share; the corners of rigid cylinders.
    """

    def __init__(self, system: System) -> None:
        self.system, self.contacts, self.corners = system, system.scene.contacts, RimCorners(system)
        self.all_rows = system.tables.contact_rows
        self.rows = np.array([rows[0] for rows in self.all_rows], int)
        self.e, self.present = np.array([c.e for c in self.contacts]), np.array([not c.absent for c in self.contacts])
        self.law = in_sequence if all(c.sequential for c in self.contacts) else at_once
        self.shortest, self.struck, self.eased, self.span = 0.0, False, False, 1.0
        self.shared: list[tuple[float, tuple[str, ...]]] = []
        self.read = SharedReactions(system)
        # of the last event: time, contacts and modes; shares, accelerations, those without reactions, and their matrix
        self._shared: tuple[tuple, Array, Array, Array, Array] | None = None
        # time of the last event, and values and gaps before it
        self._before: tuple[float, Numbers, Array] = np.nan, {}, np.zeros(0)

    def begin(self, t: float, q: Array, span: float, tol: float | None, values: Numbers) -> None:
        """Start a run of ``span`` [s] with this tolerance.

        Raises
        ------
        InitialisationError
            If bodies overlap.
        """
        size, self._before, self.shared, self._shared = self.system.tables.size, (np.nan, {}, self.e), [], None
        self._release(values)
        self.read.found = []
        self.shortest, self.span = max(OF_TOLERANCE * min(tol or LOOSEST, LOOSEST), LEAST) * span, span or 1.0
        for contact, gap in zip(self.contacts, self._gaps(t, q), strict=True):
            if not contact.absent and gap < -OVERLAP * size:
                message = f"the gap of `{contact.name}` is {gap:.6g} {contact.unit} at the start: the bodies overlap"
                raise InitialisationError(message, contact.span, "give initial values at which it is not negative")

    def _gaps(self, t: float, q: Array) -> Array:
        return self.system.Phi(t, q)[self.rows]

    def without_value(self, t: float, q: Array) -> contact_errors.UnsolvedContactsError | None:
        """The error of the first contact whose gap has no value at time t; None if all have one."""
        own = zip(self.contacts, self._gaps(t, q), strict=True)
        return next((contact_errors.no_value(c, t) for c, gap in own if not (c.absent or np.isfinite(gap))), None)

    def before(self, t: float, q: Array, values: Numbers) -> None:
        """Keep the values and the gaps before the event at time t, unless they are known."""
        if t != self._before[0]:
            self._before = t, dict(values), self._gaps(t, q)

    def left_out(self, left_out: Rows, values: Numbers) -> Rows:
        """The rows that are left out: those of ``left_out`` that are no contacts, and of contacts that are not closed
        by their rows, or do not stick."""
        own, inactive = set[int](), set[int]()
        for c, (row, *slips) in zip(self.contacts, self.all_rows, strict=True):
            own |= {row, *slips}
            inactive |= {row} if values[number(c.name, MODE)] != CLOSED else set()
            inactive |= {x for k, x in enumerate(slips) if idle(values[number(c.name, HELD)], k)}
        return tuple(sorted({row for row in left_out if row not in own} | inactive))

    def all_open(self, values: Numbers) -> bool:
        """Whether no row of a contact is closed."""
        return all(values[number(c.name, MODE)] != CLOSED for c in self.contacts)

    def act(
        self, t: float, q: Array, v: Array, left_out: Rows, values: Numbers, friction: FrictionSet | None = None
    ) -> tuple[Array, Array]:
        """q and v (n,) behind the event at time t, ``v`` itself if it does not change; ``values`` get the modes.

        Joints with ``friction`` that are held slide behind an impact that moves them: friction of a finite force has
        no impulse.

        Raises
        ------
        InitialisationError
            If no impulses or reactions satisfy the laws of the contacts.
        """
        self.struck = self.eased = False
        modes = np.array([values[number(c.name, MODE)] for c in self.contacts])
        if (problem := self.without_value(t, q)) is not None:
            raise problem
        self.corners.lean(t, q, v, values)
        gaps = self._gaps(t, q)
        if t == self._before[0]:
            contact_errors.check_jumps(self.contacts, gaps, self._before[2], OVERLAP * self.system.tables.size, t)
        near = np.where(modes == OPEN, NEAR, OVERLAP) * self.system.tables.size
        which, given = np.flatnonzero((gaps < near) & self.present), v
        self.before(t, q, values)
        before = self._before[1]
        self._release(values)
        if len(which):
            others = tuple(sorted({*left_out, *(row for rows in self.all_rows for row in rows)}))
            touching = self._touching(t, q, v, which, others)
            contact_errors.check_gradients(self.contacts, touching, self.system.tables, t)
            q, v = self._back(t, q, v, touching, np.maximum(-gaps[which], 0.0), others)
            free = tuple(sorted({*others, *self.system.tables.switchable}))
            v = self._struck(t, q, v, which, free, values)
            if self.struck and friction is not None and friction.release(t, q, v, values):
                others = friction.left_out(others, values)
            v = self._lasting(t, q, v, which, others, before, values)
        size, scale = self.system.tables.size, self.system.tables.scale
        change, fastest = (float(np.abs(x * scale).max(initial=0.0)) for x in (v - given, given))
        return q, given if change <= SAME * fastest + NOTHING * size / self.span else v

    def _release(self, values: Numbers) -> None:
        """Open all contacts."""
        for c in self.contacts:
            values[number(c.name, MODE)] = OPEN
            values[number(c.name, EDGE)] = NEVER if c.absent else -ROUNDING * self.system.tables.size
            if c.slips:
                values |= {number(c.name, x): 0.0 for x in (COEFFICIENT, SLIDING, HELD, ALONG, ALONG_2, *SHARES)}
                for name in (COEFFICIENT, SLIDING):
                    self.system.set_input(number(c.name, name), 0.0)

    def _back(
        self, t: float, q: Array, v: Array, touching: Touching, depth: Array, others: Rows
    ) -> tuple[Array, Array]:
        """q and v where the gaps closed, before they were negative by ``depth`` (k,): without what this way adds to
        the energy, u^2 - 2 a depth, impacts would not die away. Contacts at rest keep their speed."""
        if not depth.any():
            return q, v
        u, slow = self._speeds(t, q, v, touching)
        N = touching.normals
        a, _ = accelerations(self.system, t, q, v, others)
        fall = touching.W[N] @ a - self.system.gamma_c(t, q, v)[self.rows[touching.which]]
        fall = touching.supported(fall, np.abs(u[N]) <= slow)
        before = np.where(u[N] < -slow, -np.sqrt(np.maximum(u[N] * u[N] + 2.0 * fall * depth, 0.0)), u[N])
        right = np.stack([depth, before - u[N]], axis=1)
        shift = least_squares(touching.laws.G[np.ix_(N, N)], right, PARALLEL)  # nearly parallel rows would move much
        X = touching.X[:, N]
        return self.system.moved(q, X @ shift[:, 0]), v + X @ shift[:, 1]

    def _touching(self, t: float, q: Array, v: Array, which: Places, others: Rows) -> Touching:
        """The rows of contacts, and their Delassus matrix; ``others``: rows that do not constrain."""
        system, n = self.system, self.system.n
        matrix = dense(system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0))
        W = matrix[n + self._rows_of(which), :n]
        kept = np.append(np.arange(n), n + rows_kept(system.m + system.p, others))
        K, right = matrix[np.ix_(kept, kept)], np.zeros((len(kept), len(W)))
        right[:n] = W.T
        try:
            X = np.asarray(np.linalg.solve(K, right)[:n], float)
        except np.linalg.LinAlgError:
            raise self._unsolvable("impulses", (t, q, v), which, others) from None
        G = W @ X
        own = [self.contacts[k] for k in which]
        mu, mu_s = np.array([c.mu for c in own]), np.array([c.mu_s for c in own])
        return Touching(which, W, X, Contacts(0.5 * (G + G.T), tuple(1 + len(c.slips) for c in own), mu, (), mu_s))

    def _rows_of(self, which: Places) -> Places:
        """The rows of contacts, in their order."""
        return np.array([row for k in which for row in self.all_rows[k]], int)

    def _speeds(self, t: float, q: Array, v: Array, touching: Touching) -> tuple[Array, float]:
        """The rates of gaps and the slips (r,), and the speed that counts as rest."""
        fastest = float(np.abs(v * self.system.tables.scale).max(initial=0.0))
        slow = self.system.tables.size * (REST * fastest + STILL / self.span)
        return self.system.constraint_rates(t, q, v)[self._rows_of(touching.which)], slow

    def _struck(self, t: float, q: Array, v: Array, which: Places, others: Rows, values: Numbers) -> Array:
        """The velocities behind the impact, if there is one."""
        touching = self._touching(t, q, v, which, others)
        u, slow = self._speeds(t, q, v, touching)
        if not (u[touching.normals] < -slow).any():
            return v
        laws = touching.laws
        try:
            P = self.law(Contacts(laws.G, laws.sizes, laws.mu), u, self.e[which]).P
        except UnsolvableError as error:
            raise self._unsolvable("impulses", (t, q, v), which[list(error.which)], others) from None
        N = touching.normals
        if self.corners.turned(which, P[N], values):
            return self._struck(t, q, v, which, others, values)
        for k, impulse in enumerate(P[N]):
            if impulse * laws.G[N[k], N[k]] > slow:  # less is a rounding error of a body at rest
                name = self.contacts[which[k]].name
                values[number(name, COUNT)] += 1.0
                values[number(name, IMPULSE)] = float(impulse)
        self.struck = True
        return v + touching.X @ P

    def _lasting(
        self, t: float, q: Array, v: Array, which: Places, others: Rows, before: Numbers, values: Numbers
    ) -> Array:
        """The velocities with contacts at rest; ``values`` get the modes, which were those of ``before``."""
        touching = self._touching(t, q, v, which, others)
        u, slow = self._speeds(t, q, v, touching)
        a, _ = accelerations(self.system, t, q, v, others)
        b = touching.W @ a - self.system.gamma_c(t, q, v)[self._rows_of(touching.which)]
        N = np.array(touching.normals)
        rest = np.abs(u[N]) <= slow
        height = ROUNDED * np.abs(touching.W[N]) @ np.abs(q)  # in which rounding decides the times of impacts
        while self.struck:  # what comes to rest may carry others, and take part in their velocities
            fall, speeds = touching.supported(b[N], rest), touching.carried(u[N], rest)
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
        slips = senses(own, u, edge)
        each = enumerate(zip(own.which, slips, strict=True))
        last = tuple(self._last(k, sense, u[own.laws.tangents(i)], before) for i, (k, sense) in each)
        laws, turn = reduced(own, u, slips)
        if (paradox := painleve(laws)) is not None:
            raise contact_errors.too_rough(self.contacts[own.which[paradox[0]]], t, paradox[1])
        found = at_rest(laws, turn @ b, last)
        if found is None:
            raise self._unsolvable("reactions", (t, q, v), own.which, others)
        P, modes = found
        if self.corners.turned(own.which, P[laws.first], values, (laws, turn @ b)):
            return self._lasting(t, q, v, which, others, before, values)
        modes = self._opening(own, laws, P, modes, np.abs(b).max(initial=0.0), before)
        act = active(laws, P, modes)
        shares, w = self._shares(t, own, laws, P, modes, turn @ b, act)
        for i, (k, mode) in enumerate(zip(own.which, modes, strict=True)):
            name, n = self.contacts[k].name, laws.first[i]
            if n in act:
                values[number(name, MODE)] = CLOSED
            elif mode != contact_modes.OPEN or not independent_rows(laws.G, [*act, n])[-1]:
                values[number(name, MODE)] = DEPENDENT
                values[number(name, EDGE)] = -0.5 * OVERLAP * self.system.tables.size
            if self.contacts[k].slips and (n in act or mode == STICK):
                values[number(name, SLOW)] = edge
                values |= self._rub(name, laws, i, mode, u[own.laws.tangents(i)], w[laws.tangents(i)], act, shares)
        self.read.look((t, q, v), (own, laws, turn, modes), others, values)
        if not act:
            return v
        J, rate = turn[act] @ own.W, turn[act] @ u
        X = own.X @ turn[act].T
        return v - X @ least_squares(J @ X, rate, DEPENDS)

    def _opening(
        self, own: Touching, laws: Contacts, P: Array, modes: contact_modes.Modes, size: float, before: Numbers
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

    def _last(self, k: int, slides: int, slip: Array, before: Numbers) -> int:
        """The present mode of contact k, which is tried first; one that has just begun to slide goes on."""
        contact = self.contacts[k]
        if not contact.slips:
            return contact_modes.FORWARD
        sense = slides or int(before[number(contact.name, SLIDING)])
        if len(slip) == 1 and sense * slip[0] < 0.0:
            sense = 0
        return {0: STICK, 1: contact_modes.FORWARD, -1: contact_modes.BACKWARD}[sense]

    def _shares(
        self, t: float, own: Touching, laws: Contacts, P: Array, modes: contact_modes.Modes, b: Array, act: list[int]
    ) -> tuple[Array, Array]:
        """The part (r,) of the forces P that is not that of the rows ``act`` alone, and the accelerations (r,); in
        further rounds of an event the same, which rounding would change, unless a round has changed the forces."""
        same, kept = (t, own.which.tolist(), modes), self._shared
        if kept is not None and kept[0] == same and all(map(alike, (b, laws.G), kept[3:])):
            self.eased = bool(kept[1].any())
            return kept[1:3]
        C = exerted(laws, modes, act)
        shares = P - C @ least_squares((laws.G @ C)[act], -b[act], DEPENDS)
        shares[np.abs(shares) <= VANISHED * np.abs(P).max(initial=0.0)] = 0.0
        of = zip(own.which, laws.first, laws.sizes, modes, strict=True)
        names = tuple(self.contacts[k].name for k, n, size, mode in of if mode == STICK and shares[n : n + size].any())
        if len(names) > 1 and (not self.shared or self.shared[-1][1] != names):
            self.shared.append((t, names))
        self._shared, self.eased = (same, shares, w := b + laws.G @ P, b, laws.G), bool(shares.any())
        return shares, w

    @staticmethod
    def _rub(
        name: str, laws: Contacts, i: int, mode: int, slip: Array, begins: Array, act: list[int], shares: Array
    ) -> Numbers:
        """The numbers of friction of contact i, which has a ``slip`` with the accelerations ``begins``."""
        n, T = laws.first[i], laws.tangents(i)
        if mode == STICK:
            found = {number(name, HELD): held([row not in act for row in range(T.start, T.stop)])}
            return found | {number(name, SHARES[k]): float(x) for k, x in enumerate(shares[n : T.stop])}
        sense = SENSE[mode]
        found = {number(name, COEFFICIENT): -sense * laws.limit(i, mode), number(name, SLIDING): sense}
        if len(slip) > 1:
            along = slip if laws.slides(i) else begins
            along = along / (np.linalg.norm(along) or 1.0)
            found |= {number(name, x): float(d) for x, d in zip((ALONG, ALONG_2), along, strict=True)}
        return found

    def _unsolvable(self, what: str, at: State, which: Places, others: Rows) -> InitialisationError:
        drivers = drivers_at_fault(self.system, *at, self.rows[which].tolist(), others)
        return contact_errors.unsolvable(what, [self.contacts[k] for k in which], f" at t = {at[0]:.9g} s", drivers)
