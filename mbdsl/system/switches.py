"""Switches: jumps and corners of expressions, at branches of an `if`, the sign of a speed, or a corner of a table.

Between two changes the equations of motion are smooth; a step across one loses its order. The state of a switch is an
integer that follows from (t, q, v, lam), read from the registers after the tape has run:

    truth of a condition          `if`; expressions in a condition matter only through its truth
    value of sign, floor, ceil    the integer itself
    order of two arguments        min and max; abs, whose argument is compared with zero
    whole quotient                mod(a, b): floor(a/b)
    cell of a table               if its slope jumps at knots, or at the ends, beyond which another formula applies

In a branch that is not taken the state is 0. Only laws, drivers and nonholonomic constraints have switches; output
signals have none. abs, min and max of reactions have none either: they are continuous, and a reaction that is zero up
to rounding would switch at every step.

A record, at layout[layout[SWITCHES] + k]: the operation, two operands, the relevant events of a table, number of
guards; per guard the register of a condition and its required truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

from numpy import floor

from mbdsl.compilation import code_cache
from mbdsl.expressions.symbolic import QUIET, Expr, const, leaves, walk
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import rare
from mbdsl.numerics.piecewise_cubic import SMOOTHNESS
from mbdsl.system.expression_tape import Tape, cell_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mbdsl.mechanism.scene import Component, Scene

TRUTH, VALUE, ORDER, QUOTIENT, CELL = range(5)
#: an operation, and the registers or quantities that it takes
Quantity: TypeAlias = tuple[Any, ...]
#: which points of a table are events
KNOTS, ENDS = 1, 2
CONDITIONS = ("lt", "le", "eq", "ne", "and", "or", "not")
COMPARED = ("abs", "min", "max")
#: of the signature; a prime, so that the change of a single switch always changes the signature
PRIME, BASE = 2147483647, 1000003


@dataclass(frozen=True)
class Switch:
    """A node of an expression that switches, and the conditions (with their truth) under which it is used.

    ``of_force`` is true if only forces depend on it: accelerations then jump with them.
    """

    node: Expr
    guards: tuple[tuple[Expr, bool], ...] = ()
    of_force: bool = True

    @property
    def is_corner(self) -> bool:
        """Whether accelerations are continuous, as far as the node itself shows this."""
        if self.node.op == "table":
            table, order = self.node.value
            closed = table.extrapolation != "periodic" or table.y[0] == table.y[-1]
            return self.of_force and order == 0 and table.extrapolation != "error" and closed
        return self.of_force and self.node.op in COMPARED


def find(forces: Iterable[Expr], demands: Iterable[Expr] = ()) -> list[Switch]:
    """The switches of forces, and of prescribed positions and velocities."""
    demands = list(demands)
    demanded = {switch.node for switch in _find(demands)}
    found = _find([*forces, *demands])
    return [replace(switch, of_force=switch.node not in demanded) for switch in found]


def _find(roots: list[Expr]) -> list[Switch]:
    guards: dict[Expr, dict[tuple[Expr, bool], None]] = {root: {} for root in roots}
    found = []

    def reach(node: Expr, own: dict[tuple[Expr, bool], None]) -> None:
        # a node used in several places is used under the conditions common to all of them
        guards[node] = {g: None for g in guards.get(node, own) if g in own}

    for node in reversed(walk(*roots)):  # users of a node come before it
        if node not in guards:
            continue  # it is below a condition
        own = guards[node]
        if _switches(node):
            found.append(Switch(node, tuple(own)))
        if node.op in CONDITIONS:
            continue
        for k, argument in enumerate(node.args):
            arm = {(node.args[0], k == 1): None} if node.op == "select" and k else {}
            reach(argument, {**own, **arm})
    return found[::-1]


def law_of(scene: Scene, nodes: Iterable[Expr]) -> Component | None:
    """The first component with a law or a condition, of contacts and friction, in which one of the ``nodes`` occurs."""
    wanted = set(nodes)
    conditions = {x.name: x.condition for x in scene.contacts} | {x.name: x.condition for x in scene.sticking}
    for c in scene.components.values():
        laws = [c.values[p.name] for p in c.kind.parameters if p.law and isinstance(c.values[p.name], Expr)]
        laws += [conditions[c.name]] if c.name in conditions else []
        if wanted & set(walk(*laws)):
            return c
    return None


def within(term: Expr, switches: Iterable[Switch]) -> list[Switch]:
    """The ``switches`` in a term."""
    nodes = set(walk(term))
    return [switch for switch in switches if switch.node in nodes]


def _switches(node: Expr) -> bool:
    if node.value == QUIET:
        return False
    if node.op == "table":
        return table_events(node) != 0
    if node.op in COMPARED:
        return all(leaf.op != "multiplier" for leaf in leaves(node))
    return node.op in CONDITIONS or node.op in ("sign", "floor", "ceil", "mod")


def table_events(node: Expr) -> int:
    """Whether the knots and the ends of a table's derivative are events: it has corners or jumps there."""
    table, order = node.value
    smooth, nothing = SMOOTHNESS[table.smoothness if len(table.u) > 2 else "linear"]
    if order >= nothing:
        return 0
    knots = KNOTS if smooth <= order and len(table.u) > 2 else 0
    if table.extrapolation == "periodic":
        closed = smooth == 2 and table.y[0] == table.y[-1]
        return knots | (ENDS if knots or not closed else 0)
    if table.extrapolation == "linear":
        return knots | (ENDS if smooth > 0 and order > 0 else 0)
    return knots | ENDS


def tabulate(switches: list[Switch], buffers, tape: Tape) -> list[Quantity]:
    """Records of ``switches``, whose registers are on the tape, and their quantities."""
    records = [_record(switch, tape) for switch in switches]
    buffers.layout[L.SWITCHES] = buffers.ints([buffers.ints(record) for record in records])
    buffers.layout[L.N_SWITCHES] = len(records)
    return [_quantity(switch.node, tape) for switch in switches]


def _quantity(node: Expr, tape: Tape) -> Quantity:
    op = {"abs": "lt", "min": "lt", "max": "lt", "le": "lt"}.get(node.op, node.op)
    if op == "lt":
        first, second = (*node.args, const(0.0))[:2]
        return op, tape.register(first), tape.register(second)
    if op in ("and", "or", "not"):
        return op, *(_quantity(x, tape) for x in node.args)
    return "truth" if op in CONDITIONS else "", tape.register(node)


def quantity(of: Quantity, registers: NDArray[np.float64]) -> float:
    """A number that is positive where a condition is true and negative where it is false; infinite or nan if no
    number shows how far the condition is from its change."""
    op, *args = of
    if op == "lt":
        return float(registers[args[1]] - registers[args[0]])
    if op in ("and", "or"):
        return (min if op == "and" else max)(quantity(x, registers) for x in args)
    if op == "not":
        return -quantity(args[0], registers)
    return (math.inf if registers[args[0]] != 0.0 else -math.inf) if op else math.nan


def _record(switch: Switch, tape: Tape) -> list[int]:
    node = switch.node
    a = [tape.add(x) for x in node.args]
    if node.op in CONDITIONS:
        head = [TRUTH, tape.add(node), 0, 0]
    elif node.op in COMPARED:
        head = [ORDER, a[0], a[1] if len(a) > 1 else tape.add(const(0.0)), 0]
    elif node.op == "mod":
        head = [QUOTIENT, *a, 0]
    elif node.op == "table":
        head = [CELL, a[0], tape.tables.index(node.value[0]), table_events(node)]
    else:
        head = [VALUE, tape.add(node), 0, 0]
    return [*head, len(switch.guards), *(x for c, truth in switch.guards for x in (tape.add(c), int(truth)))]


@rare
def whole(x):
    """The largest integer <= x; 0 if x is not finite."""
    return int(floor(x)) if abs(x) < 1e15 else 0


@rare
def state(k, numbers, layout):
    """The state of switch k, from the registers."""
    o, r = layout[layout[L.SWITCHES] + k], layout[L.REGISTERS]
    for g in range(layout[o + 4]):
        if (numbers[r + layout[o + 5 + 2 * g]] != 0.0) != (layout[o + 6 + 2 * g] != 0):
            return 0
    kind, a = layout[o], numbers[r + layout[o + 1]]
    if kind == TRUTH:
        return 1 if a != 0.0 else 0
    if kind == VALUE:
        return whole(a)
    if kind == CELL:
        return cell_of(
            a,
            layout[L.TABLES] + 3 * layout[o + 2],
            (layout[o + 3] & KNOTS) != 0,
            (layout[o + 3] & ENDS) != 0,
            numbers,
            layout,
        )
    b = numbers[r + layout[o + 2]]
    if kind == ORDER:
        return 1 if a < b else 0
    return whole(a / b) if b != 0.0 else 0


@rare
def states(numbers, layout, S):
    """Write the states of all switches into S (N_SWITCHES)."""
    for k in range(layout[L.N_SWITCHES]):
        S[k] = state(k, numbers, layout)


@rare
def signature(numbers, layout):
    """An integer for the states of all switches, which differs if any of them has changed."""
    found = 0
    for k in range(layout[L.N_SWITCHES]):
        found = (found * BASE + state(k, numbers, layout) % PRIME) % PRIME
    return found


def combined(S: Iterable[int]) -> int:
    """The signature of states."""
    found = 0
    for k in S:
        found = (found * BASE + int(k) % PRIME) % PRIME
    return found


@cache
def compiled() -> Callable:
    """``states`` compiled."""
    from mbdsl.system import expression_tape, switches

    text = '''"""Emitted by mbdsl: the states of switches."""

from mbdsl.system import switches


def states(F, I, S):
    switches.states(F, I, S)
'''
    given = {"states": code_cache.Signature(("vector", "ints", "ints"))}
    return code_cache.functions("mbdsl_switches", text, given, lambda: [switches, expression_tape])[0]
