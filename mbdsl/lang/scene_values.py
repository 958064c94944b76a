"""From declared values to the parameters, variables and inputs of a Scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.lang import declared_display, quantities
from mbdsl.lang.entities import Namespace, Slot
from mbdsl.lang.source import span_of
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.scene import ENERGIES, Description, Input, ParameterValue


def values_of(
    slots: Iterable[Slot], root: Namespace
) -> tuple[
    dict[str, ParameterValue], dict[str, symbolic.Expr], dict[str, Description], dict[str, Input], dict[str, str]
]:
    """Parameters, variables, their descriptions, inputs, and units of display, of all declared values."""
    parameters, variables, described, inputs, display = {}, {}, {}, {}, {}
    own = {id(m) for m in root.members.values() if isinstance(m, Slot)}
    for slot in slots:
        value = slot.value()
        unit, shown = declared_display.of_value(slot, slot.unit or _unit_of(value))
        inputs |= {x.name: x for x in slot.inputs}
        if slot.constant:
            if id(slot) in own:
                display |= {slot.name: shown} if shown else {}
                parameters[slot.name] = ParameterValue(slot.name, _plain(value), unit, slot.doc, span_of(slot.at))
        else:
            for suffix, q in _scalars(value):
                if not isinstance(q.value, str):
                    if slot.name + suffix in ENERGIES:
                        raise ModelError(
                            f"every model has a signal `{slot.name}`, its energy; a variable cannot be called so",
                            span_of(slot.at),
                            f"give the sub-model `{slot.name.split('.')[0]}` or the variable another name",
                        )
                    variables[slot.name + suffix] = symbolic.expr(q.value)
                    own_unit = unit if shown else slot.unit or _unit_of(q)
                    described[slot.name + suffix] = Description(own_unit, slot.doc)
                    display |= {slot.name + suffix: shown} if shown else {}
    return parameters, variables, described, inputs, display


def _unit_of(value: Value) -> str:
    while isinstance(value, tuple) and value:
        value = value[0]
    if isinstance(value, tuple) or value.dimension is None or value.boolean:
        return ""
    unit = quantities.unit_text(value.dimension)
    return "" if unit == "1" else unit


def _plain(value: Value) -> Any:
    return tuple(_plain(v) for v in value) if isinstance(value, tuple) else value.value


def _scalars(value: Value, suffix: str = "") -> Iterator[tuple[str, Quantity]]:
    if not isinstance(value, tuple):
        yield suffix, value
        return
    for i, inner in enumerate(value, 1):
        yield from _scalars(inner, f"{suffix[:-1]},{i}]" if suffix else f"[{i}]")
