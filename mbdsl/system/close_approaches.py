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

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

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
    """An argument y at the ends of steps (N,), and its cubic within each of the N - 1 steps:
    y + x (r0 + x (c2 + x c3)) with x from 0 to 1."""

    def __init__(self, t: Array, h: Array, q: Array, v: Array, y: Array, rate: Array) -> None:
        self.t, self.h, self.q, self.v, self.y, self.rate = t, h, q, v, y, rate
        dy, self.r0, r1 = np.diff(y), h * rate[:-1], h * rate[1:]
        self.c2, self.c3 = 3.0 * dy - 2.0 * self.r0 - r1, self.r0 + r1 - 2.0 * dy
        self.bend, self.third = (2.0 * self.c2 + 6.0 * self.c3) / h**2, 6.0 * self.c3 / h**3  # at the ends of steps

    def leave_out_rounding(self, noise: float) -> None:
        """Take second and third derivatives at the end of a step from the step before, if they are rounding errors;
        ``noise`` is that of y, and rates are differences of y over the part APART of a step."""
        good = 0.1 * np.abs(self.bend) * self.h**2 * APART > 4.0 * noise
        last = np.maximum.accumulate(np.where(good, np.arange(len(good)), -1))
        self.bend, self.third = (np.where(last < 0, np.nan, x[last]) for x in (self.bend, self.third))


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
        self._of_velocities = [k for k, g in enumerate(self.arguments) if not of_positions(g)]
        self._roots = self.arguments + [der(g) if of_positions(g) else const(np.nan) for g in self.arguments]
        self._most = max(16, min(MOST, NUMBERS // max(1, system.n)))

    def add(
        self,
        found: list[Approach],
        past: Array,
        rows: tuple[Array, Array, Array, Array],
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
        known = np.array(values(self.system, self._roots, t, q, v, lam, given))
        count, h = len(self.arguments), np.diff(t)
        sizes = np.fmax(past[4], np.abs(known[:count]).max(axis=1))
        near = {
            k: _turning(np.append(past[0, k], known[k]), CLOSE * sizes[k]) if known[k].any() else np.zeros(0, np.int64)
            for k in self._of_velocities  # the reaction of an open contact is zero
        }
        a = self._accelerations(near.values(), rows, inputs, left_out)
        with np.errstate(all="ignore"):
            far = _far(h, known[:count], known[count:], past[0], CLOSE * sizes)
            for k, (y, rate) in enumerate(zip(known[:count], known[count:], strict=True)):
                largest = sizes[k]
                if k in near and not y.any():
                    past[:, k] = 0.0, np.nan, np.nan, np.nan, largest
                    continue
                if k not in near and far[k]:
                    last = _Course(t[-2:], h[-1:], q[-2:], v[-2:], y[-2:], rate[-2:])
                    past[:, k] = y[-1], rate[-1], last.bend[-1], last.third[-1], largest
                    continue
                if k in near and len(near[k]):
                    rate[near[k]] = self._rates(k, near[k], a, rows, inputs, left_out)
                before = past[:, k].copy()
                course = _Course(t, h, q, v, y, rate)
                if k in near:
                    course.leave_out_rounding(EPS * largest)
                past[:, k] = y[-1], rate[-1], course.bend[-1], course.third[-1], largest
                self._turns(found, k, course, before[3], largest)
                self._crossings(found, k, course, before, largest)
        if len(found) > 2 * self._most:
            found.sort(key=lambda x: abs(x.d) / past[4, x.number])
            del found[self._most :]
            found.sort(key=lambda x: x.t)

    def _turns(self, found: list[Approach], k: int, on: _Course, third: float, largest: float) -> None:
        """Add the turning points within steps that do not cross; ``third`` is the last third derivative before."""
        positions, h, y = k not in self._of_velocities, on.h, on.y
        least = 0.0 if positions else AT_SWITCH * largest
        change = np.abs(np.diff(on.third, prepend=third))
        error = h**3 / 384.0 * np.fmin(np.fmin(change, np.append(change[1:], np.inf)), np.abs(on.third))
        side = np.where(y[:-1] != 0.0, np.sign(y[:-1]), np.sign(on.r0))
        x, turns = _minimum(side * on.r0, side * on.c2, side * on.c3)
        d = side * (y[:-1] + x * (on.r0 + x * (on.c2 + x * on.c3)))
        stays = (side * y[1:] >= least) & (side * y[:-1] >= least) & self._is_side(k, side)
        if k in self.contacts:  # a closed gap, and one that opens or closes, turns by rounding
            rounding = ROUNDED * self.system.tables.size
            turns &= (d > rounding) | (np.abs(y[:-1] - d) > rounding) | (np.abs(y[1:] - d) > rounding)
        for i in np.flatnonzero(turns & stays & (np.abs(d) <= CLOSE * largest)).tolist():
            at, q, v = x[i], on.q, on.v
            dq, a, b = q[i + 1] - q[i], h[i] * v[i], h[i] * v[i + 1]
            c, e = 3.0 * dq - 2.0 * a - b, a + b - 2.0 * dq
            state = [*q[i] + at * (a + at * (c + at * e)), *(a + at * (2.0 * c + at * 3.0 * e)) / h[i]]
            if self.system.scene.spatial:
                state = [*q[i + round(at)], *v[i + round(at)]]
            curvature = abs(2.0 * on.c2[i] + 6.0 * at * on.c3[i]) / h[i] ** 2
            # behind zero within a step that did not meet the condition: as uncertain as it is deep
            off = max(error[i], 0.0 if positions else -d[i])
            found.append(_approach(k, on.t[i] + at * h[i], side[i], d[i], curvature, off, state))

    def _crossings(self, found: list[Approach], k: int, on: _Course, before: Array, largest: float) -> None:
        """Add crossings between consecutive rows, beginning with the last row of the previous call: ``before`` is its
        column of ``past``."""
        y, positions = on.y, k not in self._of_velocities
        value, slope = np.append(before[0], y[:-1]), np.append(before[1], on.rate[:-1])
        bends, jerks = (np.concatenate([[z, z], x[:-1]]) for z, x in ((before[2], on.bend), (before[3], on.third)))
        side = np.sign(value)
        slope, bends = side * slope, side * bends
        d = side * value - slope**2 / (2.0 * bends)
        crosses = (side * y < 0.0) & (slope < 0.0) & (bends > 0.0) & (np.abs(d) <= CLOSE * largest)
        crosses &= self._is_side(k, side)
        for i in np.flatnonzero(crosses).tolist():
            j = max(i - 1, 0)
            curvature = side[i] * self._second(k, on.t[j], on.q[j], on.v[j]) if i and positions else bends[i]
            if curvature > 0.0:
                # at least so deep, if the third derivative, perhaps that of another contact, pushes back
                third = abs(jerks[i])
                rest = -2.0 * slope[i] / (curvature + np.sqrt(curvature**2 - 2.0 * third * slope[i]))
                d_i = side[i] * value[i] + rest * (slope[i] + rest * (0.5 * curvature + rest * third / 6.0))
                d_i = min(d_i, side[i] * y[i])
                found.append(_approach(k, on.t[j], side[i], d_i, curvature, 0.0, [*on.q[j], *on.v[j]]))

    def _is_side(self, k: int, side: Array) -> NDArray[np.bool_]:
        """Whether there is motion on this side of zero: gaps of rigid contacts below zero are rounding errors."""
        return (side > 0.0) | (k not in self.contacts)

    def _rates(
        self,
        k: int,
        at: Integers,
        a: Array,
        rows: tuple[Array, Array, Array, Array],
        inputs: Mapping[str, float],
        left_out: tuple[int, ...],
    ) -> Array:
        """The time derivatives of argument k at the rows ``at`` with accelerations a (N, n), by central differences
        along the motion; nan where there are no accelerations."""
        system, g, (t, q, v, _) = self.system, self.arguments[k], rows
        h, of_reactions = np.diff(t), any(x.op == "multiplier" for x in leaves(g))
        dt, given = APART * h[np.minimum(at, len(h) - 1)], {x: np.full(len(at), value) for x, value in inputs.items()}
        t, q, v, a, ends = t[at], q[at], v[at], a[at], []
        for s in (-dt[:, None], dt[:, None]):
            there = t + s[:, 0], system.moved(q, s * v, 0.5 * s * s * a), v + s * a
            lam = np.zeros((len(at), system.m + system.p))
            for i in np.flatnonzero(np.isfinite(a).all(axis=1)).tolist() if of_reactions else ():
                try:
                    lam[i] = accelerations(system, there[0][i], there[1][i], there[2][i], left_out)[1]
                except InitialisationError:
                    lam[i] = np.nan
            ends.append(values(system, [g], *there, lam, given)[0])
        return (ends[1] - ends[0]) / (2.0 * dt)

    def _accelerations(
        self,
        rows: Iterable[Integers],
        states: tuple[Array, Array, Array, Array],
        inputs: Mapping[str, float],
        left_out: tuple[int, ...],
    ) -> Array:
        """Those (N, n) at the ``rows`` of ``states``; nan at others, and where there are none."""
        system, (t, q, v, _) = self.system, states
        at, found = np.unique(np.concatenate([np.zeros(0, np.int64), *rows])), np.full_like(q, np.nan)
        if not len(at):
            return found
        numbers = {system.tables.inputs[x]: np.full(len(at), value) for x, value in inputs.items()}
        together = sampled(system, t[at], q[at], v[at], left_out, numbers, FEW)
        done = np.zeros(len(at), bool)
        if together is not None:
            found[at], _, done = together
        for i in at[~done].tolist():
            try:
                found[i] = accelerations(system, t[i], q[i], v[i], left_out)[0]
            except InitialisationError:
                found[i] = np.nan
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


def _turning(y: Array, near: float) -> Integers:
    """The ends of steps (of y without its first entry, which precedes them) where an argument turns back or changes its
    sign within ``near`` of zero, their neighbours, and close ends at the border of the search."""
    slope = np.diff(y)
    turns, crosses = np.zeros(len(y), bool), np.zeros(len(y), bool)
    turns[1:-1] = slope[:-1] * slope[1:] <= 0.0
    turns[:3] = turns[-3:] = True
    crosses[1:-1] = (y[:-2] * y[1:-1] < 0.0) | (y[1:-1] * y[2:] < 0.0)
    close = (np.abs(y) <= near) & (y != 0.0)
    found: list[Integers] = []
    for kind in (turns & close, crosses & close & ~turns):  # the closest of each
        at = np.flatnonzero(kind)
        found.append(at[np.argsort(np.abs(y[at]), kind="stable")[: MOST_RATES // 2]])
    at = np.concatenate(found)
    wide = np.zeros(len(y) + 3, bool)
    for k in range(4):  # with both neighbours, and the one before, which crossings need
        wide[at + k] = True
    return np.flatnonzero(wide[2 : len(y) + 2][1:])


def _minimum(c1: Array, c2: Array, c3: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The x in [0, 1) at which c1 x + c2 x^2 + c3 x^3 has a minimum, and whether there is one."""
    with np.errstate(all="ignore"):
        root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
        # of the two stationary points the one with a positive second derivative
        x = np.where(c2 + root != 0.0, -c1 / (c2 + root), np.nan)
    turns = (c2 * c2 > 3.0 * c1 * c3) & (x >= 0.0) & (x < 1.0)
    return np.where(turns, x, 0.0), turns
