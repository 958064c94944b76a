"""Inputs: ``input Torque u(start = 0 N.m)``, values that the caller sets while a simulation runs."""

from __future__ import annotations

from mbdsl.errors import ModelError
from mbdsl.expressions.symbolic import input_signal
from mbdsl.lang import argument_checks, functions, quantities, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.source import At, span_of
from mbdsl.lang.units import Dimension
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.scene import Input


def refuse_other_inputs(d: s.Declaration, kind: object) -> None:
    """Raise an error if a declaration cannot be an input: only numbers can."""
    hint = 'e.g. `input Torque u;` or `input Real u(unit = "N.m");`'
    if kind != "value" or d.type in ("Integer", "Boolean", "String"):
        raise ModelError(
            f"`{d.name}` is a {d.type}, an input is a real number or a quantity", span_of(d.type_at or d.at), hint
        )
    if d.prefixes & {"parameter", "constant"}:
        word = "parameter" if "parameter" in d.prefixes else "constant"
        raise ModelError(f"`{d.name}` is either a {word} or an input, not both", span_of(d.at), hint)


def starts(value: Value | None, dimension: Dimension | None, sizes: list[int]) -> Value:
    """The start of an input, zero by default; a single value applies to all elements."""
    found: Value = Quantity(0.0, dimension) if value is None else value
    if isinstance(found, tuple):
        return found
    if -1 in sizes:
        raise ModelError("an array of inputs needs its size or its start", None, "write e.g. `input Real u[2];`")
    for n in reversed(sizes):
        functions.bounded(n, *values.shape(found))
        found = (found,) * n
    return found


def make_inputs(name: str, start: Value, unit: str, doc: str, at: At) -> tuple[Value, tuple[Input, ...]]:
    """The value of an input, as expressions, and its descriptions; arrays have one input for each element."""
    if isinstance(start, tuple):
        separator = "," if name.endswith("]") else "["
        made = [
            make_inputs(f"{name.removesuffix(']')}{separator}{i}]", x, unit, doc, at) for i, x in enumerate(start, 1)
        ]
        return tuple(value for value, _ in made), tuple(x for _, inner in made for x in inner)
    number = argument_checks.number(start, f"the start of `{name}`")
    if not unit and start.dimension not in (None, units.NUMBER):
        unit = quantities.unit_text(start.dimension)
    return Quantity(input_signal(name), start.dimension), (Input(name, number, unit, doc, span_of(at)),)
