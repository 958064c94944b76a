"""Declarations of values: ``parameter Mass m = 3 kg``, ``Real F = 2 N*sin(time)``."""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, declared_display, functions, quantities, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import Namespace, Slot
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.inputs import make_inputs, starts
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.modifiers import Modifier, Modifiers, bind, merge, refuse_inner
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import placed, span_of
from mbdsl.lang.states import refuse_no_state
from mbdsl.lang.units import Dimension
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.messages import did_you_mean

ATTRIBUTES = ("unit", "min", "max", "quantity", "displayUnit", "start", "fixed", "nominal")


def make_slot(
    assembly: Assembly,
    namespace: Namespace,
    d: s.Declaration,
    scope: Scope,
    given: Modifier | None,
    level: int,
    derived: bool = False,
    set_: bool = False,
) -> Slot:
    """The entity for a declared value; ``given`` is its modifier from outside the model. An equation gives its
    derivative if it is ``derived``, a when-equation its value if it is ``set_``."""
    constant = bool(d.prefixes & {"parameter", "constant"})
    positional, own = bind(d.arguments, scope, level)
    if positional:
        raise ModelError(f'found `{write(positional[0])}`, expected attributes such as `unit = "kg"`', span_of(d.at))
    if given is not None and ("final" in d.prefixes or "constant" in d.prefixes):
        word = "final" if "final" in d.prefixes else "a constant"
        note = (("declared here", span_of(d.at)),)
        raise ModelError(f"`{d.name}` is {word}, it cannot be modified", given.value_span(), notes=note)
    attributes = merge(given.inner, own) if given is not None and given.inner else own
    for name, modifier in attributes.items():
        if name not in ATTRIBUTES:
            hint = did_you_mean(name, ATTRIBUTES, "attributes")
            raise ModelError(f"a {d.type or 'parameter'} has no attribute `{name}`", span_of(modifier.at), hint)
        refuse_inner(modifier, f"`{name}` of `{d.name}`", f"write `{name} = ...`")
    start = given.inner.get("start") if given is not None else None
    valued = given is not None and given.value is not None
    if start is not None and (d.value is not None or valued) and not ("input" in d.prefixes and valued):
        hint = f"give it another value: `{d.name} = ...`" if constant or "input" in d.prefixes else None
        raise ModelError(f"`{d.name}` has a value and takes no start", span_of(start.at), hint)
    unit = quantities.type_unit(d.type) or ""
    full = namespace.full(d.name)
    slot = Slot(
        assembly, full, lambda: _evaluate(slot, d, scope, given, attributes, unit, namespace), d.at, d.doc, unit
    )
    slot.constant = constant
    free = not constant and d.value is None and not valued and "input" not in d.prefixes
    slot.derived, slot.discrete = free and derived, free and (set_ or "discrete" in d.prefixes)
    if derived:
        refuse_no_state(slot, d)
    assembly.slots.append(slot)
    return slot


def _evaluate(
    slot: Slot,
    d: s.Declaration,
    scope: Scope,
    given: Modifier | None,
    attributes: Modifiers,
    unit: str,
    namespace: Namespace,
) -> Value:
    what = f"`{slot.name}`"
    if not slot.constant:
        scope = scope.for_signals()
    unit = _attributes(slot, attributes, unit)
    dimension: Dimension | None = units.dimension(unit) if unit else None
    sizes = [
        functions.count(evaluate(i, scope), f"the size of {what}") if not isinstance(i, s.Everything) else -1
        for i in d.indices
    ]
    for size in sizes:
        if size > 0:
            functions.bounded(size)

    value: Value | None
    e: s.Expression | None = None
    comes_in = False
    if given is not None and given.value is not None:
        if dimension is None and d.value is not None:
            dimension = _dimension_of(evaluate(d.value, scope))
            unit = slot.unit = unit or (quantities.unit_text(dimension) if dimension else "")
        e, at = given.value, given.value.at
        value = given.evaluate() if slot.constant else evaluate(given.value, given.scope.for_signals())
        with placed(at):
            rank = len(sizes) if sizes or d.type else min(len(values.shape(value)), 0)
            value = given.pick(value, rank, namespace.contexts)
    elif d.value is not None:
        value, e, at = evaluate(d.value, scope), d.value, d.value.at
    elif "start" in attributes and attributes["start"].value is not None:
        value, at = attributes["start"].evaluate(), attributes["start"].value.at
        if "input" in d.prefixes:
            value, comes_in = attributes["start"].pick(value, len(sizes), namespace.contexts), True
        elif slot.derived or slot.discrete:
            value = attributes["start"].pick(value, len(sizes), namespace.contexts)
        elif not slot.constant:
            doubts.undetermined(slot.assembly.warn, d, what)
    elif "input" in d.prefixes or slot.derived or slot.discrete:
        value, at, comes_in = None, d.at, "input" in d.prefixes
    else:
        word = "parameter" if slot.constant else "variable"
        raise ModelError(f"{word} {what} has no value", span_of(d.at), f"write `{d.name} = ...`")
    with placed(at):
        if value is None and d.type == "Boolean":
            value = values.boolean(False)
        if comes_in or slot.derived or slot.discrete:
            value = starts(value, dimension, sizes)
        assert value is not None
        value = _check(value, d, _Wanted(what, dimension, unit, sizes), attributes, e, slot.assembly)
        if comes_in:
            value, slot.inputs = make_inputs(slot.name, value, slot.unit, d.doc, d.at)
        elif slot.derived:
            value = _state(slot, value, attributes, dimension)
        elif slot.discrete:
            value = slot.assembly.events.make(slot.name, d.type, value, slot.unit, d.doc, d.at)
    return value


def _state(slot: Slot, start: Value, attributes: Modifiers, dimension: Dimension | None) -> Value:
    """The value of a state, from its start and its attributes."""
    nominal, fixed = attributes.get("nominal"), attributes.get("fixed")
    size = None
    if nominal is not None and nominal.value is not None:
        with placed(nominal.value.at):
            size = argument_checks.fit(nominal.evaluate(), dimension, f"`nominal` of `{slot.name}`")
    kept = None if fixed is None or fixed.value is None else bool(getattr(fixed.evaluate(), "value", True))
    return slot.assembly.states.make(slot.name, start, size, kept, slot)


def _attributes(slot: Slot, attributes: Modifiers, unit: str) -> str:
    """Check the attributes, and return the unit that they give, else ``unit``."""
    written = attributes.get("unit")
    if written is not None and written.value is not None:
        unit = slot.unit = _unit_attribute(written)
        if units.valid(unit).factor != 1.0:
            si = quantities.unit_text(units.dimension(unit))  # values are kept in SI units
            slot.unit = "rad" if si == "1" else si
            slot.display = written, unit
    shown = attributes.get("displayUnit")
    if shown is not None and (text := declared_display.read(shown)):
        slot.display = shown, text
    for name, modifier in attributes.items():
        read = modifier.evaluate() if modifier.value is not None else None
        if name == "fixed" and not (isinstance(read, tuple) or (read is not None and isinstance(read.value, bool))):
            found = "nothing" if read is None else values.describe(read)
            raise ModelError(f"`fixed` is true or false, found {found}", modifier.value_span())
    return unit


def _unit_attribute(written: Modifier) -> str:
    value = written.evaluate()
    text = value.value if isinstance(value, Quantity) else None
    if not isinstance(text, str):
        raise ModelError(f"`unit` is a text, found {values.describe(value)}", written.value_span(), 'e.g. unit = "kg"')
    if units.parse(text) is None:
        raise ModelError(f'unknown unit "{text}"', written.value_span(), "units are e.g. kg, m/s2, N.m/rad, deg")
    return text


class _Wanted(NamedTuple):
    """What a value has to be: its description for messages, its dimension, unit and sizes."""

    what: str
    dimension: Dimension | None
    unit: str
    sizes: list[int]


def _check(
    value: Value, d: s.Declaration, wanted: _Wanted, attributes: Modifiers, e: s.Expression | None, assembly: Assembly
) -> Value:
    what, dimension, unit, sizes = wanted
    shape = values.shape(value)
    if (sizes or d.type) and (
        len(sizes) != len(shape) or any(a not in (b, -1) for a, b in zip(sizes, shape, strict=True))
    ):
        hint = None
        if not sizes and shape:
            hint = f"an array is declared `{d.name}[{', '.join(map(str, shape))}]`"
        elif sizes and not shape:
            hint = f"write `fill(..., {', '.join(map(str, sizes))})` for equal values"
        expected = argument_checks.shape_words(tuple(sizes)) if -1 not in sizes else "an array"
        raise ModelError(f"{what}: found {argument_checks.shape_words(shape)}, expected {expected}", None, hint)
    if unit:
        factor = units.parse(unit)
        if factor is not None and factor.factor != 1.0 and "unit" in attributes:
            value = _scaled(value, factor)
    if d.type not in ("", "Boolean", "String", "Integer") or dimension is not None:
        if unit == "rad":
            doubts.angle(assembly.warn, value, e, what)
        value = argument_checks.fit(value, dimension, what, unit, e)
    value = _typed(value, d.type, what, assembly)
    for name in ("min", "max"):
        bound = attributes.get(name)
        if bound is not None and bound.value is not None:
            _range(value, name, bound, what)
    return value


def _scaled(value: Value, unit: units.Unit) -> Value:
    """Apply the declared unit, such as "deg", to a bare number."""
    if isinstance(value, tuple):
        return tuple(_scaled(v, unit) for v in value)
    if value.dimension is None and value.number:
        scaled = values.compute("mul", lambda x, y: x * y, value, Quantity(unit.factor))
        return Quantity(scaled, unit.dimension, unit=unit)
    return value


def _typed(value: Value, type_name: str, what: str, assembly: Assembly) -> Value:
    if isinstance(value, tuple):
        return tuple(_typed(v, type_name, what, assembly) for v in value)
    if type_name == "Integer" and value.varying and value.number and assembly.events.whole(value.expression):
        return value
    if type_name == "Integer":
        return values.literal(functions.count(value, what))
    if type_name == "Boolean":
        if not value.boolean:
            hint = None if value.value not in (0, 1) else f"write `{'true' if value.value else 'false'}`"
            raise ModelError(f"{what}: found {values.describe(value)}, expected true or false", hint=hint)
        return value
    if type_name == "String":
        if not isinstance(value.value, str):
            raise ModelError(f"{what}: found {values.describe(value)}, expected a text")
        return value
    if value.literal:
        return Quantity(value.value, value.dimension)
    return value


def _range(value: Value, name: str, bound: Modifier, what: str) -> None:
    limit = values.numeric(bound.evaluate(), f"`{name}`")
    for q in _flat(value):
        if q.varying or not q.number:
            continue
        values.common(q, limit, f"`{name}`")
        wrong = q.known < limit.known if name == "min" else q.known > limit.known
        if wrong:
            word = "least" if name == "min" else "most"
            found, bounded = (argument_checks.in_unit(x.known, q) for x in (q, limit))
            raise ModelError(f"{what} is {found}, it must be at {word} {bounded}")


def _flat(value: Value) -> list[Quantity]:
    return [q for v in value for q in _flat(v)] if isinstance(value, tuple) else [value]


def _dimension_of(value: Value) -> Dimension | None:
    return next((q.dimension for q in _flat(value) if q.dimension is not None and q.number), None)
