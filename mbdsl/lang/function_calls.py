"""Calls of functions of a model: the expressions of the function with the arguments in the place of its inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, quantities, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.source import placed, span_of
from mbdsl.lang.units import Dimension
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Value
from mbdsl.messages import count, did_you_mean

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope


def call(f: s.Function, e: s.Call, scope: Scope) -> Value:
    """The value of the first output of a function.

    Raises
    ------
    ModelError
        If the arguments do not fit the inputs, or a value has not the dimension of its declaration.
    """
    given = _arguments(f, e)
    known: dict[str, Value] = {}
    for d in f.inputs:
        what = f"`{d.name}` of {f.name}()"
        if d.name in given:
            known[d.name] = _fitted(d, evaluate(given[d.name], scope), what, given[d.name])
        elif d.value is not None:
            known[d.name] = _fitted(d, evaluate(d.value, scope.of_function(known)), what, d.value)
        else:
            raise ModelError(f"{f.name}() needs `{d.name}`", span_of(e.at), _form(f))
    declared = {d.name: d for d in f.declared}
    try:
        with scope.namespace.assembly.defining(id(f), f"{f.name}()", f.at):
            for name, right in f.assigned:
                value = evaluate(right, scope.of_function(known))
                known[name] = _fitted(declared[name], value, f"`{name}` of {f.name}()", right)
    except ModelError as problem:
        problem.notes = (*problem.notes[:4], ("the function is called here", span_of(e.at)))
        raise
    return known[f.outputs[0].name]


def _arguments(f: s.Function, e: s.Call) -> dict[str, s.Expression]:
    """The expressions of the inputs that are given, by place and by name."""
    names = [d.name for d in f.inputs]
    found: dict[str, s.Expression] = {}
    for k, argument in enumerate(e.arguments):
        if argument.value is None or argument.modifiers:
            raise ModelError(f"{f.name}() takes values only", span_of(argument.at), _form(f))
        if not argument.name and k >= len(names):
            raise ModelError(
                f"{f.name}() takes {count(len(names), 'argument')}, found {len(e.arguments)}", None, _form(f)
            )
        name = argument.name or names[k]
        if name not in names:
            hint = did_you_mean(name, names) or _form(f)
            raise ModelError(f"{f.name}() has no input `{name}`", span_of(argument.at), hint)
        if name in found:
            raise ModelError(f"`{name}` of {f.name}() is given twice", span_of(argument.at), _form(f))
        found[name] = argument.value
    return found


def _form(f: s.Function) -> str:
    return f"write `{f.name}({', '.join(d.name for d in f.inputs)})`"


def _fitted(d: s.Declaration, value: Value, what: str, e: s.Expression) -> Value:
    """A value with the dimension of its declaration, which bare numbers adopt."""
    with placed(e.at):
        if len(values.shape(value)) != len(d.indices):
            expected = (
                "a single value" if not d.indices else f"an array as `{d.name}[{', '.join(':' * len(d.indices))}]`"
            )
            found = argument_checks.shape_words(values.shape(value))
            raise ModelError(f"{what}: found {found}, expected {expected}")
        if d.type in ("Boolean", "String"):
            return value
        dimension, unit = _dimension(d)
        return argument_checks.fit(value, dimension, what, unit, e)


def _dimension(d: s.Declaration) -> tuple[Dimension | None, str]:
    """The dimension of a declaration and its unit; None for ``Real``, which takes any."""
    unit = "" if d.type in ("", "Real", "Integer") else quantities.type_unit(d.type)
    if unit is None:
        raise ModelError(f"`{d.type}` is not a type of a value", span_of(d.type_at or d.at), "e.g. `input Real x;`")
    for a in d.arguments:
        if a.name == "unit" and isinstance(a.value, s.String):
            unit = a.value.value
            if units.parse(unit) is None:
                raise ModelError(f"unknown unit `{unit}`", span_of(a.value.at))
        elif a.name not in ("min", "max", "quantity", "displayUnit", "start", "nominal"):
            raise ModelError(f"a {d.type} has no attribute `{a.name or write(a.value)}`", span_of(a.at))
    return (units.dimension(unit) if unit else None), unit
