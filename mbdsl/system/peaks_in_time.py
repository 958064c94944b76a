"""Peaks of functions of time within a step: the intervals of time in which a step has to end.

Between two neighbouring extrema a function is monotone, and the ends of a step show its change. Within a step it can
hide an extremum: a pulse, a window that opens and closes. The extrema of a term of a law are found by bisection:
intervals (:mod:`mbdsl.expressions.interval_arithmetic`) on which the bounds of its slope have one sign, or on which it
changes by less than ``NEGLIGIBLE`` of its size (its largest value so far, or its bound), are finished; all others are
halved. Around each extremum lies a *zone*, in which the term differs from its extreme value by less than a quarter of
its difference from the next extremum. No step may pass over a zone: a step has to end within it, so that its error
estimate contains the force.

Sums are split into terms, so that large terms do not hide small ones; products of sums become sums of products.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain
from typing import Generic, NamedTuple, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.interval_arithmetic import CONDITIONS
from mbdsl.expressions.symbolic import TIME, Expr, is_const, leaves, walk
from mbdsl.kernels.arrays import Array
from mbdsl.system.interval_tape import NEGLIGIBLE, NOTHING
from mbdsl.system.paths import PathPoints, Paths, Work, over_time
from mbdsl.system.time_events import is_linear

T = TypeVar("T")

#: extent of a zone, as a part of the difference from the next extremum; the same for the flanks of a narrow zone
QUARTER, FLANK = 0.25, 0.98
#: a zone is narrow if its width is below this part of the distance between the neighbouring extrema; then steps end in
#: each third of it and on its flanks
NARROW = 0.125
#: width of a zone of a sine, as an angle [rad]
HALF_WAVE = 2.0 * np.pi / 3.0
#: shortest interval that is resolved, relative to the duration of the run
SHORTEST = 1e-15
#: operations that the search of functions of time may take, and how many more for each zone, with the length of the
#: program as a unit; a single part takes less than ``ENDLESS``
CREDIT, A_ZONE, ENDLESS = 1e8, 1e3, 2**62
#: samples for a first estimate of a term's largest value
SAMPLES = 65
#: most terms of a sum; larger products are not expanded
TERMS = 64
#: the size of a term is at most this many times its largest sample, even if its bounds are larger
CANCELLED = 1e6
#: operations that sums consist of
SUMS = ("add", "sub", "mul", "neg")
#: operations that jump; controlled steps end at jumps that depend on time alone
JUMPS = (*CONDITIONS, "sign", "floor", "ceil", "mod")
#: largest degree of polynomials that are not searched for peaks
DEGREE = 3


class Zone(NamedTuple):
    """A step has to end in [start, end]."""

    start: float
    end: float
    term: Expr  #: the term of a law that has a peak in the zone, or an expression of the model that contains this term


# -- terms -------------------------------------------------------------------------------------------------------------


def terms(root: Expr) -> list[Expr]:
    """The products that ``root`` is a sum of; products of sums are expanded, except polynomials of low degree."""
    found: list[Expr] = []
    for part, negative in _summands(root):
        parts = _expanded(part)
        found += [-x for x in parts] if negative else parts
    return found


def _summands(root: Expr) -> list[tuple[Expr, bool]]:
    """The summands of ``root`` in order, and whether each is negative; without recursion, as there may be thousands."""
    found, waiting = [], [(root, False)]
    while waiting:
        x, negative = waiting.pop()
        if x.op in ("add", "sub", "neg") and degree(x) > DEGREE:
            signs = (x.op == "neg", x.op == "sub")
            waiting += [(y, negative != sign) for y, sign in zip(x.args, signs, strict=False)][::-1]
        else:
            found.append((x, negative))
    return found


@lru_cache(maxsize=4096)  # of shared expressions, each once
def _expanded(root: Expr) -> list[Expr]:
    """A product or quotient of sums as a sum."""
    if degree(root) <= DEGREE:
        return [root]
    if root.op == "mul" and root.args[0] is not root.args[1]:
        a, b = (terms(x) for x in root.args)
        if 1 < len(a) * len(b) <= TERMS:
            return [x * y for x in a for y in b]
    if root.op == "div":
        a = terms(root.args[0])
        if len(a) > 1:
            return [x / root.args[1] for x in a]
    return [root]


def degree(root: Expr) -> float:
    """The degree of a polynomial in time, coordinates and multipliers; infinite if ``root`` is not a polynomial.

    Sines of angles between bodies count as constants, and lengths as the coordinates that they consist of: steps
    resolve the motion of the mechanism, and with it these functions.
    """
    if root not in _DEGREES:
        for x in walk(root):  # arguments come before the nodes that use them
            if x not in _DEGREES:
                _DEGREES[x] = _degree(x, [_DEGREES[y] for y in x.args])
    return _DEGREES[root]


_DEGREES: WeakKeyDictionary[Expr, float] = WeakKeyDictionary()


def _degree(root: Expr, d: list[float]) -> float:
    if not root.args:
        return 0.0 if root.op in ("const", "input") else 1.0
    if root.op in ("add", "sub", "neg", "hypot"):
        return max(d)
    if root.op == "mul":
        return sum(d)
    if root.op == "pow" and is_const(root.args[1]) and float(root.args[1].value).is_integer():
        return d[0] * root.args[1].value if root.args[1].value >= 0.0 else np.inf
    if root.op == "div" and d[1] == 0.0:
        return d[0]
    if root.op in ("div", "ratio") and root.args[1].op == "hypot":
        return d[0]
    if root.op in ("sin", "cos") and _is_angle(root.args[0]):
        return 0.0
    return np.inf if any(d) else 0.0


def _is_angle(x: Expr) -> bool:
    """Whether ``x`` is a sum of angles of bodies and constants."""
    if x.op in ("add", "sub", "neg"):
        return all(_is_angle(y) for y in x.args)
    return x.op == "const" or (x.op == "coordinate" and x.value[1] == "phi")


@lru_cache(maxsize=4096)
def pace(root: Expr) -> float:
    """An upper bound of the frequency [rad/s] of a function of time alone, from its form; infinite if unknown.

    Jumps at which steps end anyway (:mod:`mbdsl.system.time_events`) do not count.
    """
    if degree(root) <= DEGREE:
        return 0.0
    rate = abs(_slope(root.args[0])) if root.args and degree(root.args[0]) <= 1 else np.inf
    if root.op in ("sin", "cos", "exp", "tanh", "sinh", "cosh"):
        return rate
    if root.op == "table":
        return rate * np.pi / float(np.diff(root.value[0].u).min())
    if root.op in ("add", "sub", "neg"):
        return max(pace(x) for x, _ in _summands(root))
    if root.op == "mul":
        return sum(pace(x) for x in root.args)
    if root.op == "div" and not leaves(root.args[1]):
        return pace(root.args[0])
    if root.op == "select" and _only_jumps(root.args[0]):
        return max(pace(x) for x in root.args[1:])
    return 0.0 if _only_jumps(root) else np.inf


def _slope(x: Expr) -> float:
    rate = diff(x, TIME)[0]
    return float(rate.value) if is_const(rate) else np.inf


def _only_jumps(x: Expr) -> bool:
    return is_linear(x) and all(n.op not in ("table", "abs", "min", "max") for n in walk(x))


def hiding(roots: Iterable[Expr]) -> list[Expr]:
    """Terms of ``roots``, and of sums within them, that may have narrow peaks."""
    found: dict[Expr, None] = {}
    for root in roots:
        for sum_ in (root, *(x for n in walk(root) if n.op not in SUMS for x in n.args)):
            parts = [x for x in terms(sum_) if degree(x) > DEGREE]
            if sum_ is root or len(parts) > 1:
                found.update(dict.fromkeys(parts))
            if len(parts) > 1:
                found[sum(parts[1:], parts[0])] = None
    return list(found)


def abrupt(root: Expr) -> list[Expr]:
    """The largest parts of ``root`` that may have narrow peaks: not products and lengths of coordinates."""
    found: list[Expr] = []
    waiting = [root]
    while waiting:
        x = waiting.pop()
        smooth = x.op in (*SUMS, "div", "ratio", "hypot", "sqrt", "angle", "atan2") or degree(x) <= DEGREE
        if smooth or (x.op == "pow" and is_const(x.args[1])):
            waiting += x.args[::-1]
        else:
            found.append(x)
    return list(dict.fromkeys(found))


def of_time(roots: Iterable[Expr]) -> list[Expr]:
    """The largest parts of ``roots`` that depend on time alone."""
    alone: dict[Expr, bool] = {}
    order = walk(*roots)
    for n in order:
        alone[n] = n.op in ("time", "const") or (bool(n.args) and all(alone[x] for x in n.args))
    inner = chain(roots, (x for n in order if not alone[n] for x in n.args))
    return [x for x in dict.fromkeys(inner) if alone[x] and leaves(x)]


def passable(roots: Iterable[Expr], h: float) -> list[Expr]:
    """Terms of ``roots`` that depend on time alone and may have a peak, or a jump, within a fixed step h [s]."""
    found = hiding(of_time(list(roots)))
    return [x for x in found if not pace(x) * h < HALF_WAVE or any(n.op in JUMPS for n in walk(x))]


# -- zones on a path ---------------------------------------------------------------------------------------------------


def turns(y: Array, least: float) -> list[int]:
    """The ends of a sequence, and its extrema between them from which it returns by more than ``least``."""
    if not len(y):
        return []
    found, best, way = [0], 0, 0
    values = y.tolist()
    for i, x in enumerate(values):
        top = values[best]
        if way == 0:
            if abs(x - values[0]) > least:
                way, best = (1 if x > values[0] else -1), i
        elif way * (x - top) >= 0.0:
            best = i if way * (x - top) > 0.0 else best
        elif way * (top - x) > least:
            found.append(best)
            way, best = -way, i
    if found[-1] != len(values) - 1:
        found.append(len(values) - 1)
    return found


def zones(f: Paths, k: int, points: PathPoints, least: float, edges: bool = False) -> Array:
    """Starts and ends (2, number) of the zones around the extrema of the first root of f on piece k, from the points
    between which it is monotone; ``edges`` includes its ends."""
    s, y = points
    at = turns(y, least)
    if not at:  # finite nowhere
        return np.empty((2, 0))
    before, behind = [at[0], *at[:-1]], [*at[1:], at[-1]]
    ways = [
        (i, p, n)
        for i, p, n in zip(at, before, behind, strict=True)
        if p < i < n or (edges and max(abs(y[i] - y[p]), abs(y[i] - y[n])) > least)
    ]
    ends = np.array([[(i, side) for side in (p, n)] for i, p, n in ways], int).reshape(-1, 2)
    height, where, found = np.abs(y[ends[:, 0]] - y[ends[:, 1]]), s[ends[:, 0]], []
    for part in (QUARTER, FLANK):
        reach = part * height
        within, beyond = where.copy(), where.copy()
        values = y.tolist()
        for n, (i, other) in enumerate(ends.tolist()):
            j, way = i, 1 if other > i else -1
            while j != other and abs(values[j + way] - values[i]) <= reach[n]:
                j += way
            within[n], beyond[n] = s[j], s[j + way if j != other else j]
        f.narrow(0, k, y[ends[:, 0]], reach, where, within, beyond)
        found.append(within.reshape(-1, 2))
    every = []
    for (_, p, n), inner, outer in zip(ways, *found, strict=True):
        narrow = inner[1] - inner[0] < NARROW * (s[n] - s[p])
        every += _parts(inner, outer) if narrow else [inner]
    return np.array(every).reshape(-1, 2).T


def _parts(inner: Array, outer: Array) -> list[Array]:
    """The zones of a narrow peak: its flanks, unless they are jumps, and the thirds of its top."""
    cuts = np.array([outer[0], *np.linspace(inner[0], inner[1], 4), outer[1]])
    return [cuts[n : n + 2] for n in range(5) if cuts[n + 1] - cuts[n] > 0.1 * (inner[1] - inner[0])]


# -- time alone --------------------------------------------------------------------------------------------------------


def time_zones(
    roots: Iterable[Expr], t0: float, t1: float, longest: float, given_up: list[float] | None = None
) -> Iterator[Zone]:
    """The zones in (t0, t1) of all terms that depend on time alone, ordered by their ends; generated lazily. No step is
    longer than ``longest``. Where the search takes too many operations, it ends, and its time is added to ``given_up``.
    """
    found = [x for x in hiding(of_time(list(roots))) if pace(x) > 0.0 and not pace(x) * longest < HALF_WAVE]
    left, ends = [CREDIT], [] if given_up is None else given_up
    return heapq.merge(*(_of_term(term, t0, t1, left, ends) for term in found), key=lambda zone: zone.end)


def _of_term(term: Expr, t0: float, t1: float, left: list[float], given_up: list[float]) -> Iterator[Zone]:
    """The zones of a term; all terms share the number of operations ``left`` (1,)."""
    f, path = over_time(term), np.zeros(1, np.int64)
    with np.errstate(all="ignore"):
        samples = f.at(np.zeros(SAMPLES, np.int64), np.linspace(t0, t1, SAMPLES))[:, 0]
        lo, hi, *_ = f.jets(path, np.array([t0]), np.array([t1]))
        bound = float(np.maximum(-lo, hi)[0, 0])  # much larger than the term's values where its summands cancel
    largest = np.abs(samples[np.isfinite(samples)]).max(initial=0.0)
    size = np.array([max(largest, min(bound, CANCELLED * largest)) if np.isfinite(bound) else largest])
    least = max(SHORTEST * (t1 - t0), 4.0 * float(np.spacing(max(abs(t0), abs(t1)))))
    shortest, slight = np.full(1, least), np.full(1, NOTHING)
    rest, width = [(t0, t1)], t1 - t0
    while rest:
        a, b = rest.pop()
        if left[0] < 0.0:
            given_up.append(a)
            return
        with np.errstate(all="ignore"):
            points = None
            if b - a <= 4.0 * width:
                work = Work(np.full(1, ENDLESS))
                ((_, points),) = f.monotone(0, path, np.array([[a, b]]), shortest, size, slight, work, every=True)
                left[0] -= work.each[0]
            if points is None:
                middle = 0.5 * (a + b)
                if a < middle < b:
                    rest += [(middle, b), (a, middle)]
                    width = min(width, middle - a)
                continue
            width = b - a
            floor = 4.0 * NEGLIGIBLE * float(size[0]) + NOTHING
            found = sorted(zones(f, 0, points, floor, a > t0 or b < t1).T.tolist(), key=lambda zone: zone[1])
        left[0] += len(found) * A_ZONE * f.program.length
        for start, end in found:
            if t0 < start and end < t1:
                yield Zone(start, end, term)


class Replayed(Generic[T]):
    """An iterable over the items of an iterator, which it stores so that they can be iterated again."""

    def __init__(self, source: Iterator[T]) -> None:
        self._source, self._found = source, list[T]()

    def __iter__(self) -> Iterator[T]:
        at = 0
        while True:
            if at == len(self._found):
                following = next(self._source, None)
                if following is None:
                    return
                self._found.append(following)
            yield self._found[at]
            at += 1
