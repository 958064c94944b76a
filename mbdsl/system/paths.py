"""Expressions along paths, with values and bounds: the compiled :mod:`mbdsl.system.interval_tape` for arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import code_cache
from mbdsl.expressions.interval_arithmetic import CONDITIONS, ROUNDING, Jet
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics.piecewise_cubic import SMOOTHNESS, piecewise
from mbdsl.system import interval_tape
from mbdsl.system.expression_tape import TABLE, Tape

Ints = Integers
EMPTY = np.zeros((0, 4))
EXTRAPOLATION = {"hold": 0, "linear": 1, "periodic": 2, "error": 3}
_WAY, _CODE = ("int", "matrix"), ("ints", "ints", "vector", "vector", "matrix")
_GROUPS: dict[str, Any] = {"room": interval_tape.Room, "way": interval_tape.Way, "code": interval_tape.TapeProgram}
_GROUPS |= {"found": interval_tape.Bounds, "search": interval_tape.Search, "zones": interval_tape.Zones}
SIGNATURES = {
    "enclose": code_cache.Signature(("matrix", "ints", "matrix", *_CODE)),
    "along": code_cache.Signature(("ints", "matrix", "ints", "matrix", *_WAY, *_CODE)),
    "at": code_cache.Signature(("ints", "vector", "ints", "matrix", *_WAY, *_CODE)),
    "bisect": code_cache.Signature(
        (
            *("int", "int", "ints", "matrix", "vector", "vector", "vector", "ints", "ints", "ints"),
            *("matrix", "ints", "int matrix", *_WAY, *_CODE),
        ),
        gives="int",
    ),
    "look": code_cache.Signature(("ints", "ints", "vector", *["matrix"] * 4, "int matrix", *_WAY, *_CODE), gives="int"),
    "ranges": code_cache.Signature(("int", "int", "int", *_CODE)),
    "narrow": code_cache.Signature(("int", "int", *["vector"] * 5, *_WAY, *_CODE)),
}
NAME = "mbdsl_bounds"


@cache
def _text() -> str:
    """The text of the emitted module: the kernels with their tuples taken apart."""
    lines = ['"""Emitted by mbdsl: bounds of expressions along paths."""', "", "from mbdsl.system import interval_tape"]
    for name in SIGNATURES:
        code = getattr(interval_tape, name).__code__
        takes = code.co_varnames[: code.co_argcount]
        apart = ", ".join(field for x in takes for field in getattr(_GROUPS.get(x), "_fields", (x,)))
        made = (
            f"interval_tape.{_GROUPS[x].__name__}({', '.join(_GROUPS[x]._fields)})" if x in _GROUPS else x
            for x in takes
        )
        lines += ["", "", f"def {name}({apart}):", f"    return interval_tape.{name}({', '.join(made)})"]
    return "\n".join([*lines, ""])


class PathKernels(NamedTuple):
    enclose: Callable
    along: Callable
    at: Callable
    bisect: Callable
    look: Callable
    ranges: Callable
    narrow: Callable


def kernels() -> PathKernels:
    """The compiled kernels of :mod:`mbdsl.system.interval_tape`, from the cache."""
    return PathKernels(*code_cache.functions(NAME, _text(), SIGNATURES, lambda: [interval_tape]))


class Program:
    """Expressions as a program over their leaves.

    Parameters
    ----------
    roots : iterable of Expr
    time : bool
        Whether the parameter s of the paths is time; else time is one of the leaves.
    """

    def __init__(self, roots: Iterable[Expr], time: bool = False) -> None:
        self.roots = list(roots)
        found = [x for x in leaves(*self.roots) if not (time and x.op == "time")]
        self.leaves = [x for x in found if x.op != "input"]
        tape = Tape({}, starts={str(x.value): 0.0 for x in found if x.op == "input"})
        tape.take(self.leaves)
        self.inputs = tape.inputs
        self.registers = np.array([tape.add(x) for x in self.roots], np.int64)
        self.length = len(tape.code)
        self.kernels = kernels()
        self._conditions = {tape.register(x) for x in walk(*self.roots) if x.op in CONDITIONS}
        self._store(tape)

    def _store(self, tape: Tape) -> None:
        layout, numbers, headers, where = [0] * L.BLOCKS, list(tape.registers), list[int](), list[int]()
        count = len(tape.registers)
        for table in tape.tables:
            breaks, coefficients = piecewise(table)
            where.append(len(numbers))
            headers += [len(breaks), len(numbers), EXTRAPOLATION[table.extrapolation]]
            numbers += [*breaks.tolist(), *coefficients.ravel().tolist()]
        layout[L.TABLES] = len(layout)
        layout += headers
        layout[L.TAPE], layout[L.TAPE_LENGTH] = len(layout), len(tape.code)
        layout += [x for instruction in tape.code for x in instruction]
        notes = [int(register in self._conditions) for register in range(count)]
        ranges = []
        for op, target, _, number, order in tape.code:
            if op != TABLE:
                continue
            table, at, n = tape.tables[number], where[number], len(tape.tables[number].u)
            smooth, _ = SMOOTHNESS[table.smoothness if n > 2 else "linear"]
            both, size = (len(numbers), len(numbers) + 4 * n), 8 * n
            notes[target] = len(notes)
            ranges += [(len(notes), order + i, offset) for i, offset in enumerate(both)]
            notes += [n, at, at + n, EXTRAPOLATION[table.extrapolation], order, smooth]
            notes += [int(table.y[0] != table.y[-1]), *both]
            numbers += [0.0] * size
        jets = np.zeros(4 * count)
        jets[0::4] = jets[1::4] = numbers[:count]
        self.code = np.array(layout), np.array(notes), np.array(numbers), jets, np.zeros((1, 1))
        with np.errstate(all="ignore"):
            for given in ranges:
                self.kernels.ranges(*given, *self.code)

    def of(self, ways: Mapping[Expr, Array], inputs: Mapping[str, float]) -> Paths:
        """The expressions along paths: each leaf has the coefficients (K, 4) of a polynomial on each of K pieces."""
        return Paths(self, np.concatenate([ways[x] for x in self.leaves] or [EMPTY]), inputs)


class Looks(NamedTuple):
    """What bounds show of R roots on each of K pieces; arrays (K, R).

    The largest magnitude of each root so far, the negligible height of a peak, by how much the bounds exceed the values
    at the ends, and whether a peak is possible; and whether it is possible anywhere.
    """

    size: Array
    slight: Array
    excess: Array
    suspected: NDArray[np.bool_]
    any: bool


class Paths:
    """A program along paths of K pieces; ``ways`` (leaves*K, 4) holds the coefficients of leaf after leaf.

    The registers belong to the program, and inputs keep the values of the Paths made last.
    """

    def __init__(self, program: Program, ways: Array, inputs: Mapping[str, float], pieces: int | None = None) -> None:
        self.program, self._ways = program, np.ascontiguousarray(ways, float)
        count = len(program.leaves)
        self.pieces = (len(ways) // count if count else 1) if pieces is None else pieces
        _, _, numbers, jets, _ = self._code = program.code
        for name, register in program.inputs.items():
            numbers[register] = jets[4 * register] = jets[4 * register + 1] = inputs[name]
        self._way = self.pieces, self._ways
        self._kernels = program.kernels

    def at(self, k: Ints, s: Array) -> Array:
        """Values (N, R) at the places s (N,) of pieces k (N,)."""
        out = np.empty((len(k), len(self.program.roots)))
        self._kernels.at(_ints(k), _floats(s), self.program.registers, out, *self._way, *self._code)
        return out

    def jets(self, k: Ints, a: Array, b: Array) -> Jet:
        """Bounds (N, R) on the intervals [a, b] (N,) of pieces k (N,)."""
        out = np.empty((len(k), 4 * len(self.program.roots)))
        ends = np.stack([a, b], axis=1)
        self._kernels.along(_ints(k), ends, self.program.registers, out, *self._way, *self._code)
        return Jet(*out.reshape(len(k), -1, 4).transpose(2, 0, 1))

    def enclose(self, leaves: Array) -> Jet:
        """Bounds (N, R) from those of the leaves (N, L, 4)."""
        out = np.empty((len(leaves), 4 * len(self.program.roots)))
        given = np.ascontiguousarray(leaves.reshape(len(leaves), -1))
        self._kernels.enclose(given, self.program.registers, out, *self._code)
        return Jet(*out.reshape(len(leaves), -1, 4).transpose(2, 0, 1))

    def look(self, resolved: NDArray[np.bool_], seen: Array) -> Looks:
        """What bounds show of all pieces, of which those that are not ``resolved`` (K,) are not searched; ``seen`` (R,)
        are the largest magnitudes of the roots so far."""
        shape = self.pieces, len(self.program.roots)
        y, size, slight, excess = np.empty((shape[0] + 1, shape[1])), *(np.empty(shape) for _ in range(3))
        suspected = np.empty(shape, np.int64)
        given = resolved.astype(np.int64), self.program.registers, seen.copy()
        count = self._kernels.look(*given, y, size, slight, excess, suspected, *self._way, *self._code)
        return Looks(size, slight, excess, suspected == 1, count > 0)

    def over(self, first: Ints) -> Jet:
        """Bounds (N, R) over all pieces from each of ``first`` (N,) to the next one."""
        c0, c1, c2, c3 = self._ways.reshape(-1, self.pieces, 4).transpose(2, 0, 1)
        values = np.array([c0, c0 + c1 / 3.0, c0 + (2.0 * c1 + c2) / 3.0, c0 + c1 + c2 + c3])
        slopes = np.array([c1, c1 + c2, c1 + 2.0 * c2 + 3.0 * c3])
        lo, d_lo = (np.minimum.reduceat(x.min(axis=0), first, axis=1) for x in (values, slopes))
        hi, d_hi = (np.maximum.reduceat(x.max(axis=0), first, axis=1) for x in (values, slopes))
        slack = ROUNDING * np.maximum(np.abs(lo), np.abs(hi))
        return self.enclose(np.stack([lo - slack, hi + slack, d_lo, d_hi], axis=-1).swapaxes(0, 1))

    def monotone(
        self,
        root: int,
        tried: Ints,
        ends: Array,
        least: Array,
        largest: Array,
        slight: Array,
        work: Work,
        every: bool = False,
    ) -> Iterator[tuple[int, PathPoints | None]]:
        """Points between which root number ``root`` is monotone, for those of the pieces ``tried`` on which it has
        extrema; ``every``: for all of them.

        On piece k the root is searched from ends[i, 0] to ends[i, 1], where k = tried[i]. Intervals that are shorter
        than ``least`` (K,), or on which it changes by a negligible part of ``slight`` (K,), the negligible height of a
        peak, or of its largest value, are not halved; ``largest`` (K,) is a lower bound of that, and is updated. None
        in place of points: there are too many. The search ends where its ``work`` exceeds the credit.
        """
        state, most = np.zeros(3, np.int64), interval_tape.MOST
        points = np.empty((2 + most, 2))
        room = points, np.empty(2 + most, np.int64), np.empty((2, 2 * most), np.int64)
        tried, spent = _ints(tried), np.zeros(len(tried), np.int64)
        credit = work.left[tried]
        given = tried, _floats(ends), _floats(least), _floats(largest), _floats(slight), credit, spent, state
        register = int(self.program.registers[root])
        try:
            while True:
                found = self._kernels.bisect(int(every), register, *given, *room, *self._way, *self._code)
                if found == interval_tape.FINISHED:
                    return
                k = int(tried[state[0] - 1])
                if found == interval_tape.TIRED:
                    work.until = k
                    return
                yield k, None if found == interval_tape.TOO_MANY else PathPoints.of(points[: state[1]])
        finally:
            work.add(tried, spent)

    def narrow(self, root: int, k: int, peak: Array, reach: Array, where: Array, within: Array, beyond: Array) -> None:
        """Move ``within`` and ``beyond`` (N,) to the places on piece k where root number ``root`` differs from ``peak``
        (N,), its value at ``where`` (N,), by ``reach`` (N,); the values at ``within`` differ less."""
        given = k, int(self.program.registers[root]), peak, reach, where, within, beyond
        self._kernels.narrow(*given, *self._way, *self._code)


class Work:
    """The operations of a search in K pieces that follow each other.

    Attributes
    ----------
    left : (K,)
        How many operations may still be added to those of each piece and all pieces before it.
    each : (K,)
        Those of each piece so far.
    until : int
        The first piece that takes more; K: there is none.
    """

    def __init__(self, left: Array) -> None:
        self.left = left.astype(np.int64)
        self.each, self.until = np.zeros(len(left), np.int64), len(left)

    def add(self, pieces: Ints, spent: Ints) -> None:
        """Count the operations spent on pieces."""
        self.each[pieces] += spent
        more = np.zeros(len(self.left), np.int64)
        more[pieces] = spent
        self.left -= np.cumsum(more)


class PathPoints(NamedTuple):
    """Values y at points s, in order, between which a function is monotone."""

    s: Array
    y: Array

    @classmethod
    def of(cls, points: Array) -> PathPoints:
        """Those of unordered points (N, 2) that have finite values, each once."""
        s, first = np.unique(points[:, 0], return_index=True)
        y = points[first, 1]
        good = np.isfinite(y)
        return cls(s[good], y[good])


def over_time(root: Expr) -> Paths:
    """An expression of time alone: one path, the time itself."""
    return Paths(Program([root], time=True), EMPTY, {}, 0)


def _ints(x: Ints) -> Ints:
    return np.ascontiguousarray(x, np.int64)


def _floats(x: Array) -> Array:
    return np.ascontiguousarray(x, float)
