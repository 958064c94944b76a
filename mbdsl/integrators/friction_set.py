"""Friction that sticks: which joints of a run slide, and which are held.

At an event, joints that are at rest are held or begin to slide. A set of modes fits if the accelerations that follow
from it do: no joint that is held needs more than mu_s N, and no joint that slides is accelerated against its sliding.
The modes with the fewest changes are tried first; joints that arrive at rest count as held. Friction and reactions are
those of the equations of motion at this state.

A joint that begins to slide in several directions does it along d, the direction of its acceleration A(d) with friction
along -d. With k above the change of A by friction, d = A(d) + k d, made a unit vector, converges to it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.integrators.shared_friction import At, RowsHeld, independent, motion, put, share
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism import contacts
from mbdsl.mechanism.sticking import DRIVEN, EDGE, MARGIN, SLIDING, Sticking, number
from mbdsl.system import System
from mbdsl.system.paradox import paradox
from mbdsl.system.signals import gradients, values

Modes = tuple[int, ...]
Numbers = dict[str, float]

#: joints at rest up to which all modes are tried; with more of them, one joint after the other changes its mode
MOST_TRIED = 5
#: speed that counts as rest: this part of the size of the mechanism over the run, and of its largest velocity
OF_SIZE, OF_SPEED = 1e-9, 1e-10
#: part of it that is left by rounding where joints were stopped, and multiple of it at which a joint that slides in
#: several directions may stop
ROUNDED, NEAR = 1e-3, 10.0
#: acceleration against the sliding, relative to the largest, that is rounding; and of a joint that is held
ROUNDING, MOVED = 1e-9, 1e-6
#: iterations for the direction in which a joint begins to slide, and their last change
TURNS, TURNED = 300, 1e-13


class UndecidedFrictionError(InitialisationError):
    """No modes of joints at rest fit."""


class FrictionSet:
    """The joints of ``system`` whose friction sticks, in a run.

    Attributes
    ----------
    shared : list of (float, tuple of str)
        Times [s] at which joints were held that hold the same motion, and their names.
    """

    def __init__(self, system: System) -> None:
        self.system, self.joints = system, system.scene.sticking
        self.rows = [[system.tables.rows[row] for row in x.rows] for x in self.joints]
        names = [name for x in self.joints for name in x.held]
        self.held = dict(zip([row for rows in self.rows for row in rows], names, strict=True))  #: row -> its number
        self.gaps = [rows[0] for rows in system.tables.contact_rows]
        self.turning = any(len(x.rates) > 1 for x in self.joints)  #: whether some slide in several directions
        self.span = 1.0
        self.shared: list[tuple[float, tuple[str, ...]]] = []

    def begin(self, t: float, span: float, q: Array, v: Array, numbers: Numbers) -> None:
        """Set the sense of sliding at the start of a run of ``span`` [s]; nothing is held before the first event."""
        self.span, self.shared = span or 1.0, []
        for x, rate in zip(self.joints, self._rates(t, q, v), strict=True):
            self._set_sliding(x, rate, numbers, self._slow(v))
        self._latch(t, q, v, numbers, range(len(self.joints)))

    def left_out(self, left_out: tuple[int, ...], numbers: Numbers) -> tuple[int, ...]:
        """The rows that are left out: those of ``left_out`` that hold no joint, and of joints that are not held."""
        inactive = (row for row, name in self.held.items() if not numbers[name])
        return tuple(sorted({*(row for row in left_out if row not in self.held), *inactive}))

    def act(self, t: float, q: Array, v: Array, left_out: tuple[int, ...], numbers: Numbers) -> Array:
        """The velocities (n,) behind the event at time t; sets modes and places in ``numbers``.

        Raises
        ------
        UndecidedFrictionError
            If no modes fit.
        """
        rates, slow = self._rates(t, q, v), self._slow(v)
        before = [int(numbers[number(x.name, SLIDING)]) for x in self.joints]
        along = [float(np.dot([numbers[d] for d in x.directions], r)) for x, r in zip(self.joints, rates, strict=True)]
        resting = [k for k in range(len(before)) if self._may_rest(k, before[k], along[k], rates[k], numbers, slow)]
        for k, x in enumerate(self.joints):
            numbers[number(x.name, EDGE)] = slow
            if k not in resting:
                self._set_sliding(x, rates[k], numbers, slow)
        if not resting:
            return v
        self._latch(t, q, v, numbers, [k for k in resting if before[k]])
        # a joint that has just begun to slide is at rest as well, but goes on
        past = [before[k] if along[k] >= 0.0 else 0 for k in resting]
        at = At(t, q, v, left_out, numbers, resting)
        if max(np.abs(rates[k]).max() for k in resting) > ROUNDED * slow:
            at = at._replace(v=self._stopped(at))
        for modes in self._tried(past):
            if self._fits(at, modes):
                self._support(at)
                return at.v
        raise self._undecided(at)

    def release(self, t: float, q: Array, v: Array, numbers: Numbers) -> bool:
        """Let the joints slide as an impulse has moved them; whether some were held."""
        slow, held = self._slow(v), False
        for x, rate in zip(self.joints, self._rates(t, q, v), strict=True):
            if np.linalg.norm(rate) > slow:
                held = held or not numbers[number(x.name, SLIDING)]
                self._set_sliding(x, rate, numbers, slow)
                numbers.update(dict.fromkeys(x.held, 0.0))
        return held

    def _support(self, at: At) -> None:
        """Let closed contacts be dependent whose bodies friction holds."""
        rows = self._left_out(at)
        for c, (row, *_) in zip(self.system.scene.contacts, self.system.tables.contact_rows, strict=True):
            if row in rows and row not in at.left_out:
                at.numbers[contacts.number(c.name, contacts.MODE)] = contacts.DEPENDENT

    def _may_rest(self, k: int, before: int, along: float, rate: Array, numbers: Numbers, slow: float) -> bool:
        """Whether a joint is held, or so slow that it may be."""
        speed = float(np.linalg.norm(rate))
        if before == 0:
            return all(numbers[name] for name in self.joints[k].held) or speed <= DRIVEN * slow
        return along <= slow if len(rate) == 1 else speed <= NEAR * slow

    def _undecided(self, at: At) -> UndecidedFrictionError:
        names = ", ".join(f"`{self.joints[k].name}`" for k in at.resting)
        for k in at.resting:
            at.numbers[number(self.joints[k].name, SLIDING)] = 1.0
            at.numbers.update(dict.fromkeys(self.joints[k].held, 0.0))
        rows = self.left_out(at.left_out, at.numbers)
        put(self.system, at.numbers, rows)
        near = paradox(self.system, at.t, at.q, at.v, np.ones(self.system.m + self.system.p), rows)
        return UndecidedFrictionError(
            f"friction of {names} at t = {at.t:.9g} s: neither rest nor sliding agrees with the reactions"
            + (f"; {near.text}" if near else ""),
            self.joints[at.resting[0]].span,
            "take smaller coefficients of friction",
        )

    def _tried(self, past: list[int]) -> Iterator[Modes]:
        """The modes of joints at rest, those with the fewest changes first."""
        self._advice: list[int] | None = None
        if len(past) <= MOST_TRIED:
            every = product((0, 1, -1), repeat=len(past))
            yield from sorted(every, key=lambda modes: sum(a != b for a, b in zip(modes, past, strict=True)))
            return
        modes = list(past)
        for _ in range(3 * len(past)):
            yield tuple(modes)
            if self._advice is None:
                return
            modes, self._advice = self._advice, None

    # -- one set of modes ----------------------------------------------------------------------------------------------

    def _fits(self, at: At, modes: Modes) -> bool:
        """Whether accelerations and reactions agree with ``modes`` of the joints at rest, which are set."""
        free = [k for k, mode in zip(at.resting, modes, strict=True) if mode and len(self.joints[k].rates) > 1]
        if any(mode < 0 and k in free for k, mode in zip(at.resting, modes, strict=True)):
            return False  # the same as 1
        for k, mode in zip(at.resting, modes, strict=True):
            at.numbers[number(self.joints[k].name, SLIDING)] = float(mode)
        held = [k for k, mode in zip(at.resting, modes, strict=True) if not mode]
        rows_held = self._hold(at, held)
        rows = self._left_out(at)
        try:
            if free:
                self._direct(at, rows, free)
            a, lam = motion(self.system, at, rows)
        except InitialisationError:
            return False
        if rows_held is not None:
            given = share(self.system, at, [(self.joints[k], self.rows[k]) for k in held], rows_held, lam)
            if given is None:
                return False
            at.numbers.update(given)
        fits = self._agree(at, modes, a, lam)
        if fits and rows_held is not None:
            which = np.flatnonzero(np.abs(rows_held.Z).max(axis=1, initial=0.0))
            names = tuple(self.joints[k].name for k in held if set(self.rows[k]) & set(which.tolist()))
            if len(names) > 1 and (not self.shared or self.shared[-1][1] != names):
                self._check_unread(at.t, names)
                self.shared.append((at.t, names))
        return fits

    def _check_unread(self, t: float, names: tuple[str, ...]) -> None:
        """Check that no law reads the friction of joints that is not unique.

        Raises
        ------
        UndecidedFrictionError
            If a law does.
        """
        rows = {row: x.name for x in self.joints if x.name in names for row in x.rows}
        for c in self.system.scene.components.values():
            laws = [x for x in (*c.values.values(), *c.velocity_constraints) if isinstance(x, Expr)]
            for leaf in leaves(*laws):
                if leaf.op == "multiplier" and leaf.value[0] in rows:
                    name = rows[leaf.value[0]]
                    raise UndecidedFrictionError(
                        f"`{c.name}` reads the friction of `{name}`, which is not unique from t = {t:.9g} s on: "
                        f"{', '.join(f'`{x}`' for x in names)} hold the same motion",
                        c.span,
                        "let only one of these joints stick, with the friction of all of them",
                    )

    def _agree(self, at: At, modes: Modes, a: Array, lam: Array) -> bool:
        """Whether accelerations a (n,) and multipliers agree with modes; else notes which mode differs most."""
        inputs = {name: np.array([x]) for name, x in at.numbers.items()}
        own = [self.joints[k] for k in at.resting]
        roots = [root for x in own for root in (x.normal, *x.grips)]
        found = iter(values(self.system, roots, np.array([at.t]), at.q[None], at.v[None], lam[None], inputs))
        change = self._accelerations(at, a)
        tiny = float(np.finfo(float).tiny)
        fastest = self._largest(a, self._free(at))
        # a contact may keep it at rest, but for rounding
        largest = fastest if not {*self.gaps} <= {*at.left_out} else self._largest(a)
        advice, worst = list(modes), 0.0
        for i, (k, mode, x) in enumerate(zip(at.resting, modes, own, strict=True)):
            normal = float(next(found)[0])
            grip = np.array([float(next(found)[0]) for _ in x.grips])
            if mode:
                along = float(np.dot([at.numbers[d] for d in x.directions], change[k]))
                over, other = -along / largest - ROUNDING, 0
            else:
                force, most = float(np.linalg.norm(grip)), x.mu_s * normal
                over = (force - most * (1.0 + 0.5 * MARGIN)) / max(most, force, tiny)
                over = max(over, float(np.linalg.norm(change[k])) / fastest - MOVED)  # others move it
                other = 1 if len(grip) > 1 else int(np.sign(grip[0] or change[k][0]))
            if over > worst:
                worst, advice = over, list(modes)
                advice[i] = other
        self._advice = advice if worst > 0.0 else None
        return worst <= 0.0

    def _largest(self, *accelerations: Array) -> float:
        """The largest acceleration [m/s2]."""
        size, scale = self.system.tables.size, self.system.tables.scale
        found = max(float(np.abs(a * scale).max(initial=0.0)) for a in accelerations) * size
        return max(found, float(np.finfo(float).tiny))

    def _free(self, at: At) -> Array:
        """The accelerations of bodies by applied forces alone, about."""
        mass = self.system.M(at.t, at.q).diagonal()
        return np.divide(self.system.Q(at.t, at.q, at.v), mass, out=np.zeros(len(mass)), where=mass > 0.0)

    def _hold(self, at: At, held: list[int]) -> RowsHeld | None:
        """Let those rows of the joints ``held`` act that are independent of all others and of those before them; None
        if all are."""
        rows = [row for k in held for row in self.rows[k]]
        for row, name in self.held.items():
            at.numbers[name] = float(row in rows)
        at.numbers.update({name: x for joint in self.joints for name, x in joint.alone.items()})
        if not rows:
            return None
        without = self.left_out(at.left_out, at.numbers)
        put(self.system, at.numbers, without)
        found = independent(self.system, at, (*without, *self.gaps), rows)
        for row in rows:
            at.numbers[self.held[row]] = float(row in found.kept)
        return found if len(found.kept) < len(rows) else None

    def _left_out(self, at: At) -> tuple[int, ...]:
        """The rows that are left out, with those of closed contacts that depend on what friction holds: contacts do
        not pull."""
        rows = self.left_out(at.left_out, at.numbers)
        closed = [row for row in self.gaps if row not in rows]
        if not (closed and any(at.numbers[name] for name in self.held.values())):
            return rows
        put(self.system, at.numbers, rows)
        return (*rows, *(set(closed) - set(independent(self.system, at, rows, closed).kept)))

    def _direct(self, at: At, left_out: tuple[int, ...], free: list[int]) -> None:
        """Set the directions in which the joints ``free`` begin to slide.

        Raises
        ------
        InitialisationError
            If there are none.
        """
        own = [self.joints[k] for k in free]
        names = [number(x.name, SLIDING) for x in own]
        at.numbers.update(dict.fromkeys(names, 0.0))
        bare = self._directed(at, left_out, free)
        at.numbers.update(dict.fromkeys(names, 1.0))
        size = 0.0
        for i in range(max(len(x.rates) for x in own)):
            for x in own:
                self._point(x, np.eye(len(x.rates))[i % len(x.rates)], at.numbers)
            braked = self._directed(at, left_out, free)
            size = max(size, *(float(np.linalg.norm(b - a)) for b, a in zip(bare, braked, strict=True)))
        k, way = 2.0 * len(own) * size, bare
        for _ in range(TURNS):
            for x, d in zip(own, way, strict=True):
                self._point(x, d, at.numbers)
            now = [np.array([at.numbers[d] for d in x.directions]) for x in own]
            way = [a + k * d for a, d in zip(self._directed(at, left_out, free), now, strict=True)]
            new = [w / max(float(np.linalg.norm(w)), np.finfo(float).tiny) for w in way]
            if max(float(np.abs(a - b).max()) for a, b in zip(new, now, strict=True)) < TURNED:
                return

    def _directed(self, at: At, left_out: tuple[int, ...], free: list[int]) -> list[Array]:
        """The accelerations of sliding of the joints ``free``."""
        change = self._accelerations(at, motion(self.system, at, left_out)[0])
        return [change[k] for k in free]

    # -- states and numbers --------------------------------------------------------------------------------------------

    def time_left(self, at: At, above: float = 0.0) -> float:
        """The time [s] in which the first of the joints that slide in several directions comes to rest, at its present
        deceleration, if it is faster than ``above`` times rest; points its friction against the present sliding."""
        rates, slow = self._rates(at.t, at.q, at.v), self._slow(at.v)
        own = [k for k, x in enumerate(self.joints) if len(x.rates) > 1 and at.numbers[number(x.name, SLIDING)]]
        for k in own:
            self._set_sliding(self.joints[k], rates[k], at.numbers, slow)
        change = self._accelerations(at, motion(self.system, at, at.left_out)[0])
        own = [k for k in own if np.linalg.norm(rates[k]) > above * slow]
        square = [(float(rates[k] @ rates[k]), -float(rates[k] @ change[k])) for k in own]
        return min((r / braked for r, braked in square if braked > 0.0), default=np.inf)

    def stopped(self, at: At) -> bool:
        """Whether a joint that slides in several directions may be held."""
        slow = NEAR * self._slow(at.v)
        rates = zip(self.joints, self._rates(at.t, at.q, at.v), strict=True)
        sliding = (r for x, r in rates if len(r) > 1 and at.numbers[number(x.name, SLIDING)])
        return any(float(np.linalg.norm(r)) <= slow for r in sliding)

    def _point(self, joint: Sticking, along: Array, numbers: Numbers) -> None:
        """Set the direction of sliding of a joint that slides in several directions, if the vector has one."""
        size = float(np.linalg.norm(along))
        if size > 0.0:
            numbers.update(zip(joint.directions, (along / size).tolist(), strict=True))

    def _set_sliding(self, joint: Sticking, rate: Array, numbers: Numbers, slow: float) -> None:
        """Set the sense and the direction of sliding to those of the present rate."""
        moves = float(np.linalg.norm(rate)) > slow
        numbers[number(joint.name, SLIDING)] = 0.0 if not moves else float(np.sign(rate[0])) if len(rate) == 1 else 1.0
        if moves and len(rate) > 1:
            self._point(joint, rate, numbers)

    def _latch(self, t: float, q: Array, v: Array, numbers: Numbers, which) -> None:
        """Set the places of the joints ``which`` to the present ones."""
        for k in which:
            x, rows = self.joints[k], self.rows[k]
            if x.by_coordinates:  # which count turns
                numbers.update({**dict.fromkeys(x.kept, 0.0), **dict.fromkeys(x.held, 1.0)})
                put(self.system, numbers, self.left_out((), numbers))
                found = self.system.Phi(t, q)[rows].tolist()
                numbers.update(dict.fromkeys(x.held, 0.0))
            else:
                found = [float(y[0]) for y in values(self.system, x.places, np.array([t]), q[None], v[None])]
            numbers.update(zip(x.kept, found, strict=True))

    def _rates(self, t: float, q: Array, v: Array) -> list[Array]:
        found = values(self.system, [r for x in self.joints for r in x.rates], np.array([t]), q[None], v[None])
        return self._by_joint(np.array([float(x[0]) for x in found]))

    def _by_joint(self, rates: Array) -> list[Array]:
        """Numbers of all rates of sliding, by joints."""
        return np.split(rates, np.cumsum([len(x.rates) for x in self.joints])[:-1])

    def _slow(self, v: Array) -> float:
        """The speed of sliding that counts as rest, in m/s or rad/s."""
        size, scale = self.system.tables.size, self.system.tables.scale
        fastest = float(np.abs(v * scale).max(initial=0.0))
        return size * (OF_SIZE / self.span + OF_SPEED * fastest)

    def _stopped(self, at: At) -> Array:
        """The velocities with the joints at rest stopped; they are slow already."""
        self._hold(at, at.resting)
        rows = self._left_out(at)
        put(self.system, at.numbers, rows)
        return onto_constraints(self.system, at.t, at.q, at.v, rows)[1]

    def _accelerations(self, at: At, a: Array) -> list[Array]:
        """The rates of the rates of all joints, at accelerations a (n,)."""
        _, d_q, d_v = gradients(self.system, [r for x in self.joints for r in x.rates], at.t, at.q, at.v)
        return self._by_joint(np.asarray(d_q @ at.v + d_v @ a, float))
