"""Close approaches: points of a run where the argument of a condition almost changes its sign, or barely changes it.

A stop acts where g = s + gap is below zero. A path that turns back shortly before g = 0 does not touch the stop; a path
that would turn back shortly behind it does. A small error of the path decides between the two. Each approach is
recorded with its distance d from zero at the turning point: d > 0 where the path turns back before zero, d < 0 where it
would turn back that far behind zero if the forces did not change. Two runs with different errors show how accurate d is
(:mod:`mbdsl.simulation.undecided_contacts`).

Between the ends of steps g is the cubic through its values and rates. The rate of an argument with velocities or
reactions needs accelerations, which the records of steps do not contain: they are computed where values at three ends
of steps turn back close to zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.expressions.derivatives import der, diff
from mbdsl.expressions.spatial_coordinates import AXES
from mbdsl.expressions.symbolic import TIME, Expr, const, is_const, leaves, walk
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.system.accelerations import accelerations
from mbdsl.system.batch_accelerations import sampled
from mbdsl.system.signals import gradients, values

if TYPE_CHECKING:
    from mbdsl.system.system import System


#: distance, relative to the largest value of the argument, above which an approach is not close
CLOSE = 0.05
#: most approaches that are kept, the closest ones, and most numbers in them
MOST, NUMBERS = 1000, 200_000
COMPARISONS, CORNERS = ("lt", "le"), ("min", "max")
POSITIONS = ("x", "y", "phi")
#: most ends of steps around which the rate of an argument of velocities or reactions is computed, in a search; the
#: difference of time for that, relative to the step; values below this part of the largest one are at a switch
MOST_RATES, APART, AT_SWITCH = 32, 1e-2, 1e-9
EPS = float(np.finfo(float).eps)
#: gaps of rigid contacts, relative to the mechanism's size, that count as closed
ROUNDED = 1e-14
#: least number of states whose accelerations are computed together
FEW = 8
#: width of a narrow cell of a table, relative to the table; most knots of such cells that are examined
NARROW, MOST_KNOTS = 1e-2, 32
#: most comparisons in a condition, and operations in an argument, that are examined
MOST_COMPARED, MOST_NODES = 16, 500


#: t (N,), q, v (N, n) and lam (N, m + p)
States: TypeAlias = tuple[Array, Array, Array, Array]


class Approach(NamedTuple):
    """An approach of argument number ``number`` at time ``t`` [s] from a ``side`` (1: the argument is positive), with
    its distance d, the second time derivative of the argument, away from zero, and the interpolation error of d;
    ``state``: q and v at that time."""

    number: int
    t: float
    side: float
    d: float
    curvature: float
    error: float
    state: list[float]


def arguments(system: System) -> list[Expr]:
    """The arguments whose signs determine the forces: differences of what is compared."""
    found: dict[Expr, None] = {}
    for switch in system.tables.switches:
        for g in _compared(switch.node):
            variables = leaves(g)
            moves = any(x.op in ("coordinate", "multiplier") for x in variables)
            # in space, positions are searched between steps; angles count turns, which states do not contain
            apart = (system.scene.spatial and of_positions(g)) or any(x.op == "angle" for x in walk(g))
            # a stop with a damper, as max(0, -k s - c v): its contact is shorter than what interpolation resolves
            mixed = not of_positions(g) and any(map(_is_position, _summands(g)))
            large = len(walk(g)) > MOST_NODES  # as distances from profiles: they would cost more than steps
            if moves and not apart and not mixed and not large and all(x.op != "input" for x in variables):
                found[g] = None
    # in space, positions are searched between steps
    found |= dict.fromkeys(c.gap for c in system.scene.contacts if not system.scene.spatial)
    return list(found)


def of_events(system: System) -> set[Expr]:
    """The arguments of conditions of when-equations: what these do is not bounded by a change of forces."""
    events = system.scene.events
    conditions = [c for branch in events.branches if not events.of_component(branch) for c in branch.conditions]
    return {g for c in conditions for g in _compared(c)}


def _compared(node: Expr) -> list[Expr]:
    """The differences of what is compared in a node; of the choice among many, as of the nearest feature of a profile,
    that of the outermost comparison, if its arguments vary."""
    nodes = [n for n in walk(node) if n.op in COMPARISONS]
    if len(nodes) > MOST_COMPARED:
        varies = node.op in COMPARISONS and any(not is_const(x) for x in diff(node.args[0], *leaves(node)))
        nodes = [node] if varies else []
    nodes += [node] if node.op in (*CORNERS, "abs", "sign") else []
    return [*(n.args[0] - n.args[1] if len(n.args) == 2 else n.args[0] for n in nodes), *_corners(node)]


def _corners(node: Expr) -> list[Expr]:
    """The argument of a table less the knots of its narrow cells, which steps can pass over."""
    if node.op != "table" or node.value[0].extrapolation == "periodic":
        return []
    u = np.asarray(node.value[0].u)
    narrow = np.diff(u) < NARROW * (u[-1] - u[0])
    knots = u[np.append(narrow, False) | np.append(False, narrow)]
    return [node.args[0] - float(x) for x in knots] if len(knots) <= MOST_KNOTS else []


def _summands(g: Expr) -> list[Expr]:
    """The terms of a sum, without constant factors."""
    found, waiting = [], [g]
    while waiting:
        x = waiting.pop()
        factors = [y for y in x.args if leaves(y)]
        if x.op in ("add", "sub", "neg") or (x.op in ("mul", "div") and len(factors) == 1):
            waiting += factors
        else:
            found.append(x)
    return found


def _is_position(x: Expr) -> bool:
    """Whether a term depends on coordinates, but not on velocities or reactions."""
    return bool(leaves(x)) and of_positions(x) and any(y.op == "coordinate" for y in leaves(x))


def of_positions(g: Expr) -> bool:
    """Whether an argument depends on positions and time alone."""
    variables = [x for x in leaves(g) if x.op != "time"]
    return all(x.op == "coordinate" and x.value[1] in (*POSITIONS, "z", *AXES) for x in variables)


class _Course:
    """Arguments y (k, N) at the ends of steps h (N - 1,), and their cubics within the steps:
    y + x (r0 + x (c2 + x c3)) with x from 0 to 1."""

    def __init__(self, h: Array, y: Array, rate: Array) -> None:
        self.h, self.y, self.rate = h, y, rate
        dy, self.r0, r1 = np.diff(y), h * rate[:, :-1], h * rate[:, 1:]
        self.c2, self.c3 = 3.0 * dy - 2.0 * self.r0 - r1, self.r0 + r1 - 2.0 * dy
        self.bend, self.third = (2.0 * self.c2 + 6.0 * self.c3) / h**2, 6.0 * self.c3 / h**3  # at the ends of steps

    def leave_out_rounding(self, which: NDArray[np.bool_], noise: Array) -> None:
        """Of the arguments ``which`` (k,), take second and third derivatives at the end of a step from the step before,
        if they are rounding errors; ``noise`` (k,) is that of y, and rates are differences of y over the part APART of
        a step."""
        good = 0.1 * np.abs(self.bend) * self.h**2 * APART > 4.0 * noise[:, None]
        last = np.maximum.accumulate(np.where(good, np.arange(good.shape[1]), -1), axis=1)
        for x in (self.bend, self.third):
            x[which] = np.where(last < 0, np.nan, np.take_along_axis(x, np.maximum(last, 0), axis=1))[which]

    @property
    def last(self) -> tuple[Array, Array, Array, Array]:
        """The values at the end of the last step, and their three derivatives."""
        return self.y[:, -1], self.rate[:, -1], self.bend[:, -1], self.third[:, -1]


class Approaches:
    """Finds the approaches in the recorded steps of a run.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.arguments = arguments(system)
        own = of_events(system)
        #: rigid contacts by the numbers of their gaps
        self.contacts = {self.arguments.index(c.gap): c for c in system.scene.contacts if c.gap in self.arguments}
        self.of_events = frozenset(k for k, g in enumerate(self.arguments) if g in own)  #: numbers of their arguments
        self._of_positions = np.array([of_positions(g) for g in self.arguments], bool)
        self._rigid = np.array([k in self.contacts for k in range(len(self.arguments))], bool)
        self._of_reactions = [any(x.op == "multiplier" for x in leaves(g)) for g in self.arguments]
        self._roots = self.arguments + [der(g) if of_positions(g) else const(np.nan) for g in self.arguments]
        self._order, self._orders = walk(*self._roots), [walk(g) for g in self.arguments]
        self._most = max(16, min(MOST, NUMBERS // max(1, system.n)))

    def add(
        self,
        found: list[Approach],
        past: Array,
        rows: States,
        inputs: Mapping[str, float],
        left_out: tuple[int, ...] = (),
    ) -> None:
        """Add the close approaches within successive steps to ``found``.

        Parameters
        ----------
        found : list of Approach
        past : (5, k)
            For each of k arguments, the data that the next call needs: its value, its first, second and third
            derivative at the end of the last step, and the largest value so far.
        rows : t (N,), q (N, n), v (N, n), lam (N, m + p)
            The states at the ends of steps; the first is the start of the first step.
        inputs : values of inputs by name
        left_out : tuple of int
            Redundant constraints.
        """
        t, q, v, lam = rows
        given = {name: np.full(len(t), value) for name, value in inputs.items()}
        known = np.array(values(self.system, self._roots, t, q, v, lam, given, self._order))
        (y, rate), h = np.split(known, 2), np.diff(t)
        sizes = np.fmax(past[4], np.abs(y).max(axis=1))
        apart, zero = ~self._of_positions, ~y.any(axis=1)  # the reaction of an open contact is zero
        near = np.zeros(y.shape, bool)
        with np.errstate(all="ignore"):
            if (own := np.flatnonzero(apart & ~zero)).size:
                near[own] = _turning(np.append(past[0, own, None], y[own], axis=1), CLOSE * sizes[own])
                if near.any():
                    self._add_rates(rate, near, rows, inputs, left_out)
            far = ~apart & _far(h, y, rate, past[0], CLOSE * sizes)
            which = np.flatnonzero(~(far | (apart & zero)))
            before, on = past[:, which], _Course(h, y[which], rate[which])
            if apart[which].any():
                on.leave_out_rounding(apart[which], EPS * sizes[which])
            if len(which) < len(y):
                past[:4] = _Course(h[-1:], y[:, -2:], rate[:, -2:]).last
            past[:4, which], past[4] = on.last, sizes
            past[:4, apart & zero] = np.array([[0.0], [np.nan], [np.nan], [np.nan]])
            turns = self._turns(which, on, before[3], sizes[which], rows)
            found += sorted([*turns, *self._crossings(which, on, before, sizes[which], rows)], key=lambda x: x.number)
        if len(found) > 2 * self._most:
            found.sort(key=lambda x: abs(x.d) / past[4, x.number])
            del found[self._most :]
            found.sort(key=lambda x: x.t)

    def _turns(self, which: Integers, on: _Course, third: Array, largest: Array, rows: States) -> Iterator[Approach]:
        """The turning points within steps that do not cross, of the arguments ``which`` (k,); ``third`` (k,) is the
        last third derivative before, and ``largest`` (k,) the largest value so far."""
        (t, q, v, _), h, y = rows, on.h, on.y
        positions, free = self._of_positions[which, None], ~self._rigid[which, None]
        side = np.where(y[:, :-1] != 0.0, np.sign(y[:, :-1]), np.sign(on.r0))
        x, turns = _minimum(side * on.r0, side * on.c2, side * on.c3)
        if not turns.any():
            return
        d = side * (y[:, :-1] + x * (on.r0 + x * (on.c2 + x * on.c3)))
        least = np.where(positions, 0.0, AT_SWITCH * largest[:, None])
        turns &= (side * y[:, 1:] >= least) & (side * y[:, :-1] >= least) & ((side > 0.0) | free)
        # a closed gap, and one that opens or closes, turns by rounding; and gaps below zero are rounding errors
        rounding = ROUNDED * self.system.tables.size
        clear = (d > rounding) | (np.abs(y[:, :-1] - d) > rounding) | (np.abs(y[:, 1:] - d) > rounding)
        turns &= (clear | free) & (np.abs(d) <= CLOSE * largest[:, None])
        change = np.abs(np.diff(on.third, prepend=third[:, None]))
        behind = np.append(change[:, 1:], np.full((len(which), 1), np.inf), axis=1)
        error = h**3 / 384.0 * np.fmin(np.fmin(change, behind), np.abs(on.third))
        for k, i in np.argwhere(turns).tolist():
            at = x[k, i]
            dq, a, b = q[i + 1] - q[i], h[i] * v[i], h[i] * v[i + 1]
            c, e = 3.0 * dq - 2.0 * a - b, a + b - 2.0 * dq
            state = [*q[i] + at * (a + at * (c + at * e)), *(a + at * (2.0 * c + at * 3.0 * e)) / h[i]]
            if self.system.scene.spatial:
                state = [*q[i + round(at)], *v[i + round(at)]]
            curvature = abs(2.0 * on.c2[k, i] + 6.0 * at * on.c3[k, i]) / h[i] ** 2
            # behind zero within a step that did not meet the condition: as uncertain as it is deep
            off = max(error[k, i], 0.0 if positions[k] else -d[k, i])
            yield _approach(int(which[k]), t[i] + at * h[i], side[k, i], d[k, i], curvature, off, state)

    def _crossings(
        self, which: Integers, on: _Course, before: Array, largest: Array, rows: States
    ) -> Iterator[Approach]:
        """The crossings between consecutive rows, beginning with the last row of the previous call: ``before`` (5, k)
        is its part of ``past``."""
        (t, q, v, _), y = rows, on.y
        value = np.append(before[0, :, None], y[:, :-1], axis=1)
        side = np.sign(value)
        crosses = side * y < 0.0
        if not crosses.any():
            return
        slope = np.append(before[1, :, None], on.rate[:, :-1], axis=1)
        bends, jerks = (
            np.concatenate([z[:, None], z[:, None], x[:, :-1]], axis=1)
            for z, x in ((before[2], on.bend), (before[3], on.third))
        )
        slope, bends = side * slope, side * bends
        d = side * value - slope**2 / (2.0 * bends)
        crosses &= (slope < 0.0) & (bends > 0.0) & (np.abs(d) <= CLOSE * largest[:, None])
        crosses &= (side > 0.0) | ~self._rigid[which, None]
        for k, i in np.argwhere(crosses).tolist():
            j, number = max(i - 1, 0), int(which[k])
            curvature, own = bends[k, i], side[k, i]
            if i and self._of_positions[number]:
                curvature = own * self._second(number, t[j], q[j], v[j])
            if curvature > 0.0:
                # at least so deep, if the third derivative, perhaps that of another contact, pushes back
                third, falls = abs(jerks[k, i]), slope[k, i]
                rest = -2.0 * falls / (curvature + np.sqrt(curvature**2 - 2.0 * third * falls))
                deep = own * value[k, i] + rest * (falls + rest * (0.5 * curvature + rest * third / 6.0))
                yield _approach(number, t[j], own, min(deep, own * y[k, i]), curvature, 0.0, [*q[j], *v[j]])

    def _add_rates(
        self, rate: Array, near: NDArray[np.bool_], rows: States, inputs: Mapping[str, float], left_out: tuple[int, ...]
    ) -> None:
        """Enter the time derivatives of arguments at the rows ``near`` (k, N) into ``rate``, by central differences
        along the motion; nan where there are no accelerations."""
        system, (t, q, v, _) = self.system, rows
        which, at, h = np.flatnonzero(near.any(axis=1)).tolist(), np.flatnonzero(near.any(axis=0)), np.diff(t)
        dt, a, count = APART * h[np.minimum(at, len(h) - 1)], self._accelerations(at, rows, inputs, left_out), len(at)
        s = np.append(-dt, dt)[:, None]
        t, q, v, a = (np.concatenate([x, x]) for x in (t[at], q[at], v[at], a))
        t, q, v = t + s[:, 0], system.moved(q, s * v, 0.5 * s * s * a), v + s * a
        lam = np.zeros((2 * count, rows[3].shape[1]))
        of_reactions = near[np.ix_([k for k in which if self._of_reactions[k]], at)].any(axis=0)
        for i in np.flatnonzero(np.tile(of_reactions, 2) & np.isfinite(a).all(axis=1)).tolist():
            try:
                lam[i] = accelerations(system, t[i], q[i], v[i], left_out)[1]
            except InitialisationError:
                lam[i] = np.nan
        order = list(dict.fromkeys(x for k in which for x in self._orders[k]))
        given = {x: np.full(2 * count, value) for x, value in inputs.items()}
        ends = values(system, [self.arguments[k] for k in which], t, q, v, lam, given, order)
        for k, x in zip(which, ends, strict=True):
            rate[k, near[k]] = ((x[count:] - x[:count]) / (2.0 * dt))[near[k, at]]

    def _accelerations(
        self, at: Integers, states: States, inputs: Mapping[str, float], left_out: tuple[int, ...]
    ) -> Array:
        """Those (k, n) at the rows ``at`` (k,) of ``states``; nan where there are none."""
        system, (t, q, v, _) = self.system, states
        found, done = np.full((len(at), system.n), np.nan), np.zeros(len(at), bool)
        numbers = {system.tables.inputs[x]: np.full(len(at), value) for x, value in inputs.items()}
        together = sampled(system, t[at], q[at], v[at], left_out, numbers, FEW)
        if together is not None:
            found, _, done = together
        for k in np.flatnonzero(~done).tolist():
            i = at[k]
            try:
                found[k] = accelerations(system, t[i], q[i], v[i], left_out)[0]
            except InitialisationError:
                found[k] = np.nan
        return found

    def _second(self, number: int, t: float, q: Array, v: Array) -> float:
        """The second time derivative of an argument at a state; 0 where there are no accelerations."""
        try:
            a, _ = accelerations(self.system, t, q, v)
        except InitialisationError:
            return 0.0
        rate = self._roots[len(self.arguments) + number]
        _, by_q, by_v = gradients(self.system, [rate], t, q, v)
        (by_t,) = diff(rate, TIME)
        explicit = values(self.system, [by_t], np.array([t]), q[None], v[None])[0][0]
        return float((by_q @ v)[0] + (by_v @ a)[0] + explicit)


def _approach(number: int, t: float, side: float, d: float, curvature: float, error: float, state: list) -> Approach:
    return Approach(number, float(t), float(side), float(d), float(curvature), float(error), list(map(float, state)))


def _far(h: Array, y: Array, rate: Array, before: Array, near: Array) -> NDArray[np.bool_]:
    """Whether arguments y (k, N) with these rates, that were ``before`` (k,), stay on one side of zero, farther away
    than ``near`` (k,): the cubics within the steps do so if their control points do."""
    slope = h * rate[:, :-1] / 3.0, h * rate[:, 1:] / 3.0
    points = np.concatenate([y, y[:, :-1] + slope[0], y[:, 1:] - slope[1]], axis=1)
    above, below = points.min(axis=1) > near, points.max(axis=1) < -near
    return (above & ~(before < 0.0)) | (below & ~(before > 0.0))


def _turning(y: Array, near: Array) -> NDArray[np.bool_]:
    """The ends of steps (of y (k, N + 1) without its first column, which precedes them) where arguments turn back or
    change their sign within ``near`` (k,) of zero, their neighbours, and close ends at the border of the search."""
    slope, (count, columns) = np.diff(y), y.shape
    turns, crosses = np.zeros(y.shape, bool), np.zeros(y.shape, bool)
    turns[:, 1:-1] = slope[:, :-1] * slope[:, 1:] <= 0.0
    turns[:, :3] = turns[:, -3:] = True
    crosses[:, 1:-1] = (y[:, :-2] * y[:, 1:-1] < 0.0) | (y[:, 1:-1] * y[:, 2:] < 0.0)
    close = (np.abs(y) <= near[:, None]) & (y != 0.0)
    wide, few = np.zeros((count, columns + 3), bool), MOST_RATES // 2
    for kind in (turns & close, crosses & close & ~turns):
        for k in np.flatnonzero(kind.sum(axis=1) > few).tolist():  # the closest of each
            at = np.flatnonzero(kind[k])
            kind[k, at[np.argsort(np.abs(y[k, at]), kind="stable")[few:]]] = False
        for k in range(4):  # with both neighbours, and the one before, which crossings need
            wide[:, k : k + columns] |= kind
    return wide[:, 3 : columns + 2]


def _minimum(c1: Array, c2: Array, c3: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The x in [0, 1) at which c1 x + c2 x^2 + c3 x^3 has a minimum, and whether there is one."""
    with np.errstate(all="ignore"):
        root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
        # of the two stationary points the one with a positive second derivative
        x = np.where(c2 + root != 0.0, -c1 / (c2 + root), np.nan)
    turns = (c2 * c2 > 3.0 * c1 * c3) & (x >= 0.0) & (x < 1.0)
    return np.where(turns, x, 0.0), turns
