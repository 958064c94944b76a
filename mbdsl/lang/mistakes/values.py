"""Values in models of Modelica, as texts of the language: numbers with units, vectors, directions, angles."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from functools import reduce

from mbdsl.lang import syntax as s
from mbdsl.lang import units
from mbdsl.lang.unparse import inner, write

ZERO = s.Number(0)


#: operations of numbers
_OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "^": operator.pow}


def number(e: s.Expression | None) -> float | None:
    """The value of an expression of numbers, in SI units; None for other expressions."""
    if isinstance(e, s.Number):
        return e.value * (e.unit.factor if e.unit is not None else 1.0)
    if isinstance(e, s.Reference) and write(e) in ("pi", "Modelica.Constants.pi"):
        return math.pi
    if isinstance(e, s.Unary) and e.operator == "-":
        x = number(e.operand)
        return None if x is None else -x
    if isinstance(e, s.Binary) and e.operator in _OPERATIONS:
        x, y = number(e.left), number(e.right)
        if x is not None and y is not None and not (e.operator == "/" and y == 0.0):
            return float(_OPERATIONS[e.operator](x, y))
    return None


def is_zero(e: s.Expression | None) -> bool:
    return number(e) == 0.0


def items(e: s.Expression | None, size: int = 3) -> list[s.Expression] | None:
    """The components of a vector, each with its unit, zeros for those left out; None if they are not written out."""
    if e is None:
        return [ZERO] * size
    if not isinstance(e, s.ArrayNode) or len(e.items) > 3:
        return None
    found = [_with_unit(x, e) for x in e.items]
    return (found + [ZERO] * size)[:size]


def _with_unit(x: s.Expression, e: s.ArrayNode) -> s.Expression:
    if e.unit is None or is_zero(x):
        return x
    if isinstance(x, s.Number):
        return s.Number(x.value, e.unit)
    return s.Binary("*", x, s.Number(1, e.unit))


def numbers(e: s.Expression | None) -> list[float] | None:
    """The components of a vector in SI units; None if one of them is not a number."""
    given = items(e) or []
    found = [x for x in map(number, given) if x is not None]
    return found if given and len(found) == len(given) else None


def sized(e: s.Expression, name: str) -> s.Expression:
    """An expression; a number without a unit has the unit ``name``, so that its meaning is certain."""
    if isinstance(e, s.Unary) and e.operator == "-":
        return s.Unary("-", sized(e.operand, name))
    if isinstance(e, s.Number) and e.unit is None and e.value != 0:
        return s.Number(e.value, units.parse(name))
    return e


def metres(e: s.Expression | None) -> str:
    """A length as text."""
    return "..." if e is None else write(sized(e, "m"))


def combined(operator: str, *terms: s.Expression) -> s.Expression:
    """Terms that are joined by an operator from left to right."""
    return reduce(lambda a, b: s.Binary(operator, a, b), terms)


def degrees(e: s.Expression, sign: int = 1) -> str:
    """A number of degrees as an angle."""
    x = number(e)
    if x is not None:
        return f"{sign * x:.15g} deg"
    return f"{'-' if sign < 0 else ''}{inner(e)}*(1 deg)"


def opposite(e: s.Expression) -> s.Expression:
    """-e"""
    if is_zero(e):
        return e
    return e.operand if isinstance(e, s.Unary) and e.operator == "-" else s.Unary("-", e)


def vector(found: Sequence[s.Expression], size: int) -> str:
    return "{" + ", ".join(write(x) for x in found[:size]) + "}"


def floats(found: Sequence[float]) -> str:
    return "{" + ", ".join(f"{x + 0.0:.15g}" for x in found) + "}"


def along(e: s.Expression | None) -> tuple[int, int] | None:
    """Axis (0, 1, 2) and sign of a vector along an axis of its frame; None for other vectors."""
    found = items(e)
    nonzero = [k for k, x in enumerate(found or ()) if not is_zero(x)]
    if found is None or len(nonzero) != 1:
        return None
    x = found[nonzero[0]]
    negative = (number(x) or 1.0) < 0.0 or (isinstance(x, s.Unary) and x.operator == "-")
    return nonzero[0], -1 if negative else 1


def length(e: s.Expression | None) -> s.Expression | None:
    """The length of a vector; None if its components are not written out, or all zero."""
    found, axis, known = items(e), along(e), numbers(e)
    if axis is not None and found is not None:
        x = found[axis[0]]
        x = x if axis[1] > 0 else s.Number(-x.value, x.unit) if isinstance(x, s.Number) else opposite(x)
        return sized(x, "m")
    if known is not None:
        return s.Number(math.hypot(*known), units.parse("m")) if any(known) else None
    nonzero = [sized(x, "m") for x in found or () if not is_zero(x)]
    if not nonzero:
        return None
    hypot = s.Reference((s.NamePart("hypot"),))
    return reduce(lambda a, b: s.Call(hypot, (s.Argument(value=a), s.Argument(value=b))), nonzero)
