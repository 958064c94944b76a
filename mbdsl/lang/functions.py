"""The functions of the language, with their effect on dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from mbdsl.errors import ModelError
from mbdsl.expressions.symbolic import OPERATIONS, Expr, leaves, without_events
from mbdsl.lang import limits, units, values
from mbdsl.lang.modelica_names import CONVERSIONS
from mbdsl.lang.quantities import unit_text, words
from mbdsl.lang.units import NUMBER
from mbdsl.lang.values import Quantity, Value, compute, describe, numeric

CONSTANTS = {"pi": math.pi, "e": math.e}

#: functions of pure numbers: name -> operation
_PURE = {name: name for name in "sin cos tan asin acos atan sinh cosh tanh exp log log10".split()} | {"ln": "log"}
_PYTHON: dict[str, Callable] = dict(OPERATIONS)


def _integer(x: float) -> int:
    return math.floor(x)


def _counts_seconds(a: Quantity) -> bool:
    """Whether an argument is a number of times the time, as in `sin(2*pi*time)`: a rate in rad/s."""
    found = leaves(a.value) if isinstance(a.value, Expr) and a.value.args else []
    return a.dimension == units.dimension("s") and bool(found) and all(leaf.op == "time" for leaf in found)


def _pure(name: str, arguments: list[Value]) -> Value:
    (a,) = arguments
    if isinstance(a, tuple):
        return tuple(_pure(name, [x]) for x in a)
    numeric(a, f"{name}()")
    if a.dimension not in (None, NUMBER) and not _counts_seconds(a):
        hint = None
        if a.dimension == units.dimension("s"):
            hint = "multiply the time by a rate, e.g. `2 rad/s * time`"
        elif a.dimension is not None and (unit := unit_text(a.dimension)):
            hint = f"divide it by a unit: `{name}(x/(1 {unit}))`"
        raise ModelError(f"{name}() takes a pure number or an angle, found {describe(a)}", hint=hint)
    operation = _PURE[name]
    return Quantity(compute(operation, _PYTHON[operation], a), NUMBER)


def _sqrt(arguments: list[Value]) -> Value:
    (a,) = arguments
    a = numeric(a, "sqrt()")
    dimension = None if a.dimension is None else units.power(a.dimension, values.Fraction(1, 2))
    return Quantity(compute("sqrt", math.sqrt, a), dimension, a.literal)


def _same(name: str) -> Callable[[list[Value]], Value]:
    """Functions of one value that keep its dimension."""

    def apply(arguments: list[Value]) -> Value:
        (a,) = arguments
        if isinstance(a, tuple):
            return tuple(apply([x]) for x in a)
        numeric(a, f"{name}()")
        if name in ("floor", "ceil") and a.dimension not in (None, NUMBER):
            raise ModelError(f"{name}() takes a pure number, found {describe(a)}")
        return Quantity(compute(name, _PYTHON[name], a), a.dimension, a.literal)

    return apply


def _sign(arguments: list[Value]) -> Value:
    a = numeric(arguments[0], "sign()")
    return Quantity(compute("sign", OPERATIONS["sign"], a), NUMBER)


def _pair(name: str, keep: bool = True) -> Callable[[list[Value]], Value]:
    """Functions of two values of the same dimension; with ``keep``, the result has it, too."""

    def apply(arguments: list[Value]) -> Value:
        a, b = (numeric(x, f"{name}()") for x in arguments)
        dimension = values.common(a, b, f"{name}()")
        result = compute(name, _PYTHON[name], a, b)
        return Quantity(result, dimension if keep else NUMBER, keep and a.literal and b.literal)

    return apply


def _extreme(name: str) -> Callable[[list[Value]], Value]:
    pair = _pair(name)

    def apply(arguments: list[Value]) -> Value:
        first = arguments[0] if len(arguments) == 1 else None
        array, items = isinstance(first, tuple), list(first) if isinstance(first, tuple) else arguments
        if not items:
            raise ModelError(f"{name}() of nothing")
        if len(items) == 1 and not array:
            word = "least" if name == "min" else "largest"
            hint = (
                f"the {word} value of a run is in the lines `over all steps` of `mbdsl simulate`, and a measure of "
                f'`mbdsl sweep`: --measure "{name}(...)"'
            )
            raise ModelError(f"`{name}` takes two values or more, or an array", hint=hint)
        result = items[0]
        for item in items[1:]:
            result = pair([result, item])
        return numeric(result, f"{name}()")

    return apply


def _fold(name: str, start: int, step: Callable[[Value, Value], Value]) -> Callable[[list[Value]], Value]:
    def apply(arguments: list[Value]) -> Value:
        (a,) = arguments
        if not isinstance(a, tuple):
            raise ModelError(f"{name}() takes an array, found {describe(a)}")
        items = [apply([x]) if isinstance(x, tuple) else x for x in a]
        result = items[0] if items else values.literal(start)
        for item in items[1:]:
            result = step(result, item)
        return result

    return apply


def count(value: Value, what: str) -> int:
    """A whole number that is known before the start."""
    if isinstance(value, tuple) or not value.number or value.dimension not in (None, NUMBER):
        raise ModelError(f"{what} is a whole number, found {describe(value)}")
    if value.varying:
        raise ModelError(f"{what} must be known before the start; it depends on time or signals")
    number = getattr(value.value, "value", value.value)
    if not isinstance(number, int | float) or number != int(number):
        raise ModelError(f"{what} is a whole number, found {number!r}")
    return int(number)


def bounded(*sizes: int) -> int:
    """The number of elements of an array, if it is within the limits."""
    total = 1
    for size in sizes:
        if size < 0:
            raise ModelError(f"an array cannot have {size} elements")
        total *= size
    if total > limits.ARRAY:
        raise ModelError(f"an array of {total} elements is more than the {limits.ARRAY} allowed")
    return total


def _size(arguments: list[Value]) -> Value:
    a = arguments[0]
    if not isinstance(a, tuple):
        raise ModelError(f"size() takes an array, found {describe(a)}")
    sizes = [values.literal(n) for n in values.shape(a)]
    if len(arguments) == 1:
        return tuple(sizes)
    index = count(arguments[1], "the second argument of size()")
    if not 1 <= index <= len(sizes):
        raise ModelError(f"size(..., {index}) of an array with {len(sizes)} dimension{'s' * (len(sizes) > 1)}")
    return sizes[index - 1]


def _fill(value: Value, sizes: list[Value]) -> Value:
    counts = [count(n, "the size of an array") for n in sizes]
    bounded(*counts, *values.shape(value))
    for n in reversed(counts):
        value = (value,) * n
    return value


def _linspace(arguments: list[Value]) -> Value:
    first, last = numeric(arguments[0], "linspace()"), numeric(arguments[1], "linspace()")
    n = count(arguments[2], "the number of points of linspace()")
    if n < 2:
        raise ModelError(f"linspace() needs at least 2 points, found {n}")
    bounded(n)
    step = values.subtract(last, first)
    return tuple(values.add(first, values.multiply(step, values.literal(i / (n - 1)))) for i in range(n))


def _div(arguments: list[Value]) -> Value:
    a, b = (numeric(x, "div()") for x in arguments)
    result = compute("floor", lambda x: math.trunc(x), numeric(values.divide(a, b), "div()"))
    return Quantity(result, NUMBER, True)


def _to_integer(arguments: list[Value]) -> Value:
    a = numeric(arguments[0], "integer()")
    return Quantity(compute("floor", _integer, a), a.dimension, True)


def _from_unit(name: str, unit: str, arguments: list[Value]) -> Value:
    """A number in ``unit`` as a quantity."""
    a = numeric(arguments[0], f"{name}()")
    if a.dimension not in (None, NUMBER):
        raise ModelError(f"{name}() takes a pure number, found {describe(a)}")
    return values.with_unit(Quantity(a.value), units.valid(unit))


def _to_unit(name: str, unit: str, arguments: list[Value]) -> Value:
    """A quantity as a number in ``unit``."""
    known = units.parse(unit)
    assert known is not None
    a = numeric(arguments[0], f"{name}()")
    if a.dimension not in (None, known.dimension):
        raise ModelError(f"{name}() takes {words(known.dimension, unit)}, found {describe(a)}")
    return values.divide(Quantity(a.value, known.dimension), Quantity(known.factor, known.dimension))


def _without_events(value: Value) -> Value:
    """A value at whose jumps and corners no events are located."""
    if isinstance(value, tuple):
        return tuple(map(_without_events, value))
    if not isinstance(value.value, Expr):
        return value
    return Quantity(without_events(value.value), value.dimension, value.literal, value.boolean, value.unit)


def _smooth(order: Value, value: Value) -> Value:
    """smooth(p, x): without events if x has p >= 1 continuous derivatives; corners, p = 0, are located."""
    return _without_events(value) if count(order, "the first argument of smooth()") >= 1 else value


#: name -> (smallest and largest number of arguments, implementation)
FUNCTIONS: dict[str, tuple[int, int, Callable[[list[Value]], Value]]] = {
    **{name: (1, 1, partial(_pure, name)) for name in _PURE},
    "sqrt": (1, 1, _sqrt),
    "abs": (1, 1, _same("abs")),
    "sign": (1, 1, _sign),
    "floor": (1, 1, _same("floor")),
    "ceil": (1, 1, _same("ceil")),
    "integer": (1, 1, _to_integer),
    "atan2": (2, 2, _pair("atan2", keep=False)),
    "hypot": (2, 2, _pair("hypot")),
    "mod": (2, 2, _pair("mod")),
    "div": (2, 2, _div),
    "min": (1, 100, _extreme("min")),
    "max": (1, 100, _extreme("max")),
    "sum": (1, 1, _fold("sum", 0, values.add)),
    "product": (1, 1, _fold("product", 1, values.multiply)),
    "size": (1, 2, _size),
    "fill": (2, 5, lambda a: _fill(a[0], a[1:])),
    "zeros": (1, 4, lambda a: _fill(values.literal(0), a)),
    "ones": (1, 4, lambda a: _fill(values.literal(1), a)),
    "linspace": (3, 3, _linspace),
    "noEvent": (1, 1, lambda a: _without_events(a[0])),
    "smooth": (2, 2, lambda a: _smooth(*a)),
    **{f"from_{name}": (1, 1, partial(_from_unit, f"from_{name}", unit)) for name, unit in CONVERSIONS.items()},
    **{f"to_{name}": (1, 1, partial(_to_unit, f"to_{name}", unit)) for name, unit in CONVERSIONS.items()},
}


def call(name: str, arguments: list[Value]) -> Value:
    least, most, function = FUNCTIONS[name]
    if not least <= len(arguments) <= most:
        expected = str(least) if least == most else f"{least} to {most}" if most < 100 else f"at least {least}"
        raise ModelError(f"{name}() takes {expected} argument{'s' * (expected != '1')}, found {len(arguments)}")
    return function(arguments)
