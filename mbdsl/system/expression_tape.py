"""Expressions of the model in the step loop: a program over registers, which one compiled interpreter runs.

For the compiled code an expression is data, so that a change requires no compilation. Values and exact derivatives
share their subexpressions: the value tape runs at every evaluation; the gradient tape continues it when the iteration
matrix is computed. An instruction is (op, target, a, b, c); operands are registers.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from numpy import arccos as acos
from numpy import arcsin as asin
from numpy import arctan as atan
from numpy import arctan2 as atan2
from numpy import ceil, cos, cosh, exp, floor, hypot, log, log10, nan, pi, sin, sinh, sqrt, tan, tanh

from mbdsl.expressions import spatial_coordinates
from mbdsl.expressions.symbolic import COORDINATES, Expr, const, walk
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

# The order matters: the interpreter compares in this order, so that frequent cheap operations come first.
_NAMES = (
    "load add sub mul div neg sin cos ratio hypot sqrt select lt le eq ne and or not abs sign min max pow tan asin "
    "acos atan atan2 sinh cosh tanh exp log log10 floor ceil mod multiplier table angle"
).split()
OPCODE = {name: i for i, name in enumerate(_NAMES)}
LOAD, ADD, SUB, MUL, DIV, NEG, SIN, COS, RATIO, HYPOT, SQRT, SELECT = range(12)
LT, LE, EQ, NE, AND, OR, NOT, ABS, SIGN, MIN, MAX, POW, TAN, ASIN = range(12, 26)
ACOS, ATAN, ATAN2, SINH, COSH, TANH, EXP, LOG, LOG10, FLOOR, CEIL, MOD, MULTIPLIER, TABLE, ANGLE = range(26, 41)


@dataclass
class Tape:
    """A program under construction: ``code`` in order, ``registers`` with their initial content (constants, time)."""

    frames: dict[str, int]
    spatial: bool = False
    multipliers: dict[tuple[str, int], int] = field(default_factory=dict)  #: (joint, k) -> entry in a row of vectors
    starts: dict[str, float] = field(default_factory=dict)  #: name of an input -> its start value
    inputs: dict[str, int] = field(default_factory=dict)  #: name -> register, of those in use
    code: list[tuple[int, int, int, int, int]] = field(default_factory=list)
    registers: list[float] = field(default_factory=lambda: [0.0])  #: register 0 is time
    tables: list = field(default_factory=list)
    roots: list[Expr] = field(default_factory=list)  #: the expressions requested by ``add``
    begun: dict[Expr, int] = field(default_factory=dict)  #: value at the start -> its register
    angles: dict[Expr, int] = field(default_factory=dict)  #: angle that counts turns -> register of its last value
    _where: dict[Expr, int] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[str, ...]:
        """The coordinates in the columns of the frame table."""
        return spatial_coordinates.COORDINATES if self.spatial else COORDINATES

    def add(self, root: Expr) -> int:
        """The register of ``root``; appends the missing instructions."""
        self.roots.append(root)
        for node in walk(root, known=self._where):
            if node.op == "time":
                self._where[node] = 0
                continue
            if node.op == "angle":  # the register before that of the angle is for its value at the last accepted step
                self.angles[node] = len(self.registers)
                self.registers.append(0.0)
            self._where[node] = target = len(self.registers)
            self.registers.append(float(node.value) if node.op == "const" else 0.0)
            if node.op == "const":
                continue
            if node.op == "start":
                self.begun[node] = target
                continue
            if node.op == "input":
                name = str(node.value)
                self.inputs[name], self.registers[target] = target, self.starts[name]
                continue
            if node.op == "multiplier":
                self.code.append((OPCODE["multiplier"], target, self.multipliers[node.value], 0, 0))
                continue
            if node.op == "coordinate":
                frame, key = node.value
                self.code.append((LOAD, target, self.frames[frame], self.columns.index(key), 0))
                continue
            if node.op == "table":
                table, order = node.value
                if table not in self.tables:
                    self.tables.append(table)
                self.code.append((TABLE, target, self._where[node.args[0]], self.tables.index(table), order))
                continue
            a = [self._where[x] for x in node.args] + [0, 0]
            if node.op == "angle":
                a[2] = target - 1
            self.code.append((OPCODE[node.op], target, a[0], a[1], a[2]))
        return self._where[root]

    @property
    def known(self) -> dict[Expr, int]:
        """The registers of all nodes so far; a copy."""
        return dict(self._where)

    def continue_from(self, known: dict[Expr, int]) -> None:
        """Let what follows share the nodes ``known`` only."""
        self._where = dict(known)

    def take(self, leaves: list[Expr]) -> None:
        """Append a register for each of ``leaves``, which the caller fills."""
        for leaf in leaves:
            self._where[leaf] = len(self.registers)
            self.registers.append(0.0)

    def register(self, node: Expr) -> int:
        """The register of a part of an expression that was added."""
        return self._where[node]

    def zero(self) -> int:
        return self.add(const(0.0))


@rare
def search(v, o, n, numbers):
    """The index of the cell of v among the n breaks at o in numbers: the last break <= v, at most the last but one."""
    lo, hi = 0, n - 1
    while hi - lo > 1:
        mid = (lo + hi) // 2
        if numbers[o + mid] <= v:
            lo = mid
        else:
            hi = mid
    return lo


@rare
def cell_of(u, header, knots, ends, numbers, layout):
    """An integer for the piece of a table that contains u; pieces end at ``knots``, at its ``ends``, or at both."""
    n, o, beyond = layout[header], layout[header + 1], layout[header + 2]
    first, last = numbers[o], numbers[o + n - 1]
    lap = 0
    if beyond == 2 and (u < first or u > last):  # periodic, see below
        lap = int(floor((u - first) / (last - first)))
        u = first + (u - first) - lap * (last - first)
    elif ends and u < first:
        return -1
    elif ends and u > last:
        return n
    lo = search(min(max(u, first), last), o, n, numbers) if knots else 0
    return (lap * n if ends else 0) + lo


@rare
def interpolate(u, order, header, numbers, layout):
    """Piecewise cubic: derivative ``order`` at u of the table with (points, offset, extrapolation) at ``header``."""
    n, o, beyond = layout[header], layout[header + 1], layout[header + 2]
    first, last = numbers[o], numbers[o + n - 1]
    outside = u < first or u > last
    if outside and beyond == 2:  # periodic
        u = first + (u - first) - floor((u - first) / (last - first)) * (last - first)
    if beyond == 3 and outside:
        return nan if order == 0 else 0.0  # "error": not a number, which stops the integration
    v = min(max(u, first), last)
    lo = search(v, o, n, numbers)
    c = o + n + 4 * lo
    x = v - numbers[o + lo]
    if outside and beyond < 2:
        slope = numbers[c + 1] + x * (2.0 * numbers[c + 2] + x * 3.0 * numbers[c + 3])
        value = numbers[c] + x * (numbers[c + 1] + x * (numbers[c + 2] + x * numbers[c + 3]))
        if beyond == 0:  # hold
            slope = 0.0
        if order == 0:
            return value + slope * (u - v)
        return slope if order == 1 else 0.0
    if order == 0:
        return numbers[c] + x * (numbers[c + 1] + x * (numbers[c + 2] + x * numbers[c + 3]))
    if order == 1:
        return numbers[c + 1] + x * (2.0 * numbers[c + 2] + x * 3.0 * numbers[c + 3])
    if order == 2:
        return 2.0 * numbers[c + 2] + 6.0 * x * numbers[c + 3]
    return 6.0 * numbers[c + 3] if order == 3 else 0.0


@kernel
def function(op, a, b):
    """A relation, or a function of one or two numbers."""
    if op == LT:
        y = 1.0 if a < b else 0.0
    elif op == LE:
        y = 1.0 if a <= b else 0.0
    elif op == EQ:
        y = 1.0 if a == b else 0.0
    elif op == NE:
        y = 1.0 if a != b else 0.0
    elif op == AND:
        y = 1.0 if a != 0.0 and b != 0.0 else 0.0
    elif op == OR:
        y = 1.0 if a != 0.0 or b != 0.0 else 0.0
    elif op == NOT:
        y = 1.0 if a == 0.0 else 0.0
    elif op == ABS:
        y = abs(a)
    elif op == SIGN:
        y = 1.0 if a > 0.0 else (-1.0 if a < 0.0 else 0.0)
    elif op == MIN:
        y = min(a, b)
    elif op == MAX:
        y = max(a, b)
    elif op == POW:
        y = a**b
    elif op == TAN:
        y = tan(a)
    elif op == ASIN:
        y = asin(a)
    elif op == ACOS:
        y = acos(a)
    elif op == ATAN:
        y = atan(a)
    elif op == ATAN2:
        y = atan2(a, b)
    elif op == SINH:
        y = sinh(a)
    elif op == COSH:
        y = cosh(a)
    elif op == TANH:
        y = tanh(a)
    elif op == EXP:
        y = exp(a)
    elif op == LOG:
        y = log(a)
    elif op == LOG10:
        y = log10(a)
    elif op == FLOOR:
        y = floor(a) * 1.0
    elif op == CEIL:
        y = ceil(a) * 1.0
    elif op == MOD:
        y = a - floor(a / b) * b
    else:
        y = nan
    return y


@rare
def run(t, first, count, vectors, frames, numbers, layout):
    """Run instructions ``first`` ... ``first + count - 1`` of the tape; writes registers, in numbers."""
    r = layout[L.REGISTERS]
    numbers[r] = t
    for i in range(first, first + count):
        o = layout[L.TAPE] + 5 * i
        op, target = layout[o], r + layout[o + 1]
        if op == LOAD:
            numbers[target] = frames[layout[o + 2], layout[o + 3]]
            continue
        if op == MULTIPLIER:
            numbers[target] = vectors[layout[L.LAW_ROW], layout[o + 2]]
            continue
        a, b = numbers[r + layout[o + 2]], numbers[r + layout[o + 3]]
        if op == ADD:
            y = a + b
        elif op == SUB:
            y = a - b
        elif op == MUL:
            y = a * b
        elif op == DIV:
            y = a / b
        elif op == NEG:
            y = -a
        elif op == SIN:
            y = sin(a)
        elif op == COS:
            y = cos(a)
        elif op == RATIO:
            y = a / b if b != 0.0 else 0.0
        elif op == HYPOT:
            y = hypot(a, b)
        elif op == SQRT:
            y = sqrt(a)
        elif op == SELECT:
            y = b if a != 0.0 else numbers[r + layout[o + 4]]
        elif op == ANGLE:
            y = atan2(a, b)
            y = y + 2.0 * pi * floor((numbers[r + layout[o + 4]] - y) / (2.0 * pi) + 0.5)
        elif op == TABLE:
            y = interpolate(a, layout[o + 4], layout[L.TABLES] + 3 * layout[o + 3], numbers, layout)
        else:
            y = function(op, a, b)
        numbers[target] = y
