"""Interval arithmetic of tables: bounds of piecewise cubics and their derivatives over an interval."""

from numpy import ceil, floor, inf, sqrt

from mbdsl.expressions.interval_arithmetic import ROUNDING, hull, jet, mul
from mbdsl.kernels.marks import kernel, rare

#: a derivative of a table: number of its breaks; offsets in numbers of breaks and coefficients; extrapolation; order of
#: the derivative, of the first with corners; whether its ends differ; offset in numbers of its ranges, see
#: ``ranges``, and of those of the next derivative
RECORD = 9
BREAKS, AT, COEFFICIENTS, BEYOND, ORDER, SMOOTH, OPEN, RANGES, NEXT = range(RECORD)
HOLD, LINEAR, PERIODIC, ERROR = range(4)


@kernel
def before(u, at, n, numbers):
    """How many of n breaks are less than u."""
    lo, hi = 0, n
    while lo < hi:
        mid = (lo + hi) // 2
        if numbers[at + mid] < u:
            lo = mid + 1
        else:
            hi = mid
    return lo


@kernel
def up_to(u, at, n, numbers):
    """How many of n breaks are at most u."""
    lo, hi = 0, n
    while lo < hi:
        mid = (lo + hi) // 2
        if numbers[at + mid] <= u:
            lo = mid + 1
        else:
            hi = mid
    return lo


@kernel
def cubic(c, x):
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


@kernel
def extreme(x, c, x0, x1, lo, hi):
    """The range [lo, hi] with the value at x, if that is a number between x0 and x1."""
    y = cubic(c, min(max(x, x0), x1)) if x == x else lo
    return min(lo, y), max(hi, y)


@rare
def partly(record, order, k, x0, x1, notes, numbers):
    """The range of derivative ``order`` of piece k from x0 to x1 after its start."""
    o = notes[record + COEFFICIENTS] + 4 * k
    c = (numbers[o], numbers[o + 1], numbers[o + 2], numbers[o + 3])
    for _ in range(order):
        c = (c[1], 2.0 * c[2], 3.0 * c[3], 0.0)
    root = sqrt(max(c[2] * c[2] - 3.0 * c[1] * c[3], 0.0))
    far = -(c[2] + (root if c[2] >= 0.0 else -root))  # both roots without cancellation
    y0, y1 = cubic(c, x0), cubic(c, x1)
    lo, hi = min(y0, y1), max(y0, y1)
    if c[3] != 0.0:
        lo, hi = extreme(far / (3.0 * c[3]), c, x0, x1, lo, hi)
    if far != 0.0:
        lo, hi = extreme(c[1] / far, c, x0, x1, lo, hi)
    size = ROUNDING * (abs(c[0]) + abs(x1) * (abs(c[1]) + abs(x1) * (abs(c[2]) + abs(x1) * abs(c[3]))))
    return (lo, hi) if lo == hi else (lo - size, hi + size)


@kernel
def piece(record, u, notes, numbers):
    n = notes[record + BREAKS]
    return min(max(up_to(u, notes[record + AT], n, numbers) - 1, 0), n - 2)


@rare
def over(record, order, ranges, lo, hi, notes, numbers):
    """The range of derivative ``order`` between two arguments within the table; ``ranges``: see :func:`ranges`."""
    at, count = notes[record + AT], notes[record + BREAKS] - 1
    i, j = piece(record, lo, notes, numbers), piece(record, hi, notes, numbers)
    u = numbers[at + i]
    # an end that lies on a break belongs to the piece before it, too
    found = partly(record, order, i, lo - u, min(hi, numbers[at + i + 1]) - u, notes, numbers)
    u = numbers[at + j]
    found = hull(found, partly(record, order, j, max(lo, u) - u, hi - u, notes, numbers))
    a, b = count + i + 1, count + j
    while a < b:
        if a % 2 == 1:
            found = hull(found, (numbers[ranges + 2 * a], numbers[ranges + 2 * a + 1]))
            a += 1
        if b % 2 == 1:
            b -= 1
            found = hull(found, (numbers[ranges + 2 * b], numbers[ranges + 2 * b + 1]))
        a, b = a // 2, b // 2
    return found


@kernel
def ranges(record, order, offset, notes, numbers):
    """Write the ranges of derivative ``order`` from ``offset`` on in numbers, as a binary tree: node i, of two numbers,
    is the hull of nodes 2 i and 2 i + 1, and the nodes from ``count`` on are the pieces of the table."""
    at, count = notes[record + AT], notes[record + BREAKS] - 1
    for i in range(2 * count - 1, 0, -1):
        if i >= count:
            end = numbers[at + i - count + 1] - numbers[at + i - count]
            found = partly(record, order, i - count, 0.0, end, notes, numbers)
        else:
            a, b = offset + 4 * i, offset + 4 * i + 2
            found = hull((numbers[a], numbers[a + 1]), (numbers[b], numbers[b + 1]))
        numbers[offset + 2 * i], numbers[offset + 2 * i + 1] = found


@rare
def range_of(record, order, ranges, lo, hi, notes, numbers):
    """Bounds of derivative ``order`` between two arguments, its jumps left out."""
    at, beyond = notes[record + AT], notes[record + BEYOND]
    first, last = numbers[at], numbers[at + notes[record + BREAKS] - 1]
    if beyond == PERIODIC:
        period = last - first
        if not hi - lo < period:
            return over(record, order, ranges, first, last, notes, numbers)
        lap = floor((lo - first) / period)
        a, b = min(max(lo - lap * period, first), last), max(hi - lap * period, first)
        end = last if a == first else a  # of the previous period
        found = over(record, order, ranges, a, min(b, last), notes, numbers)
        found = hull(found, over(record, order, ranges, end, end, notes, numbers))
        if b > last:
            wrapped = over(record, order, ranges, first, min(max(b - period, first), last), notes, numbers)
            found = hull(wrapped, found)
        return found
    a, b = min(max(lo, first), last), min(max(hi, first), last)
    found = over(record, order, ranges, a, b, notes, numbers)
    if order == 0 and beyond == LINEAR:
        n = notes[record + BREAKS]
        if lo < first:
            way = mul((lo - first, 0.0), partly(record, 1, 0, 0.0, 0.0, notes, numbers))
            found = found[0] + min(way[0], 0.0), found[1] + max(way[1], 0.0)
        if hi > last:
            x = last - numbers[at + n - 2]
            way = mul((0.0, hi - last), partly(record, 1, n - 2, x, x, notes, numbers))
            found = found[0] + min(way[0], 0.0), found[1] + max(way[1], 0.0)
    if order > 0 and (lo < first or hi > last) and (beyond != LINEAR or order > 1):
        found = hull(found, (0.0, 0.0))
    return found


@kernel
def met(u, at, n, periodic, inclusive, notes, numbers):
    """How many of n breaks, of a periodic table in all periods, lie before u; ``inclusive``: or at u."""
    if not periodic:
        return up_to(u, at, n, numbers) if inclusive else before(u, at, n, numbers)
    first, last = numbers[at], numbers[at + n - 1]
    lap = floor((u - first) / (last - first))
    v = u - lap * (last - first)
    own = up_to(v, at, n - 1, numbers) if inclusive else before(v, at, n - 1, numbers)
    return lap * (n - 1) + own


@rare
def of_table(record, a, da, notes, numbers):
    """A derivative of a table."""
    at, n, beyond = notes[record + AT], notes[record + BREAKS], notes[record + BEYOND]
    order, smooth = notes[record + ORDER], notes[record + SMOOTH]
    lo, hi = range_of(record, order, notes[record + RANGES], a[0], a[1], notes, numbers)
    if da[0] == 0.0 and da[1] == 0.0:
        return lo, hi, 0.0, 0.0
    first, last, jumps = numbers[at], numbers[at + n - 1], False
    if beyond == PERIODIC:
        if order > smooth:
            jumps = met(a[0], at, n, True, False, notes, numbers) != met(a[1], at, n, True, True, notes, numbers)
        elif notes[record + OPEN] == 1 or (order > 0 and smooth < 2):  # only splines meet smoothly at the ends
            period = last - first
            jumps = ceil((a[0] - first) / period) != floor((a[1] - first) / period) + 1.0
    else:
        if order > smooth:
            jumps = before(a[0], at, n, numbers) != up_to(a[1], at, n, numbers)
        if order > (1 if beyond == LINEAR else 0):
            jumps = jumps or (a[0] <= first and a[1] >= first) or (a[0] <= last and a[1] >= last)
    if jumps:
        return lo, hi, -inf, inf
    return jet((lo, hi), mul(range_of(record, order + 1, notes[record + NEXT], a[0], a[1], notes, numbers), da))
