"""Time events: changes of switches that depend on time alone, which are known in advance.

They are found for expressions that are piecewise linear in time: between two corners, such an expression has the value
of a level where the straight line through two of its points does. There may be infinitely many events (a periodic
table, mod); therefore they are generated one by one.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain, pairwise

import numpy as np

from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import Expr, evaluate, leaves, walk
from mbdsl.system.switches import CONDITIONS, ENDS, KNOTS, Switch, table_events

#: levels in ascending order, and the period in which they repeat (None: they do not)
Levels = tuple[list[float], float | None]
#: operations that keep a function piecewise linear
LINEAR = ("time", "add", "sub", "neg", "abs", "sign", "min", "max", "floor", "ceil", "select", *CONDITIONS)
#: events closer than this number of units in the last place are one event
ULPS = 64


def time_events(switches: list[Switch], t0: float, t1: float) -> Iterator[float]:
    """Times at which ``switches`` change within (t0, t1), for expressions that are piecewise linear in time."""
    sources = dict.fromkeys(node for switch in switches for node in _alone(switch.node))
    return _apart(heapq.merge(*(_seen(node, _events(node, t0, t1), t0, t1) for node in sources)))


def _alone(node: Expr) -> Iterator[Expr]:
    """The parts of a switch that depend on time alone: all of it, or conditions that it is composed of."""
    found = leaves(node)
    if found and all(leaf.op == "time" for leaf in found):
        yield node
    elif node.op in ("and", "or", "not"):
        for x in node.args:
            yield from _alone(x)


def _seen(node: Expr, times: Iterator[float], t0: float, t1: float) -> Iterator[float]:
    """The times at which a condition changes: not all corners of the compared expressions change it."""
    if node.op not in CONDITIONS:
        yield from times
        return
    last, before = t0, None
    for t, behind in pairwise(chain(times, [t1])):
        before = _at(node, 0.5 * (last + t)) if before is None else before
        after = _at(node, 0.5 * (t + behind))
        if after != before:
            yield t
        last, before = t, after


def _close(t: float) -> float:
    return ULPS * float(np.spacing(abs(t)))


def _apart(times: Iterable[float]) -> Iterator[float]:
    last = -np.inf
    for t in times:
        if t - last > _close(t):
            yield t
            last = t


def _events(node: Expr, t0: float, t1: float) -> Iterator[float]:
    """Corners and jumps in (t0, t1) of a node that depends on time alone."""
    corners = [x for x in node.args if leaves(x)]
    measured = _measured(node)
    if measured is not None and is_linear(measured[0]):
        return _apart(_with_levels(*measured, corners, t0, t1))
    return _apart(heapq.merge(*(_events(x, t0, t1) for x in corners)))


def _measured(node: Expr) -> tuple[Expr, Levels] | None:
    """The expressions that determine the state of a node, and their levels."""
    a = node.args
    if node.op in ("lt", "le", "eq", "ne", "min", "max"):
        return a[0] - a[1], ([0.0], None)
    if node.op in ("abs", "sign"):
        return a[0], ([0.0], None)
    if node.op in ("floor", "ceil"):
        return a[0], ([0.0], 1.0)
    if node.op == "mod":
        return a[0] / a[1], ([0.0], 1.0)
    return (a[0], _knots(node)) if node.op == "table" else None


def _knots(node: Expr) -> Levels:
    """The arguments at which the derivative of a node's table has its events."""
    table, _ = node.value
    which = table_events(node)
    inner = list(table.u[1:-1]) if which & KNOTS else []
    first, last = table.u[0], table.u[-1]
    if table.extrapolation == "periodic":
        return ([first] if which & ENDS else []) + inner, last - first
    return ([first, *inner, last] if which & ENDS else inner), None


def is_linear(root: Expr) -> bool:
    """Whether ``root`` is piecewise linear in time."""
    return all(_keeps_linear(node) for node in walk(root) if leaves(node))


def _keeps_linear(node: Expr) -> bool:
    if node.op == "table":
        table, order = node.value
        return table.smoothness == "linear" or len(table.u) == 2 or order > 2
    if node.op == "mul":
        return any(not leaves(x) for x in node.args)
    return node.op in LINEAR or (node.op in ("div", "mod") and not leaves(node.args[1]))


def _with_levels(x: Expr, levels: Levels, corners: list[Expr], t0: float, t1: float) -> Iterator[float]:
    """Corners of the arguments, and between them the times at which x equals a level."""
    start = t0
    for corner in heapq.merge(*(_events(y, t0, t1) for y in corners)):
        yield from _crossings(x, levels, start, corner)
        yield corner
        start = corner
    yield from _crossings(x, levels, start, t1)


def _crossings(x: Expr, levels: Levels, start: float, end: float) -> Iterator[float]:
    """The times at which x, linear in (start, end), equals a level."""
    quarter = 0.25 * (end - start)
    ta, tb = start + quarter, end - quarter
    if not start < ta < tb < end:
        return
    xa, xb = _at(x, ta), _at(x, tb)
    slope = (xb - xa) / (tb - ta)
    if slope == 0.0 or not np.isfinite(slope):
        return
    for level in _between(levels, xa - quarter * slope, xb + quarter * slope):
        t = ta + (level - xa) / slope
        if start < t < end:
            t -= (_at(x, t) - level) / slope  # rounding errors of a long interval
        if start < t < end:
            yield t


def _between(levels: Levels, a: float, b: float) -> Iterator[float]:
    """The levels between a and b, in this direction."""
    values, period = levels
    way = 1 if b > a else -1
    if period is None or not values:
        yield from (x for x in values[::way] if min(a, b) <= x <= max(a, b))
        return
    first, last = (int(np.floor((x - values[0]) / period)) for x in (a, b))
    for lap in range(first - way, last + 2 * way, way):
        yield from (x + lap * period for x in values[::way])


def _at(x: Expr, t: float) -> float:
    with np.errstate(all="ignore"):
        value = evaluate([x], lambda leaf: np.float64(t), ARRAY_OPERATIONS, table_value, order=_order(x))
    return float(value[0])


@lru_cache(maxsize=64)
def _order(x: Expr) -> list[Expr]:
    """The nodes of an expression in order; those of the last expressions, each of which is evaluated many times."""
    return walk(x)
