"""Evaluation of expressions in a scope."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.expressions.derivatives import der
from mbdsl.lang import functions, modelica_names, values
from mbdsl.lang import syntax as s
from mbdsl.lang.limits import ARRAY, NODES
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.mistakes import units as unit_mistakes
from mbdsl.lang.source import placed, span_of
from mbdsl.lang.units import Unit
from mbdsl.lang.unparse import write, write_argument
from mbdsl.lang.values import Quantity, Value


class Budget:
    """Counts the operations of one model, so that the work of reading it is bounded."""

    def __init__(self) -> None:
        self.left = NODES

    def spend(self, amount: int = 1) -> None:
        self.left -= amount
        if self.left < 0:
            raise ModelError(f"evaluating the model takes more than {NODES} operations")


class Names(ABC):
    """The meaning of names in an expression; where nothing else is said, there are values only."""

    __slots__ = ()
    budget: Budget

    @abstractmethod
    def value(self, reference: s.Reference) -> Value:
        """Value of a name; raises ModelError if it has none here."""

    def apply(self, reference: s.Reference, argument: Value) -> Value | None:
        """``reference`` as a table at ``argument``; None if it is not a table."""
        return None

    @abstractmethod
    def with_locals(self, names: dict[str, Value]) -> Names:
        """The same scope with additional names, as in a loop."""

    def last(self) -> Value:
        """The value of `end` in an index."""
        raise ModelError("`end` is an index, it has no value here")

    def declared(self, name: str) -> str | None:
        """The unit of a parameter, variable or loop variable of this name, "" for none; None if there is none."""
        return None

    def doubt_angle(self, value: Value, e: s.Expression, what: str) -> None:
        """Warn if ``value`` is probably in degrees; where nothing else is said, do not."""
        return

    def rate(self, leaf: symbolic.Expr) -> symbolic.Expr | None:
        """The derivative of a leaf that is a state of the model; None of other leaves."""
        return None

    def function_names(self) -> list[str]:
        """Names of the tables and functions."""
        return []

    def call(self, e: s.Call) -> Value | None:
        """The value of a function of the model; None if it has none of this name."""
        return None


def evaluate(e: s.Expression, scope: Names) -> Value:
    """The value of ``e``; an error without a place is given that of the innermost faulty expression."""
    try:
        return _evaluate(e, scope)
    except ModelError as problem:
        if problem.span is None:
            problem.span = span_of(e.at)
        raise


def _evaluate(e: s.Expression, scope: Names) -> Value:
    scope.budget.spend()
    match e:
        case s.Number():
            if e.unit is None:
                return Quantity(e.value, None, True)
            unit_mistakes.check_readings(e.unit, scope.declared)
            return Quantity(e.value * e.unit.factor, e.unit.dimension, unit=e.unit)
        case s.Reference():
            return scope.value(e)
        case s.Binary():
            return _binary(e, scope)
        case s.Unary(operator, operand):
            value = evaluate(operand, scope)
            if operator == "not":
                return values.logical("not", value)
            return values.negate(value) if operator == "-" else value
        case s.Call():
            return _spend(_call(e, scope), scope)
        case s.ArrayNode(items, unit):
            found = tuple(evaluate(item, scope) for item in items)
            if unit:
                unit_mistakes.check_readings(unit, scope.declared)
            return _rectangular(_with_unit(found, unit, items) if unit else found)
        case s.Boolean(value):
            return values.boolean(value)
        case s.String(value):
            return Quantity(value)
        case s.Choice():
            return _choice(e, scope)
        case s.Range():
            return tuple(values.literal(x) for x in range_values(e, scope))
        case s.Comprehension(item, iterators, unit):
            found = tuple(evaluate(item, inner) for inner in loop(iterators, scope))
            return _rectangular(_with_unit(found, unit, (item,)) if unit else found)
        case s.Literal(value):
            return value
        case s.Last():
            return scope.last()
    raise ModelError("`:` is an index, it has no value here")


def _with_unit(found: tuple, unit: Unit, items: tuple[s.Expression, ...]) -> Value:
    """An array whose elements have the unit behind it."""
    try:
        return values.with_unit(found, unit)
    except ModelError as problem:
        problem.hint = unit_mistakes.of_elements(items, found, unit)
        raise


def _spend(value: Value, scope: Names) -> Value:
    if isinstance(value, tuple):
        scope.budget.spend(math.prod(values.shape(value)))
    return value


def _rectangular(value: Value) -> Value:
    """An array whose elements are all scalars or all arrays of one size."""
    if isinstance(value, tuple):
        inner = values.shape(value[0]) if value else ()
        for item in value:
            if values.shape(item) != inner:
                raise ModelError(
                    f"the elements of an array have the same size, found {values.describe(value[0])} "
                    f"and {values.describe(item)}"
                )
    return value


_OPERATORS = {
    "+": values.add,
    "-": values.subtract,
    "*": values.multiply,
    "/": values.divide,
    "^": values.power,
    "and": lambda a, b: values.logical("and", a, b),
    "or": lambda a, b: values.logical("or", a, b),
}


def _binary(e: s.Binary, scope: Names) -> Value:
    # Sums and products associate to the left; a long one must not need a deep recursion.
    spine = [e]
    while isinstance(e.left, s.Binary):
        e = e.left
        spine.append(e)
    result = evaluate(e.left, scope)
    for node in reversed(spine):
        scope.budget.spend()
        if node.operator in ("and", "or") and isinstance(result, Quantity) and isinstance(result.value, bool):
            if result.value is (node.operator == "or"):
                continue  # decided: the other side need not be valid (`i > 1 and x[i - 1] > 0`)
        try:
            right = evaluate(node.right, scope)
        except ModelError as problem:
            if (written := unit_mistakes.one_word(spine[0])) is not None:
                problem.hint = f"a unit is one word without `*`: write `{written[0]}`"
            raise
        with placed(node.at):
            operation = _OPERATORS.get(node.operator)
            result = operation(result, right) if operation else values.compare(node.operator, result, right)
        if isinstance(result, tuple):
            _spend(result, scope)
    return result


def _choice(e: s.Choice, scope: Names) -> Value:
    branches = []
    otherwise: Value | None = None
    for condition, value in e.branches:
        decided = evaluate(condition, scope)
        if isinstance(decided, tuple) or not decided.boolean:
            raise ModelError(
                f"`if` takes a condition (true or false), found {values.describe(decided)}", span_of(condition.at)
            )
        known = decided.value if isinstance(decided.value, bool) else None
        if isinstance(decided.value, symbolic.Expr) and symbolic.is_const(decided.value):
            known = bool(decided.value.value)
        if known is None:
            branches.append((decided, evaluate(value, scope)))
        elif known:
            otherwise = evaluate(value, scope)
            break
    result = evaluate(e.otherwise, scope) if otherwise is None else otherwise
    for decided, value in reversed(branches):
        result = values.choose(decided, value, result)
    return result


def _call(e: s.Call, scope: Names) -> Value:
    written = write(e.function)
    name = modelica_names.function(written)
    if name not in functions.FUNCTIONS and name != "der" and (found := scope.call(e)) is not None:
        return found
    named = next((a for a in e.arguments if a.name or a.each or a.final), None)
    if named is not None:
        raise ModelError(f"{name}() takes values only, found `{write_argument(named)}`", span_of(named.at))
    expressions_ = [a.value for a in e.arguments if a.value is not None]
    if name == "der":
        return _der(expressions_, scope)
    if name in functions.FUNCTIONS:
        arguments = [evaluate(a, scope) for a in expressions_]
        if name in ("sin", "cos", "tan") and isinstance(expressions_[0] if expressions_ else None, s.Number):
            scope.doubt_angle(arguments[0], expressions_[0], f"the argument of {name}()")
        return functions.call(name, arguments)
    if len(expressions_) == 1 and not written.startswith("Modelica."):
        found = scope.apply(e.function, evaluate(expressions_[0], scope))
        if found is not None:
            return found
    from mbdsl.lang.event_functions import FUNCTIONS as OF_EVENTS
    from mbdsl.messages import did_you_mean

    known = [*functions.FUNCTIONS, *OF_EVENTS, "der", *scope.function_names()]
    hint = other_names.FUNCTIONS.get(name) or did_you_mean(name, known)
    if hint is None and written.startswith("Modelica."):
        hint = other_names.constant(written)
    raise ModelError(f"no function is called `{written}`", span_of(e.function.at), hint)


def _der(arguments: list[s.Expression], scope: Names) -> Value:
    if len(arguments) != 1:
        raise ModelError(f"der() takes 1 argument, found {len(arguments)}")
    inner = values.numeric(evaluate(arguments[0], scope), "der()")
    dimension = None
    if inner.dimension is not None:
        dimension = values.units.multiply(inner.dimension, values.units.dimension("s"), -1)
    try:
        rate = der(inner.expression, scope.rate)
    except ValueError as problem:
        raise ModelError(str(problem)) from None
    return Quantity(rate, dimension)


def range_values(e: s.Range, scope: Names) -> list[int | float]:
    """The numbers of ``first:step:last``."""
    bounds = [evaluate(x, scope) for x in (e.start, e.step, e.stop) if x is not None]
    if e.step is None or all(isinstance(getattr(b, "value", None), int) for b in bounds):
        first, *step, last = (functions.count(b, "a bound of a range") for b in bounds)
        by = step[0] if step else 1
        if by == 0:
            raise ModelError("the step of a range is zero")
        found = range(first, last + (1 if by > 0 else -1), by)
        if bool(found) and (last - first) // by >= ARRAY:
            raise ModelError(f"this range has {(last - first) // by + 1} numbers, more than the {ARRAY} allowed")
        scope.budget.spend(len(found))
        return list(found)
    numbers = [values.numeric(b, "a range") for b in bounds]
    if any(q.varying or q.dimension not in (None, values.NUMBER) for q in numbers):
        raise ModelError("the bounds of a range are pure numbers known before the start")
    start, by_, stop = (q.known for q in numbers)
    if by_ == 0:
        raise ModelError("the step of a range is zero")
    n = max(0, math.floor((stop - start) / by_ * (1 + 1e-12)) + 1)
    functions.bounded(n)
    scope.budget.spend(n)
    return [start + i * by_ for i in range(n)]


def loop(iterators: tuple[s.Iterator, ...], scope: Names):
    """One scope for every iteration of a loop; the last iterator varies fastest."""
    if not iterators:
        yield scope
        return
    first, *rest = iterators
    over = evaluate(first.values, scope)
    if not isinstance(over, tuple):
        raise ModelError(
            f"a loop runs over a range or an array, found {values.describe(over)}",
            span_of(first.values.at),
            "write e.g. `for i in 1:N loop`",
        )
    for item in over:
        scope.budget.spend()
        yield from loop(tuple(rest), scope.with_locals({first.name: item}))
