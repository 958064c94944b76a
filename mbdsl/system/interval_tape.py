"""Bounds of expressions along paths, compiled: the program of an expression, run with intervals in place of numbers.

A path is a function of one parameter s that all leaves of the expressions follow: each leaf is a cubic polynomial of s,
with its own coefficients on each of several pieces, such as the steps of a run. The program is that of
:mod:`mbdsl.system.expression_tape`, in which every shared subexpression occurs once. It is run with numbers, or with
the jets of :mod:`mbdsl.expressions.interval_arithmetic`. :mod:`mbdsl.system.paths` calls these kernels, which are
compiled once for all models.
"""

from __future__ import annotations

from typing import NamedTuple

from numpy import inf

from mbdsl.expressions import interval_arithmetic as bounds
from mbdsl.expressions import interval_tables
from mbdsl.expressions.interval_arithmetic import ROUNDING
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system import expression_tape as tape
from mbdsl.system.interval_operations import condition, jumping, smooth

#: negligible change of a term, relative to its largest known value; and absolute [SI]
NEGLIGIBLE, NOTHING = 1e-9, 1e-100
#: negligible height of a peak, relative to the term's value at both ends; relative to its largest value so far
SLIGHT, TINY = 0.05, 1e-6
#: an interval is not halved if the term changes in it by less than this part of the negligible height of a peak
PART = 0.25
#: most intervals of one piece that are halved
MOST = 2048
#: tolerance of the ends of a zone, relative to its width
CLOSE = 0.05
#: results of ``bisect``
FINISHED, FOUND, TOO_MANY, TIRED = range(4)


class TapeProgram(NamedTuple):
    """A program and its registers.

    ``layout`` and ``numbers`` are as for the expression tape; ``notes`` holds for every register 1 if it is that of a
    condition, and the offset in notes of the record of a table; ``jets`` four numbers a register; ``nothing`` is empty.
    """

    layout: object
    notes: object
    numbers: object
    jets: object
    nothing: object


class Way(NamedTuple):
    """Polynomials of K pieces, (leaves*K, 4); 0 pieces: without leaves, s is the time."""

    pieces: int
    ways: object


class Room(NamedTuple):
    """Points (s, f), for each the next one, and the intervals of a level as pairs of points."""

    points: object
    links: object
    queue: object


class Bounds(NamedTuple):
    """What bounds show of each of K pieces and R roots, (K, R); ``y`` (K + 1, R) are the values at the ends.

    ``size`` is the largest magnitude at the ends of resolved pieces so far, ``slight`` the negligible height of a peak,
    and ``excess`` by how much the bounds exceed the values at the ends. ``suspected`` is 1 where they exceed them by
    more, and where the slopes have both signs.
    """

    y: object
    size: object
    slight: object
    excess: object
    suspected: object


class Search(NamedTuple):
    """A search for extrema on N of K pieces: the numbers ``tried`` of the pieces, from ends[:, 0] to ends[:, 1].

    ``least`` (K,) are the shortest intervals, ``largest`` (K,) the largest values so far, and ``slight`` (K,) the
    negligible heights of a peak. ``spent`` (N,) are the operations of each piece; the search ends where their sum
    exceeds the ``credit`` (N,) of a piece. ``state``: the next number in ``tried``; the number of points (s, f) between
    which f is monotone; the sum of the operations.
    """

    tried: object
    ends: object
    least: object
    largest: object
    slight: object
    credit: object
    spent: object
    state: object


class Zones(NamedTuple):
    """Zones (N,) of extreme values ``peak`` at the places ``where``, which differ by ``reach`` at their ends.

    An end lies between ``within``, where the difference is less, and ``beyond``.
    """

    peak: object
    reach: object
    where: object
    within: object
    beyond: object


@rare
def operation(op, at, x, y, z, code):
    """The jet of an instruction for register ``at`` from those of its arguments, in registers x, y and z."""
    w, notes = code.jets, code.notes
    a, da = (w[4 * x], w[4 * x + 1]), (w[4 * x + 2], w[4 * x + 3])
    b, db = (w[4 * y], w[4 * y + 1]), (w[4 * y + 2], w[4 * y + 3])
    if op == tape.ADD:
        return bounds.jet(bounds.add(a, b), bounds.add(da, db))
    if op == tape.SUB:
        return bounds.jet(bounds.add(a, bounds.neg(b)), bounds.add(da, bounds.neg(db)))
    if op == tape.MUL and x == y:
        return bounds.jet(bounds.square(a), bounds.scaled(da, (2.0 * a[0], 2.0 * a[1])))
    if op == tape.MUL:
        return bounds.jet(bounds.mul(a, b), bounds.add(bounds.scaled(da, b), bounds.scaled(db, a)))
    if op == tape.NEG:
        return bounds.jet(bounds.neg(a), bounds.neg(da))
    if op == tape.DIV:
        return bounds.of_quotient(a, da, b, db)
    if op == tape.RATIO:
        return bounds.of_ratio(a, da, b, db)
    if op == tape.HYPOT:
        return bounds.of_hypot(a, da, b, db)
    if op == tape.ATAN2 or op == tape.ANGLE:
        return bounds.of_atan2(a, da, b, db)
    if op == tape.POW:
        return bounds.of_power(a, da, b, db)
    if op == tape.MOD:
        return bounds.of_mod(a, da, b, db)
    if op == tape.ABS:
        return bounds.of_max(a, da, bounds.neg(a), bounds.neg(da))
    if op == tape.MIN:
        return bounds.of_min(a, da, b, db)
    if op == tape.MAX:
        return bounds.of_max(a, da, b, db)
    if op == tape.TABLE:
        return interval_tables.of_table(notes[at], a, da, notes, code.numbers)
    if op == tape.SELECT:
        c, dc = condition(x, bounds.jet(a, da), notes)
        return bounds.of_select(c, dc, b, db, (w[4 * z], w[4 * z + 1]), (w[4 * z + 2], w[4 * z + 3]))
    if op == tape.NOT:
        c, dc = condition(x, bounds.jet(a, da), notes)
        return bounds.jet(bounds.add((1.0, 1.0), bounds.neg(c)), bounds.neg(dc))
    if op == tape.AND or op == tape.OR:
        c, dc = condition(x, bounds.jet(a, da), notes)
        e, de = condition(y, bounds.jet(b, db), notes)
        return bounds.of_min(c, dc, e, de) if op == tape.AND else bounds.of_max(c, dc, e, de)
    if op == tape.SIGN or op == tape.FLOOR or op == tape.CEIL or (op >= tape.LT and op <= tape.NE):
        return jumping(op, a, da, b, db)
    return smooth(op, a, da)


@rare
def run(code):
    """Run a program with jets."""
    w, layout = code.jets, code.layout
    for i in range(layout[L.TAPE_LENGTH]):
        o = layout[L.TAPE] + 5 * i
        op, at, x, y, z = layout[o], layout[o + 1], layout[o + 2], layout[o + 3], layout[o + 4]
        if op == tape.TABLE:
            y, z = 0, 0
        w[4 * at], w[4 * at + 1], w[4 * at + 2], w[4 * at + 3] = operation(op, at, x, y, z, code)


@kernel
def polynomial(c, i, a, b, w, place):
    """Bounds of a cubic polynomial on [a, b]: it lies between its coefficients in Bernstein's form."""
    h = b - a
    c0, c1, c2, c3 = c[i, 0], c[i, 1], c[i, 2], c[i, 3]
    d0 = c0 + a * (c1 + a * (c2 + a * c3))
    d1, d2, d3 = h * (c1 + a * (2.0 * c2 + a * 3.0 * c3)), h * h * (c2 + 3.0 * a * c3), h * h * h * c3
    p, q, r = d0 + d1 / 3.0, d0 + (2.0 * d1 + d2) / 3.0, d0 + d1 + d2 + d3
    lo, hi = min(min(d0, p), min(q, r)), max(max(d0, p), max(q, r))
    slack = ROUNDING * max(abs(lo), abs(hi))
    p, q = d1 + d2, d1 + 2.0 * d2 + 3.0 * d3
    w[place], w[place + 1] = lo - slack, hi + slack
    w[place + 2], w[place + 3] = min(d1, min(p, q)) / h, max(d1, max(p, q)) / h


@rare
def bounded(way, k, a, b, code):
    """Write the jets of all registers on [a, b] of piece k."""
    if way.pieces == 0:
        code.jets[0], code.jets[1], code.jets[2], code.jets[3] = a, b, 1.0, 1.0
    else:
        for leaf in range(len(way.ways) // way.pieces):
            polynomial(way.ways, leaf * way.pieces + k, a, b, code.jets, 4 * (1 + leaf))
    run(code)


@rare
def valued(way, k, s, code):
    """Write the values of all registers at s of piece k."""
    c, r = way.ways, code.layout[L.REGISTERS]
    if way.pieces > 0:
        for leaf in range(len(c) // way.pieces):
            i = leaf * way.pieces + k
            code.numbers[r + 1 + leaf] = c[i, 0] + s * (c[i, 1] + s * (c[i, 2] + s * c[i, 3]))
    tape.run(s, 0, code.layout[L.TAPE_LENGTH], code.nothing, code.nothing, code.numbers, code.layout)


@kernel
def write(roots, code, out, i):
    """Write the jets of roots to row i."""
    for j in range(len(roots)):
        for n in range(4):
            out[i, 4 * j + n] = code.jets[4 * roots[j] + n]


@kernel
def enclose(given, roots, out, code):
    """Jets (N, 4 R) of R roots from those of the leaves, given (N, 4 L)."""
    for i in range(len(given)):
        for j in range(given.shape[1]):
            code.jets[4 + j] = given[i, j]
        run(code)
        write(roots, code, out, i)


@kernel
def along(k, ends, roots, out, way, code):
    """Jets (N, 4 R) of R roots on the intervals ``ends`` (N, 2) of pieces k (N,)."""
    for i in range(len(k)):
        bounded(way, k[i], ends[i, 0], ends[i, 1], code)
        write(roots, code, out, i)


@kernel
def at(k, s, roots, out, way, code):
    """Values (N, R) of R roots at the places s (N,) of pieces k (N,)."""
    for i in range(len(k)):
        valued(way, k[i], s[i], code)
        for j in range(len(roots)):
            out[i, j] = code.numbers[code.layout[L.REGISTERS] + roots[j]]


@kernel
def ranges(record, order, offset, code):
    """Write the ranges of a table."""
    interval_tables.ranges(record, order, offset, code.notes, code.numbers)


@kernel
def look(resolved, roots, largest, found, way, code):
    """Fill in the ``Bounds`` that are found; the number of pieces and roots in which they allow a hidden peak.

    ``largest`` (R,) are the largest magnitudes before. Pieces that are not ``resolved`` (K,) are not searched.
    """
    count, hidden, y = way.pieces, 0, found.y
    for i in range(count + 1):
        valued(way, min(i, count - 1), 0.0 if i < count else 1.0, code)
        for j in range(len(roots)):
            y[i, j] = code.numbers[code.layout[L.REGISTERS] + roots[j]]
    for i in range(count):
        bounded(way, i, 0.0, 1.0, code)
        for j in range(len(roots)):
            r, y0, y1 = 4 * roots[j], y[i, j], y[i + 1, j]
            ends = abs(y0) + abs(y1)
            if resolved[i] == 1 and ends < inf:
                largest[j] = max(largest[j], ends)
            least = SLIGHT * ends + TINY * largest[j]
            above, below = code.jets[r + 1] - max(y0, y1), min(y0, y1) - code.jets[r]
            beyond = above if above > below or above != above else below
            found.size[i, j], found.slight[i, j], found.excess[i, j] = largest[j], least, beyond
            both = code.jets[r + 3] > least and -code.jets[r + 2] > least
            found.suspected[i, j] = 1 if resolved[i] == 1 and beyond > least and both else 0
            hidden += found.suspected[i, j]
    return hidden


@kernel
def turns(points, links, least):
    """Whether the values of linked points, as far as they are finite, have an extremum from which they return by more
    than ``least``."""
    began, way, first, top = False, 0, 0.0, 0.0
    i = 0
    while i >= 0:
        y = points[i, 1]
        if abs(y) < inf:
            if not began:
                began, first, top = True, y, y
            elif way == 0:
                if abs(y - first) > least:
                    way, top = (1 if y > first else -1), y
            elif way * (y - top) >= 0.0:
                top = y
            elif way * (top - y) > least:
                return True
        i = links[i]
    return False


@kernel
def halved(k, root, least, largest, slight, room, way, code):
    """Halve the interval between the first two points until f is monotone on each part, or changes by less than
    ``slight``, or a part is shorter than ``least``; the number of points, negative if there are too many. largest[k] is
    the largest value of f so far."""
    points, links, queue, w = room.points, room.links, room.queue, code.jets
    length, count, halvings, value = 1, 2, 0, code.layout[L.REGISTERS] + root
    queue[0, 0], queue[1, 0] = 0, 1
    links[0], links[1] = 1, -1
    while length > 0:
        for i in range(length):
            for side in range(2):
                y = abs(points[queue[side, i], 1])
                if y < inf:
                    largest[k] = max(largest[k], y)
        wide, left = max(slight, NEGLIGIBLE * largest[k] + NOTHING), 0
        for i in range(length):
            a, b = points[queue[0, i], 0], points[queue[1, i], 0]
            bounded(way, k, a, b, code)
            lo, hi, d_lo, d_hi = w[4 * root], w[4 * root + 1], w[4 * root + 2], w[4 * root + 3]
            # the second bound is tighter where terms cancel
            change = bounds.lower(hi - lo, max(-d_lo, d_hi) * (b - a))
            if d_lo < 0.0 and d_hi > 0.0 and change > wide and b - a > least:
                queue[0, left], queue[1, left] = queue[0, i], queue[1, i]
                left += 1
        halvings += left
        if halvings > MOST:
            return -count
        for i in range(left - 1, -1, -1):
            first, last = queue[0, i], queue[1, i]
            s = 0.5 * (points[first, 0] + points[last, 0])
            valued(way, k, s, code)
            points[count, 0], points[count, 1] = s, code.numbers[value]
            links[first], links[count] = count, last
            queue[0, 2 * i], queue[1, 2 * i] = first, count
            queue[0, 2 * i + 1], queue[1, 2 * i + 1] = count, last
            count += 1
        length = 2 * left
    return count


@kernel
def bisect(every, root, search, room, way, code):
    """Search the next pieces for one on which the root has extrema; with ``every``, the next piece.

    Returns FINISHED, FOUND, TOO_MANY intervals, or TIRED if all pieces so far took more operations than the credit.
    """
    points, state = room.points, search.state
    while state[0] < len(search.tried):
        i = state[0]
        k = search.tried[i]
        for side in range(2):
            points[side, 0] = search.ends[i, side]
            valued(way, k, search.ends[i, side], code)
            points[side, 1] = code.numbers[code.layout[L.REGISTERS] + root]
        count = halved(k, root, search.least[k], search.largest, PART * search.slight[k], room, way, code)
        search.spent[i] = 3 * abs(count) * code.layout[L.TAPE_LENGTH]  # two intervals and a value for each point
        state[0] += 1
        state[1] = abs(count)
        state[2] += search.spent[i]
        if state[2] > search.credit[i]:
            return TIRED
        if count < 0:
            return TOO_MANY
        if every == 1 or turns(points, room.links, search.slight[k]):
            return FOUND
    return FINISHED


@kernel
def narrow(k, root, zones, way, code):
    """Move the ends of zones of the root on piece k, ``within`` and ``beyond``, towards each other."""
    peak, reach, where, within, beyond = zones
    for _ in range(60):
        wide = False
        for i in range(len(within)):
            wide = wide or abs(beyond[i] - within[i]) > CLOSE * abs(beyond[i] - where[i])
        if not wide:
            return
        for i in range(len(within)):
            middle = 0.5 * (within[i] + beyond[i])
            valued(way, k, middle, code)
            if abs(code.numbers[code.layout[L.REGISTERS] + root] - peak[i]) <= reach[i]:
                within[i] = middle
            else:
                beyond[i] = middle
