"""Operations of expressions on arrays, for :func:`mbdsl.expressions.symbolic.evaluate`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbdsl.expressions.symbolic import OPERATIONS, Expr, evaluate
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.piecewise_cubic import piecewise

#: the operations of expressions on arrays
ARRAY_OPERATIONS: dict[str, Callable] = {
    **OPERATIONS,
    "div": np.divide,
    "pow": np.power,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "angle": np.arctan2,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
    "log10": np.log10,
    "sqrt": np.sqrt,
    "hypot": np.hypot,
    "ratio": lambda a, b: np.divide(a, b, out=np.zeros(np.broadcast(a, b).shape), where=np.asarray(b) != 0.0),
    "abs": np.abs,
    "sign": np.sign,
    "min": np.minimum,
    "max": np.maximum,
    "floor": np.floor,
    "ceil": np.ceil,
    "mod": lambda a, b: a - np.floor(a / b) * b,
    "lt": lambda a, b: np.less(a, b).astype(float),
    "le": lambda a, b: np.less_equal(a, b).astype(float),
    "eq": lambda a, b: np.equal(a, b).astype(float),
    "ne": lambda a, b: np.not_equal(a, b).astype(float),
    "and": lambda a, b: np.logical_and(a, b).astype(float),
    "or": lambda a, b: np.logical_or(a, b).astype(float),
    "not": lambda a: np.logical_not(a).astype(float),
    "select": lambda c, a, b: np.where(np.asarray(c) != 0.0, a, b),
}


def counted(t: Array, angle: Array, rate: Array, start: float) -> Array:
    """Angles (N,) at successive times (N,), each known up to whole turns, with their turns counted.

    The first is the closest to ``start``. Between two times, turns follow from the mean of both rates; the error of
    this change must be less than half a turn.
    """
    found = np.array(np.broadcast_to(angle, np.shape(t)), float)
    if not len(found):
        return found
    rate = np.broadcast_to(rate, found.shape)
    change = np.diff(found)
    expected = 0.5 * (rate[1:] + rate[:-1]) * np.diff(t)
    turns = np.round((expected - change) / (2.0 * np.pi))
    first = np.round((start - found[0]) / (2.0 * np.pi))
    found[0] += 2.0 * np.pi * first
    found[1:] += 2.0 * np.pi * (first + np.cumsum(turns))
    return found


def table_value(table, order: int, u) -> Array:
    """Derivative ``order`` of a table at an array of arguments, as the compiled interpolation gives it."""
    breaks, c = piecewise(table)
    u = np.asarray(u, float)
    first, last = breaks[0], breaks[-1]
    outside = (u < first) | (u > last)
    if table.extrapolation == "periodic":
        u = np.where(outside, first + np.mod(u - first, last - first), u)
        outside = np.zeros_like(outside)
    x0 = np.clip(u, first, last)
    k = np.clip(np.searchsorted(breaks, x0, side="right") - 1, 0, len(breaks) - 2)
    x = x0 - breaks[k]
    c0, c1, c2, c3 = c[k].T
    slope = c1 + x * (2 * c2 + x * 3 * c3)
    if order == 0:
        value = c0 + x * (c1 + x * (c2 + x * c3))
        if table.extrapolation == "linear":
            value = value + slope * (u - x0)
        return np.where(outside, np.nan, value) if table.extrapolation == "error" else value
    if order == 1:
        return slope if table.extrapolation in ("linear", "periodic") else np.where(outside, 0.0, slope)
    higher = 2 * c2 + 6 * x * c3 if order == 2 else 6 * c3 if order == 3 else 0.0 * x
    return np.where(outside, 0.0, higher)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
ACCURACY, DEPTH = 1e-12, 40  #: relative difference of an interval's integral from that of its halves; most halvings


def integral(given_law: tuple[Expr, float], x: object) -> Array:
    """The integral of a law of one variable from its start, ``given_law`` = (law, start), to each of ``x`` (N,).

    Gauss-Legendre quadrature between neighbouring arguments, which are halved until both agree.
    """
    (law, start), given = given_law, np.asarray(x, float)
    ends = np.unique(np.append(given.ravel(), start))
    ends = ends[np.isfinite(ends)]
    a, b, owner = ends[:-1], ends[1:], np.arange(len(ends) - 1)
    total, whole = np.zeros(len(owner)), _gauss(law, a, b)
    size = np.abs(whole).max(initial=0.0)
    for _ in range(DEPTH):
        middle = 0.5 * (a + b)
        left, right = _gauss(law, a, middle), _gauss(law, middle, b)
        good = ~(np.abs(left + right - whole) > ACCURACY * size)  # nan: the law has no value
        np.add.at(total, owner[good], (left + right)[good])
        if good.all():
            break
        bad = ~good
        a, b = np.concatenate([a[bad], middle[bad]]), np.concatenate([middle[bad], b[bad]])
        owner, whole = np.tile(owner[bad], 2), np.concatenate([left[bad], right[bad]])
    else:
        np.add.at(total, owner, whole)
    sums = np.concatenate([[0.0], np.cumsum(total)])
    sums -= sums[np.searchsorted(ends, start)]
    return np.where(np.isfinite(given), sums[np.searchsorted(ends, given).clip(0, len(ends) - 1)], np.nan)


def _gauss(law: Expr, a: Array, b: Array) -> Array:
    """The integrals over the intervals from a to b (n,)."""
    half = 0.5 * (b - a)
    points = 0.5 * (a + b)[:, None] + half[:, None] * NODES
    with np.errstate(all="ignore"):
        (found,) = evaluate([law], lambda _: points.ravel(), ARRAY_OPERATIONS, table_value)
    return half * (np.broadcast_to(np.asarray(found, float), points.size).reshape(points.shape) @ WEIGHTS)


ARRAY_OPERATIONS["integral"] = integral
