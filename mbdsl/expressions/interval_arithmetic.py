"""Interval arithmetic for expressions: bounds of a value and of its derivative for arguments between bounds.

A :class:`Jet` encloses a function of one variable on an interval: its values lie in [lo, hi], the slopes between any
two of its points in [d_lo, d_hi]. For smooth functions these slopes enclose the derivative. At a jump a bound of the
slope is infinite, with the sign of the jump if that is known. Thus bounds of one sign show that the function is
monotone in all cases. Bounds are rounded outward by more than the errors of elementary functions.

Where an expression is not a number on a part of an interval, its bounds enclose its values on the rest. Equality, which
holds at single points only, counts as false.

All functions are kernels of numbers; an interval is a tuple (lo, hi). :mod:`mbdsl.system.interval_tape` runs them over
the operations of an expression.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis (2009), chapters 2 to 6.
"""

from __future__ import annotations

from typing import NamedTuple

from numpy import arccos as acos
from numpy import arcsin as asin
from numpy import arctan as atan
from numpy import arctan2 as atan2
from numpy import ceil, cos, cosh, exp, floor, hypot, inf, log, log10, nan, pi, sinh, sqrt, tan, tanh

from mbdsl.kernels.marks import kernel, rare

#: relative error of an elementary function, with a margin
ROUNDING = 2.0**-50
LN10 = float(log(10.0))
CONDITIONS = ("lt", "le", "eq", "ne", "and", "or", "not")


class Jet(NamedTuple):
    """Bounds of values and of slopes: numbers, or arrays of one shape."""

    lo: float
    hi: float
    d_lo: float
    d_hi: float


@kernel
def lower(a, b):
    """The smaller number, or the one that is a number."""
    return a if a <= b or b != b else b


@kernel
def upper(a, b):
    return a if a >= b or b != b else b


@kernel
def outward(lo, hi):
    # infinite bounds give nan, which is ignored
    return lower(lo - abs(ROUNDING * lo), lo), upper(hi + abs(ROUNDING * hi), hi)


@kernel
def hull(a, b):
    """The smallest interval that contains both."""
    return lower(a[0], b[0]), upper(a[1], b[1])


@kernel
def neg(a):
    return -a[1], -a[0]


@kernel
def add(a, b):
    if a[0] == 0.0 and a[1] == 0.0:
        return b[0], b[1]
    if b[0] == 0.0 and b[1] == 0.0:
        return a[0], a[1]
    lo, hi = outward(a[0] + b[0], a[1] + b[1])
    return (lo if lo == lo else -inf), (hi if hi == hi else inf)


@kernel
def times(x, y):
    """A product, where 0 times infinity is 0."""
    found = x * y
    return found if found == found else 0.0


@rare
def mul(a, b):
    p, q, r, s = times(a[0], b[0]), times(a[0], b[1]), times(a[1], b[0]), times(a[1], b[1])
    return outward(min(min(p, q), min(r, s)), max(max(p, q), max(r, s)))


@kernel
def scaled(d, factor):
    """Slopes d times a factor; those of a constant stay zero."""
    return mul(d, factor) if d[0] != 0.0 or d[1] != 0.0 else (0.0, 0.0)


@kernel
def inverse(a):
    """1/a; unbounded where a contains zero."""
    across = a[0] < 0.0 and a[1] > 0.0
    return outward(-inf if across or a[1] == 0.0 else 1.0 / a[1], inf if across or a[0] == 0.0 else 1.0 / a[0])


@kernel
def absolute(a):
    x, y = abs(a[0]), abs(a[1])
    return (0.0 if a[0] <= 0.0 and a[1] >= 0.0 else min(x, y)), max(x, y)


@kernel
def square(a):
    lo, hi = absolute(a)
    return outward(lo * lo, hi * hi)


@kernel
def one_plus_square(a):
    return add((1.0, 1.0), square(a))


@kernel
def one_minus_square(a):
    lo, hi = add((1.0, 1.0), neg(square(a)))
    return max(lo, 0.0), hi


@rare
def of_cos(a):
    x, y = cos(a[0]), cos(a[1])
    lo, hi = outward(lower(x, y), upper(x, y))
    slack = ROUNDING * max(abs(a[0]), abs(a[1]))
    # whether an even, or an odd, multiple of pi lies between
    if not 2.0 * pi * ceil((a[0] - slack) / (2.0 * pi)) > a[1] + slack:
        hi = 1.0
    if not pi + 2.0 * pi * ceil((a[0] - slack - pi) / (2.0 * pi)) > a[1] + slack:
        lo = -1.0
    return min(max(lo, -1.0), 1.0), min(max(hi, -1.0), 1.0)


@kernel
def of_sin(a):
    return of_cos(outward(a[0] - pi / 2.0, a[1] - pi / 2.0))


@rare
def of_tan(a):
    lo, hi = outward(tan(a[0]), tan(a[1]))
    if floor(a[0] / pi + 0.5) != floor(a[1] / pi + 0.5) or not lo <= hi:
        return -inf, inf
    return lo, hi


@kernel
def slope_of_tan(n):
    lo, hi = one_plus_square(n)
    return (-inf if abs(n[0]) == inf or abs(n[1]) == inf else lo), hi  # down at a pole


@rare
def of_asin(a):
    if a[1] < -1.0 or a[0] > 1.0:
        return nan, nan
    return outward(asin(min(max(a[0], -1.0), 1.0)), asin(min(max(a[1], -1.0), 1.0)))


@rare
def of_acos(a):
    if a[1] < -1.0 or a[0] > 1.0:
        return nan, nan
    return outward(acos(min(max(a[1], -1.0), 1.0)), acos(min(max(a[0], -1.0), 1.0)))


@rare
def of_sqrt(a):
    if a[1] < 0.0:
        return nan, nan
    lo, hi = outward(sqrt(max(a[0], 0.0)), sqrt(a[1]))
    return max(lo, 0.0), hi


@rare
def slope_of_asin(a):
    """1/sqrt(1 - a^2) on [-1, 1]."""
    return inverse(of_sqrt(one_minus_square((min(max(a[0], -1.0), 1.0), min(max(a[1], -1.0), 1.0)))))


@rare
def of_exp(a):
    lo, hi = outward(exp(a[0]), exp(a[1]))
    return max(lo, 0.0), hi


@rare
def of_log(a):
    if a[1] < 0.0:
        return nan, nan
    return outward(log(a[0]) if a[0] > 0.0 else -inf, log(a[1]) if a[1] > 0.0 else -inf)


@rare
def of_log10(a):
    if a[1] < 0.0:
        return nan, nan
    return outward(log10(a[0]) if a[0] > 0.0 else -inf, log10(a[1]) if a[1] > 0.0 else -inf)


@kernel
def of_tanh(a):
    lo, hi = outward(tanh(a[0]), tanh(a[1]))
    return max(lo, -1.0), min(hi, 1.0)


@kernel
def of_sinh(a):
    return outward(sinh(a[0]), sinh(a[1]))


@kernel
def of_cosh(a):
    lo, hi = absolute(a)
    return outward(cosh(lo), cosh(hi))


@kernel
def of_atan(a):
    return outward(atan(a[0]), atan(a[1]))


@kernel
def jet(values, slopes):
    return values[0], values[1], slopes[0], slopes[1]


@kernel
def raised(x, exponent):
    return inf if x == 0.0 and exponent < 0.0 else x**exponent


@rare
def power(a, b):
    """a^b: a of any sign if b is an integer, else a >= 0."""
    if b[0] == b[1] and b[0] == floor(b[0]):
        exponent = abs(b[0])
        lo, hi = absolute(a) if exponent % 2.0 == 0.0 else (a[0], a[1])
        lo, hi = outward(lo**exponent, hi**exponent)
        return inverse((lo, hi)) if b[0] < 0.0 else (lo, hi)
    low, high = max(a[0], 0.0), max(a[1], 0.0)
    p, q, r, s = raised(low, b[0]), raised(low, b[1]), raised(high, b[0]), raised(high, b[1])
    lo, hi = lower(lower(p, q), lower(r, s)), upper(upper(p, q), upper(r, s))
    if b[0] < 0.0 and low == 0.0:
        lo, hi = 0.0, inf
    if a[0] < 0.0 and floor(b[1]) >= b[0]:  # of a negative number, where b contains an integer
        return -inf, inf
    wide = ROUNDING * (1.0 + abs(b[0]) + abs(b[1]))
    return lo - wide * abs(lo), (hi + wide * abs(hi) if hi < inf else hi)


@rare
def of_power(a, da, b, db):
    values = power(a, b)
    lo, hi = scaled(da, mul(b, power(a, (b[0] - 1.0, b[1] - 1.0))))
    if db[0] != 0.0 or db[1] != 0.0:
        if values[0] == -inf:
            return values[0], values[1], -inf, inf
        lo, hi = add((lo, hi), mul(mul(values, of_log((max(a[0], 0.0), max(a[1], 0.0)))), db))
    return values[0], values[1], lo, hi


@rare
def of_quotient(a, da, b, db):
    by = inverse(b)
    values = mul(a, by)
    return jet(values, mul(add(da, neg(scaled(db, values))), by))


@rare
def of_ratio(a, da, b, db):
    lo, hi, d_lo, d_hi = of_quotient(a, da, b, db)
    if b[0] <= 0.0 and b[1] >= 0.0:
        return lower(lo, 0.0), upper(hi, 0.0), -inf, inf
    return lo, hi, d_lo, d_hi


@rare
def of_atan2(y, dy, x, dx):
    """The angle of (x, y) within half a turn; turns that are not counted show as jumps."""
    if y[0] <= 0.0 and y[1] >= 0.0 and x[0] <= 0.0:
        return -pi, pi, -inf, inf
    p, q, r, s = atan2(y[0], x[0]), atan2(y[0], x[1]), atan2(y[1], x[0]), atan2(y[1], x[1])
    values = outward(lower(lower(p, q), lower(r, s)), upper(upper(p, q), upper(r, s)))
    length = add(square(x), square(y))
    turn = add(scaled(dy, x), neg(scaled(dx, y)))
    return jet(values, mul(turn, inverse((max(length[0], 0.0), length[1]))))


@rare
def of_hypot(a, da, b, db):
    values = of_sqrt(add(square(a), square(b)))
    lo, hi = mul(add(scaled(da, a), scaled(db, b)), inverse(values))
    most = hypot(max(abs(da[0]), abs(da[1])), max(abs(db[0]), abs(db[1]))) * (1.0 + ROUNDING)
    return values[0], values[1], max(lo, -most), min(hi, most)


@kernel
def step(lo, hi, d):
    """A step function that does not decrease with its argument, of slopes d; it jumps where lo and hi differ."""
    return lo, hi, (-inf if lo != hi and not d[0] >= 0.0 else 0.0), (inf if lo != hi and not d[1] <= 0.0 else 0.0)


@kernel
def truth(surely, never, d):
    return step(1.0 if surely else 0.0, 0.0 if never else 1.0, d)


@kernel
def of_number(a):
    """The truth of a number in place of a condition: whether it is not zero."""
    return truth(a[0] > 0.0 or a[1] < 0.0, a[0] == 0.0 and a[1] == 0.0, (-inf, inf))


@kernel
def sign(x):
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@rare
def of_select(c, dc, a, da, b, db):
    if c[0] == 1.0:
        return jet(a, da)
    if c[1] == 0.0:
        return jet(b, db)
    return jet(hull(a, b), add(hull(da, db), scaled(dc, add(a, neg(b)))))


@rare
def of_min(a, da, b, db):
    if a[1] < b[0]:
        return jet(a, da)
    if b[1] < a[0]:
        return jet(b, db)
    lo, hi = hull(da, db)
    return lower(a[0], b[0]), lower(a[1], b[1]), lo, hi


@kernel
def of_max(a, da, b, db):
    lo, hi, d_lo, d_hi = of_min(neg(a), neg(da), neg(b), neg(db))
    return -hi, -lo, -d_hi, -d_lo


@rare
def of_mod(a, da, b, db):
    """a - floor(a/b) b, for a divisor that stays as it is and is not zero; else without bounds on slopes."""
    least, most = lower(b[0], 0.0), upper(b[1], 0.0)
    if not (b[0] == b[1] and b[0] != 0.0 and db[0] == 0.0 and db[1] == 0.0):
        return least, most, -inf, inf
    margin = ROUNDING * max(abs(a[0]), abs(a[1]))
    lap = floor((a[0] - margin) / b[0])
    if lap == floor((a[1] + margin) / b[0]):
        lo, hi = outward(a[0] - lap * b[0] - margin, a[1] - lap * b[0] + margin)
        return max(lo, least), min(hi, most), da[0], da[1]
    upward = da[0] * sign(b[0]) >= 0.0  # grows with a between jumps in the opposite direction
    return least, most, (da[0] if upward and b[0] < 0.0 else -inf), (da[1] if upward and b[0] > 0.0 else inf)
