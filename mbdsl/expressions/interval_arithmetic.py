"""Interval arithmetic for expressions: bounds of a value and of its derivative for arguments between bounds.

A :class:`Jet` encloses a function of one variable on many intervals at once: its values lie in [lo, hi], the slopes
between any two of its points in [d_lo, d_hi]. For smooth functions these slopes enclose the derivative. At a jump a
bound of the slope is infinite, with the sign of the jump if that is known. Thus bounds of one sign show that the
function is monotone in all cases. Bounds are rounded outward by more than the errors of elementary functions.

Where an expression is not a number on a part of an interval, its bounds enclose its values on the rest. Equality, which
holds at single points only, counts as false.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis (2009), chapters 2 to 6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.numerics.piecewise_cubic import SMOOTHNESS, piecewise

Array = NDArray[np.float64]
Interval = tuple[Array, Array]

#: relative error of an elementary function, with a margin
ROUNDING = 2.0**-50
INF = np.inf
#: the slope of constants, and of all functions if no bounds on slopes are needed
FLAT = np.zeros(1)
CONDITIONS = ("lt", "le", "eq", "ne", "and", "or", "not")


class Jet(NamedTuple):
    """Bounds of values and of slopes, arrays of one shape."""

    lo: Array
    hi: Array
    d_lo: Array
    d_hi: Array


def _outward(lo: Array, hi: Array) -> Interval:
    # sums with infinite terms may be nan, which fmin and fmax ignore
    return np.fmin(lo - np.abs(ROUNDING * lo), lo), np.fmax(hi + np.abs(ROUNDING * hi), hi)


def hull(*bounds: Interval) -> Interval:
    """The smallest interval that contains all of them."""
    lo, hi = bounds[0]
    for a, b in bounds[1:]:
        lo, hi = np.fmin(lo, a), np.fmax(hi, b)
    return lo, hi


def add(a: Interval, b: Interval) -> Interval:
    if a[0] is FLAT or b[0] is FLAT:
        return b if a[0] is FLAT else a
    lo, hi = _outward(a[0] + b[0], a[1] + b[1])
    return np.where(np.isnan(lo), -INF, lo), np.where(np.isnan(hi), INF, hi)


def neg(a: Interval) -> Interval:
    if a[0] is FLAT:
        return a
    return -a[1], -a[0]


def mul(a: Interval, b: Interval) -> Interval:
    """The product, where 0 times infinity is 0."""
    products = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    p, q, r, s = (np.where(x == x, x, 0.0) for x in products)
    return _outward(np.minimum(np.minimum(p, q), np.minimum(r, s)), np.maximum(np.maximum(p, q), np.maximum(r, s)))


def inverse(a: Interval) -> Interval:
    """1/a; unbounded where a contains zero."""
    lo, hi = 1.0 / a[1], 1.0 / a[0]
    lo, hi = np.where(a[1] == 0.0, -INF, lo), np.where(a[0] == 0.0, INF, hi)
    across = (a[0] < 0.0) & (a[1] > 0.0)
    return _outward(np.where(across, -INF, lo), np.where(across, INF, hi))


def square(a: Interval) -> Interval:
    x, y = a[0] * a[0], a[1] * a[1]
    return _outward(np.where((a[0] <= 0.0) & (a[1] >= 0.0), 0.0, np.minimum(x, y)), np.maximum(x, y))


def _within(a: Interval, low: float, high: float) -> Interval:
    return np.clip(a[0], low, high), np.clip(a[1], low, high)


# -- functions of one argument: values, and derivatives ------------------------------------------------------------


def _rising(f: Callable, low: float = -INF, high: float = INF, least: float = -INF, most: float = INF) -> Callable:
    """A function that grows on its domain [low, high], with values in [least, most]."""

    def values(a: Interval) -> Interval:
        lo, hi = _outward(f(np.clip(a[0], low, high)), f(np.clip(a[1], low, high)))
        nowhere = (a[1] < low) | (a[0] > high)
        return np.where(nowhere, np.nan, np.maximum(lo, least)), np.where(nowhere, np.nan, np.minimum(hi, most))

    return values


def _cos(a: Interval) -> Interval:
    lo, hi = _outward(*hull((np.cos(a[0]),) * 2, (np.cos(a[1]),) * 2))
    slack = ROUNDING * np.maximum(np.abs(a[0]), np.abs(a[1]))
    for top, sign in ((0.0, 1.0), (np.pi, -1.0)):  # whether an even, or an odd, multiple of pi lies between
        k = np.ceil((a[0] - slack - top) / (2.0 * np.pi))
        met = ~(top + k * 2.0 * np.pi > a[1] + slack)
        lo, hi = (lo, np.where(met, 1.0, hi)) if sign > 0 else (np.where(met, -1.0, lo), hi)
    return np.clip(lo, -1.0, 1.0), np.clip(hi, -1.0, 1.0)


def _sin(a: Interval) -> Interval:
    return _cos(_outward(a[0] - np.pi / 2.0, a[1] - np.pi / 2.0))


def _abs(a: Interval) -> Interval:
    x, y = np.abs(a[0]), np.abs(a[1])
    return np.where((a[0] <= 0.0) & (a[1] >= 0.0), 0.0, np.minimum(x, y)), np.maximum(x, y)


def _cosh(a: Interval) -> Interval:
    lo, hi = _abs(a)
    return _outward(np.cosh(lo), np.cosh(hi))


def _over_root(a: Interval) -> Interval:
    """1/sqrt(1 - a^2) on [-1, 1]."""
    inside = add((np.ones(1), np.ones(1)), neg(square(_within(a, -1.0, 1.0))))
    return inverse(_rising(np.sqrt, 0.0)((np.maximum(inside[0], 0.0), inside[1])))


def _tan(a: Interval) -> Interval:
    pole = np.floor(a[0] / np.pi + 0.5) != np.floor(a[1] / np.pi + 0.5)
    lo, hi = _outward(np.tan(a[0]), np.tan(a[1]))
    pole |= ~(lo <= hi)
    return np.where(pole, -INF, lo), np.where(pole, INF, hi)


def _one_plus_square(a: Interval) -> Interval:
    return add((np.ones(1), np.ones(1)), square(a))


def _tan_slope(a: Interval, n: Interval) -> Interval:
    lo, hi = _one_plus_square(n)
    return np.where(np.isinf(n[0]) | np.isinf(n[1]), -INF, lo), hi  # down at a pole


def _one_minus_square(a: Interval) -> Interval:
    lo, hi = add((np.ones(1), np.ones(1)), neg(square(a)))
    return np.maximum(lo, 0.0), hi


_EXP = _rising(np.exp, least=0.0)
_SQRT = _rising(np.sqrt, 0.0, least=0.0)
_TANH = _rising(np.tanh, least=-1.0, most=1.0)
_SINH = _rising(np.sinh)
_LN10 = float(np.log(10.0))

#: op -> bounds of its values, and of its derivative from those of argument and value
SMOOTH: dict[str, tuple[Callable[[Interval], Interval], Callable[[Interval, Interval], Interval]]] = {
    "sin": (_sin, lambda a, n: _cos(a)),
    "cos": (_cos, lambda a, n: neg(_sin(a))),
    "tan": (_tan, _tan_slope),
    "asin": (_rising(np.arcsin, -1.0, 1.0), lambda a, n: _over_root(a)),
    "acos": (lambda a: neg(_rising(lambda x: -np.arccos(x), -1.0, 1.0)(a)), lambda a, n: neg(_over_root(a))),
    "atan": (_rising(np.arctan), lambda a, n: inverse(_one_plus_square(a))),
    "sinh": (_SINH, lambda a, n: _cosh(a)),
    "cosh": (_cosh, lambda a, n: _SINH(a)),
    "tanh": (_TANH, lambda a, n: _one_minus_square(n)),
    "exp": (_EXP, lambda a, n: n),
    "log": (_rising(np.log, 0.0), lambda a, n: inverse((np.maximum(a[0], 0.0), np.maximum(a[1], 0.0)))),
    "log10": (
        _rising(np.log10, 0.0),
        lambda a, n: mul((np.full(1, 1.0 / _LN10),) * 2, inverse((np.maximum(a[0], 0.0), np.maximum(a[1], 0.0)))),
    ),
    "sqrt": (_SQRT, lambda a, n: mul((np.full(1, 0.5),) * 2, inverse(n))),
}


# -- powers, quotients, angles ---------------------------------------------------------------------------------------


def _power(a: Interval, b: Interval) -> Interval:
    """a^b: a of any sign if b is a constant integer, else a >= 0."""
    exponent = float(b[0].flat[0])
    if b[0].size == 1 and b[0].flat[0] == b[1].flat[0] and exponent == np.floor(exponent):
        if exponent < 0.0:
            return inverse(_power(a, (-b[1], -b[0])))
        if exponent % 2.0 == 0.0:
            lo, hi = _abs(a)
            return _outward(np.power(lo, exponent), np.power(hi, exponent))
        return _outward(np.power(a[0], exponent), np.power(a[1], exponent))
    base = np.maximum(a[0], 0.0), np.maximum(a[1], 0.0)
    corners = [np.power(x, y) for x in base for y in b]
    lo, hi = corners[0], corners[0]
    for c in corners[1:]:
        lo, hi = np.fmin(lo, c), np.fmax(hi, c)
    lo, hi = np.where((b[0] < 0.0) & (base[0] == 0.0), 0.0, lo), np.where((b[0] < 0.0) & (base[0] == 0.0), INF, hi)
    wide = ROUNDING * (1.0 + np.abs(b[0]) + np.abs(b[1]))
    anything = (a[0] < 0.0) & (np.floor(b[1]) >= b[0])  # of a negative number, where b contains an integer
    lo, hi = lo - wide * np.abs(lo), np.where(np.isfinite(hi), hi + wide * np.abs(hi), hi)
    return np.where(anything, -INF, lo), np.where(anything, INF, hi)


def _power_slope(a: Jet, b: Jet, n: Interval) -> Interval:
    least = b.lo - 1.0, b.hi - 1.0
    found = mul(mul((b.lo, b.hi), _power((a.lo, a.hi), least)), (a.d_lo, a.d_hi))
    if not (np.all(b.d_lo == 0.0) and np.all(b.d_hi == 0.0)):
        logarithm = SMOOTH["log"][0]((np.maximum(a.lo, 0.0), np.maximum(a.hi, 0.0)))
        found = add(found, mul(mul(n, logarithm), (b.d_lo, b.d_hi)))
        anything = n[0] == -INF
        found = np.where(anything, -INF, found[0]), np.where(anything, INF, found[1])
    return found


def _quotient(a: Jet, b: Jet) -> Jet:
    by = inverse((b.lo, b.hi))
    value = mul((a.lo, a.hi), by)
    rate = mul(add((a.d_lo, a.d_hi), neg(mul(value, (b.d_lo, b.d_hi)))), by)
    return Jet(*value, *rate)


def _ratio(a: Jet, b: Jet) -> Jet:
    found, zero = _quotient(a, b), (b.lo <= 0.0) & (b.hi >= 0.0)
    lo, hi = np.where(zero, np.fmin(found.lo, 0.0), found.lo), np.where(zero, np.fmax(found.hi, 0.0), found.hi)
    return Jet(lo, hi, np.where(zero, -INF, found.d_lo), np.where(zero, INF, found.d_hi))


def _atan2(y: Jet, x: Jet) -> Jet:
    corners = [np.arctan2(p, q) for p in (y.lo, y.hi) for q in (x.lo, x.hi)]
    lo, hi = _outward(*hull(*((c, c) for c in corners)))
    cut = (y.lo <= 0.0) & (y.hi >= 0.0) & (x.lo <= 0.0)
    length = add(square((x.lo, x.hi)), square((y.lo, y.hi)))
    turn = add(mul((x.lo, x.hi), (y.d_lo, y.d_hi)), neg(mul((y.lo, y.hi), (x.d_lo, x.d_hi))))
    rate = mul(turn, inverse((np.maximum(length[0], 0.0), length[1])))
    return Jet(
        np.where(cut, -np.pi, lo),
        np.where(cut, np.pi, hi),
        np.where(cut, -INF, rate[0]),
        np.where(cut, INF, rate[1]),
    )


def _hypot(a: Jet, b: Jet) -> Jet:
    value = _SQRT(add(square((a.lo, a.hi)), square((b.lo, b.hi))))
    top = add(mul((a.lo, a.hi), (a.d_lo, a.d_hi)), mul((b.lo, b.hi), (b.d_lo, b.d_hi)))
    steepest = np.hypot(*(np.maximum(np.abs(x.d_lo), np.abs(x.d_hi)) for x in (a, b))) * (1.0 + ROUNDING)
    lo, hi = mul(top, inverse(value))
    return Jet(value[0], value[1], np.maximum(lo, -steepest), np.minimum(hi, steepest))


# -- functions with jumps --------------------------------------------------------------------------------------------


def _step(lo: Array, hi: Array, rate: Interval) -> Jet:
    """A step function that does not decrease with its argument; it jumps where lo and hi differ."""
    jumps = lo != hi
    up, down = jumps & ~(rate[0] >= 0.0), jumps & ~(rate[1] <= 0.0)
    return Jet(lo, hi, np.where(up, -INF, 0.0), np.where(down, INF, 0.0))


def _truth(surely: NDArray, never: NDArray, rate: Interval) -> Jet:
    return _step(np.where(surely, 1.0, 0.0), np.where(never, 0.0, 1.0), rate)


def _less(a: Jet, b: Jet, surely: NDArray, never: NDArray) -> Jet:
    """A comparison that does not decrease with b and does not increase with a."""
    return _truth(surely, never, add((b.d_lo, b.d_hi), neg((a.d_lo, a.d_hi))))


def _as_truth(node: Expr, a: Jet) -> Jet:
    """The truth value of a number in place of a condition: whether it is not zero."""
    if node.op in CONDITIONS:
        return a
    everything = np.full_like(a.lo, -INF), np.full_like(a.lo, INF)
    return _truth((a.lo > 0.0) | (a.hi < 0.0), (a.lo == 0.0) & (a.hi == 0.0), everything)


def _select(c: Jet, a: Jet, b: Jet) -> Jet:
    yes, no = c.lo == 1.0, c.hi == 0.0
    either = hull((a.lo, a.hi), (b.lo, b.hi))
    rate = hull((a.d_lo, a.d_hi), (b.d_lo, b.d_hi))
    jump = mul((c.d_lo, c.d_hi), add((a.lo, a.hi), neg((b.lo, b.hi))))
    rate = add(rate, jump)
    return Jet(*(np.where(yes, x, np.where(no, y, z)) for x, y, z in zip(a, b, (*either, *rate), strict=True)))


def _min(a: Jet, b: Jet) -> Jet:
    first, second = a.hi < b.lo, b.hi < a.lo
    both = np.fmin(a.lo, b.lo), np.fmin(a.hi, b.hi), *hull((a.d_lo, a.d_hi), (b.d_lo, b.d_hi))
    return Jet(*(np.where(first, x, np.where(second, y, z)) for x, y, z in zip(a, b, both, strict=True)))


def _minus(a: Jet) -> Jet:
    return Jet(*neg((a.lo, a.hi)), *neg((a.d_lo, a.d_hi)))


def _max(a: Jet, b: Jet) -> Jet:
    return _minus(_min(_minus(a), _minus(b)))


def _mod(a: Jet, b: Jet) -> Jet:
    """a - floor(a/b) b, for a divisor that stays as it is and is not zero; else without bounds on slopes."""
    steady = (b.lo == b.hi) & (b.lo != 0.0) & (b.d_lo == 0.0) & (b.d_hi == 0.0)
    margin = ROUNDING * np.maximum(np.abs(a.lo), np.abs(a.hi))
    lap = np.floor((a.lo - margin) / b.lo)
    same = steady & (lap == np.floor((a.hi + margin) / b.lo))
    lo, hi = _outward(a.lo - lap * b.lo - margin, a.hi - lap * b.lo + margin)
    least, most = np.fmin(b.lo, 0.0), np.fmax(b.hi, 0.0)
    upward = steady & (a.d_lo * np.sign(b.lo) >= 0.0)  # grows with a between jumps in the opposite direction
    d_lo = np.where(same, a.d_lo, np.where(upward & (b.lo < 0.0), a.d_lo, -INF))
    d_hi = np.where(same, a.d_hi, np.where(upward & (b.lo > 0.0), a.d_hi, INF))
    return Jet(np.where(same, np.maximum(lo, least), least), np.where(same, np.minimum(hi, most), most), d_lo, d_hi)


# -- tables ----------------------------------------------------------------------------------------------------------


class _Pieces:
    """A derivative of a table as piecewise polynomials, with the precomputed range of each piece."""

    def __init__(self, table, order: int) -> None:
        self.u, c = piecewise(table)
        powers = c[:-1].copy()
        for _ in range(order):
            powers = np.hstack([powers[:, 1:] * np.arange(1.0, powers.shape[1]), np.zeros((len(powers), 1))])
        self.c, self.count = powers, len(powers)
        ranges = self.partly(np.arange(self.count), np.zeros(self.count), np.diff(self.u))
        self.levels = [ranges]  # over 1, 2, 4, ... pieces
        while 2 ** len(self.levels) <= self.count:
            lo, hi = self.levels[-1]
            s = 2 ** (len(self.levels) - 1)
            self.levels.append((np.minimum(lo[:-s], lo[s:]), np.maximum(hi[:-s], hi[s:])))

    def partly(self, k: NDArray, x0: Array, x1: Array) -> Interval:
        """The range of piece k from x0 to x1 after its start."""
        c0, c1, c2, c3 = self.c[k].T
        root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
        far = -(c2 + np.copysign(root, c2))  # both roots without cancellation
        values = [c0 + x * (c1 + x * (c2 + x * c3)) for x in (x0, x1)]
        size = np.abs(c0) + np.abs(x1) * (np.abs(c1) + np.abs(x1) * (np.abs(c2) + np.abs(x1) * np.abs(c3)))
        for x in (far / (3.0 * c3), c1 / far):
            x = np.clip(np.nan_to_num(x, nan=0.0), x0, x1)
            values.append(c0 + x * (c1 + x * (c2 + x * c3)))
        lo, hi = np.min(values, axis=0), np.max(values, axis=0)
        flat = lo == hi
        return np.where(flat, lo, lo - ROUNDING * size), np.where(flat, hi, hi + ROUNDING * size)

    def piece(self, u: Array) -> NDArray:
        return np.clip(np.searchsorted(self.u, u, side="right") - 1, 0, self.count - 1)

    def over(self, lo: Array, hi: Array) -> Interval:
        """The range between two arguments within the table."""
        i, j = self.piece(lo), self.piece(hi)
        # an end that lies on a knot belongs to the piece before it, too
        first = self.partly(i, lo - self.u[i], np.minimum(hi, self.u[i + 1]) - self.u[i])
        last = self.partly(j, np.maximum(lo, self.u[j]) - self.u[j], hi - self.u[j])
        lo, hi = hull(first, last)
        many = j - i - 1
        for level, (least, most) in enumerate(self.levels):
            inside = (many >= 2**level) & (many < 2 ** (level + 1))
            if inside.any():
                a, b = np.where(inside, i + 1, 0), np.where(inside, j - 2**level, 0)
                lo = np.where(inside, np.minimum(lo, np.minimum(least[a], least[b])), lo)
                hi = np.where(inside, np.maximum(hi, np.maximum(most[a], most[b])), hi)
        return lo, hi


@lru_cache(maxsize=256)
def _pieces(table, order: int) -> _Pieces:
    return _Pieces(table, order)


def _range(table, order: int, lo: Array, hi: Array) -> Interval:
    """Bounds of derivative ``order`` of a table between two arguments, its jumps left out."""
    pieces = _pieces(table, order)
    first, last = float(pieces.u[0]), float(pieces.u[-1])
    if table.extrapolation == "periodic":
        period = last - first
        lap = np.floor((lo - first) / period)
        a, b = np.clip(lo - lap * period, first, last), np.maximum(hi - lap * period, first)
        whole = pieces.over(np.full_like(lo, first), np.full_like(lo, last))
        wraps = b > last
        one = pieces.over(a, np.minimum(b, last))
        end = pieces.over(np.where(a == first, last, a), np.where(a == first, last, a))  # of the previous period
        one = hull(one, end)
        two = pieces.over(np.full_like(lo, first), np.clip(b - period, first, last))
        found = tuple(np.where(wraps, x, y) for x, y in zip(hull(one, two), one, strict=True))
        full = ~(hi - lo < period)
        return tuple(np.where(full, x, y) for x, y in zip(whole, found, strict=True))  # type: ignore[return-value]
    inside = pieces.over(np.clip(lo, first, last), np.clip(hi, first, last))
    if order == 0 and table.extrapolation == "linear":
        slopes = _pieces(table, 1)
        for beyond, at in ((np.fmin(lo - first, 0.0), first), (np.fmax(hi - last, 0.0), last)):
            k = slopes.piece(np.full(1, at))
            slope = slopes.partly(k, at - slopes.u[k], at - slopes.u[k])
            way = mul((np.where(beyond < 0.0, beyond, 0.0), np.where(beyond > 0.0, beyond, 0.0)), slope)
            inside = inside[0] + np.minimum(way[0], 0.0), inside[1] + np.maximum(way[1], 0.0)
    if order > 0:
        beyond = (lo < first) | (hi > last)
        if table.extrapolation != "linear" or order > 1:
            with_zero = hull(inside, (np.zeros_like(lo), np.zeros_like(lo)))
            inside = np.where(beyond, with_zero[0], inside[0]), np.where(beyond, with_zero[1], inside[1])
    return inside


def _table(table, order: int, u: Jet) -> Jet:
    smooth, _ = SMOOTHNESS[table.smoothness if len(table.u) > 2 else "linear"]
    value = _range(table, order, u.lo, u.hi)
    lo, hi = mul(_range(table, order + 1, u.lo, u.hi), (u.d_lo, u.d_hi))
    knots = np.array(table.u, float)
    first, last = float(knots[0]), float(knots[-1])
    jumps = np.zeros(np.shape(u.lo), bool)
    if table.extrapolation == "periodic":
        if order > smooth:
            jumps = _count(knots, u.lo, "left") != _count(knots, u.hi, "right")
        elif table.y[0] != table.y[-1] or (order > 0 and smooth < 2):  # only splines meet smoothly at the ends
            ends = knots[[0, -1]]
            jumps = _count(ends, u.lo, "left") != _count(ends, u.hi, "right")
    else:
        if order > smooth:
            jumps = np.searchsorted(knots, u.lo, side="left") != np.searchsorted(knots, u.hi, side="right")
        if order > (1 if table.extrapolation == "linear" else 0):
            jumps = jumps | ((u.lo <= first) & (u.hi >= first)) | ((u.lo <= last) & (u.hi >= last))
    jumps = jumps & ((u.d_lo != 0.0) | (u.d_hi != 0.0))
    return Jet(*value, np.where(jumps, -INF, lo), np.where(jumps, INF, hi))


def _count(knots: Array, u: Array, side: Literal["left", "right"]) -> NDArray:
    """How many knots of a periodic table lie before u."""
    period = knots[-1] - knots[0]
    lap = np.floor((u - knots[0]) / period)
    return lap * (len(knots) - 1) + np.searchsorted(knots[:-1], u - lap * period, side=side)


# -- expressions -----------------------------------------------------------------------------------------------------


def _product(a: Jet, b: Jet) -> Jet:
    x, y = (a.lo, a.hi), (b.lo, b.hi)
    return Jet(*mul(x, y), *add(_scaled(a, y), _scaled(b, x)))


def _scaled(a: Jet, factor: Interval) -> Interval:
    """The slopes of a times a factor."""
    return (FLAT, FLAT) if a.d_lo is FLAT else mul((a.d_lo, a.d_hi), factor)


def _square(a: Jet) -> Jet:
    return Jet(*square((a.lo, a.hi)), *_scaled(a, (2.0 * a.lo, 2.0 * a.hi)))


def _absolute(a: Jet) -> Jet:
    return _max(a, _minus(a))


def _whole(f: Callable) -> Callable[[Jet], Jet]:
    return lambda a: _step(f(a.lo), f(a.hi), (a.d_lo, a.d_hi))


_JETS: dict[str, Callable[..., Jet]] = {
    "add": lambda a, b: Jet(*add((a.lo, a.hi), (b.lo, b.hi)), *add((a.d_lo, a.d_hi), (b.d_lo, b.d_hi))),
    "sub": lambda a, b: _JETS["add"](a, _minus(b)),
    "neg": _minus,
    "mul": _product,
    "div": _quotient,
    "ratio": _ratio,
    "hypot": _hypot,
    "atan2": _atan2,
    "angle": _atan2,  # turns that are not counted show as jumps
    "abs": _absolute,
    "min": _min,
    "max": _max,
    "mod": _mod,
    "sign": _whole(np.sign),
    "floor": _whole(np.floor),
    "ceil": _whole(np.ceil),
    "lt": lambda a, b: _less(a, b, a.hi < b.lo, a.lo >= b.hi),
    "le": lambda a, b: _less(a, b, a.hi <= b.lo, a.lo > b.hi),
    "eq": lambda a, b: _known((a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo)),
    "ne": lambda a, b: _known(~((a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo))),
    "and": _min,
    "or": _max,
    "not": lambda a: _JETS["sub"](constant(1.0), a),
    "select": _select,
}


def _known(truth: Array) -> Jet:
    value = np.where(truth, 1.0, 0.0)
    return Jet(value, value, value * 0.0, value * 0.0)


def constant(value: float) -> Jet:
    """The jet of a constant."""
    return Jet(np.full(1, value), np.full(1, value), FLAT, FLAT)


def enclose(roots: Iterable[Expr], leaf: Callable[[Expr], Jet]) -> list[Jet]:
    """Bounds of ``roots`` from those of every leaf; the caller has to suppress NumPy's warnings."""
    roots = list(roots)
    found: dict[Expr, Jet] = {}
    for n in walk(*roots):
        if n.op == "const":
            found[n] = constant(n.value)  # type: ignore[arg-type]
        elif n.op == "table":
            table, order = n.value  # type: ignore[misc]
            found[n] = _table(table, order, found[n.args[0]])
        elif not n.args:
            found[n] = leaf(n)
        elif n.op == "mul" and n.args[0] is n.args[1]:
            found[n] = _square(found[n.args[0]])
        elif n.op == "pow":
            a, b = (found[x] for x in n.args)
            value = _power((a.lo, a.hi), (b.lo, b.hi))
            found[n] = Jet(*value, *_power_slope(a, b, value))
        elif n.op in SMOOTH:
            values, slope = SMOOTH[n.op]
            a = found[n.args[0]]
            value = values((a.lo, a.hi))
            found[n] = Jet(*value, *((FLAT, FLAT) if a.d_lo is FLAT else _scaled(a, slope((a.lo, a.hi), value))))
        else:
            args = [found[x] for x in n.args]
            truths = {"select": 1, "and": 2, "or": 2, "not": 1}.get(n.op, 0)
            args[:truths] = [_as_truth(x, a) for x, a in zip(n.args[:truths], args, strict=False)]
            found[n] = _JETS[n.op](*args)
    return [found[r] for r in roots]
