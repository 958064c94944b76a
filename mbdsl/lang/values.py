"""Values with dimensions, and arithmetic on them.

A :class:`Quantity` is a scalar: a number, truth value or text that is known before the start, or an :class:`Expr` that
varies in time. Its dimension is None if nothing determines it ("bare": in SI, compatible with every dimension). Arrays
are tuples of quantities.

The rules for bare values: a sum has the dimension of the side that has one. In a product with a constant, a number
written out (``literal``) is a pure number (``2*L1`` is a length); in a product with a varying value, it leaves the
result bare (``-100*x`` may be a force). Any other bare value leaves a product bare.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Union

from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import limits, units
from mbdsl.lang.quantities import type_name, unit_text, words
from mbdsl.lang.units import NUMBER, Dimension


class Quantity:
    """One scalar value. ``boolean`` distinguishes a condition from a number if ``value`` is an expression.

    ``unit`` is the unit that the value was written with, for messages; None if there is none, or several.
    """

    __slots__ = ("boolean", "dimension", "literal", "unit", "value")

    def __init__(
        self,
        value: float | int | bool | str | Expr,
        dimension: Dimension | None = None,
        literal: bool = False,
        boolean: bool = False,
        unit: units.Unit | None = None,
    ) -> None:
        self.value = value
        self.unit = unit
        self.dimension = dimension
        self.literal = literal
        self.boolean = boolean or value is True or value is False

    @property
    def varying(self) -> bool:
        return isinstance(self.value, Expr) and not symbolic.is_const(self.value)

    @property
    def expression(self) -> Expr:
        """The value as an expression, of numbers and conditions."""
        assert not isinstance(self.value, str)
        return symbolic.expr(self.value)

    @property
    def known(self) -> float:
        """The value of a number that does not vary."""
        assert not isinstance(self.value, str)
        return float(self.value.value if isinstance(self.value, Expr) else self.value)

    @property
    def number(self) -> bool:
        return not self.boolean and not isinstance(self.value, str)

    def __repr__(self) -> str:
        return f"Quantity({describe(self)}, {self.value!r})"


Value = Union[Quantity, tuple["Value", ...]]  # noqa: UP007  (it names itself)


def literal(value: float | int) -> Quantity:
    return Quantity(value, None, True)


def boolean(value: float | Expr) -> Quantity:
    return Quantity(value, NUMBER, boolean=True)


def describe(value: Value) -> str:
    """A description of ``value`` for messages: "a length [m]", "an array of 3"."""
    if isinstance(value, tuple):
        return f"an array of {len(value)}"
    if value.boolean:
        return "a Boolean"
    if isinstance(value.value, str):
        return "a text"
    if value.dimension is None:
        return "a number" if value.literal else "a number without unit"
    return words(value.dimension)


def numeric(q: Value, what: str) -> Quantity:
    if isinstance(q, tuple) or not q.number:
        hint = (
            "write `(if b then 1 else 0)` for the number of a Boolean b"
            if not isinstance(q, tuple) and q.boolean
            else None
        )
        raise ModelError(f"{what} takes numbers, found {describe(q)}", hint=hint)
    return q


def _with_units(dimension: Dimension, operation: str) -> str:
    """How a pure number beside a value of another dimension gets a unit."""
    if dimension == units.dimension("s") and operation in ("`+`", "`-`"):  # `pi/2 - 2*pi*time`
        return "if an angle is meant, multiply the time by a rate, as in `2*pi*(1 rad/s)*time`"
    kind, unit = type_name(dimension), unit_text(dimension)
    declared = f"a variable has the unit of its type, as `{kind} x`; " if kind else ""
    return f"{declared}a number gets a unit by a factor, `1 {unit}*...`"


def common(a: Quantity, b: Quantity, operation: str) -> Dimension | None:
    """The common dimension of two values, which must not have different ones."""
    if a.dimension is None:
        return b.dimension
    if b.dimension is not None and a.dimension != b.dimension:
        hint = None
        if NUMBER in (a.dimension, b.dimension):
            hint = _with_units(next(x for x in (a.dimension, b.dimension) if x != NUMBER), operation)
        found = f"found {describe(a)} and {describe(b)}"
        raise ModelError(f"{operation} takes two values of the same dimension, {found}", hint=hint)
    return a.dimension


def checked(value: float | int) -> float | int:
    """A result of arithmetic, if it is finite and not too large."""
    if isinstance(value, int):
        if abs(value) > limits.INTEGER:
            return float(value) if abs(value) < 10**300 else _overflow()
        return value
    if math.isinf(value) or math.isnan(value):
        _overflow()
    return value


def _overflow() -> float:
    raise ModelError("the result is not a finite number")


def compute(operation: str, now: Callable, *operands: Quantity) -> float | int | Expr:
    """``now`` applied to the values if they are known, else an expression."""
    if any(isinstance(q.value, Expr) for q in operands):
        arguments = [q.expression for q in operands]
        if operation in symbolic._ARITHMETIC:
            return symbolic._ARITHMETIC[operation](*arguments)
        return symbolic.call(operation, *arguments)
    try:
        result = now(*(q.value for q in operands))
    except ZeroDivisionError:
        raise ModelError("division by zero") from None
    except (ValueError, OverflowError):
        raise ModelError("the result is not a finite number") from None
    return result if isinstance(result, bool) else checked(result)


def add(a: Value, b: Value) -> Value:
    return _sum("+", "add", lambda x, y: x + y, a, b)


def subtract(a: Value, b: Value) -> Value:
    return _sum("-", "sub", lambda x, y: x - y, a, b)


def _sum(symbol: str, operation: str, now: Callable, a: Value, b: Value) -> Value:
    if isinstance(a, tuple) and isinstance(b, tuple):
        if len(a) != len(b):
            raise ModelError(f"`{symbol}` takes arrays of the same size, found {describe(a)} and {describe(b)}")
        return tuple(_sum(symbol, operation, now, x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, tuple) or isinstance(b, tuple):
        raise ModelError(f"`{symbol}` takes two numbers or two arrays, found {describe(a)} and {describe(b)}")
    a, b = numeric(a, f"`{symbol}`"), numeric(b, f"`{symbol}`")
    dimension = common(a, b, f"`{symbol}`")
    unit = a.unit if b.unit in (None, a.unit) else b.unit if a.unit is None else None
    return Quantity(compute(operation, now, a, b), dimension, a.literal and b.literal, unit=unit)


def negate(a: Value) -> Value:
    if isinstance(a, tuple):
        return tuple(negate(x) for x in a)
    numeric(a, "`-`")
    return Quantity(compute("neg", lambda x: -x, a), a.dimension, a.literal, unit=a.unit)


def multiply(a: Value, b: Value) -> Value:
    if isinstance(a, tuple) and isinstance(b, tuple):
        raise ModelError("`*` of two arrays is not defined; write `sum({a[i]*b[i] for i in 1:size(a, 1)})`")
    if isinstance(a, tuple):
        return tuple(multiply(x, b) for x in a)
    if isinstance(b, tuple):
        return tuple(multiply(a, x) for x in b)
    a, b = numeric(a, "`*`"), numeric(b, "`*`")
    unit = b.unit if a.literal else a.unit if b.literal else None  # 2*30 deg
    return Quantity(compute("mul", lambda x, y: x * y, a, b), _product(a, b, 1), a.literal and b.literal, unit=unit)


def divide(a: Value, b: Value) -> Value:
    if isinstance(a, tuple):
        return tuple(divide(x, b) for x in a)
    if isinstance(b, tuple):
        raise ModelError("`/` divides by a number, found an array")
    a, b = numeric(a, "`/`"), numeric(b, "`/`")
    unit = a.unit if b.literal else None  # 90 deg/2
    return Quantity(compute("div", lambda x, y: x / y, a, b), _product(a, b, -1), a.literal and b.literal, unit=unit)


def _product(a: Quantity, b: Quantity, sign: int) -> Dimension | None:
    if a.dimension is not None and b.dimension is not None:
        return units.multiply(a.dimension, b.dimension, sign)
    if a.literal and b.dimension is not None and not b.varying:
        return units.power(b.dimension, sign)
    if b.literal and a.dimension is not None and not a.varying:
        return a.dimension
    return None


def power(a: Value, b: Value) -> Value:
    a, b = numeric(a, "`^`"), numeric(b, "`^`")
    if b.dimension not in (None, NUMBER):
        raise ModelError(f"an exponent is a pure number, found {describe(b)}")
    dimension: Dimension | None
    if a.dimension is None or a.dimension == NUMBER:
        dimension = a.dimension
    elif isinstance(b.value, Expr):
        raise ModelError(f"a power of {describe(a)} takes a constant exponent")
    else:
        dimension = units.power(a.dimension, Fraction(b.value).limit_denominator(12))
    return Quantity(compute("pow", _power, a, b), dimension, a.literal and b.literal)


def _power(a: float, b: float) -> float | int:
    if isinstance(a, int) and isinstance(b, int) and 0 <= b <= 60 and abs(a) <= 2 ** (53 // max(b, 1)):
        return a**b
    return math.pow(a, b)


_COMPARISONS: dict[str, tuple[str, Callable, bool]] = {
    "<": ("lt", lambda x, y: x < y, False),
    "<=": ("le", lambda x, y: x <= y, False),
    ">": ("lt", lambda x, y: x < y, True),
    ">=": ("le", lambda x, y: x <= y, True),
    "==": ("eq", lambda x, y: x == y, False),
    "<>": ("ne", lambda x, y: x != y, False),
}


def compare(symbol: str, a: Value, b: Value) -> Quantity:
    operation, now, swap = _COMPARISONS[symbol]
    if isinstance(a, tuple) or isinstance(b, tuple):
        raise ModelError(f"`{symbol}` compares two numbers, found {describe(a)} and {describe(b)}")
    if isinstance(a.value, str) and isinstance(b.value, str) and symbol in ("==", "<>"):
        return boolean(now(a.value, b.value))
    if a.boolean and b.boolean and symbol in ("==", "<>"):
        return boolean(compute(operation, now, a, b))
    a, b = numeric(a, f"`{symbol}`"), numeric(b, f"`{symbol}`")
    common(a, b, f"`{symbol}`")
    if swap:
        a, b = b, a
    return boolean(compute(operation, now, a, b))


_LOGICAL: dict[str, Callable] = {
    "and": lambda x, y: x and y,
    "or": lambda x, y: x or y,
    "not": lambda x: not x,
}


def logical(symbol: str, *operands: Value) -> Quantity:
    conditions = [q for q in operands if isinstance(q, Quantity) and q.boolean]
    if len(conditions) < len(operands):
        wrong = next(q for q in operands if isinstance(q, tuple) or not q.boolean)
        raise ModelError(f"`{symbol}` takes conditions (true or false), found {describe(wrong)}")
    return boolean(compute(symbol, _LOGICAL[symbol], *conditions))


def choose(condition: Quantity, a: Value, b: Value) -> Value:
    """``if`` with a condition that varies in time."""
    if isinstance(a, tuple) or isinstance(b, tuple):
        raise ModelError("an `if` that depends on time or signals chooses between numbers, found an array")
    if a.boolean and b.boolean:
        return boolean(symbolic.call("select", condition.expression, a.expression, b.expression))
    a, b = numeric(a, "`if`"), numeric(b, "`if`")
    dimension = common(a, b, "`if`")
    result = symbolic.call("select", condition.expression, a.expression, b.expression)
    return Quantity(result, dimension, a.literal and b.literal)


def with_unit(value: Value, unit: units.Unit) -> Value:
    """``{1, 2} m``: the unit applies to every element."""
    if isinstance(value, tuple):
        return tuple(with_unit(x, unit) for x in value)
    if value.dimension is not None or not value.number:
        raise ModelError(f"the unit {unit.text} behind an array is for plain numbers, found {describe(value)}")
    scaled = compute("mul", lambda x, y: x * y, value, Quantity(unit.factor))
    return Quantity(scaled, unit.dimension, unit=unit)


def shape(value: Value) -> tuple[int, ...]:
    """Sizes of an array along its dimensions (as its first elements have them); () for a scalar."""
    sizes = []
    while isinstance(value, tuple):
        sizes.append(len(value))
        value = value[0] if value else Quantity(0)
    return tuple(sizes)
