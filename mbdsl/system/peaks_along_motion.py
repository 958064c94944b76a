"""Peaks of laws between two states of a motion that the values at these states do not show.

Between two states, the coordinates of frames are interpolated by the cubic polynomials through positions and velocities
at both ends; reactions and time are linear. Along this path a law is a function of one variable, and its peaks are
found like those of functions of time (:mod:`mbdsl.system.peaks_in_time`): narrow springs, windows of position or speed.
Only terms that are not polynomials of low degree are searched.

In space, a law depends on joint coordinates, which are products of the components of axes, and angles between them
(:mod:`mbdsl.expressions.spatial_coordinates`); in the plane, ropes have angles that count turns. Each of these is
interpolated itself, by the cubic polynomial through four points: bounds on products of components would be too wide.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.derivatives import der
from mbdsl.expressions.interval_arithmetic import CONDITIONS
from mbdsl.expressions.spatial_coordinates import AXES
from mbdsl.expressions.symbolic import RATE, TIME, Expr, coordinate, leaves, rebuild, walk
from mbdsl.kernels.arrays import Array
from mbdsl.system.interval_tape import TINY
from mbdsl.system.paths import Looks, Paths, Program, Work
from mbdsl.system.peaks_in_time import Zone, hiding, terms, zones
from mbdsl.system.signals import values

if TYPE_CHECKING:
    from mbdsl.system.system import System


#: shortest step that is searched, and shortest interval in it, relative to the shortest possible step
SHORT, SHORTEST = 4.0, 0.1
#: the same of a step in which a condition is not searched further if its bounds need too many intervals: behind a
#: lift-off, they do in every step, however short, because gaps are differences of positions
BRIEF = 1e7
#: rounding error of positions, relative to them; if the displacement in a step differs by no more than that from the
#: one with a linear velocity, the velocity is taken as linear
LOST = 64.0 * np.finfo(float).eps
#: a smooth peak wider than this part of a step needs no zone, unless it is higher than this part of the largest value
WIDE, HIGH = 0.4, 0.25
JUMPS = (*CONDITIONS, "sign", "floor", "ceil", "mod", "table", "abs", "min", "max")
#: operations of joint coordinates in space, their largest degree in positions and velocities, and the key of the leaves
#: that stand for them
PRODUCTS, MOST_FACTORS, JOINT = ("add", "sub", "neg", "mul", "div"), 3, "joint"
#: coefficients of the cubic polynomial with given values at 0, 1/3, 2/3 and 1
THROUGH = np.linalg.inv(np.vander(np.arange(4) / 3.0, increasing=True))
LENGTHS = ("x", "y", "z")
POSITION = {rate: key for key, rate in RATE.items()} | {"vz": "z"}


class Turns(NamedTuple):
    """Values of angles that count turns, at the first (0) or the last (-1) of several states."""

    at: int
    angles: Mapping[Expr, float]


UNCOUNTED = Turns(0, {})


#: operations that the search of any run may take
LEAST = 1e6
#: what a run keeps of its search: the number of operations, of steps, and the time since which it is given up [s]
OPERATIONS, STEPS, GIVEN_UP = range(3)


def not_searched() -> Array:
    """The same at the start of a run."""
    return np.array([0.0, 0.0, np.inf])


class OnTheWay:
    """The terms of a system that may have a hidden peak between two states.

    The search of a run may take ``AT_ONCE`` operations and ``A_STEP`` more in each step, with the program of all terms
    as a unit; laws with jumps and narrow windows take a hundredth of that. An operation takes 20 ns to 50 ns.
    """

    AT_ONCE, A_STEP = 1e3, 1e2

    def __init__(self, system: System) -> None:
        self._system = system
        roots: dict[Expr, Expr] = {}
        # of gaps and slips only the signs count
        whole = {c.condition for c in system.scene.contacts} if system.scene.spatial else set()
        for root, law in system.searched_laws.items():
            law = _in_joint_coordinates(law) if system.counts_angles else law
            for term in [law] if root in whole else hiding([law]):
                if any(n.op in ("coordinate", "multiplier") for n in leaves(term)):
                    roots.setdefault(term, root)
        self.terms = list(roots)
        self._roots = list(roots.values())
        self._jumps = [any(n.op in JUMPS for n in walk(x)) for x in self.terms]
        self._programs: dict[int, Program] = {}
        self.spent = 0  #: operations so far, of all searches of all runs

    @cached_property
    def _summands(self) -> dict[Expr, Program]:
        """With joint coordinates: the terms that the law of each root is a sum of, as a program."""
        laws = self._system.searched_laws
        return {x: Program(terms(_with_counted_angles(laws[x]))) for x in self._roots if self._system.counts_angles}

    @cached_property
    def _leaves(self) -> list[Expr]:
        """The leaves of all programs."""
        return leaves(*self.terms, *(x for program in self._summands.values() for x in program.roots))

    @cached_property
    def _program(self) -> Program:
        """The program of all terms."""
        return Program(self.terms)

    @cached_property
    def _joints(self) -> dict[Expr, Expr]:
        """The leaves that stand for operations of joint coordinates, and these operations."""
        found = [x for x in self._leaves if x.op == "coordinate" and x.value[1] == JOINT]
        return {x: x.value[0] for x in found}

    @cached_property
    def _joint_program(self) -> Program:
        return Program(self._joints.values())

    @cached_property
    def _motions(self) -> dict[Expr, tuple[Expr, Expr] | None]:
        """The leaves that the states of a system determine, with their positions and rates; None of other leaves."""
        own = [*(x for x in self._leaves if x not in self._joints), *leaves(*self._joints.values())]
        return {x: _position(x) if x.op == "coordinate" else None for x in own if x.op != "input"}

    @cached_property
    def _states(self) -> tuple[list[tuple[Expr, Expr]], list[Expr], list[Expr], dict[Expr, int]]:
        """Positions and rates; these and other leaves except time; the nodes of all in order; and the place of each
        leaf in the list of all, time last."""
        moving = list(dict.fromkeys(x for x in self._motions.values() if x is not None))
        others = [x for x, motion in self._motions.items() if motion is None and x.op != "time"]
        known = [*(x for both in moving for x in both), *others]
        return moving, known, walk(*known), {x: [*known, TIME].index(x) for x in self._motions}

    @cached_property
    def _sizes(self) -> Array:
        """The mechanism's size for each position of ``_states``, 0 of angles: a point of a body near zero has the
        rounding error of the body's position."""
        size = self._system.tables.size
        return np.array([size if where.value[1] in LENGTHS else 0.0 for where, _ in self._states[0]])

    def first(
        self,
        states: tuple[Array, Array, Array, Array],
        inputs: Mapping[str, float],
        least: float,
        seen: Array,
        searched: Array,
        turns: Turns = UNCOUNTED,
    ) -> list[Zone]:
        """Zones (in time) of the first step in which a term has a hidden peak.

        The states are t (K + 1,), q and v (K + 1, n), and lam (K + 1, m + p). No step is shorter than ``least`` [s].
        Angles that count turns have the values ``turns`` at one of the ends; q contains them up to turns.
        ``seen`` is the largest magnitude of each term at the ends of steps so far, which the run keeps; it is updated
        if nothing is found. ``searched`` (3,), which the run keeps too, counts the operations and steps so far, and is
        updated; where the operations exceed the credit, the search is given up, and its last entry is that time. The
        result does not depend on how many steps are searched together.
        """
        t, q, v, lam = states
        if t[0] >= searched[GIVEN_UP]:
            return []
        h, count = np.diff(t), len(t) - 1
        with np.errstate(all="ignore"):
            ways = self._ways(t, q, v, lam, turns)
            found: list[Zone] = []
            looks = self._suspected(self._program.of(ways, inputs), h >= SHORT * least, seen)
            sizes: dict[Expr, Array] = {}
            granted = self.AT_ONCE + self.A_STEP * (searched[STEPS] + np.arange(1.0, count + 1.0))
            work = Work(LEAST + self._program.length * granted - searched[OPERATIONS])
            for n in np.flatnonzero(looks.suspected.any(axis=0)).tolist() if looks.any else ():
                until = min(count, work.until)
                slight, steps = looks.slight[:, n].copy(), np.flatnonzero(looks.suspected[:until, n])
                if self._system.counts_angles and len(steps):
                    slight += TINY * self._size(self._roots[n], sizes, ways, inputs)
                    steps = steps[looks.excess[steps, n] > slight[steps]]
                f = self._alone(n).of(ways, inputs)
                if hidden := self._hidden(n, f, steps, least / h, looks.size[:, n].copy(), slight, work):
                    count, parts = hidden
                    t0, dt = t[count], h[count]
                    found = [Zone(t0 + dt * a, t0 + dt * b, self._roots[n]) for a, b in parts]
        self.spent += int(work.each.sum())
        if found and count < work.until:
            searched[OPERATIONS] += work.each[count]
            return found
        searched[OPERATIONS] += work.each.sum()
        searched[STEPS] += len(h)
        if work.until < len(h):
            searched[GIVEN_UP] = t[work.until]
        seen[:] = looks.size[-1]
        return []

    def _alone(self, n: int) -> Program:
        """The program of term number n."""
        if n not in self._programs:
            self._programs[n] = Program(self.terms[n : n + 1])
        return self._programs[n]

    def _size(
        self, root: Expr, known: dict[Expr, Array], ways: Mapping[Expr, Array], inputs: Mapping[str, float]
    ) -> Array:
        """The magnitude (K,) of the largest term of a law in each step.

        Products with a component of an axis that is zero are rounding relative to it; their peaks have no meaning."""
        if root not in known:
            f = self._summands[root].of(ways, inputs)
            k = np.arange(f.pieces)
            ends = [f.at(k, np.full(f.pieces, s)) for s in (0.0, 1.0)]
            known[root] = np.nan_to_num(np.abs(ends), posinf=0.0).max(axis=(0, 2))
        return known[root]

    def _suspected(self, f: Paths, resolved: NDArray, seen: Array) -> Looks:
        """The steps in which the bounds of terms exceed their values at the ends by more than a negligible height."""
        return f.look(resolved, seen)

    def _ways(self, t: Array, q: Array, v: Array, lam: Array, turns: Turns) -> dict[Expr, Array]:
        """Coefficients (K, 4) of the polynomials for the leaves, over the completed part of a step (0 to 1)."""
        found, joints = self._of_states(t, q, v, lam), self._joints
        if joints:
            points, k = np.tile(np.arange(4) / 3.0, len(t) - 1), np.repeat(np.arange(len(t) - 1), 4)
            known = self._joint_program.of(found, {}).at(k, points)
            for (x, composite), y in zip(joints.items(), known.T, strict=True):
                if composite.op == "angle":
                    y = np.unwrap(y)
                    if composite in turns.angles:
                        y += 2.0 * np.pi * np.round((turns.angles[composite] - y[turns.at]) / (2.0 * np.pi))
                found[x] = _through(y.reshape(-1, 4), composite.op == "angle")
        return found

    def _of_states(self, t: Array, q: Array, v: Array, lam: Array) -> dict[Expr, Array]:
        """The same for the leaves that the states determine."""
        moving, roots, order, places = self._states
        known = values(self._system, roots, t, q, v, lam, None, order)
        at, count = np.array([*known, t]), 2 * len(moving)
        p, r, h = at[0:count:2], at[1:count:2], np.diff(t)
        way, r0, r1 = np.diff(p, axis=1), h * r[:, :-1], h * r[:, 1:]
        sizes = np.maximum(np.abs(p), self._sizes[:, None])
        known_way = np.abs(way - 0.5 * (r0 + r1)) > LOST * np.maximum(sizes[:, :-1], sizes[:, 1:])
        way = np.where(known_way, way, 0.5 * (r0 + r1))
        c2, c3 = 3.0 * way - 2.0 * r0 - r1, r0 + r1 - 2.0 * way
        found = np.zeros((len(at), len(h), 4))  # positions and rates in turn, then straight lines
        found[:, :, 0] = at[:, :-1]
        found[0:count:2, :, 1], found[0:count:2, :, 2], found[0:count:2, :, 3] = r0, c2, c3
        found[1:count:2, :, 1], found[1:count:2, :, 2] = 2.0 * c2 / h, 3.0 * c3 / h
        found[count:, :, 1] = np.diff(at[count:], axis=1)
        return {x: found[place] for x, place in places.items()}

    def _hidden(
        self, n: int, f: Paths, steps: NDArray, least: Array, size: Array, slight: Array, work: Work
    ) -> tuple[int, list[tuple[float, float]]] | None:
        """The first of ``steps`` in which a term has peaks that the ends do not show, and their zones as parts of the
        step; None if there is no such step."""
        ends = np.tile([0.0, 1.0], (len(steps), 1))
        for k, points in f.monotone(0, steps, ends, SHORTEST * least, size, slight, work):
            if points is None and self._jumps[n] and least[k] * BRIEF > 1.0:
                continue
            if points is None:  # a shorter step needs fewer intervals
                return k, [(0.25, 0.75)]
            found = [(a, b) for a, b in zones(f, k, points, float(slight[k])).T.tolist() if a > 0.0 and b < 1.0]
            if not found:
                continue
            wide = len(found) == 1 and found[0][1] - found[0][0] >= WIDE and np.ptp(points.y) <= HIGH * size[k]
            if self._jumps[n] or not wide:
                return k, found
        return None


def _through(y: Array, angles: bool) -> Array:
    """Coefficients (K, 4) of the cubic polynomials through y (K, 4) at 0, 1/3, 2/3 and 1.

    Axes have rounding errors relative to 1, and angles between them those in radians: if an angle differs by no more
    than that from a linear one, it is taken as linear. The angle of a joint that does not move is rounding alone.
    """
    c = y @ THROUGH.T
    straight = np.abs(c[:, 2:]).sum(axis=1) <= LOST * np.maximum(np.abs(y).max(axis=1), 1.0)
    if angles and straight.any():
        c[straight, 1] = y[straight, 3] - y[straight, 0]
        c[straight, 2:] = 0.0
    return c


def _in_joint(n: Expr) -> Expr:
    """A leaf in place of an expression in joint coordinates."""
    return Expr("coordinate", (), (n, JOINT))


def _in_joint_coordinates(law: Expr) -> Expr:
    """``law`` with leaves in place of angles between axes, their rates, and polynomials with components of axes."""
    new: dict[Expr, Expr] = {}
    joint: dict[Expr, bool] = {}
    order = walk(law)
    factors: dict[Expr, float] = {}
    for n in order:
        factors[n] = _factors(n, [factors[x] for x in n.args])
        joint[n] = n.op == "angle" or (
            n.op in PRODUCTS
            and factors[n] <= MOST_FACTORS
            and any(x.op == "coordinate" and x.value[1] in AXES for x in leaves(n))
        )
    for n in order:
        if joint[n]:
            new[n] = _in_joint(n)
        elif n.args and any(new[a] is not a for a in n.args):
            new[n] = rebuild(n, [new[a] for a in n.args])
        else:
            new[n] = n
    return new[law]


def _with_counted_angles(law: Expr) -> Expr:
    """``law`` with leaves in place of angles between axes."""
    new: dict[Expr, Expr] = {}
    for n in walk(law):
        same = all(new[a] is a for a in n.args)
        new[n] = _in_joint(n) if n.op == "angle" else n if same else rebuild(n, [new[a] for a in n.args])
    return new[law]


def _factors(n: Expr, of: list[float]) -> float:
    """The degree of a polynomial in positions and velocities with products and quotients of components of axes as
    coefficients; infinite if ``n`` is no such polynomial."""
    if n.op == "coordinate":
        return 0.0 if n.value[1] in AXES else 1.0
    if n.op in ("const", "add", "sub", "neg"):
        return max(of, default=0.0)
    if n.op == "mul":
        return sum(of)
    return of[0] if n.op == "div" and of[1] == 0.0 else np.inf


def _position(x: Expr) -> tuple[Expr, Expr] | None:
    """The position or angle that a leaf is, or whose rate it is; and the rate. None of angular velocities in space."""
    frame, key = x.value
    if key in ("wx", "wy", "wz"):
        return None
    where = coordinate(frame, str(POSITION.get(key, key)))
    return where, der(where)
