"""Events of a model during a run: which when-equations act, and what they change.

At one time there is one event. A when-equation acts if a condition of it becomes true, the first such branch alone.
What it sets is what the others read, and ``pre(x)`` are the values before. Then these become the present ones, and this
is repeated until no value changes. A condition that is true at the start has not become true (MLS 3.6, section 8.3.5),
but for `initial()`, and a clock that ticks then.

A jump of a velocity signal s by reinit is an impulse along s:

    [[M, J^T, 0], [J, 0, 0], [w^T, 0, 0]] [dv; .; .] = [0; 0; ds],   J = [Phi_q; Gam_v],   w = ds/dv
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError, ModelError
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.integrators import noted_shares
from mbdsl.integrators.contact_set import ContactSet
from mbdsl.integrators.final_slide import ContactSlides, Slides
from mbdsl.integrators.friction_set import FrictionSet
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run_state import RunState
from mbdsl.kernels import buffer_layout as L
from mbdsl.numerics.saddle_point import dense, least_squares
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations, balance
from mbdsl.system.clock_tables import CLOCKS, PLACE
from mbdsl.system.signals import gradients, values

if TYPE_CHECKING:
    from mbdsl.mechanism.events import Action, Branch, Clock

Array = NDArray[np.float64]
ROUNDS = 100  #: most rounds of one event
WHOLE = 2.0**53  #: up to this number, all whole numbers are exact
MOST_TICKS = 1e8  #: most ticks of a clock in a run, which take hours


class ReinitError(InitialisationError):
    """A jump of velocities, or a value of a discrete variable, that is not possible."""


class Acted(NamedTuple):
    """An event: its time [s], and the branches that acted."""

    t: float
    branches: tuple[Branch, ...]


class Ticked(NamedTuple):
    """Lengths of the lists of an EventSet, values of its variables, and counts of its clocks."""

    histories: int
    ticked: int
    values: dict[str, float]
    ticks: list[int]


def _of_reactions(order: list[Expr]) -> bool:
    return any(x.op == "multiplier" for x in order)


class EventSet:
    """The discrete variables of a run, and what changes them.

    Attributes
    ----------
    history : list of (k, 1 + numbers)
        Time, and the values of all numbers of the model from each event on, in the order of ``names``.
    ticked : list of (k, 2)
        Time, and the clocks that ticked then as a sum of 2^clock, of ticks in the compiled loop.
    acted : list of Acted
        The events so far.
    ended : str
        The text of `terminate`, once it has acted.
    failed : Action or None
        An assertion that does not hold.
    endless : list of Branch
        The when-equations that act without end at one time.
    """

    def __init__(self, system: System) -> None:
        self.system, self.events = system, system.scene.events
        self.friction = FrictionSet(system) if system.scene.sticking else None
        self.contacts = ContactSet(system) if system.scene.contacts else None
        joints = [self.friction] if self.friction is not None and self.friction.turning else []
        #: what slides in several directions
        self.turning: list[Slides] = [*joints, *filter(None, [ContactSlides(system)])]
        self.q = np.zeros(system.n)  #: the positions behind the last event: rounding errors of gaps are removed
        self.reactions: Array | None = None  #: multipliers (m + p,), of a method that solves the contacts itself
        self.names = list(system.scene.discrete_starts)
        self._before = {f"pre({x})": x for x in self.names if f"pre({x})" in self.events.variables}
        #: of each condition, the number of its when-equation, and its branch
        self._conditions = [
            (i, b) for i, when in enumerate(self.events.whens) for b in when.branches for _ in b.conditions
        ]
        roots = self.events.conditions
        self._count = len(roots)
        self._reads_reactions = {
            every: _of_reactions(leaves(*x)) for every, x in ((False, roots), (True, system.scene.conditions))
        }
        self._inputs = {x: at for x, at in system.tables.inputs.items() if x in system.scene.inputs}
        self._numbers = {x: at for x, at in system.tables.inputs.items() if x in self.names}
        number = {clock.name: k for k, clock in enumerate(self.events.clocks)}
        leaf = [c.args[0].value if c.op == "ne" else None for c in roots]
        #: expressions -> their nodes in order, the numbers that they read, whether they read reactions
        self._orders: dict[tuple[Expr, ...], tuple[list[Expr], set[str], bool]] = {}
        self._of_clocks = {k: number[str(x)] for k, x in enumerate(leaf) if x in number}  #: condition -> its clock
        self.reset()

    def reset(self) -> None:
        """Return to the start."""
        self.values = self.system.scene.discrete_starts
        self.inputs = {name: x.start for name, x in self.system.scene.inputs.items()}  #: values of the model's inputs
        if self.contacts is not None:
            self.contacts.read.inputs = self.inputs
        self._was = np.zeros(self._count, bool)
        self.history: list[Array] = []
        self.from_start = True  #: whether the history begins at the start of the run
        self.ticked: list[Array] = []
        self.acted: list[Acted] = []
        self.ended = ""
        self.endless: list[Branch] = []
        self.failed: Action | None = None
        self._over = False  #: whether the event at the end has acted
        self._tick, self._late = -np.inf, 0.0  #: the exact time of the last tick, and how late its event may be
        self._ticks = [0] * len(self.events.clocks)

    # -- clocks --------------------------------------------------------------------------------------------------------

    def ticks(self, t: float, stop: float) -> Iterator[float]:
        """The ticks of all clocks after t, up to ``stop`` [s]; clocks that tick together do it once."""

        def of(clock) -> Iterator[float]:
            k = max(0, int((t - float(clock.start)) / float(clock.period)) - 1)
            while (tick := clock.tick(k)) <= stop:
                if tick > t:
                    yield tick
                k += 1

        last = -np.inf
        for tick in heapq.merge(*map(of, self.events.clocks)):
            if tick > last:
                yield tick
            last = tick

    def put(self, run: RunState) -> None:
        """Let the compiled loop go on with the next ticks."""
        place, clocks = self._place(run)
        if clocks:
            run.numbers[place : place + clocks] = self._ticks
            run.reals[S.NEXT_EVENT] = min(run.reals[S.KNOWN], self.next_tick() - run.reals[S.LEAST_H])

    def next_tick(self) -> float:
        """The time of the next tick of any clock [s]."""
        return min((clock.tick(k) for clock, k in zip(self.events.clocks, self._ticks, strict=True)), default=np.inf)

    def take(self, run: RunState) -> None:
        """Enter the ticks that the compiled loop has done."""
        place, clocks = self._place(run)
        count = int(run.numbers[place + clocks]) if clocks else 0
        if not count:
            return
        targets = [a.target for _, a in self.events.of_clocks or ()]
        first, width = place + clocks + 1, 2 + len(targets)
        log = run.numbers[first : first + count * width].reshape(count, width)
        rows = np.empty((count, 1 + len(self.names)))
        rows[:, 0], rows[:, 1:] = log[:, 0], [self.values[x] for x in self.names]
        for k, name in enumerate(targets):
            self.values[name] = float(log[-1, 2 + k])
            rows[:, 1 + self.names.index(name)] = log[:, 2 + k]
            if f"pre({name})" in self.values:
                rows[:, 1 + self.names.index(f"pre({name})")] = log[:, 2 + k]
        self._remember()
        self.history.append(rows)
        self.ticked.append(log[:, :2].copy())
        self._ticks = [int(x) for x in run.numbers[place : place + clocks]]
        run.numbers[place + clocks] = 0.0

    def taken(self) -> Ticked:
        """What :meth:`take` has entered so far, for :meth:`give_back`."""
        return Ticked(len(self.history), len(self.ticked), dict(self.values), list(self._ticks))

    def give_back(self, before: Ticked) -> None:
        """Remove the ticks that were entered since, of steps that the run takes again."""
        del self.history[before.histories :], self.ticked[before.ticked :]
        self.values, self._ticks = before.values, before.ticks

    @staticmethod
    def _place(run: RunState) -> tuple[int, int]:
        """The place in numbers of the counts of clocks, and their number; 0 if Python does what they do."""
        o = run.layout[L.TICKS]
        return (int(run.layout[o + PLACE]), int(run.layout[o + CLOCKS])) if o else (0, 0)

    @staticmethod
    def _first(clock: Clock, t: float) -> int:
        """The number of the first tick at t or later; a tick before t by the rounding error of times is at t."""
        t -= 4.0 * float(np.spacing(abs(t)))
        k = max(0, int((t - float(clock.start)) / float(clock.period)) - 1)
        while clock.tick(k) < t:
            k += 1
        return k

    def _due(self, t: float) -> list[str]:
        """The clocks that tick up to time t and have not yet acted."""
        due = []
        for i, clock in enumerate(self.events.clocks):
            if clock.tick(self._ticks[i]) <= t:
                due.append(clock.name)
                while (tick := clock.tick(self._ticks[i])) <= t:
                    self._tick = max(self._tick, tick)
                    self._ticks[i] += 1
        return due

    def _exactly(self, t: float) -> float:
        """The exact time of the last tick if the event at time t is found shortly after it, else t."""
        return self._tick if 0.0 <= t - self._tick <= self._late else t

    # -- one event -----------------------------------------------------------------------------------------------------

    def begin(
        self, t: float, stop: float, q: Array, v: Array, left_out: tuple[int, ...], tol: float | None = None
    ) -> Array:
        """The event at the start; the velocities (n,) behind it.

        Raises
        ------
        ModelError
            If a clock ticks so often until ``stop`` [s] that the run would not end.
        """
        for clock in self.events.clocks:
            if (stop - t) / float(clock.period) > MOST_TICKS:
                name = f"sample({float(clock.start):g} s, {float(clock.period):g} s)"
                message = f"{name} ticks {(stop - t) / float(clock.period):.2g} times until t = {stop:g} s"
                raise ModelError(
                    message, clock.span, f"at most {MOST_TICKS:.0e} ticks are possible: take a longer period"
                )
        self.reset()
        self._late = 1e-13 * max(stop - t, abs(t), abs(stop))
        self._put(self.values)  # gaps may read variables, which have those of a run before
        if self.contacts is not None:
            self.contacts.begin(t, q, stop - t, tol, self.values)
        if self.friction is not None:
            self.friction.begin(t, stop - t, q, v, self.values)
        self._put(self.values)
        self._ticks = [self._first(clock, t) for clock in self.events.clocks]
        due = self._due(t)
        self._was = self._truth(t, q, v, left_out)
        return self._act(t, q, v, left_out, [self.events.initial, *due])

    def due(self, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> bool:
        """Whether a condition has changed since the last event, or one of contacts or of joints that stick is true."""
        truth = self._truth(t, q, v, left_out, every=True)
        return bool(truth[self._count :].any() or (truth[: self._count] != self._was).any())

    def forget(self) -> None:
        """Drop what has happened so far, in a run that does not store it."""
        self.history, self.ticked, self.acted, self.from_start = self.history[-1:], [], [], False
        self.history = [rows[-1:] for rows in self.history]

    def ticks_by(self, t: float) -> bool:
        """Whether a clock ticks up to time t that has not yet acted."""
        return any(clock.tick(k) <= t for clock, k in zip(self.events.clocks, self._ticks, strict=True))

    def act(
        self,
        t: float,
        q: Array,
        v: Array,
        left_out: tuple[int, ...],
        put: bool = True,
        given: Mapping[str, float] | None = None,
    ) -> Array:
        """The event at time t in the state q, v (n,); the velocities behind it, ``v`` itself if they do not change.

        ``put``: whether the numbers of the System are set. ``given``: values of discrete variables that are set from
        outside.
        """
        self._undone = (dict(self.values), self._was, list(self._ticks), len(self.history), len(self.acted))
        return self._act(t, q, v, left_out, self._due(t), put, given)

    def end(self, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> None:
        """The event at the end of the run, if `terminal()` is read."""
        if self.events.terminal in self.values and not self._over:
            self._over, ended, self.ended = True, self.ended, ""
            self._act(t, q, v, left_out, [self.events.terminal])
            self.ended = ended or self.ended

    def like(self, other: EventSet) -> None:
        """Take the scales of another set, of a run that has begun."""
        if self.contacts is not None and other.contacts is not None:
            self.contacts.shortest, self.contacts.span = other.contacts.shortest, other.contacts.span
        if self.friction is not None and other.friction is not None:
            self.friction.span = other.friction.span

    def undo(self) -> None:
        """Take the last event back."""
        self.values, self._was, self._ticks, histories, acted = self._undone
        del self.history[histories:], self.acted[acted:]
        self._put(self.values)
        self.ended, self.failed, self.endless = "", None, []

    def _act(
        self,
        t: float,
        q: Array,
        v: Array,
        left_out: tuple[int, ...],
        pulses: Sequence[str],
        put: bool = True,
        given: Mapping[str, float] | None = None,
    ) -> Array:
        acted: list[Branch] = []
        self.q, self.struck = q, False
        for name in pulses:
            if name in self.values:
                self.values[name] = 1.0
        for _ in range(ROUNDS):
            self._remember()
            if given:
                if self.contacts is not None:
                    self.contacts.before(t, q, self.values)
                self.values, given = {**self.values, **given}, None
            before, at_first = dict(self.values), v
            if self.contacts is not None:
                self._put(self.values)
                q, v = self.contacts.act(t, q, v, left_out, self.values, self.friction)
                left_out = self.left_out(left_out)
                self.q, self.struck = q, self.struck or self.contacts.struck
            if self.friction is not None:
                v = self.friction.act(t, q, v, left_out, self.values)
                left_out = self.left_out(left_out)
            done, v = self._round(t, q, v, left_out)
            acted += done
            if self.ended or self.failed is not None or (self.values == before and v is at_first):
                break
            if not done and self._only_struck:
                break
        else:
            self.endless = list({id(x): x for x in acted[-len(self._conditions) :]}.values())
        for name in pulses:
            if name in self.values:
                self.values[name] = 0.0
        self._remember()
        if pulses:
            self._was = self._truth(t, q, v, left_out)
        self._put(self.values if put else self._undone[0])
        if acted:
            self.acted.append(Acted(self._exactly(t), tuple(acted)))
        self.history.append(self._row(t))
        return v

    def _row(self, t: float) -> Array:
        """Time and the present values (1, 1 + numbers), for the history."""
        return np.array([[t, *map(self.values.__getitem__, self.names)]])

    @property
    def _only_struck(self) -> bool:
        """Whether the last round was an impact that leaves all contacts open, so that another round changes nothing."""
        if self.contacts is None or self.friction is not None or self._before:
            return False
        return self.contacts.struck and self.contacts.all_open(self.values)

    def _round(self, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> tuple[list[Branch], Array]:
        """Everything that acts with the same values before; the branches, and the velocities behind them.

        What one when-equation sets is what the conditions of others read; each of them acts at most once.
        """
        done: list[Branch] = []
        truth = self._was
        while not self.ended and self.failed is None:
            truth = self._truth(t, q, v, left_out)
            branches = [x for x in self._rising(truth & ~self._was) if all(x is not y for y in done)]
            if not branches:
                break
            v = self._do(branches, t, q, v, left_out)
            done += branches
        self._was = truth
        return done, v

    def left_out(self, left_out: tuple[int, ...]) -> tuple[int, ...]:
        """The rows that are left out behind the last event; ``left_out``: those before it."""
        if self.contacts is not None:
            left_out = self.contacts.left_out(left_out, self.values)
        return left_out if self.friction is None else self.friction.left_out(left_out, self.values)

    def note(self, t: float) -> None:
        """Enter the present values, which a method has set, into the history."""
        self._put(self.values)
        self.history.append(self._row(t))

    def all_left_out(self, left_out: tuple[int, ...]) -> tuple[int, ...]:
        """``left_out`` and all rows of contacts, for a method that solves the contacts itself."""
        return tuple(sorted({*left_out, *(row for rows in self.system.tables.contact_rows for row in rows)}))

    def _remember(self) -> None:
        """pre(x) <- x of all variables."""
        for before, name in self._before.items():
            self.values[before] = self.values[name]

    def _put(self, given: dict[str, float]) -> None:
        """Set the numbers of the System."""
        if self.friction is not None:
            self.system.activate(self.left_out(self.system.tables.switchable))
        self._enter(self._numbers, given)

    def _enter(self, places: Mapping[str, int], given: Mapping[str, float]) -> None:
        """Set the numbers of the System at ``places``."""
        if places:
            self.system.buffers.numbers[list(places.values())] = [given[name] for name in places]

    def numbers(self) -> dict[int, float]:
        """Offset in ``numbers`` -> value, of all variables that the equations contain."""
        return {at: self.values[name] for name, at in self._numbers.items()}

    def _reactions(self, t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> Array:
        """The multipliers (m + p,) with the present values: those of the equations of motion."""
        self._put(self.values)
        return accelerations(self.system, t, q, v, left_out)[1] if self.reactions is None else self.reactions

    def _evaluated(self, roots: Sequence[Expr], t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> list[float]:
        """Expressions in a state with the present values; reactions are those of the equations of motion."""
        key = tuple(roots)
        if key not in self._orders:
            order = walk(*key)
            read = {str(x.value) for x in order if x.op == "input"}
            self._orders[key] = order, read & self.inputs.keys() | read & self.values.keys(), _of_reactions(order)
        order, read, of_reactions = self._orders[key]
        lam = self._reactions(t, q, v, left_out)[None] if of_reactions else None
        given = self.inputs | self.values if self.inputs else self.values
        inputs = {name: np.array([given[name]]) for name in read}
        found = values(self.system, roots, np.array([t]), q[None], v[None], lam, inputs, order)
        return [float(x[0]) for x in found]

    def _truth(self, t: float, q: Array, v: Array, left_out: tuple[int, ...], every: bool = False) -> NDArray[np.bool_]:
        """The truth of the conditions with the present values, with ``every`` also those of contacts and of joints."""
        conditions, system = slice(None if every else self._count), self.system
        if not len(system.tables.conditions[conditions]):
            return self._was
        lam = self._reactions(t, q, v, left_out) if self._reads_reactions[every] else None
        self._enter(self._inputs, self.inputs)
        self._enter(self._numbers, self.values)
        return system.conditions(t, q, v, lam)[conditions]

    def _rising(self, rose: NDArray[np.bool_]) -> list[Branch]:
        """Of every when-equation, the first branch one of whose conditions rose."""
        found: dict[int, Branch] = {}
        for k in np.flatnonzero(rose).tolist():
            found.setdefault(*self._conditions[k])
        return list(found.values())

    def _do(self, branches: list[Branch], t: float, q: Array, v: Array, left_out: tuple[int, ...]) -> Array:
        """The actions of branches; the velocities behind them."""
        jumps: list[tuple[Action, float]] = []
        order, last = self.events.order, len(self.events.order)
        actions = [a for branch in branches for a in branch.actions]
        for action in sorted(actions, key=lambda a: order[a.target] if a.what == "set" else last):
            if action.value is None:
                self.ended = self.ended or action.text or "terminated"
                continue
            (x,) = self._evaluated([action.value], self._exactly(t), q, v, left_out)
            if action.what in ("set", "reinit"):
                self._check(action, x, t)
            if action.what == "set":
                self.values[action.target] = x
            elif action.what == "reinit":
                jumps.append((action, x))
            elif x == 0.0 and self.failed is None:
                self.failed = action
        return self._jumped(jumps, t, q, v) if jumps else v

    def _check(self, action: Action, x: float, t: float) -> None:
        """Check the new value of a variable or a velocity.

        Raises
        ------
        ReinitError
            If it is not finite, or so large that a whole number is rounded.
        """
        name = f"reinit of {action.target}" if action.what == "reinit" else f"`{action.target}`"
        if not np.isfinite(x):
            message = f"{name} at t = {t:.9g} s: the value is {x:g}"
            raise ReinitError(message, action.span, "it has to be a finite number at this event")
        own = self.events.variables.get(action.target)
        if own is not None and own.type == "Integer" and abs(x) > WHOLE:
            message = f"{name} at t = {t:.9g} s: the whole number {x:.6g} is too large"
            raise ReinitError(message, action.span, f"whole numbers are exact up to 2^53 = {WHOLE:.4g}: limit it")

    def _jumped(self, jumps: list[tuple[Action, float]], t: float, q: Array, v: Array) -> Array:
        """The velocities after impulses along the signals of reinit.

        Raises
        ------
        ReinitError
            If one velocity jumps twice, or constraints do not allow it.
        """
        system = self.system
        first: dict[Expr | None, Action] = {}
        for action, _ in jumps:
            if (other := first.setdefault(action.signal, action)) is not action:
                notes = (("the first one is here", other.span),) if other.span is not None else ()
                hint = "write one `when ... elsewhen ...`"
                message = f"reinit of {action.target} acts twice at t = {t:.9g} s"
                raise ReinitError(message, action.span, hint, notes)
        signals = [a.signal for a, _ in jumps if a.signal is not None]
        now, _, w = gradients(system, signals, t, q, v)
        n, matrix = system.n, dense(system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0))
        # contacts push back in the next round, and friction that sticks has no impulse
        free = n + np.array(self.all_left_out(system.tables.switchable), int)
        M, J = matrix[:n, :n], np.vstack([dense(w), matrix[np.setdiff1d(np.arange(n, system.unknowns), free), :n]])
        d = balance(system, M.diagonal(), J)  # the units of the model do not decide the rank
        K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
        wanted, change = np.array([x for _, x in jumps]), np.zeros(n + len(J))
        jumping = slice(n, n + len(jumps))
        change[jumping] = wanted - now
        dv = d[:n] * least_squares(d[:, None] * K * d, d * change, 1e-13)[:n]
        allowed = float((d[jumping] * np.maximum(np.abs(wanted), np.abs(now))).max())
        if not np.abs(d[n:] * (J @ dv - change[n:])).max() <= 1e-8 * allowed:
            names = ", ".join(a.target for a, _ in jumps)
            message = f"reinit of {names} at t = {t:.9g} s: the constraints do not allow this velocity"
            hint = "a joint or a driver determines it; a `reinit` of several signals needs values that belong together"
            raise ReinitError(message, jumps[0][0].span, hint)
        if self.friction is not None:
            self.friction.release(t, q, v + dv, self.values)
        return v + dv

    @property
    def status(self) -> int:
        """The status of a run that ends here; RUNNING if it goes on."""
        if self.failed is not None:
            return S.ASSERTED
        if self.endless:
            return S.ENDLESS
        return S.DONE if self.ended else S.RUNNING

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def saved(self) -> dict[str, Any]:
        """What a checkpoint keeps, by name."""
        number = {id(branch): k for k, branch in enumerate(self.events.branches)}
        acted = [(x.t, number[id(branch)]) for x in self.acted for branch in x.branches]
        width = 1 + len(self.names)
        return {
            "values": np.array([self.values[x] for x in self.names], float),
            "was": self._was.astype(float),
            "ticks": np.array(self._ticks, float),
            "history": np.concatenate([np.empty((0, width)), *self.history]),
            "ticked": np.concatenate([np.empty((0, 2)), *self.ticked]),
            "acted": np.array(acted, float).reshape(-1, 2),
            "ended": self.ended,
            "shares": noted_shares.saved(self.friction, self.contacts),
        }

    def restore(self, run: RunState, kept: Mapping[str, Any]) -> None:
        """Return to the state of a checkpoint.

        Raises
        ------
        KeyError, TypeError, ValueError
            If something is missing, or has a type, shape or range that is impossible in this run.
        """
        now, branches = self.saved(), self.events.branches
        del now["shares"]
        for name, own in now.items():
            found = kept[name]
            if isinstance(own, str):
                fits = isinstance(found, str)
            else:
                fits = isinstance(found, np.ndarray) and found.dtype == np.float64 and np.isfinite(found).all()
                first = 1 if name in ("history", "ticked", "acted") else 0  # tables of any number of rows
                fits = fits and found.ndim == own.ndim and found.shape[first:] == own.shape[first:]
            if not fits:
                raise ValueError(f"{name} of its events does not have the size or type that this model needs")
        ticks, acted, due = kept["ticks"], kept["acted"], kept["ticked"][:, 1]
        if not (((ticks >= 0) & (ticks < 2.0**53)).all() and ((due >= 0) & (due < 2.0**53)).all()):
            raise ValueError("a count of its clocks is impossible")
        if not ((acted[:, 1] >= 0) & (acted[:, 1] < len(branches))).all():
            raise ValueError("an event of it has no when-equation")
        noted_shares.restore(self.system, self.friction, self.contacts, kept["shares"])
        self.values = dict(zip(self.names, kept["values"].tolist(), strict=True))
        self._was, self._ticks = kept["was"] != 0.0, [int(x) for x in ticks]
        self.history, self.ticked = [kept["history"].copy()], [kept["ticked"].copy()]
        self.acted = [Acted(t, (branches[int(k)],)) for t, k in acted.tolist()]
        self.ended, self.failed, self.endless = kept["ended"], None, []
        place, clocks = self._place(run)
        if clocks:
            run.numbers[place + clocks] = 0.0  # the compiled loop does not check it
        run.left_out = self.left_out(run.left_out)
        run.mark_left_out()
        self.put(run)

    # -- results -------------------------------------------------------------------------------------------------------

    def at(self, t: Array) -> dict[str, Array]:
        """The numbers of the model at times t (N,); at the time of an event, and earlier by its rounding, behind it."""
        if not self.history:
            return {}
        times, _ = self.table()
        return self.numbers_at(t + 1e-13 * np.maximum(np.abs(t), np.abs(times).max()))

    def numbers_at(self, t: Array) -> dict[str, Array]:
        """The numbers of the model at times t (N,) exactly: behind an event at its time, and before it before that."""
        if not self.history:
            return {}
        times, rows = self.table()
        which = np.clip(np.searchsorted(times, t, side="right") - 1, 0, None)
        return {name: rows[which, k] for k, name in enumerate(self.names)}

    def jumps(self) -> Array:
        """The times at which a number of the model changes, without the start."""
        if not self.history:
            return np.empty(0)
        times, rows = self.table()
        found = times[1:][(rows[1:] != rows[:-1]).any(axis=1)]
        return np.unique(found[found > times[0]])

    def table(self) -> tuple[Array, Array]:
        """Times (k,) of all events and the numbers (k, names) behind them."""
        if len(self.history) > 1:
            self.history = [np.concatenate(self.history)]
        return self.history[0][:, 0], self.history[0][:, 1:]

    def ticks_done(self) -> list[tuple[Branch, Array]]:
        """The branches that the compiled loop does, and their times."""
        if not self.ticked:
            return []
        self.ticked = [np.concatenate(self.ticked)]
        t, due = self.ticked[0][:, 0], self.ticked[0][:, 1].astype(np.int64)
        return [(self._conditions[k][1], t[(due >> clock) & 1 == 1]) for k, clock in self._of_clocks.items()]
