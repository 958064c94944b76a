"""Classification of declarations by the names of their types."""

from __future__ import annotations

from mbdsl.elements import kinds
from mbdsl.errors import ModelError
from mbdsl.lang import quantities
from mbdsl.lang import syntax as s
from mbdsl.lang.library import Unit
from mbdsl.lang.source import span_of
from mbdsl.messages import did_you_mean

ALIASES = {"World": "Ground"}
FRAME_TYPES = ("Frame", "Frame_a", "Frame_b")
VALUE_TYPES = ("", "Real", "Integer", "Boolean", "String")


def classify(d: s.Declaration, unit: Unit) -> str | tuple[s.Model, Unit]:
    """The class of a declaration: "value", "frame", "table", the name of a kind, or a model."""
    name = d.type
    if name in VALUE_TYPES:
        return "value"
    found = unit.find(name)
    if found is not None:
        return found
    if name in FRAME_TYPES:
        return "frame"
    if name == "Table":
        return "table"
    kind = ALIASES.get(name, name)
    quantity = quantities.type_unit(name) is not None
    if quantity and (kind not in kinds() or d.value is not None or d.prefixes & {"parameter", "constant", "input"}):
        return "value"
    if kind in kinds():
        return kind
    raise no_type(d, unit)


def no_type(d: s.Declaration, unit: Unit) -> ModelError:
    if d.prefixes & {"parameter", "constant"}:
        known = [*VALUE_TYPES[1:], *quantities.TYPES]
        return ModelError(f"`{d.type}` is no type of a parameter", span_of(d.type_at), did_you_mean(d.type, known))
    known = [*kinds(), *ALIASES, "Table", "Frame", *unit.names(), *VALUE_TYPES[1:]]
    known += quantities.TYPES if d.value is not None else ()
    hint = did_you_mean(d.type, known) or f"the kinds are {', '.join(kinds())}"
    return ModelError(f"there is no kind of component or model called `{d.type}`", span_of(d.type_at), hint)
