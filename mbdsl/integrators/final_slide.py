"""The end of sliding in several directions, where the direction turns ever faster as the speed becomes zero.

An implicit step across such an end has no solution, and one that ends shortly before it has, but Newton's iteration
does not find it. The motion from the last step to the end is integrated by the explicit method of order 4 of Nystroem
type, with steps that are a part of the time that is left, and whose error is that of two steps of half the length.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mbdsl.integrators.shared_friction import At, motion
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.contacts import SLIDING, SLOW, number
from mbdsl.system import System

#: length of a step, relative to the time that is left and to a step of the run; most of them
PART, MOST = 0.25, 200
#: the end is near if it is expected within this number of steps of the run
WITHIN = 2.0
#: speed, relative to that which counts as rest, below which a slide has just begun; and that of a contact at its end
BEGUN, STOPPED = 10.0, 0.5
#: part of the tolerance that the error of velocities in a step may be, but for rounding; tolerance of fixed steps
OF_TOLERANCE, ROUNDED, FIXED = 0.1, 1e-13, 1e-6


class Slides(Protocol):
    """Joints or contacts that slide in several directions."""

    def time_left(self, at: At, above: float = 0.0) -> float:
        """The time [s] in which the first of them comes to rest, at its present deceleration; of those that are faster
        than ``above`` times the speed that counts as rest."""

    def stopped(self, at: At) -> bool:
        """Whether one of them may be held."""


class End(NamedTuple):
    """The states at steps on the way to the end with the times [s] from the first one, and whether the slide ends."""

    system: System
    nodes: list[tuple[float, At]]
    stopped: bool

    def state(self, s: float) -> tuple[Array, Array]:
        """q and v (n,) at time s [s] from the first state."""
        begin, at = next(x for x in reversed(self.nodes) if x[0] <= s or x is self.nodes[0])
        there = at if s == begin else _stepped(self.system, at, s - begin)
        return there.q, there.v


class ContactSlides:
    """The rigid contacts in space that slide."""

    def __init__(self, system: System) -> None:
        self.system = system
        own = zip(system.scene.contacts, system.tables.contact_rows, strict=True)
        self._rows = [(c.name, list(rows[1:])) for c, rows in own if len(c.slips) > 1]

    def __bool__(self) -> bool:
        return bool(self._rows)

    def _sliding(self, at: At) -> list[tuple[str, list[int]]]:
        return [(name, rows) for name, rows in self._rows if at.numbers[number(name, SLIDING)]]

    def _faster(self, at: At, above: float) -> tuple[Array, list[list[int]]]:
        """The rates of all rows, and the rows of the contacts that slide and are faster than ``above`` times rest."""
        rates = self.system.constraint_rates(at.t, at.q, at.v)
        slow = [(rows, above * at.numbers[number(name, SLOW)]) for name, rows in self._sliding(at)]
        return rates, [rows for rows, least in slow if np.linalg.norm(rates[rows]) > least]

    def time_left(self, at: At, above: float = 0.0) -> float:
        rates, own = self._faster(at, above)
        if not own:
            return np.inf
        a, _ = motion(self.system, at, at.left_out)
        J, gamma_c = self.system.velocity_jacobian(at.t, at.q, at.v), self.system.gamma_c(at.t, at.q, at.v)
        change = J @ a - gamma_c
        square = [(float(rates[rows] @ rates[rows]), -float(rates[rows] @ change[rows])) for rows in own]
        return min((u / braked for u, braked in square if braked > 0.0), default=np.inf)

    def stopped(self, at: At) -> bool:
        return len(self._faster(at, STOPPED)[1]) < len(self._sliding(at))


def final_slide(
    system: System, slides: Sequence[Slides], at: At, h: float, tol: float | None, limits: tuple[float, float]
) -> End | None:
    """The end of a slide that is expected within a few steps of length ``h`` [s], or where another event comes first;
    None if there is none. ``limits``: the shortest step, and the longest way, up to a known event [s]."""
    left = min(x.time_left(at, BEGUN) for x in slides)
    if not left < WITHIN * h:
        return None
    nodes, before, stopped = [(0.0, at)], _switches(system, at), False
    for _ in range(MOST):
        s, at = nodes[-1]
        longest = min(PART * min(left, h), limits[1] - s)
        step, there = _step(system, at, longest, max(OF_TOLERANCE * (tol or FIXED), ROUNDED), limits[0])
        there = there._replace(numbers=dict(at.numbers))
        left = min(x.time_left(there) for x in slides)
        stopped = any(x.stopped(there) for x in slides)
        if not stopped and (_switches(system, there) != before).any():
            break  # another event comes first
        nodes.append((s + step, there))
        if stopped or not s + step + left < 2.0 * WITHIN * h or not s + step + limits[0] < limits[1]:
            break
    return End(system, nodes, stopped) if len(nodes) > 1 else None


def _switches(system: System, at: At) -> NDArray[np.int64]:
    _, lam = motion(system, at, at.left_out)
    return system.switches(at.t, at.q, at.v, lam)


def _step(system: System, at: At, h: float, tol: float, least: float) -> tuple[float, At]:
    """A step of at most h [s], whose error is ``tol`` relative to the largest velocity: its length, and the state."""
    whole = _stepped(system, at, h)
    while True:
        half = _stepped(system, at, h / 2)
        there = _stepped(system, half, h / 2)
        scale = system.tables.scale
        error = float(np.abs((there.v - whole.v) * scale).max(initial=0.0)) / 15.0
        if error <= tol * float(np.abs(there.v * scale).max(initial=0.0)) or h <= 2.0 * least:
            return h, there
        h, whole = h / 2, half


def _stepped(system: System, at: At, h: float) -> At:
    """The state after a step of length h [s]."""
    moved, v = system.moved, at.v

    def rate(s: float, shift: Array, change: Array) -> Array:
        return motion(system, at._replace(t=at.t + s, q=moved(at.q, shift), v=v + change), at.left_out)[0]

    a = rate(0.0, 0.0 * v, 0.0 * v)
    b = rate(h / 2, h / 2 * v + h * h / 8 * a, h / 2 * a)
    c = rate(h / 2, h / 2 * v + h * h / 8 * a, h / 2 * b)
    d = rate(h, h * v + h * h / 2 * c, h * c)
    q = moved(at.q, h * v + h * h / 6 * (a + b + c))
    q, v = onto_constraints(system, at.t + h, q, v + h / 6 * (a + 2 * b + 2 * c + d), at.left_out)
    return at._replace(t=at.t + h, q=q, v=v)
